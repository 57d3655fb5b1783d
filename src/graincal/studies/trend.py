"""Whether a quantity has a trend with the number of particles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t

from graincal.notation import numbers
from graincal.studies.judging import CANNOT_BE_TOLD, DOES_NOT_HOLD, HOLDS, Judgement, sentence

FEWEST = 4
"""Sizes, of fewer than which no trend can be told from scatter."""


@dataclass(frozen=True)
class Trend:
    """A line by least squares over the logarithm of the number of particles.

    change: along it from the smallest to the largest; low, high: its interval of 95 %, by what the sizes scatter about the line.
    """

    change: float
    low: float
    high: float

    @classmethod
    def of(cls, sizes: Sequence[int], values: NDArray[np.float64]) -> Trend:
        """Of a value for each of at least four sizes."""
        at = np.log(sizes)
        design = np.column_stack([np.ones(len(at)), at])
        coefficients, *_ = np.linalg.lstsq(design, values, rcond=None)
        left, freedom, extent = values - design @ coefficients, len(at) - 2, at.max() - at.min()
        error = np.sqrt(left @ left / freedom / np.sum((at - at.mean()) ** 2)) * extent
        change, wide = float(coefficients[1] * extent), float(t.ppf(0.975, freedom) * error)
        return cls(change, change - wide, change + wide)


def no_trend(name: str, by_size: Mapping[int, Sequence[float]], small: float, unit: str = "", falls_only: bool = False) -> Judgement:
    """Whether a quantity does not change with the number of particles by more than `small`.

    by_size: the values of all seeds at each number of particles. It holds where the interval of the change lies within ± `small`, does not where the
    interval excludes zero and the change is larger than that, and cannot be told otherwise. falls_only: only a fall counts as a change.
    """
    found = {size: float(np.median(values)) for size, values in sorted(by_size.items()) if len(values)}
    if len(found) < FEWEST:
        return Judgement(CANNOT_BE_TOLD, f"A trend of {name} needs packings of {FEWEST} sizes, and there are {len(found)}.")
    trend = Trend.of(list(found), np.array(list(found.values())))
    seeds = [len(by_size[size]) for size in found]
    count = f"{min(seeds)} to {max(seeds)} seeds" if min(seeds) < max(seeds) else "one seed" if seeds[0] == 1 else f"{seeds[0]} seeds"
    said = (
        f"{sentence(name)} changes along the sizes by {numbers.value(trend.change, 2)}{unit}, "
        f"with an interval of 95 % of {numbers.between(trend.low, trend.high)}{unit}, "
        f"by {len(found)} sizes of {count} each"
    )
    if not np.isfinite(small):
        return Judgement(CANNOT_BE_TOLD, f"{said}: how far runs at the same parameters differ is not known.")
    said += f"; a change of up to {numbers.value(small, 2)}{unit} is called none"
    if trend.low > -small and (falls_only or trend.high < small):
        return Judgement(HOLDS, f"{said}.")
    if (trend.high < 0 and trend.change < -small) or (not falls_only and trend.low > 0 and trend.change > small):
        return Judgement(DOES_NOT_HOLD, f"{said}.")
    return Judgement(CANNOT_BE_TOLD, f"{said}: the interval is too wide to tell.")
