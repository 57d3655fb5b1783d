"""What the evaluations of a calibration take, in hours and in steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graincal.result import Result


@dataclass(frozen=True, eq=False)
class Costs:
    """Of one calibration, by iteration: the hours and the steps of its evaluations, (N,) each, NaN where they are not known. failed: how many gave no
    response; unknown: of these, those without steps.
    """

    hours: tuple[NDArray[np.float64], ...]
    steps: tuple[NDArray[np.float64], ...]
    failed: int
    unknown: int

    @classmethod
    def of(cls, result: Result) -> Costs:
        steps, hours = result.detail("steps"), result.seconds[:, 0] / 3600
        rows = [result.iteration == each.index for each in result.iterations]
        return cls(tuple(hours[each] for each in rows), tuple(steps[each] for each in rows), result.failures, int(np.sum(np.isnan(steps) & result.failed)))

    @property
    def evaluations(self) -> int:
        return sum(map(len, self.hours))

    @property
    def longest(self) -> NDArray[np.float64]:
        """(I,): of each iteration, hours."""
        return np.array([largest(each) for each in self.hours])

    @property
    def together(self) -> NDArray[np.float64]:
        """(I,): of all evaluations of each iteration, hours."""
        return np.array([np.nansum(each) for each in self.hours])

    @property
    def most_steps(self) -> NDArray[np.float64]:
        """(I,): of the longest evaluation of each iteration."""
        return np.array([largest(each) for each in self.steps])

    @property
    def all_steps(self) -> float:
        return float(sum(np.nansum(each) for each in self.steps))

    @property
    def gained(self) -> float:
        """How many times less all take where each iteration runs at once, in steps."""
        return self.all_steps / float(np.nansum(self.most_steps))


def largest(values: NDArray[np.float64]) -> float:
    """NaN where none is known."""
    known = values[np.isfinite(values)]
    return float(known.max()) if len(known) else np.nan
