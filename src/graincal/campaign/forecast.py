"""How much of a calibration by the method "posterior" is still to come, as most go."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graincal.inference.posterior_filter import GROWTH, REPLICATES
from graincal.inference.settling import FRESH

SETTLES_AFTER = 3.0
"""Times the first batch: about where most calibrations settle."""


@dataclass(frozen=True)
class Forecast:
    """evaluations: how many there will be in the end, as most calibrations go; at_most: the limit on them, None for no limit."""

    evaluations: int
    at_most: int | None

    @classmethod
    def of(cls, asked: int, first_batch: int, at_most: int | None, *, at_answer: bool = False) -> Forecast:
        """Of a calibration that has asked for so many, of which the last are the runs at the answer or not."""
        if at_answer:
            return cls(asked, at_most)
        # One that has gone further than most goes on for another batch at the least, and for the fresh runs and those at the answer.
        settles = max(SETTLES_AFTER * first_batch, (1 + GROWTH) * asked) if asked > first_batch else SETTLES_AFTER * first_batch
        expected = int(np.ceil(settles)) + FRESH + REPLICATES
        return cls(expected if at_most is None else min(expected, at_most), at_most)
