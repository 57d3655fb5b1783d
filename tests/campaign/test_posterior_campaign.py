"""A campaign of the method "posterior": what it finds and keeps, and that neither a kill nor other limits change it."""

import json
import os
from dataclasses import replace

import numpy as np
import pytest

import graincal as gc
from graincal.campaign import Calibration
from graincal.campaign.found.export import export_csv
from graincal.campaign.found.replay import tell
from graincal.campaign.found.status import status
from graincal.campaign.stored.learnt import Learnt
from graincal.campaign.stored.store import Store
from graincal.cli.check import _describe, _expectation
from graincal.inference.posterior.doubt import CENTRAL
from graincal.inference.posterior.likely_runs import likely_runs

from .as_tasks import broken_off
from .hyperbola import SPACE, STRAIN, TRUTH, model, reference, respond
from .test_campaign import assert_same

pytestmark = pytest.mark.usefixtures("fewer_draws")

# Two batches and the runs at the answer: training emulators takes most of the time.
STOP = gc.Stop(max_iterations=2)
LIMITS = {"stress_ratio": 0.05, "volumetric_strain": 2e-4}


def measured():
    return gc.Reference(STRAIN, reference().observables, measurement_errors=LIMITS)


def infeasible(theta):
    """As `respond`, but that no equilibrium means that there is no such soil."""
    return gc.Failure("infeasible", "no such soil.") if theta.sum() > 1.5 else respond(theta)


def calibrate(function=infeasible, **options):
    return gc.calibrate(gc.PythonModel(function), measured(), SPACE, method="posterior", **{"seed": 6, "stop": STOP, "workers": 1} | options)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("posterior") / "campaign"
    calibrate(folder=folder)
    return folder


@pytest.fixture(scope="module")
def result(folder):
    return gc.Result.read(folder)


def test_it_finds_the_truth_within_its_own_spread(result):
    posterior = result.posterior
    assert list(np.bincount(result.iteration)) == [8, 4, 3] and result.stopped_by == "max_iterations"
    assert np.all(np.abs(posterior.mean() - TRUTH) < 3 * posterior.std()) and np.all(posterior.std() < 0.05)
    # The reference is without error: the most probable parameters are the truth, but for the emulator.
    np.testing.assert_allclose(result.answer.theta, TRUTH, atol=0.02)
    # Its three runs are a millionth of the ranges apart, which this model shows in proportion.
    assert len(result.answer.errors) == 3 and result.answer.spread < 1e-3 and result.answer.mean < 1
    assert result.best.error == np.nanmin(result.errors) and result.grade is None
    assert result.log_evidence == result.found.log_evidence and np.isfinite(result.log_evidence)


def test_the_runs_at_the_answer_move_nothing(result):
    first, second, answer = (learnt.posterior_shift for learnt in result.learnt)
    before, after = (result._store.look(evaluations).posterior for evaluations in (8, 12))
    moved = np.abs(after.mean() - before.mean()) / after.std()
    stretched = np.abs(np.log(np.ptp(after.interval(CENTRAL), axis=0) / np.ptp(before.interval(CENTRAL), axis=0)))
    assert np.isnan(first) and second == pytest.approx(max(*moved, *stretched), rel=1e-12) and np.isnan(answer)


def test_runs_that_fit_about_as_well_are_stored_with_each_batch(result):
    known = result.knowledge
    again = likely_runs(known.evaluations, known.kept, known.errors, at_answer=3)
    assert result.fits_about_as_well == again == result.learnt[-1].fits_about_as_well
    # This model does not scatter, and its answer is the truth.
    assert again.repeated == 0 and again.count >= 3 and all(low <= at <= high for low, at, high in zip(again.low, result.answer.theta, again.high))
    first = likely_runs(known.evaluations.first(8), known.kept, known.errors)
    assert result.learnt[0].fits_about_as_well == first


def test_what_was_learnt_is_restored(result):
    last = result.learnt[-1]
    assert Learnt.restore(json.loads(json.dumps(last.plain(), allow_nan=False))) == last


def test_infeasible_parameters_are_told_as_such(result):
    impossible = result.samples.sum(axis=1) > 1.5
    assert impossible.any()
    np.testing.assert_array_equal(result.knowledge.evaluations.infeasible, impossible)


