"""The numbers of a file that a program wrote: text as laboratory files are taken, NumPy's files, and HDF5, as columns by their names."""

from __future__ import annotations

import csv
import io
import math
import re
import zipfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from graincal.data import InputError
from graincal.errors import not_installed
from graincal.laboratory.addressing import column_index
from graincal.laboratory.cells import find_decimal
from graincal.laboratory.heading import find_heading, known
from graincal.laboratory.numbers import shown
from graincal.laboratory.rows import SPACE, comment_text, delimited
from graincal.laboratory.table import Table
from graincal.laboratory.text import decode
from graincal.laboratory.units import split_header
from graincal.suggestion import did_you_mean

LARGEST_TEXT, LARGEST_BINARY = 256 * 2**20, 4 * 2**30
"""Bytes of a file that are read."""

_ENOUGH = 12
"""Rows of numbers that show the delimiter, the decimal mark and the names; the laboratory reader takes a millisecond for each."""
_MOST_ABOVE = 400
_BEGINS_WITH_NUMBER = re.compile(r"\s*[\"']?[+-]?(\d|\.\d|nan|inf)", re.IGNORECASE)


class Unreadable(Exception):
    """A file is not what it is said to be. The message says what is wrong, as a sentence."""


@dataclass(frozen=True)
class Columns:
    """The columns of a file: `find` gives the numbers (T,) of one that is named, and the text of the unit behind its name, None without; it raises Unreadable where there is none. has: whether there is one."""

    find: Callable[[str | int], tuple[NDArray[np.float64], str | None]]
    has: Callable[[str | int], bool]


def read_columns(content: Path | bytes, name: str) -> Columns:
    """The columns of a file, or of what was printed, called `name` in messages: NumPy's files and HDF5 by their first bytes, and otherwise text. Raises Unreadable, InputError, and whatever a library makes of a file that is broken."""
    head = content[:8] if isinstance(content, bytes) else _head(content)
    of_binary = next((read for begins, read in _BINARY.items() if head.startswith(begins)), None)
    size, most = (len(content) if isinstance(content, bytes) else content.stat().st_size), LARGEST_BINARY if of_binary else LARGEST_TEXT
    if size > most:
        raise Unreadable(f"{name} has {size / 2**20:,.0f} MiB, and at most {most / 2**20:,.0f} were expected.")
    if of_binary:
        return of_binary(content, name)
    return _of_text(content if isinstance(content, bytes) else content.read_bytes(), name)


def _head(path: Path) -> bytes:
    with path.open("rb") as file:
        return file.read(8)


def _opened(content: Path | bytes) -> Path | io.BytesIO:
    return io.BytesIO(content) if isinstance(content, bytes) else content


def of_named(columns: Mapping[str, NDArray], name: str) -> Columns:
    """Columns that have names, perhaps with a unit in brackets behind them."""
    without_units = {split_header(each)[0]: each for each in columns}

    def key(said: str | int) -> str | None:
        return None if isinstance(said, int) else said if said in columns else without_units.get(said)

    def find(said: str | int) -> tuple[NDArray[np.float64], str | None]:
        found = key(said)
        if found is None:
            raise Unreadable(f"{name} has no '{said}'{did_you_mean(str(said), columns)}, and holds {', '.join(map(shown, columns)) or 'nothing'}.")
        return _numbers(columns[found], f"{name}: {said}"), split_header(found)[1]

    return Columns(find, lambda said: key(said) is not None)


def _of_npy(content: Path | bytes, name: str) -> Columns:
    """An array (T, K), whose columns go by their numbers from 1, or a structured one (T,), whose fields have names."""
    array = np.load(_opened(content), allow_pickle=False)
    if array.dtype.names:
        return of_named({field: array[field] for field in array.dtype.names}, name)
    if array.ndim != 2:
        raise Unreadable(f"{name} holds an array of the shape {array.shape}, and rows and columns, or an array with named fields, were expected.")

    def number(said: str | int) -> int | None:
        digits = str(said)
        return int(digits) if digits.isascii() and digits.isdecimal() and len(digits) < 10 and 1 <= int(digits) <= array.shape[1] else None

    def find(said: str | int) -> tuple[NDArray[np.float64], str | None]:
        if (at := number(said)) is None:
            raise Unreadable(f"{name} has no column {said}, and a number from 1 to {array.shape[1]} was expected, for its columns have no names.")
        return _numbers(array[:, at - 1], f"{name}: column {said}"), None

    return Columns(find, lambda said: number(said) is not None)


def _of_npz(content: Path | bytes, name: str) -> Columns:
    # An archive may unpack to any size.
    with zipfile.ZipFile(_opened(content)) as archive:
        whole = sum(entry.file_size for entry in archive.infolist())
    if whole > LARGEST_BINARY:
        raise Unreadable(f"{name} unpacks to {whole / 2**20:,.0f} MiB, and at most {LARGEST_BINARY / 2**20:,.0f} were expected.")
    with np.load(_opened(content), allow_pickle=False) as arrays:
        return of_named({key: arrays[key] for key in arrays.files}, name)


