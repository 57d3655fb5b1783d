"""How much of a calibration by the method "posterior" is still to come, as most go."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graincal.inference.posterior.posterior_filter import GROWTH, REPLICATES
from graincal.inference.posterior.settling import FRESH

SETTLES_AFTER = 3.0
"""Times the first batch: about where most calibrations settle."""


@dataclass(frozen=True)
class Forecast:
    """evaluations: how many there will be in the end, as most calibrations go; at_most: the limit on them, None for no limit."""

    evaluations: int
    at_most: int | None

    @classmethod
    def of(cls, first_batch: int, known: int, at_most: int | None) -> Forecast:
        """Of a calibration whose first batch has so many samples, beside runs that are known already."""
        # Known runs are as good as a first batch: little more than what confirms them is wanted.
        settles = (1 + GROWTH) * first_batch if known else SETTLES_AFTER * first_batch
        expected = int(np.ceil(settles)) + FRESH + REPLICATES
        return cls(expected if at_most is None else min(expected, at_most), at_most)
