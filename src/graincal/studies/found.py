"""The numbers of a calibration that the paper's tables print, and what runs at the same parameters differ by."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from graincal.campaign import Result
from graincal.data import Response
from graincal.inference.errors import curve_error
from graincal.interpolation import interpolate
from graincal.notation.quantities import parameters
from graincal.studies import paper
from graincal.studies.records import Row
from graincal.studies.settings import ITERATIVE, space

STRESS, STRAIN, ERROR = "ε stress ratio [%]", "ε volumetric strain [%]", "ε [%]"
"""Eq. 5 of each observable, and Eq. 6 of both."""

QUANTITIES = (*paper.PARAMETERS, STRESS, STRAIN, ERROR)


@dataclass(frozen=True, eq=False)
class Fit:
    """Parameters that a calibration came to, theta (n,), their errors by quantity, percent, and a run of theirs."""

    theta: NDArray[np.float64]
    errors: Mapping[str, float]
    response: Response

    @property
    def numbers(self) -> dict[str, float]:
        """By the quantities of a table."""
        return dict(zip(paper.PARAMETERS, map(float, self.theta))) | dict(self.errors)


def fit(result: Result) -> Fit | None:
    """By the paper's method the sample of the largest weight in the last iteration, which it reports; by the method "posterior" the answer, with the mean of its runs. None where there is none."""
    if result.has_posterior:
        answer = result.answer
        if answer is None or not len(answer.samples) or (response := result.mean_response(answer)) is None:
            return None
        return Fit(answer.theta, _errors(result, np.isin(result.ids, answer.samples)), response)
    return None if result.most_probable is None else fit_of(result, result.most_probable.sample)


def fit_of(result: Result, sample: int) -> Fit:
    """Of one sample, by its id."""
    (row,) = np.flatnonzero(result.ids == sample)
    return Fit(result.samples[row], _errors(result, result.ids == sample), result.response(sample))


def fits(results: Iterable[Result]) -> list[Fit]:
    """Of several calibrations, those that have one."""
    return [found for result in results if (found := fit(result))]


def _errors(result: Result, rows: NDArray[np.bool_]) -> dict[str, float]:
    """The means over samples that gave a response."""
    rows = rows & result.complete
    names = [*result.experiments[0].reference.names, *result.experiments[0].reference.recorded]
    by_observable = np.concatenate([result.observable_errors, result.recorded_errors], axis=1)[rows].mean(axis=0)
    return {_ERROR_OF[name]: float(error) for name, error in zip(names, by_observable)} | {ERROR: float(result.errors[rows].mean())}


_ERROR_OF = {"stress_ratio": STRESS, "volumetric_strain": STRAIN}


def rows(setting: str, printed: Mapping[str, float], found: Sequence[Fit], floor: Mapping[str, float], quantities: Sequence[str] = QUANTITIES, method: str = ITERATIVE) -> list[Row]:
    """The rows of one setting: what the paper printed beside what the calibrations of all seeds came to."""
    numbers = [each.numbers for each in found]
    return [Row(setting, name, printed.get(name), tuple(each[name] for each in numbers if name in each), floor.get(name), method) for name in quantities]


def at(runs: Sequence[Response], control: NDArray[np.float64]) -> list[Response]:
    """The runs at these control values, without those that do not reach so far."""
    return [met for run in runs if isinstance(met := interpolate(run, control), Response)]


def floor(runs: Sequence[Response], control: NDArray[np.float64], shares: Mapping[str, float]) -> dict[str, float]:
    """What runs at the same parameters differ by: Eq. 5 and Eq. 6 of one against another, the median over all pairs, percent. Nothing for fewer than two."""
    errors = [[float(curve_error(one.values[name], other.values[name])) for name in shares] for one, other in combinations(at(runs, control), 2)]
    if not errors:
        return {}
    by_observable, trust = np.array(errors), 1 / np.array(list(shares.values()))
    means = by_observable @ trust / trust.sum()
    return {_ERROR_OF[name]: float(np.median(column)) for name, column in zip(shares, by_observable.T)} | {ERROR: float(np.median(means))}


def floor_of(runs: Sequence[Response], name: str) -> float:
    """What runs at the same parameters, on the same states, differ by in one quantity: Eq. 5 of one against another, the median over all pairs, percent; NaN for fewer than two."""
    errors = [curve_error(one.values[name], other.values[name]) for one, other in combinations(runs, 2)]
    return float(np.median(errors)) if errors else np.nan


def mean_of(runs: Sequence[Response], name: str) -> NDArray[np.float64]:
    """The mean curve of a quantity, (S,)."""
    return np.mean([run.values[name] for run in runs], axis=0)


def parameter_labels() -> dict[str, str]:
    """The parameters as they are written in tables and on axes."""
    return {name: shown.axis for name, shown in zip(paper.PARAMETERS, parameters(space()))}


def mean_run(runs: Sequence[Response]) -> Response:
    """The mean of runs on the same states."""
    return replace(runs[0], values={name: mean_of(runs, name) for name in runs[0].values}, details={})