def test_other_failures_are_not():
    store = Store.create(Calibration(SPACE, [gc.Experiment("drained", model(), measured())], "posterior"))
    samples = store.calibration.new_filter().ask().take([0, 1, 2])
    store.ask(0, samples, experiments=1)
    store.record(0, 0, gc.Failure("timed_out", "it took too long."))
    store.record(1, 0, gc.Failure("infeasible", "no such soil."))
    store.record(2, 0, gc.Response(STRAIN, respond(TRUTH)))
    told = []

    class Recorder:
        tell = staticmethod(lambda *arguments: told.extend(arguments))

    tell(Recorder(), samples, store, store.calibration.experiments)
    _, (responses,), failed, infeasible, stopped = told
    assert list(failed) == [True, True, False] and list(infeasible) == [False, True, False]
    assert np.isnan(responses[:2]).all() and np.isfinite(responses[2]).all()


def test_the_folder_tells_all_of_it(folder, result, tmp_path):
    found = status(folder)
    json.dumps(found, allow_nan=False)
    posterior, (low, high) = result.posterior, result.posterior.interval(0.9)
    assert found["settled"] is result.settled and list(found["posterior"]) == ["mean", "std", "interval_90"]
    assert found["posterior"]["mean"] == dict(zip(SPACE.names, posterior.mean())) and found["posterior"]["std"] == dict(zip(SPACE.names, posterior.std()))
    assert found["posterior"]["interval_90"] == {name: [a, b] for name, a, b in zip(SPACE.names, low, high)}
    assert found["answer"]["theta"] == dict(zip(SPACE.names, result.answer.theta)) and len(found["answer"]["errors"]) == 3
    first, second, last = found["iterations"]
    assert first["posterior_shift"] is None and second["posterior_shift"] == result.learnt[1].posterior_shift and second["held_out_error"] < 0.1
    assert last["log_evidence"] == result.log_evidence and first["s"] is None
    fits = result.fits_about_as_well
    assert found["fits_about_as_well"] == {
        "runs": fits.count,
        "enough": fits.enough,
        "range": {name: [low, high] for name, low, high in zip(SPACE.names, fits.low, fits.high)},
    }
    assert [each["code"] for each in found["remarks"]][:1] == ["preliminary"] and found["remarks"][-1]["code"] == "stopped"
    curve = np.genfromtxt(folder / "curves" / "experiment_answer.csv", delimiter=",", names=True)
    # Of one of the three runs there, a millionth of the ranges apart.
    np.testing.assert_allclose(curve["stress_ratio"], respond(result.answer.theta)["stress_ratio"], rtol=1e-5)
    assert "posterior shift" in (folder / "log.txt").read_text()
    tables = {path.name: np.genfromtxt(path, delimiter=",", names=True) for path in export_csv(result, tmp_path) if path.name != "samples.csv"}
    assert tables["posterior.csv"]["weight"].sum() == pytest.approx(1)
    np.testing.assert_array_equal(tables["iterations.csv"]["held_out_error"], [each.held_out_error for each in result.learnt])


def test_a_killed_campaign_ends_as_if_it_never_was(result, tmp_path):
    calls = tmp_path / "calls"

    def deadly(theta):
        """The fifth, the tenth and the seventeenth call kill the process: in either batch, and among the runs at the answer."""
        count = calls.stat().st_size if calls.exists() else 0
        calls.open("a").write(".")
        if count + 1 in (5, 10, 17):
            os._exit(9)
        return infeasible(theta)

    for _ in range(3):
        child = os.fork()
        if child == 0:
            if (tmp_path / "campaign").exists():
                gc.resume(tmp_path / "campaign", gc.PythonModel(deadly))
            else:
                calibrate(deadly, folder=tmp_path / "campaign")
            os._exit(0)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 9
    assert calls.stat().st_size == 17
    killed = gc.resume(tmp_path / "campaign", gc.PythonModel(deadly))
    assert_same(result, killed)
    assert killed.learnt == result.learnt
    np.testing.assert_array_equal(killed.posterior.weights, result.posterior.weights)


