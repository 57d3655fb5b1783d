"""What packings differ by, as a part of a campaign: run once, kept, and found again by whoever goes on with it."""

from __future__ import annotations

import threading

import numpy as np
import pytest

import graincal as gc
from graincal.campaign.asked.calibration import Calibration
from graincal.campaign.file.doubts import doubts
from graincal.campaign.found.packings import STUDY
from graincal.campaign.found.status import status
from graincal.campaign.stored.store import Store
from graincal.data import InputError
from graincal.inference.likelihood.packings import PLACES, REPEATED, SIBLINGS
from graincal.models import StressPathTest
from graincal.report import prediction

from . import frictional
from .as_tasks import as_tasks

pytestmark = pytest.mark.usefixtures("fewer_draws")

TRUTH = (32.0, 0.3)
ERRORS = {"stress_ratio": 0.01, "volumetric_strain": 3e-4}
SPACE = gc.ParameterSpace({"phi": (10, 50), "eta_m": (0, 1)}, units={"phi": "deg"})
# Of two runs of some siblings at each place.
RUNS = PLACES * (SIBLINGS + REPEATED)
FIXED = {"log_E": 8, "nu": 0.2, "beta_m": 0.1}


@pytest.fixture
def engine(monkeypatch):
    """A soil in closed form, whose siblings have other frictions; `runs` counts the evaluations on these, `prepared` how often they were asked for, and `breaks_at` ends the process' patience."""

    class Engine:
        runs = prepared = 0
        breaks_at = np.inf

    lock = threading.Lock()

    def respond(test, sample, at):
        response = frictional.respond(test, sample, at)
        if len(test.packings) == SIBLINGS:
            with lock:
                Engine.runs += 1
                if Engine.runs > Engine.breaks_at:
                    raise KeyboardInterrupt
            stress = 1 + (response.values["stress_ratio"] - 1) * (1 + 0.05 * (int(sample.ids[0]) % SIBLINGS - 2.5))
            response = gc.Response(response.control, {**response.values, "stress_ratio": stress}, response.details)
        return response

    def on_siblings(packing, count, threads=1, prepared=lambda number: None):
        Engine.prepared += 1
        for number in range(count):
            prepared(number + 1)
        return [packing] * count

    monkeypatch.setattr(StressPathTest, "tasks", as_tasks(respond))
    monkeypatch.setattr("graincal.models.stress_path.siblings", on_siblings)
    return Engine


def calibrate(folder=None, **options):
    test = gc.TriaxialTest(frictional.packing(), 0.5e6, fixed=FIXED)
    reference = gc.Reference(frictional.STRAIN, frictional.curves(*TRUTH), measurement_errors=ERRORS)
    return gc.calibrate(test, reference, SPACE, folder=folder, **{"seed": 1, "workers": 1, "first_batch": 8, "stop": gc.Stop(max_iterations=2)} | options)


def test_how_many_packings_are_prepared_is_said_now_and_then(engine, tmp_path, monkeypatch):
    monkeypatch.setattr("graincal.campaign.run.packing_study.SAID_EVERY", 0.0)
    calibrate(tmp_path / "campaign")
    log = (tmp_path / "campaign" / "log.txt").read_text()
    assert [f"{number} of {SIBLINGS} packings are prepared." in log for number in range(1, SIBLINGS + 1)] == [True] * SIBLINGS


def test_it_is_run_once_and_counted_beside_the_evaluations(engine, tmp_path):
    result = calibrate(tmp_path / "campaign")
    assert engine.runs == RUNS and engine.prepared == 1
    assert result.evaluations == len(result.samples) == status(tmp_path / "campaign")["evaluations"] and result.ids.min() == 0
    (scatter,) = result.knowledge.packings
    assert result.learnt[-1].siblings == (scatter.packings,) == (SIBLINGS,) and result.learnt[-1].apart == (scatter.apart,)
    # Six strengths from 0.875 to 1.125 of the own one, at each of the places: the same at each of them.
    last = frictional.STRAIN[-1] * np.unique(result._store.samples(STUDY).theta[:, 0]) / 10
    assert np.sqrt(scatter.covariance[19, 19]) == pytest.approx(np.std(0.05 * np.arange(6), ddof=1) * np.sqrt(np.mean(last**2)), rel=0.1)
    alone = calibrate(packing_scatter=False)
    assert engine.runs == RUNS
    assert result.posterior.std()[0] > 1.5 * alone.posterior.std()[0]
    again = gc.Result.read(tmp_path / "campaign")
    np.testing.assert_array_equal(again.knowledge.packings[0].covariance, scatter.covariance)
    np.testing.assert_array_equal(again.posterior.weights, result.posterior.weights)


