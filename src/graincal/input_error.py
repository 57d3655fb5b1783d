"""The one error for what a user gave and cannot be used, and numbers that are checked as they enter."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graincal.notation.printable import printable

LONGEST_MESSAGE = 10_000
"""Characters of a message: a list of many columns is long."""


class InputError(ValueError):
    """What a user gave cannot be used. The message is one sentence that names the place and what was expected; whatever it quotes is made printable in it."""

    def __init__(self, message: object = "") -> None:
        super().__init__(printable(message, LONGEST_MESSAGE, lines=True))


def read_only(values: ArrayLike, *, ndim: int, what: str) -> NDArray[np.float64]:
    """A copy as float64 that cannot be written to. Raises InputError, beginning with `what`, for what holds no numbers or has other dimensions."""
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{what} must hold numbers only.") from None
    if array.ndim != ndim:
        raise InputError(f"{what} must have {ndim} dimension{'s' if ndim > 1 else ''}, not {array.ndim}.")
    array.setflags(write=False)
    return array
