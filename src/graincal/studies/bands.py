"""How wide the bands of volumetric strain are that posteriors predict, and how sure that is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from graincal.data import Response
from graincal.studies.judging import SURE, Values, spread_at

RESAMPLED = 1000
"""Samples of the runs, drawn again from them, by which a width's error is found."""


def width(runs: Sequence[Response]) -> float:
    """The mean width of the 90 % interval of volumetric strain over the test, percent of strain, by runs at the same states; NaN for fewer than two."""
    return _width(_strains(runs)) if len(runs) > 1 else np.nan


def ratio_of_widths(name: str, runs: Sequence[Sequence[Response]], others: Sequence[Sequence[Response]], where: str) -> Values:
    """The widths by the runs of each seed over the median of the others'.

    Its floor is what the ratio may be off by for so few draws (bootstrap, Efron 1979, Ann. Statist. 7), half of an interval of 95 %. For one seed its
    spread is that of the others, as parts of them.
    """
    widths, known = ([each for each in map(width, many) if np.isfinite(each)] for many in (runs, others))
    if not widths or not known:
        return Values(name, (), unit=" times")
    middle = float(np.median(known))
    ratios = [each / middle for each in widths]
    rng = np.random.default_rng(0)
    of_runs, of_others = (_relative_error(next(each for each in many if len(each) > 1), rng) for many in (runs, others))
    floor = SURE * float(np.hypot(of_runs, of_others)) * float(np.median(ratios))
    return Values.of_finite(name, ratios, floor, " times", elsewhere=spread_at(where, [each / middle for each in known], float(np.median(ratios))))


def _relative_error(runs: Sequence[Response], rng: np.random.Generator) -> float:
    """The standard deviation of a width over samples of its runs, as a part of it."""
    strains = _strains(runs)
    drawn = [_width(strains[rng.integers(len(strains), size=len(strains))]) for _ in range(RESAMPLED)]
    return float(np.std(drawn) / np.mean(drawn))


def _strains(runs: Sequence[Response]) -> NDArray[np.float64]:
    return np.array([run.values["volumetric_strain"] for run in runs])


def _width(strains: NDArray[np.float64]) -> float:
    low, high = np.quantile(strains, [0.05, 0.95], axis=0)
    return 100 * float(np.mean(high - low))
