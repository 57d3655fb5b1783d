"""Errors of runs that were repeated, of which some may have failed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def mean_of(errors: NDArray[np.float64]) -> float:
    """The mean of errors (R,), but for those that are not finite; NaN where none is."""
    known = _known(errors)
    return float(known.mean()) if known.size else np.nan


def spread_of(errors: NDArray[np.float64]) -> float:
    """Their standard deviation; NaN for fewer than two."""
    known = _known(errors)
    if known.size < 2:
        return np.nan
    # Exactly none of runs that are the same, whatever their mean is rounded to.
    return float(known.std(ddof=1)) if np.ptp(known) else 0.0


def _known(errors: NDArray[np.float64]) -> NDArray[np.float64]:
    return errors[np.isfinite(errors)]
