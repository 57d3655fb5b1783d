"""Numbers that are checked as they enter."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graincal.errors import InputError


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
