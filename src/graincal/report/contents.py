"""What stands in a report, from top to bottom."""

from __future__ import annotations

from graincal.campaign.found.emulated import Emulated
from graincal.campaign.found.findings import find, rule
from graincal.campaign.found.record import Record
from graincal.campaign.found.remarks import remarks
from graincal.drawing.figure import Figure
from graincal.inference.iterative.close_fits import close_fits
from graincal.notation.numbers import count, pressure
from graincal.report import error_terms, tables, verdict
from graincal.report.answer import as_samples
from graincal.report.command import simulate_command
from graincal.report.emulated_figures import draw_bands, draw_emulated_pairs, draw_emulator
from graincal.report.first_screen import compose_first_screen
from graincal.report.page import Page
from graincal.report.pairs import draw_pairs
from graincal.report.prediction import OtherPressure, draw_other_pressure
from graincal.report.responses import draw_fabric, draw_responses
from graincal.report.run_times import draw_run_times, stopped_sentence, where_failed
from graincal.report.sampling import draw_convergence, draw_samples
from graincal.report.stress_paths import draw_stress_paths
from graincal.report.words import cautions, errors_rule, found


def figures(result: Record, prediction: OtherPressure | None = None) -> list[Figure]:
    """All figures that a result has."""
    return _figures(result, prediction, Emulated.of(result))


def _figures(result: Record, prediction: OtherPressure | None, emulated: Emulated | None) -> list[Figure]:
    if emulated:
        drawn = [
            draw_bands(emulated),
            draw_samples(result),
            draw_emulator(emulated),
            draw_emulated_pairs(emulated),
            draw_stress_paths(result, emulated),
            draw_fabric(result),
            draw_run_times(result),
        ]
    elif result.has_posterior:
        drawn = [draw_samples(result), draw_stress_paths(result), draw_run_times(result)]
    else:
        drawn = [draw(result) for draw in (draw_responses, draw_samples, draw_convergence, draw_pairs, draw_stress_paths, draw_fabric, draw_run_times)]
    return [figure for figure in (*drawn, draw_other_pressure(prediction)) if figure]


def compose(result: Record, prediction: OtherPressure | None) -> Page:
    """The report of a result: the first screen, and behind it everything else, folded."""
    emulated = Emulated.of(result)
    drawn = {figure.name: figure for figure in _figures(result, prediction, emulated)}
    page = Page("Calibration report", f"{', '.join(experiment.name for experiment in result.experiments)}. {tables.origin(result)}")
    compose_first_screen(page, result, emulated, drawn.get("responses"))
    _compose_words(page, result, emulated)
    _compose_posterior(page, result, emulated, drawn.get("posterior"))
    if prediction:
        _compose_prediction(page, result, prediction, drawn.get("prediction"))
    for name, heading, sentence in (
        ("stress_paths", "Stress paths and pore pressure", "The undrained tests in p′ and q."),
        ("fabric", "Fabric", "Contacts and their directions, of the answer or the best response."),
    ):
        if name in drawn:
            with page.folded(heading, sentence):
                page.figure(drawn[name])
    _compose_runs(page, result, drawn)
    if emulated:
        with page.folded("Evidence", "How probable the model makes the reference, to compare models with each other."):
            page.paragraph([verdict.evidence(emulated)])
    with page.folded("Method", "What the words and the figures mean, and by which rules."):
        for rule in _rules(result, emulated):
            page.paragraph([rule])
    with page.folded("Provenance", "What was compared with what, and what it was computed with."):
        page.table(tables.of_experiments(result))
        page.table(tables.of_provenance(result))
    return page


def _compose_words(page: Page, result: Record, emulated: Emulated | None) -> None:
    """What was found in sentences, doubts among them."""
    findings = () if result.has_posterior else find(result.space, result.iterations, result.truth)
    with page.folded("What was found", "Each parameter, the fit, the doubts and the end of the campaign, in sentences."):
        said = verdict.found(result, emulated) if result.has_posterior else found(result, findings)
        # The evidence has a section of its own.
        page.items(each for each in said if each[0] != "Evidence")
        page.paragraph(() if result.has_posterior else cautions(result), "note")
        page.paragraph(() if result.has_posterior else [each.text for each in remarks(result, None)], "note")