def _of_hdf5(content: Path | bytes, name: str) -> Columns:
    try:
        import h5py
    except ImportError as error:
        raise not_installed(f"{name}: an HDF5 file", "h5py", "hdf5", error) from None
    names: list[str] = []

    def look(path: str, node: object) -> None:
        if isinstance(node, h5py.Dataset):
            names.extend([f"{path}/{field}" for field in node.dtype.names] if node.dtype.names else [path] * (node.ndim == 1))

    with h5py.File(_opened(content), "r") as file:
        file.visititems(look)
    return of_named(_Datasets(content, {spelt: each for each in names for spelt in (each, f"/{each}")}), name)


class _Datasets(Mapping):
    """The datasets of an HDF5 file by their paths, the fields of one that has some behind it; each is read when it is asked for, since files of simulations are large."""

    def __init__(self, content: Path | bytes, paths: Mapping[str, str]) -> None:
        self._content, self._paths = content, paths

    def __getitem__(self, name: str) -> NDArray:
        import h5py

        path = self._paths[name]
        with h5py.File(_opened(self._content), "r") as file:
            if isinstance(file.get(path), h5py.Dataset):
                return file[path][()]
            table, _, field = path.rpartition("/")
            return file[table][field]

    def __iter__(self) -> Iterator[str]:
        return iter(self._paths)

    def __len__(self) -> int:
        return len(self._paths)


_BINARY = {b"\x93NUMPY": _of_npy, b"PK\x03\x04": _of_npz, b"\x89HDF\r\n\x1a\n": _of_hdf5}
"""Readers of files by their first bytes."""


def _numbers(values: NDArray, called: str) -> NDArray[np.float64]:
    if values.dtype.kind not in "biuf" or values.ndim != 1:
        raise Unreadable(f"{called} has the shape {values.shape} and the type {values.dtype}, and one number for each row was expected.")
    return values.astype(np.float64)


def _of_text(raw: bytes, name: str) -> Columns:
    if not raw.strip():
        raise Unreadable(f"{name} is empty.")
    lines = re.split(r"\r\n|\r|\n", decode(raw, name, None, known_names).text.replace("\u2212", "-"))
    table, first = _heading(lines, name)
    rows = list(_rows(lines, first, table.delimiter))

    def index(said: str | int) -> int:
        return column_index(table, said)

    def has(said: str | int) -> bool:
        try:
            index(said)
        except InputError:
            return False
        return True

    def find(said: str | int) -> tuple[NDArray[np.float64], str | None]:
        try:
            at = index(said)
        except InputError as error:
            raise Unreadable(str(error)) from None
        unit = split_header(table.header[at])[1] if at < len(table.header) else None
        if unit is None and at < len(table.units):
            unit = table.units[at] or None
        return np.array([_cell(row, at, line, table) for line, row in rows]), unit

    return Columns(find, has)


def known_names(text: str) -> int:
    """How many words of a text are names of quantities."""
    return known(text.split()[:200])


def _heading(lines: list[str], name: str) -> tuple[Table, int]:
    """The names of the columns, as the laboratory reader finds them at the beginning of the text, and the index of the first line of numbers."""
    numbered = [at for at, line in enumerate(lines[: _MOST_ABOVE + _ENOUGH]) if _BEGINS_WITH_NUMBER.match(line)]
    beginning = lines[: numbered[min(len(numbered), _ENOUGH) - 1] + 1] if numbered else lines[:_MOST_ABOVE]
    grid = delimited(name, "\n".join(beginning))
    heading = find_heading(grid)
    body = [row for row in grid.rows if row.line >= heading.first]
    width = max(len(row.cells) for row in body)
    header = (*heading.names, *[""] * (width - len(heading.names)))
    decimal = find_decimal(body, name)
    table = Table(name, "", False, grid.delimiter, decimal, heading.line, header, heading.units, (), (), heading.groups)
    return table, heading.first - 1


def _rows(lines: list[str], first: int, delimiter: str) -> Iterator[tuple[int, list[str]]]:
    """The rows of numbers with the numbers of their lines: no comments, and no lines without a number, such as a header that is repeated."""
    chosen = [
        (at + 1, line) for at, line in enumerate(lines[first:], first) if line.strip() and not (line.lstrip()[0] in "#%/!;" and comment_text(line) is not None)
    ]
    if delimiter == SPACE:
        split = [line.split() for _, line in chosen]
    else:
        split = list(csv.reader((line for _, line in chosen), delimiter=delimiter, skipinitialspace=delimiter != "\t"))
        if len(split) != len(chosen):
            raise Unreadable("an open quotation mark swallows lines of it.")
    for (number, _), cells in zip(chosen, split):
        if any(_BEGINS_WITH_NUMBER.match(cell) for cell in cells):
            yield number, cells


def _cell(row: list[str], at: int, line: int, table: Table) -> float:
    text = row[at].strip() if at < len(row) else ""
    try:
        return float(text if table.decimal == "." else text.replace(",", ".")) if text else math.nan
    except ValueError:
        raise Unreadable(f"{table.path}: line {line} says '{shown(text)}' in the column {table.label(at)}, and a number was expected.") from None
