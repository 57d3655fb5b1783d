"""The page of results: of each study the paper's tables beside ours, the figures, and which of its conclusions hold."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from graincal.notation import numbers
from graincal.report.page import Page
from graincal.report.tables import Table as Shown
from graincal.studies.beside import beside
from graincal.studies.judging import CANNOT_BE_TOLD, DOES_NOT_HOLD, HOLDS
from graincal.studies.plan import Plan
from graincal.studies.records import Conclusion, Findings
from graincal.studies.settings import ACCURACY, Setup
from graincal.studies.study import Done, Study
from graincal.studies.work import Work


def render(found: Mapping[Study, Findings], setup: Setup, done: Done, plan: Plan, title: str, failed: Mapping[str, str], broken: Mapping[str, str]) -> str:
    """The whole page. failed: why work could not be run, by its name. broken: why a study's numbers could not be evaluated, by its name."""
    page = Page(title, _subtitle(setup))
    page.heading("What came out")
    page.table(_summary(found, setup, done, plan))
    page.paragraph(_method(setup), "note")
    for study, findings in found.items():
        page.heading(study.title)
        page.paragraph([f"{study.question} ({study.where}; graincal reproduce hartmann2022 --study {study.name})"])
        page.paragraph(
            [*([f"Its numbers could not be evaluated, {broken[study.name]}"] if study.name in broken else []), *_state(study, plan, done, failed)],
            "note",
        )
        if findings.conclusions:
            page.table(Shown(("conclusion", "by graincal", "why"), tuple((_claim(each), *_judged(each, setup)) for each in findings.conclusions), figures=3))
        for table in findings.tables:
            page.subheading(table.heading)
            page.table(beside(table))
            page.paragraph(table.notes, "note")
        for figure in findings.numbered_figures.values():
            page.figure(figure)
        page.paragraph(findings.notes, "note")
    page.heading("Made with")
    page.table(_made_with(done, plan))
    return page.render()


def _made_with(done: Done, plan: Plan) -> Shown:
    """What all work was begun with: each build that was, and how many calibrations and series of runs it began."""
    builds = Counter(tuple(made.items()) for each in plan.all if (made := each.made_with(done.folder_of(each))))
    rows = [(f"{count} of {sum(builds.values())}", ", ".join(f"{name} {value}" for name, value in build)) for build, count in builds.most_common()]
    return Shown(("calibrations and series of runs", "begun with"), tuple(rows), figures=2)


def _claim(conclusion: Conclusion) -> str:
    return conclusion.claim if conclusion.of_paper else f"(Not in the paper) {conclusion.claim}"


def _summary(found: Mapping[Study, Findings], setup: Setup, done: Done, plan: Plan) -> Shown:
    rows = []
    for study, findings in found.items():
        verdicts = [_judged(each, setup)[0] for each in findings.conclusions if each.of_paper]
        rows.append(
            (
                study.title,
                study.where,
                *(str(verdicts.count(word)) for word in (HOLDS, DOES_NOT_HOLD, CANNOT_BE_TOLD)),
                *_cost(plan.of_study[study.name], done),
            )
        )
    rows.append(("all together, what several share counted once", "", "", "", "", *_cost(plan.all, done)))
    return Shown(
        ("study", "in the paper", "the paper's conclusions that hold", "that do not hold", "that cannot be told", "runs", "core hours"),
        tuple(rows),
        figures=2,
    )


def _cost(work: Sequence[Work], done: Done) -> tuple[str, str]:
    """The runs that were made so far, and the hours that they took, each on one core."""
    made, seconds = np.sum([each.runs(done.folder_of(each)) for each in work], axis=0) if work else (0, 0.0)
    return f"{int(made):,}".replace(",", "\u202f"), numbers.value(seconds / 3600, 2) if seconds else "–"


def _judged(conclusion: Conclusion, setup: Setup) -> tuple[str, str]:
    """The verdict and why."""
    if setup.own_everywhere:
        return CANNOT_BE_TOLD, f"This is a rehearsal, of which no conclusion follows. Its numbers: {conclusion.judgement.reason}"
    return conclusion.judgement.verdict, conclusion.judgement.reason


def _subtitle(setup: Setup) -> str:
    if setup.own_everywhere:
        return f"A small rehearsal on a packing of {setup.size.particles} spheres of graincal's own: no number here compares with the paper's."
    return "Our numbers beside the paper's: the median over seeds, and their range in brackets."


def _method(setup: Setup) -> Sequence[str]:
    return (
        "Calibrations are made by the paper's method with its only criterion of stopping, s at most 0.01, "
        'and many of them by graincal\'s method "posterior" too. '
        f'The density of grains is scaled by 1,000 at every confining pressure, as in the paper. The engine\'s accuracy is "{ACCURACY}".',
        f"Seeds of a calibration: {len(setup.short)} in studies that take at most an hour a seed, {len(setup.long)} in longer ones.",
        "A conclusion rests on a difference. Where runs at the same parameters differ by as much, or seeds spread as far, it cannot be told. "
        "For a setting with one seed the spread is taken from a setting of the same study that has several, which is named.",
    )


def _state(study: Study, plan: Plan, done: Done, failed: Mapping[str, str]) -> list[str]:
    work = plan.of_study[study.name]
    said = [f"Skipped, for {why}: {'; '.join(settings)}." for why, settings in plan.skipped_of(study.name).items()]
    said += [f"{each.title} could not be run: {failed[each.name]}" for each in work if each.name in failed]
    if waiting := [each for each in work if not done.has(each) and each.name not in failed]:
        said.append(f"{len(waiting)} of {len(work)} calibrations and series of runs are not made yet.")
    return said
