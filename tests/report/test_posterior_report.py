"""The report of the method "posterior": what it says against what is known, and what it draws."""

import json
from copy import copy
from dataclasses import replace

import numpy as np
import pytest

import graincal as gc
from graincal.campaign.found.emulated import Emulated
from graincal.campaign.found.remarks import remarks
from graincal.campaign.found.scatter import Scatter
from graincal.drawing import with_matplotlib
from graincal.drawing.figure import Band, Points
from graincal.inference.likelihood.likelihood import ReducedLikelihood
from graincal.report import error_terms, first_screen, summarise, tables, verdict, write_report
from graincal.report.contents import figures
from graincal.report.emulated_figures import draw_bands, draw_emulated_pairs

from . import soil, test_report
from .test_report import read

ERRORS = {"stress_ratio": 0.03, "volumetric_strain": 5e-4}


pytestmark = pytest.mark.usefixtures("fewer_draws")


@pytest.fixture(scope="module")
def result():
    reference = gc.Reference(soil.STRAIN, soil.reference().observables, measurement_errors=ERRORS)
    options = {"method": "posterior", "seed": 3, "workers": 1, "stop": gc.Stop(max_iterations=2), "discrepancy": False}
    return gc.calibrate(gc.PythonModel(soil.respond), reference, soil.SPACE, truth={"phi": 30.0}, **options)


@pytest.fixture(scope="module")
def emulated(result):
    return Emulated.of(result)


def settled(result):
    """The result, had its posterior settled."""
    other = copy(result)
    other.stopped_by = "posterior_shift"
    return other


def test_it_says_which_parameters_are_identified_once_it_has_settled(result, emulated):
    # Stress tells phi alone, volume psi alone, nothing the third.
    known = Emulated(settled(result), emulated.emulation)
    assert verdict.verdicts(known) == ("identified", "identified", "not identified")
    assert "Identified: φ and ψ. Not identified: η_{m}." in dict(verdict.found(known.result, known))["Identifiability"]
    assert verdict.verdicts(emulated) == ("not settled",) * 3
    table = tables.of_identified(emulated, verdict.verdicts(emulated))
    assert not any("identified" in cell for row in (table.head, *table.rows) for cell in row) and "90 % interval so far" in table.head
    assert "90 % interval" in tables.of_identified(known, verdict.verdicts(known)).head
    assert emulated.shrinkage[2] == pytest.approx(1, abs=0.15)
    stress, volume = emulated.alone[0, "stress_ratio"], emulated.alone[0, "volumetric_strain"]
    assert stress[0] < 0.1 < 0.8 < volume[0] and volume[1] < 0.1 < 0.8 < stress[1]


def test_bands_hold_the_responses_and_the_measurements(emulated):
    (bands,) = emulated.bands
    reference = emulated.result.experiments[0].reference
    inside = (bands.measurement[0] <= reference.values) & (reference.values <= bands.measurement[1])
    # The reference is the truth itself, without error.
    assert inside.all()
    width = bands.measurement[1] - bands.measurement[0]
    assert np.all(width >= 0.95 * (bands.response[1] - bands.response[0]))
    # Nine tenths of a Gaussian lie within 1.64 standard deviations; the ends of 500 draws scatter by 6 % of one.
    for place, error in enumerate(ERRORS.values()):
        assert np.all(width[:, place] > 2 * 1.64 * error * 0.8)


def test_the_report_has_the_verdict_first_and_nothing_of_the_paper_s_method(result, tmp_path):
    page = read(write_report(result, tmp_path / "report.html"))
    text = "".join(page.text)
    assert page.headings[0].startswith("The answer's responses are ") and "The answer and its 90 % interval" in page.headings
    assert page.headings[-8:] == ["What was found", "Parameters", "Pairs", "Fabric", "Where the runs went", "Evidence", "Method", "Provenance"]
    for words in (
        "φ, so far: ",
        "cannot be said yet",
        "Runs that fit about as well: ",
        "runs that fit",
        "The truth, 30 deg, lies in the interval.",
        "3 runs at the answer, a millionth of the ranges apart, are",
        "give the same curve: the model does not scatter",
        "log p(reference) =",
        "Hartmann, Cheng and Thornton (2022)",
    ):
        assert words in text, words
    assert not any(words in text for words in ("εGL", "covariance coefficient", "optimal", "percentage points above the smallest", "most probable sample"))
    assert page.loaded == []
    first, second = summarise(result).splitlines()[:2]
    assert first.startswith("Preliminary: the posterior has not settled.") and second.startswith("φ, so far: ")