@pytest.mark.parametrize("ahead", [0, 1])
def test_broken_off_within_it_a_campaign_ends_as_if_it_never_was(engine, tmp_path, ahead):
    whole = calibrate(ahead=ahead)
    engine.runs, engine.breaks_at = 0, 5
    with pytest.raises(KeyboardInterrupt):
        calibrate(tmp_path / "campaign", ahead=ahead)
    engine.breaks_at = np.inf
    resumed = gc.resume(tmp_path / "campaign")
    # The five that had ended are kept.
    assert engine.runs == 6 + RUNS - 5
    np.testing.assert_array_equal(resumed.samples, whole.samples)
    np.testing.assert_array_equal(resumed.posterior.samples, whole.posterior.samples)
    np.testing.assert_array_equal(resumed.posterior.weights, whole.posterior.weights)


def test_a_study_of_an_earlier_version_is_refused_in_words(engine, tmp_path):
    calibrate(tmp_path / "campaign")
    with Store.open(tmp_path / "campaign").database.transaction() as db:
        db.execute("DELETE FROM evaluation WHERE sample < -18")
        db.execute("DELETE FROM sample WHERE id < -18")
    with pytest.raises(
        InputError, match="an earlier version of graincal found out what packings differ by, in another way; calibrate in another folder with --runs"
    ):
        gc.resume(tmp_path / "campaign", max_iterations=4)


def test_where_no_packing_can_be_prepared_that_is_said_and_left_out(engine, tmp_path, monkeypatch):
    def out_of_reach(packing, count, threads=1, prepared=None):
        raise InputError("particles: too few.")

    monkeypatch.setattr("graincal.models.stress_path.siblings", out_of_reach)
    result = calibrate(tmp_path / "campaign")
    assert result.knowledge.packings == (None,) and engine.runs == 0
    assert (
        "What packings differ by is left out, for none like that of experiment could be prepared: particles: too few."
        in (tmp_path / "campaign" / "log.txt").read_text()
    )
    assert gc.Result.read(tmp_path / "campaign").knowledge.packings == (None,)


def test_a_campaign_that_goes_on_does_not_run_it_again(engine, tmp_path):
    calibrate(tmp_path / "campaign")
    more = gc.resume(tmp_path / "campaign", max_iterations=4)
    assert engine.runs == RUNS and len(more._store.samples(STUDY)) == RUNS
    whole = calibrate(stop=gc.Stop(max_iterations=4))
    np.testing.assert_array_equal(more.posterior.weights, whole.posterior.weights)


def test_a_simulated_reference_is_said_to_be_taken_for_another_packing_s(engine):
    test = gc.TriaxialTest(frictional.packing(), 0.5e6, fixed=FIXED)
    for simulated, options, said in ((True, {}, True), (True, {"packing_scatter": False}, False), (False, {}, False)):
        reference = gc.Reference(frictional.STRAIN, frictional.curves(*TRUTH), measurement_errors=ERRORS, simulated=simulated)
        found = doubts(Calibration(SPACE, [gc.Experiment("drained", test, reference)], filter_options=options))
        assert any("is taken for one on another packing like this one" in doubt.sentence for doubt in found) is said


def test_a_report_simulates_its_prediction_once(engine, tmp_path, monkeypatch):
    result, predicted = calibrate(tmp_path / "campaign"), []
    own = prediction.predict
    monkeypatch.setattr(prediction, "predict", lambda *arguments, **options: predicted.append(options) or own(*arguments, **options))
    first = prediction.predict_response(result, 2.0).drawn
    again = prediction.predict_response(gc.Result.read(tmp_path / "campaign"), 2.0).drawn
    assert len(predicted) == 1 and list(again.values) == list(first.values)
    np.testing.assert_array_equal(again.control, first.control)
    np.testing.assert_array_equal(again.values["stress_ratio"], first.values["stress_ratio"])
    prediction.predict_response(result, 4.0)
    assert len(predicted) == 2
