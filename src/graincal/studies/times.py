"""How long does a calibration take? (section 4.2.3: Figure 16)"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from graincal.drawing.figure import Axis, Bars, Figure, Line, Mark, Panel
from graincal.drawing.palette import BAND, distinct
from graincal.studies.common import at_truth
from graincal.studies.costs import Costs, largest
from graincal.studies.curves import iterations
from graincal.studies.floors import floor_of_steps
from graincal.studies.found import cut, fits
from graincal.studies.judging import Values, all_of, at_least, at_most, smaller, spread_at
from graincal.studies.range_alpha import SETTINGS, SEVERAL, Setting, cases_by_setting, posteriors_by_box
from graincal.studies.records import Conclusion, Findings, Row, Table, conclusions
from graincal.studies.settings import ITERATIVE, POSTERIOR, Setup
from graincal.studies.study import Case, Done, Study

SHOWN = 15
"""The last iteration of the figure."""

AT_ONCE, IN_TURN, STEPS, EVALUATIONS = "all of an iteration at once [h]", "one after the other [h]", "steps [million]", "evaluations"

PRINTED: dict[str, dict[str, float]] = {
    "mid, α = 10": {AT_ONCE: 3.91, IN_TURN: 119.24, EVALUATIONS: 880},
    "small, α = 5": {AT_ONCE: 1.96, IN_TURN: 44.15},
    "small, α = 20": {IN_TURN: 250},
    "mid, α = 20": {IN_TURN: 250},
    "wide, α = 20": {AT_ONCE: 8.29, IN_TURN: 250},
}
"""The paper says that the totals of the three calibrations with α = 20 are above 250 hours."""

LONGEST = "longest evaluation [h]"
PEAKS = {
    "the shortest peak of the nine, of a small range": 0.52,
    "the highest peak of the nine, of a wide range": 4.08,
    "the highest of the nine at iteration 6": 0.29,
}
LATE = 6

INSET = "wide, α = 20"
BINS = (1.0, 2.0, 3.0)
COUNTS = {0: (150, 7, 2, 1), 1: (155, 5, 0, 0)}
"""Of the 160 evaluations of iterations 0 and 1 of the setting of the inset: how many took less than 1 h, up to 2 h, up to 3 h and longer. Their
longest took slightly above 4 h and 1.41 h.
"""


class Times(Study):
    name = "times"
    title = "The time that a calibration takes"
    where = "section 4.2, Figure 16"
    question = "How long do evaluations take along the iterations, and what is gained where all of an iteration run at once?"

    def cases(self, setup: Setup, done: Done) -> Sequence[Case]:
        return [at_truth(setup), *_shown(setup).values(), *_posteriors(setup, done).values()]

    def findings(self, setup: Setup, done: Done) -> Findings:
        cases = _shown(setup)
        missing = next((case.missing for case in cases.values() if case.missing), "")
        found = {setting.name: [Costs.of(result) for result in done.results(case)] for setting, case in cases.items()}
        by_posterior = {box: [Costs.of(result) for result in done.results(case)] for box, case in _posteriors(setup, done).items()}
        first = {name: many[0] for name, many in found.items() if many}
        notes = (
            "Hours are the sum over runs of the time of each on one core: "
            "ours on the machine that ran them, beside its other work; the paper's on an Intel Xeon Gold 6150 with YADE. "
            "Steps compare across machines.",
            "The paper prints of the three calibrations with α = 20 that each took more than 250 hours one after the other.",
            "The time that choosing samples takes is not counted, in the paper and here.",
            'By "posterior" runs are made a few at a time, and not in iterations.',
            *_failures(found),
        )
        cuts = {setting.name: cut(fits(done.results(case))) for setting, case in cases.items()}
        tables = (
            Table("times", "Evaluations, steps and hours to the end", tuple(_rows(found, by_posterior, missing, cuts)), notes),
            Table("times-longest", "The longest evaluations", (*_peaks(found, missing), *_inset_rows(first, missing)), (_OF_OTHER_MACHINES,)),
        )
        figures = {16: _figure(first)} if first else {}
        return Findings(tables, figures, _conclusions(found, cuts, floor_of_steps(done.repeats(at_truth(setup)))))


_OF_OTHER_MACHINES = (
    "Of the first seed of each setting. Hours of two machines and two programs do not compare; what does is how many runs are much longer than the others."
)


def _numbers(costs: Costs) -> dict[str, float]:
    """By the quantities of the table."""
    return {
        EVALUATIONS: float(costs.evaluations),
        STEPS: costs.all_steps / 1e6,
        AT_ONCE: float(np.nansum(costs.longest)),
        IN_TURN: float(costs.together.sum()),
    }


def _shown(setup: Setup) -> dict[Setting, Case]:
    """The nine calibrations of the figure."""
    return {setting: case for setting, case in cases_by_setting(setup).items() if setting.box != "extra wide"}


def _posteriors(setup: Setup, done: Done) -> dict[str, Case]:
    return {box: case for box, case in posteriors_by_box(setup, done).items() if box != "extra wide"}


def _failures(found: Mapping[str, Sequence[Costs]]) -> list[str]:
    """What failed runs have to do with these numbers."""
    every = [each for many in found.values() for each in many]
    failed, unknown = sum(each.failed for each in every), sum(each.unknown for each in every)
    if not failed:
        return []
    return [f"{failed} runs failed; their hours and steps are counted, but for the steps of {unknown}, which are not known."]


def _rows(found: Mapping[str, Sequence[Costs]], by_posterior: Mapping[str, Sequence[Costs]], missing: str, cuts: Mapping[str, str]) -> list[Row]:
    lines, shown = [], (EVALUATIONS, STEPS, AT_ONCE, IN_TURN)
    for setting in SETTINGS:
        if setting.box != "extra wide":
            printed, ours = PRINTED.get(setting.name, {}), [_numbers(each) for each in found[setting.name]]
            how = cuts[setting.name]
            lines += [Row(setting.name, name, printed.get(name), tuple(each[name] for each in ours), None, ITERATIVE, missing, how) for name in shown]
    for box, many in by_posterior.items():
        lines += [Row(box, name, None, tuple(_numbers(each)[name] for each in many), None, POSTERIOR) for name in (EVALUATIONS, STEPS, IN_TURN)]
    return lines


def _peaks(found: Mapping[str, Sequence[Costs]], missing: str) -> list[Row]:
    """The longest evaluations, of the first seeds: those of the text."""
    first = [many[0] for many in found.values() if many]
    peaks, late = [largest(each.longest) for each in first], [each.longest[LATE] for each in first if len(each.longest) > LATE]
    ours = (min(peaks), max(peaks), max(late, default=np.nan)) if len(first) == len(found) else ()
    return [Row(name, LONGEST, printed, ours[number : number + 1], missing=missing) for number, (name, printed) in enumerate(PEAKS.items())]


def _inset_rows(first: Mapping[str, Costs], missing: str) -> list[Row]:
    """How many evaluations took how long, in hours of the machine."""
    lines = []
    for number, printed in COUNTS.items():
        hours = first[INSET].hours[number] if INSET in first and len(first[INSET].hours) > number else np.empty(0)
        counts = np.bincount(np.searchsorted(BINS, hours[np.isfinite(hours)], side="right"), minlength=len(printed)) if len(hours) else ()
        for column, (name, value) in enumerate(zip(("runs below 1 h", "from 1 to 2 h", "from 2 to 3 h", "above 3 h"), printed)):
            lines.append(Row(f"{INSET}, iteration {number}", name, value, tuple(map(float, counts[column : column + 1])), missing=missing))
    return lines


def _figure(first: Mapping[str, Costs]) -> Figure:
    def panel(title: str, label: str, series: Mapping[str, NDArray[np.float64]]) -> Panel:
        shown = {name: values[: SHOWN + 1] for name, values in series.items()}
        lines = tuple(Line(np.arange(len(values), dtype=float), values, distinct(number), name) for number, (name, values) in enumerate(shown.items()))
        return Panel(title, iterations(shown.values()), Axis(label), lines)

    panels = [
        panel("Longest evaluation", "time [h]", {name: each.longest for name, each in first.items()}),
        panel("All of an iteration at once, summed", "time [h]", {name: np.cumsum(each.longest) for name, each in first.items()}),
        panel("One after the other, summed", "time [h]", {name: np.cumsum(each.together) for name, each in first.items()}),
        panel("Longest evaluation", "steps [million]", {name: each.most_steps / 1e6 for name, each in first.items()}),
    ]
    if INSET in first:
        panels += [_histogram(number, first[INSET]) for number in COUNTS if number < len(first[INSET].hours)]
    caption = "The first seed of each setting, on one core. Steps do not depend on the machine and its other work. Below, the inset of the paper's figure."
    return Figure("figure-16", "Times along the iterations", caption, tuple(panels), columns=2)


def _histogram(number: int, costs: Costs) -> Panel:
    hours = costs.hours[number][np.isfinite(costs.hours[number])]
    heights, edges = np.histogram(hours, bins=20)
    mark: Mark = Bars(edges, heights.astype(float), BAND, "runs")
    return Panel(f"{INSET}, iteration {number}", Axis("time of an evaluation [h]"), Axis("runs"), (mark,))


def _conclusions(found: Mapping[str, Sequence[Costs]], cuts: Mapping[str, str], floor: float | None) -> tuple[Conclusion, ...]:
    """By steps, for they do not depend on the machine.

    cuts: whether calibrations were cut. floor: what the steps of runs at the same parameters differ by, as a part of them.
    """
    several = found[SEVERAL]

    def of(name: str, setting: str, number: Callable[[Costs], float]) -> Values:
        """For one seed as many parts of its number as those of the setting with several seeds spread over."""
        ours = [number(each) / 1e6 for each in found[setting]]
        middle, elsewhere = np.nanmedian(ours) if ours else np.nan, [number(each) / 1e6 for each in several]
        spread = spread_at(SEVERAL, elsewhere, middle / np.nanmedian(elsewhere) if elsewhere else np.nan)
        how = f" ({cuts[setting]})" if cuts[setting] else ""
        return Values.of_finite(f"{name} of {setting}{how}", ours, None if floor is None else floor * middle, " million steps", elsewhere=spread)

    def early(setting: str) -> Values:
        return of("the longest run in iterations 0 and 1", setting, lambda each: largest(each.most_steps[:2]))

    def late(setting: str) -> Values:
        return of("the longest run of later iterations", setting, lambda each: largest(each.most_steps[2:]))

    def longest(box: str, alpha: int) -> Values:
        return of("the longest run", f"{box}, α = {alpha}", lambda each: largest(each.most_steps))

    def total(box: str, alpha: int) -> Values:
        return of("the sum of all runs", f"{box}, α = {alpha}", lambda each: each.all_steps)

    ratios = [each.gained for each in several]
    gained = Values.of_finite(f"what is gained with {SEVERAL}", ratios, None if floor is None or not ratios else floor * float(np.median(ratios)), " times")
    boxes = ("small", "mid", "wide")
    return conclusions(
        {
            "The longest runs are in iterations 0 and 1, and are gone after that.": all_of([smaller(late(name), early(name)) for name in found]),
            "The wide range has the longest runs.": all_of(
                [smaller(longest(box, alpha), longest("wide", alpha)) for box in boxes[:2] for alpha in (5, 10, 20)]
            ),
            "Runs of one iteration at once take 10 to 100 times less than one after the other (the paper: 30 times).": all_of(
                [at_least(gained, 10), at_most(gained, 100)]
            ),
            "α = 5 takes the least in all.": all_of([smaller(total(box, 5), total(box, alpha)) for box in boxes for alpha in (10, 20)]),
        }
    )
