"""The dictionaries that GrainLearning keeps in `.npy` files, which are pickles: read by an unpickler that knows dict, list, str, numbers and NumPy's arrays, and nothing else.

A pickle is a program that may call any function. Here it can call some functions of this file: they make plain arrays and numbers, and check what they are given. NumPy's own code for pickles is not run.
"""

from __future__ import annotations

import io
import math
import pickle
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

LARGEST = 256 * 2**20
"""Bytes of a file that are read, and of an array that one says it holds."""

_NUMBERS = re.compile(r"[?biuf]\d*")
"""The types of arrays that are known, as NumPy writes them in a pickle."""


class NotPlain(Exception):
    """A file holds something else than a dictionary of numbers. The message says what, as the end of a sentence."""


def read_dictionary(path: Path) -> dict[str, Any]:
    """The dictionary in a `.npy` file: names -> numbers and arrays (T,); values of other kinds are left out. Raises NotPlain for what is none, OSError for what cannot be read."""
    if path.stat().st_size > LARGEST:
        raise NotPlain(f"it has more than {LARGEST / 2**20:,.0f} MiB")
    file = io.BytesIO(path.read_bytes())
    try:
        found = _content(file)
    except NotPlain:
        raise
    # A pickle that is damaged, or made to do harm, may break off in any way.
    except Exception as error:
        raise NotPlain(f"it cannot be read ({type(error).__name__}: {error})") from None
    if not isinstance(found, dict):
        raise NotPlain("it holds no dictionary")
    return {name: value for name, each in found.items() if isinstance(name, str) and (value := _plain(each)) is not None}


def _content(file: io.BytesIO) -> Any:
    version = npy.read_magic(file)
    shape, _, dtype = npy.read_array_header_1_0(file) if version == (1, 0) else npy.read_array_header_2_0(file)
    if not dtype.hasobject:
        raise NotPlain("it holds an array without names, and a dictionary was expected")
    held = _Unpickler(file, encoding="latin1").load()
    if shape != () or not isinstance(held, _Array) or not isinstance(held.value, list) or len(held.value) != 1:
        raise NotPlain("it holds an array of several things, and a single dictionary was expected")
    return held.value[0]


def _plain(value: object) -> float | NDArray[np.float64] | None:
    """A number, or an array of numbers; None for anything else."""
    if isinstance(value, _Array):
        value = value.value
    if isinstance(value, (bool, int, float)):
        return _number(value)
    if isinstance(value, np.ndarray):
        return value.astype(np.float64)
    if isinstance(value, list) and value and all(isinstance(each, (bool, int, float)) for each in value):
        return np.array([_number(each) for each in value])
    return None


def _number(value: float) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf


class _Type:
    """The type of an array's numbers; `code` is None for one of Python's objects."""

    def __init__(self, text: object, *flags: object) -> None:
        self.code: str | None = None
        if isinstance(text, str) and _NUMBERS.fullmatch(text):
            self.code = text
        elif text not in ("O8", "O4", "O"):
            raise NotPlain(f"it holds an array of the type {str(text)[:60]}, and numbers were expected")
        self.order: Literal["<", ">", "|", "="] = "="

    def __setstate__(self, state: object) -> None:
        self.order = state[1] if isinstance(state, tuple) and len(state) > 1 and state[1] in ("<", ">", "|", "=") else "="

    @property
    def dtype(self) -> np.dtype:
        if self.code is None:
            raise NotPlain("it holds one of Python's objects where a number was expected")
        return np.dtype(self.code).newbyteorder(self.order)


class _Array:
    """An array that is being read: an NDArray of numbers, or a list of whatever objects it holds."""

    value: NDArray | list | None = None

    def __setstate__(self, state: object) -> None:
        match state:
            case (int(), tuple(shape), _Type(code=None), _, list(held)) if all(isinstance(size, int) and size >= 0 for size in shape) and math.prod(
                shape
            ) == len(held):
                self.value = held
            case (int(), tuple(shape), _Type() as kind, fortran, bytes() | str() as raw) if all(isinstance(size, int) and size >= 0 for size in shape):
                # Python 2 wrote bytes as text.
                raw = raw.encode("latin1") if isinstance(raw, str) else raw
                self.value = np.frombuffer(raw, kind.dtype).reshape(shape, order="F" if fortran else "C")
            case _:
                raise NotPlain("it holds an array that is not as NumPy writes one")


class _Maker:
    """A function that a pickle may call, and not change."""

    def __init__(self, make: Callable[..., Any]) -> None:
        self._make = make

    def __call__(self, *arguments: object) -> Any:
        return self._make(*arguments)

    def __setstate__(self, state: object) -> None:
        raise NotPlain("it changes a function")


def _no_array(*ignored: object) -> None:
    raise NotPlain("it makes an array in another way than NumPy does")


_NDARRAY = _Maker(_no_array)
"""Stands for NumPy's class of arrays, which cannot be called here."""


def _reconstruct(subtype: object, *ignored: object) -> _Array:
    if subtype is not _NDARRAY:
        raise NotPlain("it holds an array of a class of somebody's")
    return _Array()


def _scalar(kind: object, raw: object) -> float:
    if not isinstance(kind, _Type) or not isinstance(raw, (bytes, str)):
        raise NotPlain("it holds a number that is not as NumPy writes one")
    (value,) = np.frombuffer(raw.encode("latin1") if isinstance(raw, str) else raw, kind.dtype)
    return value.item()


def _as_bytes(text: object, encoding: object) -> bytes:
    """How the oldest pickles of Python 3 write bytes."""
    if not isinstance(text, str) or encoding != "latin1":
        raise NotPlain("it holds bytes that are not as Python writes them")
    return text.encode("latin1")


_OF_ARRAYS: dict[str, Callable[..., Any]] = {"_reconstruct": _reconstruct, "scalar": _scalar}
_KNOWN = {(f"{package}.multiarray", name): _Maker(function) for package in ("numpy.core", "numpy._core") for name, function in _OF_ARRAYS.items()} | {
    ("numpy", "ndarray"): _NDARRAY,
    ("numpy", "dtype"): _Maker(_Type),
    ("_codecs", "encode"): _Maker(_as_bytes),
}


class _Unpickler(pickle.Unpickler):
    def find_class(self, module: str, name: str) -> _Maker:
        """Where a pickle asks for a function or a class."""
        if (module, name) not in _KNOWN:
            raise NotPlain(f"it asks for {module}.{name}, which is not run, and numbers were expected")
        return _KNOWN[module, name]