def test_it_goes_on_by_other_limits_as_if_they_had_been_its_own(result, tmp_path):
    calibrate(stop=gc.Stop(max_iterations=1), folder=tmp_path)
    with pytest.raises(gc.InputError, match="it would still be at its end, by max_iterations"):
        gc.resume(tmp_path, gc.PythonModel(infeasible), max_evaluations=30)
    continued = gc.resume(tmp_path, gc.PythonModel(infeasible), max_iterations=2)
    assert_same(result, continued)
    with pytest.raises(gc.InputError, match="it would have ended after 1 of the 3 batches that are begun"):
        gc.resume(tmp_path, gc.PythonModel(infeasible), max_iterations=1)


def test_another_shift_that_would_have_asked_for_other_runs_is_refused(tmp_path):
    # By so large a shift the first look is enough, and fresh runs follow.
    calibrate(folder=tmp_path, stop=gc.Stop(max_iterations=2, posterior_shift=9))
    with pytest.raises(
        gc.InputError, match=r"by posterior_shift = 0.001 its batch 1 would have had other samples than by 9; calibrate in another folder with --runs"
    ):
        gc.resume(tmp_path, gc.PythonModel(infeasible), max_iterations=4, posterior_shift=0.001)


def test_what_another_build_began_stays_as_it_was(tmp_path):
    calibrate(folder=tmp_path)
    # Samples that this build would not have asked for.
    Store.open(tmp_path).database.rows("UPDATE sample SET theta = '[0.3, 0.3]' WHERE id = 9")
    before = Store.open(tmp_path)
    with pytest.raises(gc.InputError, match="batch 1 comes out with other samples than are stored"):
        gc.resume(tmp_path, gc.PythonModel(infeasible), max_iterations=3)
    after = Store.open(tmp_path)
    assert after.meta("stopped_by") == "max_iterations" and after.counts() == before.counts()


def test_criteria_that_it_does_not_look_at_are_refused():
    with pytest.raises(
        gc.InputError,
        match='stop.s is a criterion of method = "iterative-bayesian", and "posterior", the default, looks at posterior_shift, max_iterations, max_evaluations',
    ):
        calibrate(stop=gc.Stop(s=0.1))


def test_a_limit_in_time_ends_it_with_an_answer_and_it_goes_on_from_there(result, tmp_path):
    ended = calibrate(folder=tmp_path / "campaign", stop=gc.Stop(max_iterations=2, hours=1e-9))
    assert ended.stopped_by == "hours" and ended.stopped_because == "The limit of 1e-09 hours is over." and list(np.bincount(ended.iteration)) == [8, 3]
    # The clock is not asked again about what it has said.
    assert gc.resume(tmp_path / "campaign", gc.PythonModel(infeasible)).stopped_by == "hours"
    more = gc.resume(tmp_path / "campaign", gc.PythonModel(infeasible), hours=False)
    assert more.stopped_by == "max_iterations"
    np.testing.assert_array_equal(more.samples, result.samples)
    np.testing.assert_array_equal(more.posterior.weights, result.posterior.weights)


def test_the_clock_counts_all_sittings(tmp_path, monkeypatch):
    now = iter(np.arange(0.0, 1e9, 600.0))
    monkeypatch.setattr("graincal.campaign.run.campaign.time.monotonic", lambda: float(next(now)))
    stop = gc.Stop(max_iterations=3, hours=2)
    with broken_off(after=4):
        calibrate(infeasible, folder=tmp_path / "campaign", stop=stop)
    # Ten minutes pass at each look at the clock: within the first batch an hour is over, and with what follows two are.
    assert float(Store.open(tmp_path / "campaign").meta("seconds spent")) > 3000
    ended = gc.resume(tmp_path / "campaign", gc.PythonModel(infeasible))
    assert ended.stopped_by == "hours" and len(ended.iterations) == 2
    with pytest.raises(gc.InputError, match="it would still be at its end, by hours"):
        gc.resume(tmp_path / "campaign", gc.PythonModel(infeasible), max_evaluations=60)


def test_by_the_papers_method_too(tmp_path):
    ended = gc.calibrate(model(), reference(), SPACE, method="iterative-bayesian", seed=1, stop=gc.Stop(hours=1e-9), workers=1)
    assert ended.stopped_by == "hours" and len(ended.iterations) == 1


