"""How many samples does how wide a range need? (section 4.2: Tables 7 to 9, Figures 11 to 13 and 17)"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from graincal.data import Reference
from graincal.drawing.figure import Axis, Figure, Panel, Points
from graincal.drawing.palette import GREEN, ORANGE, VERMILLION, Style
from graincal.result import Result
from graincal.studies import paper
from graincal.studies.common import at_truth, floor_on_synthetic, on_synthetic, on_synthetic_by_posterior, proof
from graincal.studies.curves import over_iterations, over_strain
from graincal.studies.floors import ERROR
from graincal.studies.found import ITERATIONS, QUANTITIES, Fit, cut, fits, rows, values
from graincal.studies.judging import CANNOT_BE_TOLD, DOES_NOT_HOLD, HOLDS, Elsewhere, Judgement, Values, all_of, at_least, at_most, smaller, spread_at
from graincal.studies.records import Conclusion, Findings, Row, Table, conclusions
from graincal.studies.settings import POSTERIOR, Setup
from graincal.studies.study import Case, Done, Study

CUT = 20
"""Iterations of the two runs that do not come to an end in the paper either."""


@dataclass(frozen=True)
class Setting:
    """One calibration of the paper: its range of log E, α, the samples of an iteration, about how many iterations it takes, what was printed of it,
    and the last iteration where that was.
    """

    box: str
    alpha: int
    samples: int
    iterations: int
    printed: tuple[float, ...]
    last: int | None = None

    @property
    def name(self) -> str:
        return f"{self.box}, α = {self.alpha}"

    @property
    def numbers(self) -> dict[str, float]:
        """What was printed, by quantity."""
        return dict(zip(QUANTITIES, self.printed)) | ({} if self.last is None else {ITERATIONS: float(self.last)})

    @property
    def width(self) -> float:
        low, high = paper.BOXES[self.box]
        return high - low

    @property
    def most_iterations(self) -> int:
        return CUT if (self.box, self.alpha) in (("wide", 5), ("extra wide", 20)) else paper.MOST_ITERATIONS


SETTINGS = (
    Setting("small", 5, 40, 10, (8.950, 0.063, 26.937, 0.466, 0.217, 1.45, 6.80, 4.13)),
    Setting("mid", 5, 40, 12, (8.805, 0.184, 26.406, 0.112, 0.554, 1.76, 2.88, 2.32)),
    Setting("wide", 5, 40, CUT, (9.090, 0.381, 22.721, 0.068, 0.432, 4.19, 8.52, 6.36), 100),
    Setting("small", 10, 80, 10, (8.785, 0.122, 27.285, 0.222, 0.236, 1.08, 2.18, 1.63)),
    Setting("mid", 10, 80, 11, (8.733, 0.186, 28.530, 0.095, 0.797, 1.06, 1.20, 1.13), 10),
    Setting("wide", 10, 80, 10, (8.736, 0.300, 26.625, 0.078, 0.767, 2.71, 2.55, 2.63)),
    Setting("small", 20, 160, 10, (8.778, 0.107, 26.736, 0.741, 0.175, 1.82, 1.94, 1.88)),
    Setting("mid", 20, 160, 12, (8.706, 0.286, 27.928, 0.069, 0.493, 1.44, 1.33, 1.38)),
    Setting("wide", 20, 160, 10, (8.715, 0.198, 27.635, 0.115, 0.260, 0.95, 1.61, 1.28)),
    Setting("extra wide", 20, 160, CUT, (9.219, 0.037, 24.365, 0.637, 0.520, 3.03, 14.01, 8.52), 100),
    Setting("extra wide", 30, 241, 12, (8.738, 0.169, 27.129, 0.174, 0.233, 1.15, 1.41, 1.28)),
)

OPTIMAL, SUB_OPTIMAL = 2.0, 5.0
"""The limits of the paper's grades, percent of ε."""

SEVERAL = "mid, α = 10"
"""The setting that has several seeds."""


def cases_by_setting(setup: Setup) -> dict[Setting, Case]:
    """The calibrations, which other studies look at too. That of the proof of concept has as many seeds here."""
    return {
        each: proof(setup)
        if (each.box, each.alpha) == ("mid", 10)
        else on_synthetic(setup, each.box, each.samples, setup.long, each.iterations, each.most_iterations)
        for each in SETTINGS
    }


