"""Evaluations of somebody's own function."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graincal.data import LONGEST_NAME, Failure, Response
from graincal.models.named_function import describe_exception, find_function
from graincal.notation.printable import as_text, printable

Function = Callable[[NDArray[np.float64]], Mapping[str, ArrayLike]]


@dataclass(frozen=True, eq=False)
class FunctionWork:
    """A function, or its name as "module:name" with the folder that its module is looked for in first, and the control values (K,) that what it returns belongs to. A task's argument is theta (n,).

    A function by its name runs in processes, which import it. Any other may not be one that can be sent, and runs on threads.
    Names of what a function returns are made printable, and cut to 500 characters; what has an empty name, or one that is there already, is left out.
    """

    function: Function | str
    folder: Path | None
    control: NDArray[np.float64]
    timeout: float | None = None
    executor: Executor | None = None

    @property
    def key(self) -> str:
        """The same for the same function and control values."""
        return f"{self.function} of {self.folder} at {hashlib.sha256(self.control.tobytes()).hexdigest()}, {self.timeout}"

    @property
    def own_process(self) -> bool:
        """Whether an evaluation runs in a process, which may crash or be ended."""
        return isinstance(self.function, str) and self.executor is None

    def prepare(self) -> None:
        """Import the function. Raises InputError where it is not there."""
        self._callable()

    def __call__(self, theta: NDArray[np.float64]) -> Response | Failure:
        function, start = self._callable(), time.perf_counter()
        try:
            returned = function(theta)
        # Whatever it is: one evaluation's trouble. A KeyboardInterrupt that the function raises is not the user's.
        except BaseException as error:
            return Failure("error", f"{describe_exception(error)}.", {"seconds": time.perf_counter() - start})
        details = {"seconds": time.perf_counter() - start}
        try:
            if isinstance(returned, Failure):
                # Not one of a class of somebody's, which may not be one that can be sent.
                return Failure(returned.kind, returned.reason, {**details, **returned.details})
            return Response(self.control, self._columns(returned), details)
        except _Unusable as reason:
            return Failure("output", str(reason), details)
        except BaseException as error:
            return Failure("output", f"what the function returned cannot be read: {describe_exception(error)}.", details)

    def __getstate__(self) -> dict:
        # An executor stays where it is.
        return {**self.__dict__, "executor": None}

    def _callable(self) -> Function:
        return find_function(self.function, self.folder) if isinstance(self.function, str) else self.function

    def _columns(self, returned: object) -> dict[str, NDArray[np.float64]]:
        if not isinstance(returned, Mapping) or not returned:
            raise _Unusable(f"the function must return a mapping of names to values, and returned {type(returned).__name__}.")
        columns: dict[str, NDArray[np.float64]] = {}
        for name, values in returned.items():
            name = printable(as_text(name), LONGEST_NAME)
            if not name.strip() or name in columns:
                continue
            try:
                column = _numbers(values)
            except (TypeError, ValueError, OverflowError):
                raise _Unusable(f"{name} is not an array of numbers.") from None
            if column.shape != self.control.shape:
                raise _Unusable(
                    f"{name} has the shape {column.shape}, and one value for each of the {self.control.size} control values was expected: "
                    "those of the reference, or of `control`, which a function with values of its own states them in."
                )
            columns[name] = column
        return columns


def _numbers(values: object) -> NDArray[np.float64]:
    """A copy, as numbers. Raises TypeError, ValueError or OverflowError for what is none: text and complex numbers are not read as something else."""
    found = np.asarray(values)
    if found.dtype.kind not in "biufO" or any(isinstance(each, (str, bytes, complex)) for each in found.flat if found.dtype.kind == "O"):
        raise TypeError
    return np.array(found, dtype=np.float64)


class _Unusable(ValueError):
    """What a function returned is no response. The message says why."""