def _compose_posterior(page: Page, result: Record, emulated: Emulated | None, pairs: Figure | None) -> None:
    """The parameters in numbers and in pairs."""
    with page.folded("Parameters", "Ranges, intervals and moments, and what they rest on."):
        if emulated:
            _compose_identified(page, result, emulated)
        elif not result.has_posterior:
            page.table(tables.of_parameters(result, find(result.space, result.iterations, result.truth)))
            page.paragraph(tables.of_prior(result), "note")
            if groups := tables.of_groups(result):
                page.paragraph(["Groups of parameter values among which the weight is divided:"])
                page.table(groups)
    if pairs:
        with page.folded("Pairs", "Which parameters trade off against each other."):
            page.figure(pairs)


_ALONE_TELLS_MORE = "Where one alone gives less than all, it singles out values that the others speak against, or too few runs are known there. Together they leave more values possible."


def _compose_identified(page: Page, result: Record, emulated: Emulated) -> None:
    """The tables of the method "posterior"."""
    page.table(tables.of_identified(emulated, verdict.verdicts(emulated)))
    page.paragraph(tables.of_prior(result), "note")
    page.paragraph([verdict.fits_rule(emulated.fits)], "note")
    if informing := tables.of_informing(emulated):
        page.paragraph(
            ["Which observable informs which parameter: the posterior's sd over the prior's, had the others not been measured. The smaller, the more it tells."]
        )
        page.table(informing)
        if tables.tells_more_alone(emulated):
            page.paragraph([_ALONE_TELLS_MORE], "note")
    taken = error_terms.error_terms(emulated)
    page.paragraph([f"How large each term of the errors was taken. {error_terms.sentence(emulated, taken)}"])
    page.table(error_terms.table(emulated, taken))
    if terms := tables.of_terms(emulated):
        page.paragraph(["What the intervals would be if less were counted: were the model able to reproduce the test, and were all packings alike."])
        page.table(terms)
    if modes := tables.of_modes(emulated):
        page.paragraph(["Modes, the separate groups of values among which the probability is divided:"])
        page.table(modes)


def _compose_prediction(page: Page, result: Record, prediction: OtherPressure, figure: Figure | None) -> None:
    """The test at another pressure."""
    what = f"{len(prediction.drawn.theta)} simulations by the posterior" if prediction.drawn else "One simulation of the answer"
    with page.folded(
        f"Prediction at {pressure(prediction.test.confining_pressure)}", f"{what} at another confining pressure, which no test was compared with."
    ):
        if figure:
            page.figure(figure)
        page.paragraph([prediction.missing], "note")
        page.paragraph(["The answer alone, once more:"] if prediction.drawn else ())
        page.command(simulate_command(prediction.test, as_samples(result, prediction.candidate, prediction.experiment), prediction.experiment.reference))


def _compose_runs(page: Page, result: Record, drawn: dict[str, Figure]) -> None:
    """Where the runs went, what they took, and which failed."""
    failed = f"{count(result.failures, 'run')} of them failed" if result.failures else "none failed"
    with page.folded("Where the runs went", f"{count(result.evaluations, 'run')}; {failed}."):
        for name in ("samples", "convergence", "emulator"):
            if name in drawn:
                page.figure(drawn[name])
        page.table(tables.of_batches(result) if result.has_posterior else tables.of_iterations(result))
        page.paragraph([verdict.effective_runs()] if result.has_posterior else (), "note")
        if "run_times" in drawn:
            page.figure(drawn["run_times"])
        if stopped := stopped_sentence(result):
            page.paragraph([stopped])
        if failures := tables.of_failures(result):
            page.paragraph([where_failed(result)])
            page.table(failures)


def _rules(result: Record, emulated: Emulated | None) -> list[str]:
    """What the words mean."""
    if emulated:
        return [verdict.rule(result.space), verdict.emulator_rule(), errors_rule()]
    findings = () if result.has_posterior else find(result.space, result.iterations, result.truth)
    close = close_fits(result.iterations)
    return [*([rule(findings, close)] if findings and close is not None else []), errors_rule()]