def test_check_says_what_it_will_take_and_how_errors_were_understood():
    experiment = gc.Experiment("drained", model(), replace_errors(gc.data.MeasurementError(0.05, relative=0.01, step=0.02)))
    calibration = Calibration(SPACE, [experiment], "posterior").check()
    said = "\n".join(_describe(experiment, "posterior"))
    assert "measurement error of stress_ratio: sd 0.05, 1 % of the value, steps of 0.02" in said
    # The volumetric strain has its peak of 0.00624 at an axial strain of 0.12.
    assert "measurement error of volumetric_strain: sd 6.24e-05, taken for 1 % of the peak: none is stated" in said
    assert (
        "Expect 8 evaluations that fill the ranges (about" in _expectation(calibration)[-1] and "and ends after 60 at the most" in _expectation(calibration)[-1]
    )
    assert "The limit ends it after 39 (about" in _expectation(replace(calibration, stop=gc.Stop(max_evaluations=40)))[-1]
    # What a run is said to take is not timed, and lets hundreds fill the ranges.
    seconds, forecast = _expectation(replace(calibration, expected_seconds=10.0, workers=1, stop=gc.Stop(hours=2)))
    assert seconds == "about 10 s for an evaluation, as expected_seconds says"
    assert (
        "Expect 60 evaluations that fill the ranges (about 10 min)" in forecast
        and "settles after some 203" in forecast
        and "begins no further batch after 2 hours" in forecast
    )


def replace_errors(error):
    return gc.Reference(STRAIN, reference().observables, measurement_errors={"stress_ratio": error})


def test_what_was_learnt_is_read_and_not_learnt_again(folder, result, monkeypatch):
    def search(*arguments):
        raise AssertionError("nothing was to be searched for")

    monkeypatch.setattr("graincal.inference.emulator.process._most_probable", search)
    monkeypatch.setattr("graincal.inference.posterior.emulation.explore", search)
    again = gc.Result.read(folder)
    np.testing.assert_array_equal(again.posterior.samples, result.posterior.samples)
    np.testing.assert_array_equal(again.emulation.log_likelihood(SPACE.to_unit(again.samples)), result.emulation.log_likelihood(SPACE.to_unit(result.samples)))
    # And so does a campaign that goes on, as far as it has come.
    assert gc.resume(folder, gc.PythonModel(infeasible)).log_evidence == result.log_evidence


def test_a_campaign_of_which_another_build_would_have_made_other_runs_does_not_go_on_and_is_still_read(folder, result, monkeypatch):
    monkeypatch.setattr(
        "graincal.inference.posterior.posterior_filter.PosteriorFilter._rng", lambda self, purpose, batch: np.random.default_rng([99, batch, len(purpose)])
    )
    np.testing.assert_array_equal(gc.Result.read(folder).posterior.samples, result.posterior.samples)
    with pytest.raises(gc.InputError, match="other samples than are stored"):
        gc.resume(folder, gc.PythonModel(infeasible), max_iterations=3)


def unrelated(theta):
    """A soil whose parameters say nothing of its response."""
    return respond(np.random.default_rng(np.float64(theta).view(np.uint64)).random(2) * 0.7)


def test_an_emulator_that_predicts_nothing_is_dropped_in_words(tmp_path):
    result = calibrate(unrelated, folder=tmp_path / "campaign", stop=gc.Stop(max_iterations=5))
    dropped = [index for index, learnt in enumerate(result.learnt) if not learnt.predicts]
    log = (tmp_path / "campaign/log.txt").read_text()
    assert dropped and [index for index in range(len(result.learnt)) if f"trained after batch {index} predicts runs no better" in log] == dropped
    assert gc.Result.read(tmp_path / "campaign").learnt == result.learnt and result.stopped_by == "max_iterations"


def test_the_runs_at_the_answer_scatter_as_runs_of_the_engine_do():
    # By the default accuracy too, whose float32 takes parameters for the same that differ in the eighth digit.
    from graincal import demo
    from graincal.inference.posterior.posterior_filter import REPLICATES
    from graincal.inference.sampling.samples import APART

    packing, space = demo.packing(), gc.ParameterSpace.paper()
    theta = np.array(list(demo.TRUTH.values())) + APART * np.arange(REPLICATES)[:, None] * (space.high - space.low)
    runs = gc.TriaxialTest(packing, 0.5e6).simulate(theta, at=[0.0, 0.02], threads=1)
    assert len({run.values["stress_ratio"][-1] for run in runs}) == REPLICATES