class RangeAlpha(Study):
    name = "range-alpha"
    title = "The width of the range and the number of samples"
    where = "section 4.2, Tables 7 to 9, Figures 11 to 13 and 17"
    question = "How many samples does an iteration need, for how wide a range of log E?"

    def cases(self, setup: Setup, done: Done) -> Sequence[Case]:
        return [at_truth(setup), *cases_by_setting(setup).values(), *posteriors_by_box(setup, done).values()]

    def findings(self, setup: Setup, done: Done) -> Findings:
        cases = cases_by_setting(setup)
        missing = next((case.missing for case in cases.values() if case.missing), "")
        scatter = floor_on_synthetic(setup, done)
        results = {setting: done.results(case) for setting, case in cases.items()}
        found = {setting: fits(many) for setting, many in results.items()}
        posteriors = {box: fits(done.results(case)) for box, case in posteriors_by_box(setup, done).items()}
        notes = (
            "The paper's calibrations of the wide range with α = 5 and of the extra wide one with α = 20 did not end by s, "
            "and were stopped after iteration 100; "
            f"ours have {CUT} iterations at most. Where s ended one of ours before, the table does not say that it was cut.",
        )
        figures = _figures(results, found, None if missing else setup.synthetic())
        return Findings(_tables(found, posteriors, scatter, missing), figures, _conclusions(found, scatter), notes)


def posteriors_by_box(setup: Setup, done: Done) -> dict[str, Case]:
    """The method "posterior" for each range of log E."""
    return {box: on_synthetic_by_posterior(setup, done, box, setup.short if box == "mid" else setup.long) for box in paper.BOXES}


def _tables(found: Mapping[Setting, list[Fit]], posteriors: Mapping[str, list[Fit]], scatter: Mapping[str, float], missing: str) -> tuple[Table, ...]:
    ranges = tuple(Row(box, f"log E {end}", float(value), (float(value),)) for box, limits in paper.BOXES.items() for end, value in zip(("from", "to"), limits))

    def table(number: int, title: str, extra: bool) -> Table:
        lines = []
        for setting, many in found.items():
            if (setting.box == "extra wide") == extra:
                lines += rows(setting.name, setting.numbers, many, scatter, (*QUANTITIES, ITERATIONS), missing=missing)
        lines += [row for box, many in posteriors.items() if (box == "extra wide") == extra for row in rows(box, {}, many, scatter, method=POSTERIOR)]
        return Table(number, title, tuple(lines))

    return (
        Table(7, "Ranges of log E", ranges),
        table(8, "Three ranges and three numbers of samples", False),
        table(9, "The extra wide range", True),
    )


def _figures(results: Mapping[Setting, list[Result]], found: Mapping[Setting, list[Fit]], reference: Reference | None) -> dict[int, Figure]:
    figures, first = {}, {setting.name: many[0] for setting, many in results.items() if many}
    usual = {name: [each.gl_error for each in result.iterations] for name, result in first.items() if not name.startswith("extra")}
    if usual:
        figures[11] = over_iterations("figure-11", "GL error over iterations", "Eq. 7, the first seed of each setting of Table 8.", usual, "ε_{GL} [%]")
    for number, extra, what in ((12, False, "Table 8"), (13, True, "Table 9")):
        curves = {setting.name: many[0].response for setting, many in found.items() if many and (setting.box == "extra wide") == extra}
        if curves and reference:
            caption = "The first seed of each setting, and the synthetic reference."
            figures[number] = over_strain(f"figure-{number}", f"Calibrated curves of {what}", caption, curves, {"synthetic reference": reference})
    if any(found.values()):
        figures[17] = _grades(found)
    return figures


def _grades(found: Mapping[Setting, list[Fit]]) -> Figure:
    """Figure 17: which settings end in a good fit."""
    groups: dict[str, list[tuple[float, float]]] = {}
    for setting, many in found.items():
        if many:
            groups.setdefault(grade(float(np.median([each.errors[ERROR] for each in many]))), []).append((setting.width, setting.alpha))
    at = {word: np.array(points) for word, points in groups.items()}
    marks = [Points(at[word][:, 0], at[word][:, 1], style, f"{word}: {limits}") for word, (style, limits) in _GRADES.items() if word in groups]
    panel = Panel("", Axis("width of the range of log E [log_{10} Pa]", (0, 10)), Axis("α", (0, 35)), tuple(marks))
    return Figure("figure-17", "Which settings end in a good fit", "The median over seeds of the error ε of the calibrated parameters.", (panel,), columns=1)


