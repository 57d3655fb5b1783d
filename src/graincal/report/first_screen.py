"""What a reader sees first: how far the campaign is, the curves, the answer with its interval, and the lines that use it."""

from __future__ import annotations

import os

from graincal.campaign.asked.file_names import file_name
from graincal.campaign.found.emulated import Emulated
from graincal.campaign.found.export_contact import PROGRAMS, contact_texts
from graincal.campaign.found.next_command import next_command, what_it_does
from graincal.campaign.found.record import Record
from graincal.campaign.found.remarks import remarks
from graincal.campaign.found.summary import summarise
from graincal.campaign.found.trust import has_settled
from graincal.drawing.figure import Figure
from graincal.inference.sampling.posterior import PROBABILITY
from graincal.models import StressPathTest
from graincal.notation import numbers
from graincal.report.answer import answer_of, as_samples, name_of_answer
from graincal.report.command import PLACEHOLDER, comparison, from_file, pack_command, simulate_command
from graincal.report.page import Page
from graincal.report.tables import Table

_DOUBTS = 2
"""As many doubts as stand on the first screen; all stand below."""
_FIRST, _BEYOND = "answer-far", "answer-outside-interval"
_TITLES = {"yade": "YADE", "lammps": "LAMMPS", "pfc": "PFC"}


def compose_first_screen(page: Page, result: Record, emulated: Emulated | None, curves: Figure | None) -> None:
    """The first screen of a report."""
    with page.group("state"):
        word, *more = state(result)
        page.paragraph([word], "word")
        page.paragraph(more)
        page.notes(doubts(result, emulated))
        if command := command_from_anywhere(result):
            page.paragraph([f"{what_it_does(result.stopped_by).capitalize()}:"])
            page.command(command)
    if curves:
        page.figure(curves, leads=True)
    with page.group("answer"):
        with page.group("values"):
            page.heading(
                f"The {'answer' if result.answer else name_of_answer(result)} and its {100 * PROBABILITY:.0f} % interval" if result.posterior else "Parameters"
            )
            page.table(of_answer(result, emulated))
            if result.answer:
                page.paragraph([_answer_and_interval(result)], "note")
        _compose_lines(page, result)


def state(result: Record) -> list[str]:
    """How far the campaign is, in short sentences."""
    summary, grade = summarise(result, None), result.grade
    said = [summary.state, *([f"Grade: {grade.word}."] if grade else [])]
    failed = f"{result.failures:,}".replace(",", "\u202f") if result.failures else "none"
    said.append(f"{numbers.count(result.evaluations, 'evaluation')}, {failed} failed.")
    if answer := answer_of(result):
        error = (
            f"{numbers.repeated(result.answer.mean, result.answer.spread)} %" if result.answer and len(result.answer.samples) else numbers.percent(answer.error)
        )
        said.append(f"Error ε of the {name_of_answer(result)}: {error} of the reference.")
    return said


def doubts(result: Record, emulated: Emulated | None) -> list[str]:
    """Why not to trust it, the first few."""
    # That the posterior has not settled is the state, which stands before; an answer beyond its interval is said below both.
    elsewhere = ("preliminary", _BEYOND)
    said = [each for each in remarks(result, emulated.known if emulated else None) if each.level == "doubt" and each.code not in elsewhere]
    found = [each.text for each in sorted(said, key=lambda each: each.code != _FIRST)]
    more = len(found) - _DOUBTS
    return found[:_DOUBTS] + ([f"{numbers.count(more, 'more doubt')}, under “What was found”."] if more > 0 else [])


def _answer_and_interval(result: Record) -> str:
    """How the two come to differ, and where the one is beyond the other."""
    said = "The answer fits best under the errors of measurement alone. The interval counts all errors, so the answer need not lie in its middle."
    beyond = [remark.text for remark in remarks(result) if remark.code == _BEYOND]
    return " ".join([said, *beyond])


def command_from_anywhere(result: Record) -> str | None:
    """The command that goes on with a campaign, from anywhere; None where there is none, or the campaign is kept in memory."""
    return next_command(os.path.abspath(result.folder), result.calibration, result.stopped_by) if result.folder else None


def of_answer(result: Record, emulated: Emulated | None) -> Table:
    """Each parameter with its unit: the answer, its interval, and what informs it. A logarithm of a stiffness has the stiffness in GPa below it."""
    summary = summarise(result, emulated)
    so_far = "" if has_settled(result) or not result.has_posterior else " so far"
    head = ["parameter", "answer", f"{100 * PROBABILITY:.0f} % interval{so_far}", "informed by"]
    rows = [(each.quantity.axis, each.answer, each.interval, each.informed_by) for each in summary.rows]
    known = [column for column in range(4) if column < 2 or any(row[column] != "–" for row in rows)]
    return Table(tuple(head[column] for column in known), tuple(tuple(row[column] for column in known) for row in rows), figures=1)


def _compose_lines(page: Page, result: Record) -> None:
    """The lines that use the answer, in each experiment with a built-in test."""
    tests = [(experiment, experiment.model) for experiment in result.experiments if isinstance(experiment.model, StressPathTest)]
    candidate = answer_of(result)
    if not tests or candidate is None:
        return
    with page.group("lines"):
        page.heading("Simulate it again")
        titles = " and ".join(dict.fromkeys(model.title for _, model in tests))
        page.paragraph([f"The {name_of_answer(result)} in the built-in {titles}, to paste into a terminal:"])
        for experiment, model in tests:
            output = f"curve-{file_name(experiment.name)}.csv" if len(tests) > 1 else "curve.csv"
            page.command(simulate_command(model, as_samples(result, candidate, experiment), experiment.reference, comparison(result, experiment), output))
        _compose_packings(page, result)
        for program in PROGRAMS:
            texts = (
                dict.fromkeys(contact_texts(result, candidate.theta, name_of_answer(result), program).values()) if len(tests) == len(result.experiments) else ()
            )
            if texts:
                with page.folded(f"Lines for {_TITLES[program]}", level=3):
                    page.paragraph([f"Not printed: the page itself has these lines, and graincal export --to {program} writes them to a file."], "on-paper")
                    for text in texts:
                        page.lines(text)


def _compose_packings(page: Page, result: Record) -> None:
    """Where the packings of these lines are from."""
    tests = [(experiment, experiment.model) for experiment in result.experiments if isinstance(experiment.model, StressPathTest)]
    packed = {experiment.name: line for experiment, _ in tests if (line := pack_command(experiment, result.calibration.source))}
    unnamed = not all(from_file(model) or experiment.name in packed for experiment, model in tests)
    with page.folded("Its packing, and its scatter", level=3):
        page.paragraph(
            [
                "A second run differs from that of the calibration by the scatter of runs, and so does the error that it prints: a last digit sends grains other ways."
            ],
            "note",
        )
        for line in dict.fromkeys(packed.values()):
            names = ", ".join(name for name in packed if packed[name] == line)
            page.paragraph([f"The packing of {names} was prepared. Should its file not be there, this makes the same again, to name instead:"])
            page.command(line)
        if unnamed:
            page.paragraph([f"Put the name of the packing's file in place of {PLACEHOLDER}: this packing was not read from one."], "note")
