"""What a calibration came to: the numbers that the paper's tables print."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from graincal.data import Response
from graincal.inference.driving.iteration import Iteration
from graincal.notation.quantities import parameters
from graincal.result import Result
from graincal.studies import paper
from graincal.studies.floors import ERROR, ERROR_OF, STRAIN, STRESS
from graincal.studies.judging import EXACT, Elsewhere, Values
from graincal.studies.records import Row
from graincal.studies.settings import ITERATIVE, space

ITERATIONS = "last iteration"
"""Counted from 0, as in the paper."""

QUANTITIES = (*paper.PARAMETERS, STRESS, STRAIN, ERROR)


@dataclass(frozen=True, eq=False)
class Fit:
    """Parameters that a calibration came to.

    theta (n,); errors: by quantity, percent. response: a run at them, or the mean of several. last: the last iteration, None by methods without one.
    stopped_by: the criterion that ended the calibration. evaluations: how many it took.
    """

    theta: NDArray[np.float64]
    errors: Mapping[str, float]
    response: Response
    last: int | None = None
    stopped_by: str = ""
    evaluations: int = 0

    @property
    def numbers(self) -> dict[str, float]:
        """By the quantities of a table."""
        iterations = {} if self.last is None else {ITERATIONS: float(self.last)}
        return dict(zip(paper.PARAMETERS, map(float, self.theta))) | dict(self.errors) | iterations

    @property
    def cut(self) -> bool:
        """Whether it was at its most iterations before it ended by s."""
        return self.stopped_by == "max_iterations" and self.last is not None and self.last > 0


def fit(result: Result) -> Fit | None:
    """By the paper's method the sample of the largest weight in the last iteration, which it reports; by the method "posterior" the answer, with the
    mean of its runs. None where there is none.
    """
    if result.has_posterior:
        answer = result.answer
        if answer is None or not len(answer.samples) or (response := result.mean_response(answer)) is None:
            return None
        return Fit(answer.theta, _errors(result, np.isin(result.ids, answer.samples)), response, None, result.stopped_by or "", result.evaluations)
    return None if result.most_probable is None else fit_of(result, result.most_probable.sample)


def fit_of(result: Result, sample: int) -> Fit:
    """Of one sample, by its id."""
    (row,) = np.flatnonzero(result.ids == sample)
    response = result.response(sample)
    assert isinstance(response, Response), "it has a weight"
    return Fit(
        result.samples[row],
        _errors(result, result.ids == sample),
        response,
        result.iterations[-1].index,
        result.stopped_by or "",
        result.evaluations,
    )


def fit_in(result: Result, iteration: Iteration) -> Fit | None:
    """Of the sample of the largest weight in an iteration; None where that has no weights."""
    if iteration.unweighted:
        return None
    # Up to this iteration: what ended the calibration later is not of it.
    return replace(fit_of(result, int(iteration.samples.ids[iteration.most_probable])), last=iteration.index, stopped_by="")


def fits(results: Iterable[Result]) -> list[Fit]:
    """Of several calibrations, those that have one."""
    return [found for result in results if (found := fit(result))]


def _errors(result: Result, rows: NDArray[np.bool_]) -> dict[str, float]:
    """The means over samples that gave a response."""
    rows = rows & result.complete
    names = [*result.experiments[0].reference.names, *result.experiments[0].reference.recorded]
    by_observable = np.concatenate([result.observable_errors, result.recorded_errors], axis=1)[rows].mean(axis=0)
    return {ERROR_OF[name]: float(error) for name, error in zip(names, by_observable)} | {ERROR: float(result.errors[rows].mean())}


def rows(
    setting: str,
    printed: Mapping[str, float],
    found: Sequence[Fit],
    floor: Mapping[str, float],
    quantities: Sequence[str] = QUANTITIES,
    method: str = ITERATIVE,
    missing: str = "",
) -> list[Row]:
    """The rows of one setting: what the paper printed beside what the calibrations of all seeds came to. missing: why they cannot be run."""
    numbers = [each.numbers for each in found]
    return [
        Row(
            setting,
            name,
            printed.get(name),
            tuple(each[name] for each in numbers if name in each),
            floor.get(name),
            method,
            missing,
            cut(found) if method == ITERATIVE else "",
        )
        for name in quantities
    ]


def cut(found: Sequence[Fit]) -> str:
    """That calibrations were cut before they ended by s, in words; nothing where none was."""
    if not (those := [each for each in found if each.cut]):
        return ""
    how_many = "" if len(those) == len(found) else f"{len(those)} of {len(found)} "
    first = those[0].last
    assert first is not None, "one that is cut was cut after an iteration"
    return f"{how_many}cut at {first + 1} iterations"


def values(name: str, found: Sequence[Fit], quantity: str, floor: Mapping[str, float], unit: str = " %", elsewhere: Elsewhere | None = None) -> Values:
    """What a conclusion speaks of: a quantity of the calibrations of one setting. That these were cut is said with its name. Parameters and
    iterations have no floor but the spread of the seeds.
    """
    known = floor.get(quantity) if quantity in (STRESS, STRAIN, ERROR) else EXACT
    named = f"{name} ({how})" if (how := cut(found)) else name
    return Values.of_finite(named, [each.numbers.get(quantity, np.nan) for each in found], known, unit, elsewhere=elsewhere)


def parameter_labels() -> dict[str, str]:
    """The parameters as they are written in tables and on axes."""
    return {name: shown.axis for name, shown in zip(paper.PARAMETERS, parameters(space()))}


def labels() -> dict[str, str]:
    """The quantities of tables as their columns are headed, where that is not their name."""
    return parameter_labels() | {STRESS: "ε_{stress} [%]", STRAIN: "ε_{strain} [%]"}


def parameter_names() -> dict[str, str]:
    """The parameters as they are written in sentences."""
    return {name: shown.label for name, shown in zip(paper.PARAMETERS, parameters(space()))}