_GRADES = {
    "optimal": (Style(GREEN, symbol="circle", size=10), "ε below 2 %"),
    "sub-optimal": (Style(ORANGE, symbol="square", size=9), "ε from 2 to 5 %"),
    "poor": (Style(VERMILLION, symbol="cross", size=9), "ε above 5 %"),
}


def grade(error: float) -> str:
    """The paper's grade of a fit by its error ε, percent; it calls both of the worse ones sub-optimal, in orange and red."""
    return "optimal" if error < OPTIMAL else "sub-optimal" if error <= SUB_OPTIMAL else "poor"


def spread_of_seeds(found: Mapping[Setting, Sequence[Fit]], quantity: str) -> Elsewhere:
    """How far the seeds of the setting that has several spread in a quantity."""
    several = next((many for setting, many in found.items() if setting.name == SEVERAL), ())
    return spread_at(SEVERAL, [each.numbers[quantity] for each in several])


def _conclusions(found: Mapping[Setting, list[Fit]], scatter: Mapping[str, float]) -> tuple[Conclusion, ...]:
    def of(quantity: str, shown: str, unit: str, box: str, alpha: int) -> Values:
        (many,) = [many for setting, many in found.items() if (setting.box, setting.alpha) == (box, alpha)]
        return values(f"{shown} with {box}, α = {alpha}", many, quantity, scatter, unit, spread_of_seeds(found, quantity))

    def error(box: str, alpha: int) -> Values:
        return of(ERROR, "ε", " %", box, alpha)

    def modulus(box: str, alpha: int) -> Values:
        return of("log_E", "log E", "", box, alpha)

    usual = ("small", "mid", "wide")
    larger = [smaller(modulus(box, alpha), modulus(other, 5)) for other in usual for box in usual for alpha in (10, 20)]
    return conclusions(
        {
            "With α = 5 no range ends in an optimal fit: ε is above 2 %.": all_of([at_least(error(box, 5), OPTIMAL) for box in usual]),
            "The three calibrations with α = 5 have the largest log E of the nine.": all_of(larger),
            "α = 10 is enough for ranges of up to four decades: ε is below 2 %.": all_of([at_most(error(box, 10), OPTIMAL) for box in ("small", "mid")]),
            "The wide range needs α = 20: with α = 10 ε is larger.": smaller(error("wide", 20), error("wide", 10)),
            "The extra wide range needs α = 30: with α = 20 ε is larger.": smaller(error("extra wide", 30), error("extra wide", 20)),
            "The small range ends worse than the mid one, with the same α.": all_of(
                [smaller(error("mid", alpha), error("small", alpha)) for alpha in (5, 10, 20)]
            ),
            "Five of the nine calibrations of the three ranges have ε below 2 %.": _count(
                [at_most(error(box, alpha), OPTIMAL) for box in usual for alpha in (5, 10, 20)], 5
            ),
            "s alone is not a sufficient stop: some calibration ends by it with ε above 2 %.": _s_alone(found, error),
        }
    )


def _count(judged: Sequence[Judgement], printed: int) -> Judgement:
    """Whether as many of some limits are kept as the paper has."""
    kept, exceeded = (sum(each.verdict == verdict for each in judged) for verdict in (HOLDS, DOES_NOT_HOLD))
    said = f"{kept} are below for certain, {exceeded} above, and of {len(judged) - kept - exceeded} of {len(judged)} it cannot be told"
    if kept == printed and kept + exceeded == len(judged):
        return Judgement(HOLDS, f"{said}.")
    return Judgement(DOES_NOT_HOLD if kept > printed or exceeded > len(judged) - printed else CANNOT_BE_TOLD, f"{said}.")


def _s_alone(found: Mapping[Setting, list[Fit]], error: Callable[[str, int], Values]) -> Judgement:
    """By the calibrations that none was cut of: it holds where one is above the limit for certain, and does not where all are below."""
    ended = [setting for setting, many in found.items() if many and not cut(many)]
    judged = [at_least(error(setting.box, setting.alpha), OPTIMAL) for setting in ended]
    if above := [each for each in judged if each.verdict == HOLDS]:
        return Judgement(HOLDS, f"{above[0].reason} This is so of {len(above)} of {len(judged)} settings that ended by s.")
    if judged and all(each.verdict == DOES_NOT_HOLD for each in judged):
        return Judgement(DOES_NOT_HOLD, f"All {len(judged)} settings that ended by s are below.")
    return Judgement(CANNOT_BE_TOLD, f"Of {len(judged)} settings that ended by s none is above 2 % for certain." if judged else "Nothing of it was run.")
