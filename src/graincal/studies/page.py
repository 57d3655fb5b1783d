"""The page of results: of each study the paper's tables beside ours, the figures, and which of its conclusions hold."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from graincal.campaign.provenance import provenance
from graincal.notation import numbers
from graincal.report.page import Page
from graincal.report.tables import Table as Shown
from graincal.studies.found import parameter_labels
from graincal.studies.records import CANNOT_BE_TOLD, DOES_NOT_HOLD, HOLDS, Conclusion, Findings, Row, Table
from graincal.studies.settings import ACCURACY, ITERATIVE, Setup
from graincal.studies.study import Done, Study
from graincal.studies.work import Work

if TYPE_CHECKING:
    from graincal.studies.running import Plan

PAPER, FLOOR = "the paper", "runs at the same parameters"


def render(found: Mapping[Study, Findings], setup: Setup, done: Done, plan: Plan, title: str, failed: Mapping[str, str]) -> str:
    """The whole page."""
    page = Page(title, _subtitle(setup))
    page.heading("What came out")
    page.table(_summary(found, setup, done, plan))
    page.paragraph(_method(setup), "note")
    for study, findings in found.items():
        skipped = {case.setting for name, case in plan.skipped if name == study.name}
        page.heading(study.title)
        page.paragraph([f"{study.question} ({study.where}; graincal reproduce hartmann2022 --study {study.name})"])
        page.paragraph(_state(study, plan, done, failed), "note")
        if findings.conclusions:
            page.table(Shown(("the paper's conclusion", "by graincal", "why"), tuple((each.claim, *_judged(each, setup)) for each in findings.conclusions), figures=3))
        for table in findings.tables:
            page.subheading(table.heading)
            page.table(beside(table, skipped))
            page.paragraph(table.notes, "note")
        for figure in findings.numbered_figures.values():
            page.figure(figure)
        page.paragraph(findings.notes, "note")
    page.heading("Made with")
    page.table(Shown(("", ""), tuple((name, value) for name, value in provenance().items())))
    return page.render()


def beside(table: Table, skipped: Collection[str] = ()) -> Shown:
    """A table as the paper prints it, a column a quantity; of each setting the paper's row, and ours below it: the median over seeds, and their range where there are several. skipped: settings that lack a file."""
    quantities = tuple(dict.fromkeys(row.quantity for row in table.rows))
    labels = parameter_labels()
    rows = []
    for setting in dict.fromkeys(row.setting for row in table.rows):
        of_setting = [row for row in table.rows if row.setting == setting]
        lines = []
        if any(row.paper is not None for row in of_setting):
            printed = {row.quantity: row.paper for row in of_setting if row.paper is not None}
            lines.append((PAPER, *(f"{printed[name]:.5g}" if name in printed else "–" for name in quantities)))
        for method in dict.fromkeys(row.method for row in of_setting):
            ours = {row.quantity: row for row in of_setting if row.method == method}
            if any(row.ours for row in ours.values()):
                lines.append((_by(method), *(_ours(ours.get(name)) for name in quantities)))
            elif method in ("", ITERATIVE):
                lines.append((f"graincal: {'skipped' if setting in skipped else 'not run'}", *("–" for _ in quantities)))
        rows += [(labels.get(setting, setting) if number == 0 else "", *line) for number, line in enumerate(lines)]
    if floor := {row.quantity: row.floor for row in table.rows if row.floor is not None}:
        rows.append((FLOOR, "differ by", *(numbers.value(floor[name], 3) if name in floor else "–" for name in quantities)))
    return Shown(("setting", "", *(labels.get(name, name) for name in quantities)), tuple(rows), figures=2)


def _by(method: str) -> str:
    return "graincal" if method in ("", ITERATIVE) else f"graincal, {method}"


def _ours(row: Row | None) -> str:
    """The median, and the range where seeds differ."""
    if row is None or not np.isfinite(row.median):
        return "–"
    middle = numbers.value(row.median, 4)
    return middle if len(row.ours) < 2 or row.low == row.high else f"{middle} ({numbers.between(row.low, row.high)})"


def _summary(found: Mapping[Study, Findings], setup: Setup, done: Done, plan: Plan) -> Shown:
    rows = []
    for study, findings in found.items():
        verdicts = [_judged(each, setup)[0] for each in findings.conclusions]
        rows.append((study.title, study.where, *(str(verdicts.count(word)) for word in (HOLDS, DOES_NOT_HOLD, CANNOT_BE_TOLD)), *_cost(plan.of_study[study.name], done)))
    rows.append(("all together, what several share counted once", "", "", "", "", *_cost(plan.all, done)))
    return Shown(("study", "in the paper", "conclusions that hold", "that do not", "cannot be told", "runs", "core hours"), tuple(rows), figures=2)


def _cost(work: Sequence[Work], done: Done) -> tuple[str, str]:
    """The runs that were made so far, and the hours that they took, each on one core."""
    made, seconds = np.sum([each.runs(done.folder_of(each)) for each in work], axis=0) if work else (0, 0.0)
    return f"{int(made):,}".replace(",", "\u202f"), numbers.value(seconds / 3600, 2) if seconds else "–"


def _judged(conclusion: Conclusion, setup: Setup) -> tuple[str, str]:
    """The verdict and why."""
    if setup.own_everywhere:
        return CANNOT_BE_TOLD, "A rehearsal says nothing of it."
    return conclusion.judgement.verdict, conclusion.judgement.reason


def _subtitle(setup: Setup) -> str:
    if setup.own_everywhere:
        return f"A small rehearsal on a packing of {setup.size.particles} spheres of graincal's own: no number here compares with the paper's."
    return "Ours beside the paper's: the median over seeds, and their range in brackets."


def _method(setup: Setup) -> Sequence[str]:
    return (
        f"Each calibration is made by the paper's method with its only criterion of stopping, s at most 0.01, and beside it by graincal's method \"posterior\". Grains' density is scaled by 1,000 at every "
        f"confining pressure, as in the paper. The engine's accuracy is \"{ACCURACY}\".",
        f"Seeds of a calibration: {len(setup.short)} in studies that take at most an hour a seed, {len(setup.long)} in longer ones.",
        "A conclusion rests on a difference. Where runs at the same parameters differ by as much, or seeds spread as far, it cannot be told.",
    )


def _state(study: Study, plan: Plan, done: Done, failed: Mapping[str, str]) -> list[str]:
    work = plan.of_study[study.name]
    said = [f"Skipped, for {why}: {'; '.join(settings)}." for why, settings in plan.skipped_of(study.name).items()]
    said += [f"{each.title} could not be run: {failed[each.name]}" for each in work if each.name in failed]
    if waiting := [each for each in work if not done.has(each) and each.name not in failed]:
        said.append(f"{len(waiting)} of {len(work)} calibrations and series of runs are not made yet.")
    return said