def test_the_first_screen_has_the_state_the_answer_and_what_informs_it(result, emulated):
    assert first_screen.state(result)[0] == "Not settled: stopped by the limit on batches."
    assert first_screen.state(settled(result))[0] == "Settled."
    table = first_screen.of_answer(result, emulated)
    assert table.head == ("parameter", "answer", "90 % interval so far", "informed by")
    assert [row[0] for row in table.rows] == ["φ [deg]", "ψ [deg]", "η_{m} [-]"]
    assert [row[3] for row in table.rows] == ["stress ratio σ_{1}/σ_{3}", "volumetric strain", "not told yet"]
    known = first_screen.of_answer(settled(result), Emulated(settled(result), emulated.emulation))
    assert known.head[2] == "90 % interval" and [row[3] for row in known.rows][2] == "not informed"


def test_a_logarithm_of_a_stiffness_has_the_stiffness_beside_it():
    space = gc.ParameterSpace({"log_E": (7, 11)}, units={"log_E": "log10 Pa"})
    found = gc.calibrate(
        gc.PythonModel(lambda theta: {"stress_ratio": theta[0] * soil.STRAIN}),
        gc.Reference(soil.STRAIN, {"stress_ratio": 8.5 * soil.STRAIN}),
        space,
        **{"method": "iterative-bayesian", "alpha": 20, "stop": soil.STOP, "workers": 1},
    )
    logarithm, stiffness = first_screen.of_answer(found, None).rows
    assert stiffness[0] == "E [GPa]"
    low, high = ([float(end) for end in row[2].split(" to ")] for row in (logarithm, stiffness))
    np.testing.assert_allclose(np.log10(high) + 9, low, atol=0.02)
    # As in a notebook.
    assert [each.split()[0] for each in repr(found.summary()).splitlines()[2:]] == [
        "log",
        "E",
    ] and "<td>GPa</td><td>0.01 to 100</td>" in found.summary()._repr_html_()


def test_the_command_that_goes_on_is_said_where_a_limit_ended_it(result, tmp_path):
    assert first_screen.command_from_anywhere(result) is None
    stored = soil.calibrate(folder=tmp_path / "a campaign")
    assert first_screen.command_from_anywhere(stored) == f"graincal resume '{tmp_path / 'a campaign'}' --max-iterations 6"


def test_bands_that_coincide_are_said(emulated):
    assert "coincide" not in next(iter(figures(emulated.result))).caption
    wide = copy(emulated)
    (found,) = emulated.bands
    wide.__dict__["bands"] = (replace(found, response=found.measurement),)
    assert "In stress ratio σ_{1}/σ_{3} and volumetric strain the two nearly coincide" in draw_bands(wide).caption


def test_separate_modes_are_told_with_their_masses_and_best_fits(result, emulated):
    # Two clouds, of seven tenths of the probability and of three, whose most probable points are known.
    rng = np.random.default_rng(1)
    centres = np.array([[15.0, 8.0, 0.5], [50.0, 8.0, 0.5]])
    which = (np.arange(1000) >= 700).astype(int)
    theta = centres[which] + rng.normal(size=(1000, 3)) * [1.0, 0.5, 0.1]
    log_likelihood = -np.sum((theta - centres[which]) ** 2, axis=1)
    explored = replace(emulated.emulation.explored, theta=theta, log_likelihood=log_likelihood)
    posterior = gc.Posterior(soil.SPACE.names, theta, np.full(1000, 1e-3))
    apart = Emulated(result, replace(emulated.emulation, explored=explored))
    apart.posterior = posterior
    first, second = apart.modes
    assert (first.share, second.share) == pytest.approx((0.7, 0.3), abs=0.01)
    for mode, centre, rows in ((first, centres[0], which == 0), (second, centres[1], which == 1)):
        assert mode.centre == pytest.approx(centre, abs=0.3)
        np.testing.assert_array_equal(mode.best, theta[rows][np.argmax(log_likelihood[rows])])
    # The best run, at 30 degrees, is nearer to the first.
    assert first.error == result.best.error < second.error
    assert "2 separate groups of values, of 70 % and 30 %" in " ".join(text for _, said in verdict.found(result, apart) for text in said)
    table = tables.of_modes(apart)
    assert len(table.head) == len(table.rows[0]) == 5 and tables.of_modes(emulated) is None
    with_matplotlib.draw(draw_emulated_pairs(apart))


def test_every_figure_is_drawn_by_matplotlib_too(result):
    drawn = {figure.name: figure for figure in figures(result)}
    assert list(drawn) == ["responses", "samples", "emulator", "posterior", "fabric", "run_times"]
    for figure in drawn.values():
        with_matplotlib.draw(figure)
    stress = drawn["responses"].panels[0]
    assert [mark.name for mark in stress.marks if isinstance(mark, Band)] == ["90 % of measurements", "90 % of mean responses"]
    failed = [mark for mark in drawn["samples"].panels[0].marks if mark.name.startswith("failed")]
    assert sum(len(mark.x) for mark in failed if isinstance(mark, Points)) == result.failures


