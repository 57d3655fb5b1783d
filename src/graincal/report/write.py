"""Writing a report, and its figures."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from graincal.campaign import FolderError, Result
from graincal.models import TriaxialTest
from graincal.report import tables, with_matplotlib
from graincal.report.command import PLACEHOLDER, from_file, simulate_command
from graincal.report.drawing import Figure
from graincal.report.findings import find, rule
from graincal.report.numbers import pressure
from graincal.report.page import Page
from graincal.report.pairs import draw_pairs
from graincal.report.prediction import Prediction, answer_of, draw_prediction, predict_response, samples_of
from graincal.report.responses import draw_fabric, draw_responses
from graincal.report.run_times import draw_run_times, where_failed
from graincal.report.sampling import draw_convergence, draw_samples
from graincal.report.words import cautions, found

PREDICTED = 2.0
"""The confining pressure of the prediction, as a multiple of the calibration's."""


def write_report(result: Result, path: str | Path, *, predict: float | None = PREDICTED) -> Path:
    """Write what was found as one HTML file, readable without a network, and return its path. A file that is there is replaced once all is written.

    predict: simulate the most probable sample once more at so many times the confining pressure, in the triaxial experiment of the highest one; it
    takes as long as one evaluation, and is left out where that took longer than two minutes. None leaves it out in any case.
    Raises FolderError where the file cannot be written.
    """
    path = Path(path)
    page = _page(result, predict_response(result, predict))
    unfinished = path.with_name(f".{path.name}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        unfinished.write_text(page.render(), encoding="utf-8")
        os.replace(unfinished, path)
    except OSError as error:
        unfinished.unlink(missing_ok=True)
        raise FolderError.of(path, error) from error
    return path


def write_figures(result: Result, folder: str | Path, formats: Sequence[str] = ("png", "pdf"), *, predict: float | None = PREDICTED) -> list[Path]:
    """Write the report's figures by Matplotlib, to print, and return the files' paths: `responses.png`, `responses.pdf`, ...

    formats: any that Matplotlib writes. predict: as in `write_report`. Raises FolderError where a file cannot be written.
    """
    folder = Path(folder)
    paths = []
    for figure in figures(result, predict_response(result, predict)):
        for suffix in formats:
            path = folder / f"{figure.name}.{suffix}"
            try:
                folder.mkdir(parents=True, exist_ok=True)
                with_matplotlib.save(figure, path)
            except OSError as error:
                raise FolderError.of(path, error) from error
            paths.append(path)
    return paths


def figures(result: Result, prediction: Prediction | None = None) -> list[Figure]:
    """All figures that a result has, in the order of the report."""
    drawn = [draw(result) for draw in (draw_responses, draw_samples, draw_convergence, draw_pairs, draw_fabric, draw_run_times)]
    return [figure for figure in (*drawn, draw_prediction(prediction)) if figure]


def _page(result: Result, prediction: Prediction | None) -> Page:
    drawn = {figure.name: figure for figure in figures(result, prediction)}
    findings = find(result.space, result.iterations)
    page = Page("Calibration report", f"{', '.join(experiment.name for experiment in result.experiments)}. {tables.origin(result)}")

    def section(heading: str, *names: str) -> None:
        page.heading(heading)
        for name in names:
            if name in drawn:
                page.figure(drawn[name])

    section("What was found")
    page.items(found(result))
    page.paragraph(cautions(result), "note")
    page.paragraph([rule(findings)] if findings else [], "note")
    if "responses" in drawn:
        section("Reference and responses", "responses")
    section("Iterations", "samples", "convergence")
    page.table(tables.of_iterations(result))
    if "posterior" in drawn:
        section("Posterior", "posterior")
    section("Parameters")
    page.table(tables.of_parameters(result, findings))
    if "fabric" in drawn:
        section("Fabric", "fabric")
    section("Run times and failures", "run_times")
    if failures := tables.of_failures(result):
        page.paragraph([where_failed(result)])
        page.table(failures)
    _again(page, result)
    if prediction:
        section(f"Prediction at {pressure(prediction.test.confining_pressure)}", "prediction")
        page.paragraph([prediction.missing], "note")
        page.command(simulate_command(prediction.test, samples_of(result, prediction.candidate), prediction.experiment.reference))
    section("Provenance")
    page.table(tables.of_experiments(result))
    page.table(tables.of_provenance(result))
    return page


def _again(page: Page, result: Result) -> None:
    """The lines that simulate the answer again in each triaxial experiment."""
    tests = [experiment for experiment in result.experiments if isinstance(experiment.model, TriaxialTest)]
    candidate = answer_of(result)
    if not tests or candidate is None:
        return
    page.heading("Simulate it again")
    word = "most probable" if result.most_probable else "best"
    page.paragraph([f"The {word} sample in the built-in triaxial test, as command lines to paste:"])
    for experiment in tests:
        page.command(simulate_command(experiment.model, samples_of(result, candidate), experiment.reference))
    if not all(from_file(experiment.model) for experiment in tests):
        page.paragraph([f"Put the name of the packing's file in place of {PLACEHOLDER}: this packing was not read from one."], "note")
