"""How do the errors change along the iterations? (Figure 18)"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from graincal.drawing.figure import Axis, Figure, Line, Panel, counting_axis
from graincal.drawing.palette import distinct
from graincal.result import Result
from graincal.studies.common import at_truth, floor_on_synthetic, proof
from graincal.studies.floors import ERROR, STRAIN, STRESS
from graincal.studies.found import Fit, fit_in, rows
from graincal.studies.judging import Judgement, Values, at_least, at_most, smaller
from graincal.studies.records import Conclusion, Findings, Table, conclusions
from graincal.studies.settings import Setup
from graincal.studies.study import Case, Done, Study

PRINTED = {
    0: {ERROR: 16.46},
    1: {STRESS: 3.79, STRAIN: 15.55, ERROR: 9.67},
    2: {STRESS: 10.60, STRAIN: 1.55, ERROR: 6.07},
    3: {STRESS: 3.66, STRAIN: 5.81, ERROR: 4.73},
    5: {ERROR: 3.11},
    6: {ERROR: 2.36},
    7: {ERROR: 1.99},
    8: {ERROR: 1.73},
    9: {ERROR: 1.51},
    10: {STRESS: 1.06, STRAIN: 1.20, ERROR: 1.13},
}
"""By iteration, of the sample of the largest weight.

The text's 3.79 and 15.55 are read as those of iteration 1: otherwise the drop to iteration 5 that it states does not come out.
"""

SWINGS, HALF, LAST = 3, 5, 10
ACCEPTABLE = 5.0
"""The limit of the paper's grade "sub-optimal", percent of ε."""

Along = Mapping[int, Fit]
"""The most probable sample of each iteration that has one, by the iteration's number."""


class Errors(Study):
    name = "errors"
    title = "The errors along the iterations"
    where = "section 4.5, Figure 18"
    question = "How do the errors of the most probable sample fall, and when is more iterating of no use?"

    def cases(self, setup: Setup, done: Done) -> Sequence[Case]:
        return [at_truth(setup), proof(setup)]

    def findings(self, setup: Setup, done: Done) -> Findings:
        calibrated = proof(setup)
        results = done.results(calibrated)
        scatter = floor_on_synthetic(setup, done)
        along = [found for result in results if (found := _along(result))]
        lines = []
        for number in sorted({*PRINTED, *(number for each in along for number in each)}):
            there = [each[number] for each in along if number in each]
            lines += rows(f"iteration {number}", PRINTED.get(number, {}), there, scatter, (STRESS, STRAIN, ERROR), missing=calibrated.missing)
        table = Table("errors", "Errors of the most probable sample along the iterations", tuple(lines))
        figures = {18: _figure(along[0])} if along else {}
        notes = ('The method "posterior" is not beside: it has no iterations whose samples follow from those before, and no most probable one among them.',)
        return Findings((table,), figures, _conclusions(along, _last_gl_errors(results), scatter), notes)


def _along(result: Result) -> Along:
    return {each.index: fit for each in result.iterations if (fit := fit_in(result, each))}


def _last_gl_errors(results: Sequence[Result]) -> list[float]:
    """Of the last iteration with weights of each."""
    return [[each.gl_error for each in result.iterations if not each.unweighted][-1] for result in results if _along(result)]


def _figure(along: Along) -> Figure:
    numbers = np.array(sorted(along), dtype=float)
    lines = tuple(
        Line(numbers, np.array([along[int(number)].errors[name] for number in numbers]), distinct(k), name.removesuffix(" [%]"))
        for k, name in enumerate((ERROR, STRESS, STRAIN))
    )
    panel = Panel("", counting_axis("iteration", 0, max(1, numbers[-1])), Axis("error [%]"), lines)
    return Figure("figure-18", "Errors along the iterations", "Of the sample of the largest weight, the first seed.", (panel,), columns=1)


def _conclusions(along: Sequence[Along], last_gl_errors: Sequence[float], scatter: Mapping[str, float]) -> tuple[Conclusion, ...]:
    floor, points = scatter.get(ERROR), " percentage points"
    error = [{number: fit.errors[ERROR] for number, fit in each.items()} for each in along]
    there = [each for each in error if 0 in each and HALF in each]
    early = Values.of_finite(f"what ε falls by from iteration 0 to {HALF}", [each[0] - each[HALF] for each in there], floor, points)
    after = [each[HALF] - each[min(LAST, max(each))] for each in there if min(LAST, max(each)) in each]
    late = Values.of_finite(f"what it falls by from there to iteration {LAST} or the last", after, floor, points)
    rises = Values.of_finite("the largest rise of ε from one iteration to the next", [_largest_rise(each) for each in error], floor, points)
    half = Values.of_finite(f"ε at iteration {HALF}", [each[HALF] for each in there], floor)
    last = Values.of_finite("the last ε of the most probable sample", [each[max(each)] for each in error], floor)
    last_of_all = Values.of_finite("the last GL error, the mean over all samples,", last_gl_errors, floor)
    return conclusions(
        {
            "ε falls steadily.": at_most(rises, 0.0),
            f"The errors of stress and of strain swing against each other up to iteration {SWINGS}: in some step one falls and the other rises.": _swings(
                along, scatter
            ),
            f"Most of it is gained by iteration {HALF}.": smaller(late, early),
            f"An acceptable fit is there at iteration {HALF}: ε is at most 5 % (the paper: 3.11 %).": at_most(half, ACCEPTABLE),
            "The most probable sample fits better than the mean of all samples does.": smaller(last, last_of_all),
        }
    )


def _largest_rise(error: Mapping[int, float]) -> float:
    """NaN for one iteration alone."""
    return float(max(np.diff([error[number] for number in sorted(error)]), default=np.nan))


def _swings(along: Sequence[Along], scatter: Mapping[str, float]) -> Judgement:
    """By the largest of the smaller of a fall and a rise in one step, seed by seed."""
    floors = [scatter[name] for name in (STRESS, STRAIN) if name in scatter]
    found = []
    for each in along:
        early = [each[number] for number in range(SWINGS + 1) if number in each]
        stress, strain = (np.diff([fit.errors[name] for fit in early]) for name in (STRESS, STRAIN))
        # Nothing where both rise, or both fall, in each step.
        steps = np.minimum(np.maximum(-stress, -strain), np.maximum(stress, strain))
        found.append(max(0.0, steps.max()) if len(steps) else np.nan)
    swing = Values.of_finite(
        "what one error falls by and the other rises by at least, in one step,", found, max(floors) if floors else None, " percentage points"
    )
    return at_least(swing, 0.0)