def test_the_table_shows_what_a_discrepancy_does(result, emulated):
    assert emulated.without_discrepancy is None
    allowed, known = copy(result), copy(result.knowledge)
    known.error_options = {**known.error_options, "discrepancy": True}
    known.errors = known.errors_if()
    allowed.__dict__["knowledge"] = known
    assert tables.of_terms(emulated) is None
    table = tables.of_terms(Emulated(allowed, emulated.emulation))
    assert len(table.head) == len(table.rows[0])
    # The emulation at hand has none either, and so the two columns say the same but for the draws.
    row = dict(zip(table.head, table.rows[0]))
    ends = [[float(end) for end in row[column].split(" to ")] for column in ("90 % interval", "without a discrepancy")]
    assert np.abs(np.subtract(*ends)).max() < 0.2 * np.ptp(ends[0])


def test_it_says_how_large_each_term_of_the_errors_was_taken(result, emulated):
    (terms,) = error_terms.error_terms(emulated)
    reference = result.experiments[0].reference
    peaks = np.abs(reference.values).max(axis=0)
    np.testing.assert_allclose(terms.deviations["measurement"], np.array([ERRORS[name] for name in reference.names]) / peaks, rtol=1e-3)
    assert list(terms.deviations) == ["measurement", "what the emulator's components leave out", "all together, as the curve makes them"]
    # The reference has no error at all, and the model can reproduce it.
    assert terms.residual < 0.5 and "is as much as the errors lead to" in error_terms.sentence(emulated, [terms])
    # What a discrepancy of two percent allows is counted, and three times as large an answer's error is not of size one.
    known, off = copy(result.knowledge), copy(result)
    known.error_options = {**known.error_options, "discrepancy": True}
    known.errors = known.errors_if()
    evaluations = known.evaluations
    known.evaluations = replace(evaluations, responses=tuple(responses + 0.5 * peaks for responses in evaluations.responses))
    off.__dict__["knowledge"] = known
    likelihood = replace(emulated.emulation.likelihoods[0], **hypotheses_of(known, emulated))
    (allowed,) = error_terms.error_terms(Emulated(off, replace(emulated.emulation, likelihoods=(likelihood,))))
    assert 0.01 <= allowed.discrepancy <= 0.04 and allowed.residual > 3
    assert list(allowed.deviations) == [
        "measurement",
        "what the model cannot reproduce",
        "what the emulator's components leave out",
        "all together, as the curve makes them",
    ]
    assert len(error_terms.table(emulated, [allowed]).rows) == 4


def hypotheses_of(known, emulated):
    """The likelihood under other hypotheses on the errors, of the same emulator."""
    emulator = emulated.emulation.emulators[0]
    return vars(ReducedLikelihood.of(known.kept[0], known.errors[0], emulator.centre, emulator.basis, emulator.added(False)))


def moved(iteration, theta):
    """The same, with all samples at theta."""
    samples = gc.Samples(iteration.samples.ids, np.tile(theta, (len(iteration.samples), 1)), iteration.samples.names)
    return replace(iteration, samples=samples)


def test_when_not_to_trust_it_is_said(result, emulated):
    def said(found=None, emulators=emulated.emulation.emulators, **changes):
        doubtful = copy(result)
        for name, value in {"found": replace(result.found, **found or {}), **changes}.items():
            setattr(doubtful, name, value)
        other = Emulated(doubtful, replace(emulated.emulation, emulators=emulators))
        return " ".join(each.text for each in remarks(doubtful, other.known))

    def off(percent):
        """The last runs, which are those at the answer, so much further from the reference."""
        return (*result.iterations[:-1], replace(result.iterations[-1], errors=result.iterations[-1].errors + percent))

    # Measurement errors alone lead to 5 %.
    assert "Nothing that was looked at speaks against it" in said(stopped_by="posterior_shift", iterations=off(5))
    assert "the errors look too large as they are stated" in said()
    theta = emulated.posterior.interval(0.9)[1] * 1.01
    assert "The answer lies outside the 90 % interval of φ" in said(iterations=(*result.iterations[:-1], moved(result.iterations[-1], theta)))
    assert "The emulator is rough: near the posterior it misses held-out runs by 30 %" in said({"held_out": (0.3,), "of_mean": (0.5,)})
    # Runs at one place that differ by so much explain it.
    scattering = said({"held_out": (0.3,), "of_mean": (0.5,)}, scatter=Scatter(0.056, 0.06))
    assert "The runs at the answer differ by 5.6 % of the peak" in scattering and "The emulator is rough" not in scattering
    assert "The emulator is rough" in said({"held_out": (0.3,), "of_mean": (0.5,)}, scatter=Scatter(0.01, 0.06))
    assert "The emulator predicts held-out runs no better than their mean does" in said({"held_out": (0.3,), "of_mean": (0.2,)})
    doubting = copy(emulated.emulation.emulators[0])
    doubting.inflation = 1e6 * doubting.inflation
    assert "100 % of the probability lies where too few runs were made" in said(emulators=(doubting,))
    assert "surer than it should be: 60 % of held-out runs" in said({"coverage": 0.6})
    assert "A few runs carry most of the weight" in said({"pareto_k": 0.9, "weights": np.full(300, 1 / 300)})
    assert "has not settled: the emulator predicts nothing by which to tell" in said({"of_mean": (0.0001,)}, stopped_by=None)
    assert "The posterior has not settled" in said(stopped_by=None, calibration=replace(result.calibration, stop=gc.Stop(posterior_shift=0)))
    assert "% of the evaluations failed" in said(failed=np.arange(len(result.failed)) % 2 == 0)
    assert "the model cannot reproduce the test that well" in said(iterations=off(60))


