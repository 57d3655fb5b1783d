"""What stands in a report, from top to bottom."""

from __future__ import annotations

from collections.abc import Callable

from graincal.campaign.found.emulated import Emulated
from graincal.campaign.found.findings import find, rule
from graincal.campaign.found.record import Record
from graincal.campaign.found.remarks import remarks
from graincal.drawing.figure import Figure
from graincal.inference.iterative.close_fits import close_fits
from graincal.models import StressPathTest
from graincal.notation.numbers import pressure
from graincal.report import error_terms, tables, verdict
from graincal.report.answer import answer_of, as_samples, name_of_answer
from graincal.report.command import PLACEHOLDER, comparison, from_file, pack_command, simulate_command
from graincal.report.emulated_figures import draw_bands, draw_emulated_pairs, draw_emulator
from graincal.report.page import Page
from graincal.report.pairs import draw_pairs
from graincal.report.prediction import Prediction, draw_prediction
from graincal.report.responses import draw_fabric, draw_responses
from graincal.report.run_times import draw_run_times, stopped_sentence, where_failed
from graincal.report.sampling import draw_convergence, draw_samples
from graincal.report.words import cautions, errors_rule, found


def figures(result: Record, prediction: Prediction | None = None) -> list[Figure]:
    """All figures that a result has."""
    return _figures(result, prediction, Emulated.of(result))


def _figures(result: Record, prediction: Prediction | None, emulated: Emulated | None) -> list[Figure]:
    if emulated:
        drawn = [draw_bands(emulated), draw_samples(result), draw_emulator(emulated), draw_emulated_pairs(emulated), draw_fabric(result), draw_run_times(result)]
    elif result.has_posterior:
        drawn = [draw_samples(result), draw_run_times(result)]
    else:
        drawn = [draw(result) for draw in (draw_responses, draw_samples, draw_convergence, draw_pairs, draw_fabric, draw_run_times)]
    return [figure for figure in (*drawn, draw_prediction(prediction)) if figure]


def compose(result: Record, prediction: Prediction | None) -> Page:
    """The report of a result."""
    emulated = Emulated.of(result)
    drawn = {figure.name: figure for figure in _figures(result, prediction, emulated)}
    page = Page("Calibration report", f"{', '.join(experiment.name for experiment in result.experiments)}. {tables.origin(result)}")

    def figure_of(name: str, heading: str = "") -> None:
        if name in drawn:
            if heading:
                page.heading(heading)
            page.figure(drawn[name])

    page.heading("What was found")
    if result.has_posterior:
        _compose_posterior(page, result, emulated, figure_of)
    else:
        _compose_iterations(page, result, figure_of)
    figure_of("fabric", "Fabric")
    page.heading("Run times and failures")
    figure_of("run_times")
    if stopped := stopped_sentence(result):
        page.paragraph([stopped])
    if failures := tables.of_failures(result):
        page.paragraph([where_failed(result)])
        page.table(failures)
    _simulate_again(page, result)
    if prediction:
        page.heading(f"Prediction at {pressure(prediction.test.confining_pressure)}")
        figure_of("prediction")
        page.paragraph([prediction.missing], "note")
        page.command(simulate_command(prediction.test, as_samples(result, prediction.candidate, prediction.experiment), prediction.experiment.reference))
    page.heading("Provenance")
    page.table(tables.of_experiments(result))
    page.table(tables.of_provenance(result))
    return page


def _compose_posterior(page: Page, result: Record, emulated: Emulated | None, figure_of: Callable[..., None]) -> None:
    """What the method "posterior" found."""
    page.items(verdict.found(result, emulated))
    if emulated:
        page.paragraph([verdict.rule(result.space)], "note")
        page.paragraph([verdict.emulator_rule()], "note")
    page.paragraph([errors_rule()], "note")
    figure_of("responses", "Reference and responses")
    if emulated:
        page.heading("Parameters")
        page.table(tables.of_identified(emulated, verdict.verdicts(emulated)))
        page.paragraph(tables.of_prior(result), "note")
        page.paragraph([verdict.fits_rule(result.fits_about_as_well)], "note")
        if informing := tables.of_informing(emulated):
            page.paragraph(["Which observable informs which parameter: the posterior's sd over the prior's, had the others not been measured. The smaller, the more it tells."])
            page.table(informing)
        taken = error_terms.error_terms(emulated)
        page.paragraph([f"How large each term of the errors was taken. {error_terms.sentence(emulated, taken)}"])
        page.table(error_terms.table(emulated, taken))
        if terms := tables.of_terms(emulated):
            page.paragraph(["What the intervals would be if less were counted: were the model able to reproduce the test, and were all packings alike."])
            page.table(terms)
        if modes := tables.of_modes(emulated):
            page.paragraph(["Modes, the separate groups of values among which the probability is divided:"])
            page.table(modes)
    figure_of("posterior", "Posterior")
    page.heading("Evaluations and emulator")
    figure_of("samples")
    figure_of("emulator")
    page.table(tables.of_batches(result))
    page.paragraph([verdict.effective_runs()], "note")


def _compose_iterations(page: Page, result: Record, figure_of: Callable[..., None]) -> None:
    """What the paper's method found."""
    findings = find(result.space, result.iterations, result.truth)
    page.items(found(result, findings))
    page.paragraph(cautions(result), "note")
    page.paragraph([each.text for each in remarks(result, None)], "note")
    page.paragraph([rule(findings, close_fits(result.iterations))] if findings else [], "note")
    page.paragraph([errors_rule()], "note")
    figure_of("responses", "Reference and responses")
    page.heading("Iterations")
    figure_of("samples")
    figure_of("convergence")
    page.table(tables.of_iterations(result))
    figure_of("posterior", "Posterior")
    page.heading("Parameters")
    page.table(tables.of_parameters(result, findings))
    page.paragraph(tables.of_prior(result), "note")
    if groups := tables.of_groups(result):
        page.paragraph(["Groups of parameter values among which the weight is divided:"])
        page.table(groups)


def _simulate_again(page: Page, result: Record) -> None:
    """The lines that simulate the answer again in each experiment with a built-in test."""
    tests = [experiment for experiment in result.experiments if isinstance(experiment.model, StressPathTest)]
    candidate = answer_of(result)
    if not tests or candidate is None:
        return
    page.heading("Simulate it again")
    titles = " and ".join(dict.fromkeys(experiment.model.title for experiment in tests))
    page.paragraph([f"The {name_of_answer(result)} in the built-in {titles}, to paste into a terminal:"])
    for experiment in tests:
        page.command(simulate_command(experiment.model, as_samples(result, candidate, experiment), experiment.reference, comparison(result, experiment)))
    page.paragraph(["A second run differs from that of the calibration by the scatter of runs, and so does the error that it prints: a last digit sends grains other ways."], "note")
    packed = {experiment.name: line for experiment in tests if (line := pack_command(experiment, result.calibration.source))}
    for line in dict.fromkeys(packed.values()):
        names = ", ".join(name for name in packed if packed[name] == line)
        page.paragraph([f"The packing of {names} was prepared. Should its file not be there, this makes the same again, to name instead:"])
        page.command(line)
    if not all(from_file(experiment.model) or experiment.name in packed for experiment in tests):
        page.paragraph([f"Put the name of the packing's file in place of {PLACEHOLDER}: this packing was not read from one."], "note")
