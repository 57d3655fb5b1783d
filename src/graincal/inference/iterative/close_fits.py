"""The samples that fit about as well as the best: what is known of the parameters whatever the weights say."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graincal.inference import Iteration

MARGIN = 3.0
"""Percentage points of the error ε (Eq. 6) beyond the best sample's, within which another fits about as well.

It is chosen, not measured in each campaign: runs of one set of parameters differ by about as much where 1,000 grains are sheared by 11 to 20 % at 0.5 MPa.
Short shears repeat better (the demo's, to 5 %, within 0.4 %). There it is the samples that need the margin: a few tens outline what fits, one or two do not.
"""
ENOUGH = 10
"""Samples that outline a range; fewer are single points of it."""


@dataclass(frozen=True, eq=False)
class CloseFits:
    """limit: the error up to which samples count, percent. count: how many of all iterations do. low, high (n,): the ends of the values that they have."""

    limit: float
    count: int
    low: NDArray[np.float64]
    high: NDArray[np.float64]

    @property
    def enough(self) -> bool:
        """Whether there are so many that they outline what fits."""
        return self.count >= ENOUGH


def close_fits(iterations: Sequence[Iteration]) -> CloseFits | None:
    """The close fits among the samples of all iterations; None if all failed.

    Every one of them is a simulation that was run, so their ranges are facts, and the least of what fits: samples come to where earlier ones fitted, and
    values beyond were seldom tried with all others tuned to them.
    """
    theta = np.concatenate([iteration.samples.theta for iteration in iterations])
    errors = np.concatenate([iteration.errors for iteration in iterations])
    if np.isnan(errors).all():
        return None
    limit = float(np.nanmin(errors)) + MARGIN
    close = theta[errors <= limit]
    return CloseFits(limit, len(close), close.min(axis=0), close.max(axis=0))