def test_a_standard_deviation_that_far_samples_make_is_explained(emulated):
    def said(samples):
        other, explored = copy(emulated.result), emulated.result.found.explored
        other.found = replace(emulated.result.found, explored=replace(explored, theta=samples, log_weights=np.zeros(len(samples))))
        return next(each.text for each in remarks(other) if each.numbers.get("parameter") == "phi")

    near = 30 + 0.1 * np.random.default_rng(1).standard_normal((len(emulated.posterior.samples), 3))
    far = near.copy()
    far[::25, 0] = 45.0
    assert "far from it" not in said(near) and "The sd is large beside the interval, for a small part of the probability lies far from it." in said(far)


def test_what_the_weights_of_the_runs_say_stands_beside_the_evidence(result, emulated):
    def evidence(weights):
        other = copy(emulated)
        other.emulation = replace(emulated.emulation, weights=weights, log_evidence_of_runs=1.25)
        return dict(verdict.found(result, other))["Evidence"][0]

    count = len(result.knowledge.evaluations)
    assert f"By the weights of the runs, worth {count} of equal weight, log p(reference) is 1.25, and means are at most" in evidence(np.full(count, 1 / count))
    # Of one run they say nothing.
    assert "By the weights of the runs" not in evidence(np.eye(count)[0])


def test_a_sample_that_is_closer_than_scatter_explains_is_not_called_lucky(result, emulated):
    # Runs at the answer that are 5 % from the reference and scatter by 0.1 %, where one of the batches before is next to none from it.
    last = result.iterations[-1]
    apart = copy(result)
    apart.iterations = (*result.iterations[:-1], replace(last, errors=np.array([4.9, 5.0, 5.1])))
    apart.errors = np.concatenate([iteration.errors for iteration in apart.iterations])
    said = dict(verdict.found(apart, emulated))["Answer"][0]
    assert f"Sample {apart.best.sample} is closer by ε" in said and "more than these runs scatter" in said and "chance" not in said


def test_what_may_yet_move_is_said_first(result, emulated):
    assert verdict.found(result, emulated)[0] == ("Caution", ("Preliminary: the posterior has not settled. What follows may yet move.",))
    assert verdict.found(settled(result), emulated)[0][0] == "Parameters"
    unsure = copy(emulated)
    unsure.__dict__["unsure"] = 0.97
    assert "97 % of the probability lies where too few runs were made: it may move by more than its intervals say." in verdict.found(result, unsure)[0][1][0]
    # What is known is not preliminary.
    assert verdict.found(settled(result), unsure)[0][0] == "Parameters"


def test_before_the_end_it_says_what_is_known_so_far(result, tmp_path):
    running = copy(result)
    running.iterations, running.learnt, running.stopped_by, running.stopped_because = result.iterations[:-1], result.learnt[:-1], None, None
    assert "It has not been run again yet." in summarise(running) and "Not at its end: 2 batches are complete" in summarise(running)
    write_report(running, tmp_path / "report.html")


@pytest.mark.parametrize("width", [1280, 390])
def test_a_browser_draws_it(width, request, tmp_path):
    test_report.test_a_browser_draws_it_without_a_network_an_error_or_a_scroll_to_the_side("result", width, request, tmp_path)


def test_without_a_response_nothing_is_found(tmp_path):
    never = gc.PythonModel(lambda theta: {"stress_ratio": np.nan})
    result = gc.calibrate(never, soil.reference(), soil.SPACE, method="posterior", workers=1)
    assert result.stopped_by == "failures" and result.posterior is None and result.answer is None
    assert "All 12 samples failed, so that nothing was found." in summarise(result)
    write_report(result, tmp_path / "report.html")


def test_figures_are_the_same_when_they_are_drawn_again(result):
    from graincal.drawing.with_plotly import describe

    once, again = (json.dumps([describe(panel) for panel in next(iter(figures(result))).panels]) for _ in range(2))
    assert once == again
