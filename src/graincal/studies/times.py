"""How long does a calibration take? (section 4.2.3: Figure 16)"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from graincal.campaign import Result
from graincal.report.drawing import Axis, Figure, Line, Panel
from graincal.report.palette import distinct
from graincal.studies.curves import iterations
from graincal.studies.range_alpha import SETTINGS, Setting, cases_by_setting
from graincal.studies.records import Conclusion, Findings, Row, Table, Values, all_of, smaller
from graincal.studies.settings import Setup
from graincal.studies.study import Case, Done, Study

SHOWN = 15
"""The last iteration of the figure."""

AT_ONCE, IN_TURN, STEPS, EVALUATIONS = "all of an iteration at once [h]", "one after the other [h]", "steps [million]", "evaluations"

PRINTED = {
    "mid, α = 10": {AT_ONCE: 3.91, IN_TURN: 119.24, EVALUATIONS: 880},
    "small, α = 5": {AT_ONCE: 1.96, IN_TURN: 44.15},
    "wide, α = 20": {AT_ONCE: 8.29},
}


class Times(Study):
    name = "times"
    title = "The time that a calibration takes"
    where = "section 4.2, Figure 16"
    question = "How long do evaluations take along the iterations, and what is gained where all of an iteration run at once?"

    def cases(self, setup: Setup, done: Done) -> Sequence[Case]:
        return list(_shown(setup).values())

    def findings(self, setup: Setup, done: Done) -> Findings:
        found = {setting.name: _costs(results[0]) for setting, case in _shown(setup).items() if (results := done.results(case))}
        lines = []
        for setting in SETTINGS:
            if setting.box != "extra wide":
                ours = found[setting.name].numbers if setting.name in found else {}
                lines += [Row(setting.name, name, PRINTED.get(setting.name, {}).get(name), (ours[name],) if ours else ()) for name in (EVALUATIONS, STEPS, AT_ONCE, IN_TURN)]
        notes = (
            "Hours are of one core: ours of the machine that ran them, with whatever else it did; the paper's of an Intel Xeon Gold 6150 with YADE. Steps compare across machines.",
            "The time of the paper's sampling, and ours, is not in it.",
        )
        figures = {16: _figure(found)} if found else {}
        return Findings((Table("times", "Evaluations, steps and hours to the end", tuple(lines), notes),), figures, _conclusions(found))


class _Costs:
    """Of one calibration, by iteration: the longest of its evaluations and all of them together, in hours and in steps, (I,)."""

    def __init__(self, hours: list[NDArray[np.float64]], steps: list[NDArray[np.float64]]) -> None:
        self.evaluations = sum(map(len, hours))
        self.longest, self.together = (np.array([fold(each) for each in hours]) for fold in (np.nanmax, np.nansum))
        self.most_steps, self.steps = (np.array([fold(each) for each in steps]) for fold in (np.nanmax, np.nansum))

    @property
    def numbers(self) -> dict[str, float]:
        return {EVALUATIONS: float(self.evaluations), STEPS: float(self.steps.sum() / 1e6), AT_ONCE: float(self.longest.sum()), IN_TURN: float(self.together.sum())}


def _shown(setup: Setup) -> dict[Setting, Case]:
    """The nine calibrations of the figure."""
    return {setting: case for setting, case in cases_by_setting(setup).items() if setting.box != "extra wide"}


def _costs(result: Result) -> _Costs:
    steps = np.array([outcome.details.get("steps", np.nan) if (outcome := result.response(int(id))) else np.nan for id in result.ids])
    of = [result.iteration == each.index for each in result.iterations]
    return _Costs([result.seconds[rows, 0] / 3600 for rows in of], [steps[rows] for rows in of])


def _figure(found: Mapping[str, _Costs]) -> Figure:
    def panel(title: str, label: str, series: Mapping[str, NDArray[np.float64]]) -> Panel:
        lines = tuple(Line(np.arange(len(values[: SHOWN + 1]), dtype=float), values[: SHOWN + 1], distinct(number), name) for number, (name, values) in enumerate(series.items()))
        return Panel(title, iterations(values[: SHOWN + 1] for values in series.values()), Axis(label), lines)

    panels = (
        panel("Longest evaluation", "time [h]", {name: each.longest for name, each in found.items()}),
        panel("All of an iteration at once, summed", "time [h]", {name: np.cumsum(each.longest) for name, each in found.items()}),
        panel("One after the other, summed", "time [h]", {name: np.cumsum(each.together) for name, each in found.items()}),
        panel("Longest evaluation", "steps [million]", {name: each.most_steps / 1e6 for name, each in found.items()}),
    )
    return Figure("figure-16", "Times along the iterations", "Of one core. Steps do not depend on the machine and what else it does.", panels, columns=2)


def _conclusions(found: Mapping[str, _Costs]) -> tuple[Conclusion, ...]:
    early = [Values.of(f"the longest run of iterations 0 and 1 of {name}", [each.most_steps[:2].max() / 1e6], unit=" million steps") for name, each in found.items()]
    late = [Values.of("that of later ones", [each.most_steps[2:].max() / 1e6] if len(each.most_steps) > 2 else [], unit=" million steps") for each in found.values()]

    def longest(box: str, alpha: int) -> Values:
        name = f"{box}, α = {alpha}"
        return Values.of(f"the longest run of {name}", [found[name].most_steps.max() / 1e6] if name in found else [], unit=" million steps")

    def total(name: str) -> Values:
        return Values.of(f"the sum of {name}", [found[name].steps.sum() / 1e6] if name in found else [], unit=" million steps")

    gained = [found["mid, α = 10"].together.sum() / found["mid, α = 10"].longest.sum()] if "mid, α = 10" in found else []
    claims = {
        "The longest runs are in iterations 0 and 1, and are gone after that.": all_of([smaller(one, other) for one, other in zip(late, early)]),
        "The wide range has the longest runs.": all_of([smaller(longest(box, alpha), longest("wide", alpha)) for box in ("small", "mid") for alpha in (5, 10, 20)]),
        "Runs of one iteration at once take 10 to 100 times less than one after the other (the paper: 30 times).": smaller(Values("10", (10.0,), unit=""), Values.of("what is gained with mid, α = 10", gained, unit=" times")),
        "α = 5 takes the least in all.": all_of([smaller(total(f"{box}, α = 5"), total(f"{box}, α = {alpha}")) for box in ("small", "mid", "wide") for alpha in (10, 20)]),
    }
    return tuple(Conclusion(claim, judgement) for claim, judgement in claims.items())
