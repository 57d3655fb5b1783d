"""Errors of runs that were repeated, of which some may have failed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


class Repeated:
    """What has the errors (R,) of runs that were repeated, percent, NaN for a failure."""

    errors: NDArray[np.float64]

    @property
    def mean(self) -> float:
        """Of the errors; NaN where no run has one."""
        return mean_of(self.errors)

    @property
    def spread(self) -> float:
        """The errors' standard deviation; NaN for fewer than two."""
        return spread_of(self.errors)


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
