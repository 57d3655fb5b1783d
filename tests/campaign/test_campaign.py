"""A calibration from Python: what it finds, what it keeps, and that neither interruptions nor workers change it."""

import json
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import graincal as gc
from graincal.campaign.stored.store import Store

from .as_tasks import broken_off
from .hyperbola import SPACE, STRAIN, TRUTH, model, reference, respond

STOP = gc.Stop(s=False, gl_error_increment=False, error=False, error_increment=False, max_iterations=3)


def calibrate(**options):
    return gc.calibrate(model(), reference(), SPACE, **{"method": "iterative-bayesian", "seed": 4, "stop": STOP, "workers": 2} | options)


@pytest.fixture(scope="module")
def result():
    return calibrate()


def assert_same(one, other):
    """Bitwise the same samples, weights and outcomes."""
    np.testing.assert_array_equal(one.samples, other.samples)
    np.testing.assert_array_equal(one.errors, other.errors)
    for mine, theirs in zip(one.iterations, other.iterations, strict=True):
        np.testing.assert_array_equal(mine.weights, theirs.weights)
        np.testing.assert_equal(mine.s, theirs.s)
    for id in one.ids:
        mine, theirs = one.response(id), other.response(id)
        assert type(mine) is type(theirs)
        if isinstance(mine, gc.Response):
            for name in mine.values:
                np.testing.assert_array_equal(mine.values[name], theirs.values[name])


def test_it_finds_the_truth_and_says_what_it_did(result):
    assert result.samples.shape == (60, 2) and result.evaluations == 60 and list(np.bincount(result.iteration)) == [20, 20, 20]
    assert result.stopped_by == "max_iterations" and "limit of 3 iterations" in result.stopped_because
    assert result.best.error == np.nanmin(result.errors) < 5
    np.testing.assert_allclose(result.best.theta, TRUTH, atol=0.1)
    np.testing.assert_allclose(result.posterior.mean(), TRUTH, atol=0.15)
    assert result.posterior.correlation().shape == (2, 2) and result.posterior.interval(0.9).shape == (2, 2)
    assert result.grade.word in ("optimal", "sub-optimal")
    assert result.most_probable.iteration == 2
    assert np.all(result.seconds[:, 0] >= 0) and np.all(result.attempts == 1)
    assert result.provenance["instruction set"]


def test_failures_are_outcomes(result):
    impossible = result.samples.sum(axis=1) > 1.5
    assert impossible.any() and result.failures == impossible.sum()
    np.testing.assert_array_equal(np.isnan(result.errors), impossible)
    failure = result.response(result.ids[np.argmax(impossible)])
    assert isinstance(failure, gc.Failure) and "ArithmeticError: no equilibrium" in failure.reason
    assert result.iterations[0].final_weights[impossible[:20]].sum() == 0


def test_a_quantity_that_only_some_responses_have_is_nothing_to_the_others():
    def respond_and_sometimes_more(theta):
        found = respond(theta)
        return found if theta[0] < 0.5 else {name: found[name] for name in ("stress_ratio", "volumetric_strain")} | {"more": STRAIN}

    found = gc.calibrate(gc.PythonModel(respond_and_sometimes_more), reference(), SPACE, method="sequential-monte-carlo", seed=4, workers=1)
    curves = found.responses(iteration=0)
    (last,) = set(curves) & {"void_ratio", "more"}
    has = np.array([isinstance(outcome := found.response(int(id)), gc.Response) and last in outcome.values for id in found.ids])
    np.testing.assert_array_equal(np.isfinite(curves[last]).all(axis=1), has)
    assert 0 < has.sum() < len(has)


def test_responses_hold_every_quantity_that_the_model_returned(result):
    best = result.response(result.best.sample)
    np.testing.assert_array_equal(best.values["void_ratio"], respond(result.best.theta)["void_ratio"])
    band = result.responses(iteration=2)["void_ratio"]
    np.testing.assert_allclose(result.posterior.mean(of=band)[0], 0.7)


def test_neither_workers_nor_folder_nor_executor_change_the_result(result, tmp_path):
    assert_same(result, calibrate(workers=1))
    assert_same(result, calibrate(folder=tmp_path / "new" / "campaign"))
    with ThreadPoolExecutor(2) as executor:
        assert_same(result, gc.calibrate(gc.PythonModel(respond, executor=executor), reference(), SPACE, method="iterative-bayesian", seed=4, stop=STOP))


def test_the_result_knows_the_model_that_was_handed_over(result):
    ((_, again),) = result.experiments[0].evaluate(gc.Samples(np.zeros(1, int), result.best.theta[None], SPACE.names))
    np.testing.assert_array_equal(again.values["void_ratio"], result.response(result.best.sample).values["void_ratio"])


def test_another_seed_gives_other_samples(result):
    assert not np.any(calibrate(seed=5, stop=gc.Stop(max_iterations=1)).samples == result.samples[:20])


def test_the_folder_tells_what_was_found(result, tmp_path):
    calibrate(folder=tmp_path)
    assert_same(result, gc.Result.read(tmp_path))
    assert_same(result, gc.resume(tmp_path))
    curve = np.genfromtxt(tmp_path / "curves" / "experiment_best.csv", delimiter=",", names=True)
    np.testing.assert_array_equal(curve["axial_strain"], STRAIN)
    np.testing.assert_array_equal(curve["stress_ratio"], result.response(result.best.sample).values["stress_ratio"])
    assert (tmp_path / "curves" / "experiment_most_probable.csv").exists()
    assert "Stops by max_iterations" in (tmp_path / "log.txt").read_text()


def test_ctrl_c_costs_only_what_is_under_way(result, tmp_path):
    calls = []

    def counted(theta):
        calls.append(theta)
        return respond(theta)

    with broken_off(after=26):
        gc.calibrate(gc.PythonModel(counted), reference(), SPACE, method="iterative-bayesian", seed=4, stop=STOP, workers=1, folder=tmp_path)
    assert Store.open(tmp_path).counts()["evaluated"] == 26
    with pytest.raises(gc.InputError, match="was handed over in Python"):
        gc.resume(tmp_path)
    resumed = gc.resume(tmp_path, gc.PythonModel(counted))
    assert_same(result, resumed)
    # What was broken off is not counted as an attempt.
    assert len(calls) > 60 and resumed.attempts.max() == 1
    assert "Breaks off: KeyboardInterrupt" in (tmp_path / "log.txt").read_text()


def test_several_experiments_share_their_parameters(tmp_path):
    calls = []

    def second(theta):
        calls.append(theta)
        return respond(theta)

    experiments = [
        gc.Experiment("stress alone", model(), reference(names=("stress_ratio",))),
        gc.Experiment("volume alone", gc.PythonModel(second), reference(names=("volumetric_strain",))),
    ]
    result = gc.calibrate(experiments, space=SPACE, method="iterative-bayesian", seed=4, stop=STOP, folder=tmp_path)
    np.testing.assert_allclose(result.best.theta, TRUTH, atol=0.1)
    assert result.observable_errors.shape == (60, 2) and result.seconds.shape == (60, 2)
    assert result.iterations[0].weights.shape == (2 * len(STRAIN), 20)
    # What failed in the first experiment is not evaluated in the second.
    assert result.failures > 0 and len(calls) == 60 - result.failures
    assert result.response(result.ids[np.argmax(result.failed)], "volume alone") is None
    assert {path.name for path in (tmp_path / "curves").iterdir()} >= {"stress_alone_best.csv", "volume_alone_best.csv"}
    with pytest.raises(gc.InputError, match="a model for each of the 2 experiments"):
        gc.resume(tmp_path, model())


def test_a_model_on_another_control_is_interpolated():
    fine = np.linspace(-0.1, 0.5, 1201)
    line = gc.PythonModel(lambda theta: {"y": theta[0] * fine}, control=fine)
    result = gc.calibrate(
        line,
        gc.Reference([0.0, 0.1234], {"y": [0.0, 0.5 * 0.1234]}),
        gc.ParameterSpace({"a": (0, 1)}),
        method="iterative-bayesian",
        stop=gc.Stop(max_iterations=1),
    )
    # It is kept as the model gave it, and compared between.
    np.testing.assert_array_equal(result.response(0).control, fine)
    np.testing.assert_allclose(result.experiments[0].observables(result.response(0))[:, 0], result.samples[0] * [0.0, 0.1234])


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"space": None}, "needs a parameter space"),
        ({"reference": None}, "needs the reference"),
        ({"method": "magic"}, 'method must be one of iterative-bayesian, sequential-monte-carlo, posterior, not "magic"'),
        ({"alhpa": 3}, 'filter.alhpa is not an option of the filter .did you mean "alpha".*; expected one of alpha'),
        ({"workers": 0}, 'workers must be a whole number above 0 or "all", not 0'),
        ({"seed": -1}, "seed must be a whole number, not negative, not -1"),
        ({"max_evaluations": 3}, "does not hold one iteration of 20 samples"),
    ],
)
def test_what_cannot_be_calibrated_is_said(change, said):
    options = {"model": model(), "reference": reference(), "space": SPACE, "method": "iterative-bayesian"} | change
    with pytest.raises(gc.InputError, match=said):
        gc.calibrate(**options)


def test_a_model_that_returns_something_else_fails_evaluation_by_evaluation():
    found = gc.calibrate(model(), gc.Reference(STRAIN, {"pore_pressure": STRAIN}), SPACE, method="iterative-bayesian", seed=4)
    said = {kind: reason for kind, reason, _ in found.failure_kinds()}
    assert found.stopped_by == "failures" and found.failures == found.evaluations
    assert said["output"] == "the model returns stress_ratio, volumetric_strain, void_ratio, and the reference needs pore_pressure too."


def test_the_python_face_is_whole():
    filter = gc.IterativeBayesianFilter(SPACE, reference(), alpha=10, seed=4)
    asked = filter.ask()
    filter.tell(asked, np.stack([np.stack(list(respond(0.7 * theta).values())[:2], axis=1) for theta in asked.theta]))
    assert len(filter.iterations) == 1
    assert gc.ParameterSpace.paper().names == ("log_E", "nu", "phi", "beta_m", "eta_m")
    assert all(hasattr(gc, name) for name in gc.__all__)
    with pytest.raises(AttributeError, match="has no attribute 'calibrat'"):
        gc.calibrat


def test_max_evaluations_ends_it():
    assert calibrate(max_evaluations=40).stopped_by == "max_evaluations"


def test_a_campaign_whose_evaluations_all_fail_ends_with_the_reason():
    def never(theta):
        raise RuntimeError("never")

    result = gc.calibrate(gc.PythonModel(never), reference(), SPACE, method="iterative-bayesian")
    assert result.stopped_by == "failures" and result.best is None and result.posterior is None and result.most_probable is None


def test_the_baseline_is_one_iteration(result):
    baseline = calibrate(method="sequential-monte-carlo")
    assert baseline.evaluations == 20
    np.testing.assert_array_equal(baseline.samples, result.samples[:20])


def test_a_folder_that_holds_a_campaign_is_left_alone(tmp_path):
    calibrate(folder=tmp_path)
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    with pytest.raises(gc.InputError, match=f"begun here before, go on with it by: graincal resume {tmp_path}"):
        calibrate(folder=tmp_path)
    with pytest.raises(gc.InputError, match="this folder holds another campaign"):
        calibrate(folder=tmp_path, seed=5)
    assert before == {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}


def test_files_that_belong_to_no_campaign_are_left_alone(tmp_path):
    (tmp_path / "report.html").write_text("mine")
    with pytest.raises(gc.InputError, match="report.html is there already and belongs to no campaign"):
        calibrate(folder=tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["report.html"]
    with pytest.raises(gc.InputError, match="this is a file, and a folder was expected"):
        calibrate(folder=tmp_path / "report.html")


def test_a_log_that_cannot_be_written_is_said(tmp_path):
    (tmp_path / "log.txt").symlink_to("/dev/full")
    with pytest.raises(gc.FolderError, match=r"log.txt: the disk is full; what was finished before is safe"):
        calibrate(folder=tmp_path)


def test_two_processes_do_not_run_one_campaign(tmp_path):
    waiting, go_on = threading.Event(), threading.Event()

    def waits(theta):
        waiting.set()
        go_on.wait(30)
        return respond(theta)

    with ThreadPoolExecutor(1) as other:
        first = other.submit(gc.calibrate, gc.PythonModel(waits), reference(), SPACE, seed=4, stop=STOP, folder=tmp_path)
        waiting.wait(30)
        with pytest.raises(gc.InputError, match="another process is running this campaign"):
            gc.resume(tmp_path, model())
        with pytest.raises(gc.InputError, match="another process is running a campaign in this folder; `graincal status .*` says how far it is"):
            calibrate(folder=tmp_path)
        go_on.set()
        first.result()


def test_a_resume_with_something_else_says_so(tmp_path):
    store = Store.create(gc.campaign.Calibration(SPACE, [gc.Experiment("x", model(), reference())], "iterative-bayesian", stop=STOP), tmp_path)
    changed = store.provenance | {"instruction set": "abacus"}
    store._rows("UPDATE meta SET value = ? WHERE key = 'provenance'", json.dumps(changed))
    store.close()
    gc.resume(tmp_path, model())
    assert "instead of abacus; its figures may differ" in (tmp_path / "log.txt").read_text()


@pytest.mark.parametrize("more", [{"max_iterations": 5}, {"max_evaluations": 100, "max_iterations": False}])
def test_a_campaign_goes_on_by_other_limits_as_if_they_had_been_its_own(tmp_path, more):
    whole = calibrate(stop=replace(STOP, **more), folder=tmp_path / "whole")
    calibrate(folder=tmp_path / "continued")
    continued = gc.resume(tmp_path / "continued", model(), **more)
    assert_same(whole, continued)
    assert len(whole.iterations) == 5 and whole.stopped_by == continued.stopped_by and whole.stopped_because == continued.stopped_because
    assert Store.open(tmp_path / "whole").description == Store.open(tmp_path / "continued").description
    # What was evaluated once is not evaluated again, and the new limits are kept: the same again changes nothing.
    assert continued.attempts.max() == 1
    assert_same(whole, gc.resume(tmp_path / "continued", **more))
    assert_same(whole, gc.resume(tmp_path / "continued"))


def test_a_criterion_that_is_switched_off_lets_the_campaign_go_on(tmp_path):
    whole = calibrate(folder=tmp_path / "whole")
    # The samples close in, so s falls; its value after iteration 1 ends a campaign there.
    s = whole.iterations[1].s
    assert calibrate(stop=replace(STOP, s=s), folder=tmp_path / "short").stopped_by == "s"
    with pytest.raises(
        gc.InputError, match=r"short: it would still be at its end, by s \(the covariance coefficient .*; raise that limit, or switch it off by false"
    ):
        gc.resume(tmp_path / "short", model(), max_iterations=9)
    assert gc.Result.read(tmp_path / "short").stopped_by == "s"
    assert_same(whole, gc.resume(tmp_path / "short", model(), s=False))


@pytest.mark.parametrize(
    ("criteria", "said"),
    [
        ({"max_iterations": 2}, "it would have ended after 2 of the 3 iterations that are begun, by max_iterations"),
        ({"error": 1e3, "max_iterations": 9}, "it would have ended after 1 of the 3 iterations that are begun, by error"),
        ({"max_iteration": 9}, "stop.max_iteration is not a criterion of stopping .did you mean .max_iterations...; expected some of s, "),
        ({"max_iterations": 0}, "stop.max_iterations must be a whole number above 0 or false, not 0"),
    ],
)
def test_criteria_that_would_have_ended_it_before_are_refused(tmp_path, criteria, said):
    calibrate(folder=tmp_path)
    before = Store.open(tmp_path).description
    with pytest.raises(gc.InputError, match=said):
        gc.resume(tmp_path, model(), **criteria)
    assert Store.open(tmp_path).description == before and gc.Result.read(tmp_path).stopped_by == "max_iterations"


def test_an_end_that_no_criterion_makes_is_one(tmp_path):
    calibrate(method="sequential-monte-carlo", folder=tmp_path / "one")
    with pytest.raises(gc.InputError, match="at its end, by sequential-monte-carlo and max_iterations, and no criterion of stopping changes that"):
        gc.resume(tmp_path / "one", model(), max_iterations=9)
    never = gc.PythonModel(lambda theta: 1 / 0)
    gc.calibrate(never, reference(), SPACE, method="iterative-bayesian", folder=tmp_path / "all failed")
    with pytest.raises(gc.InputError, match="at its end, by iterative-bayesian and failures"):
        gc.resume(tmp_path / "all failed", never, max_iterations=90)


KILLED = """
import os, sys, time
import graincal as gc
import graincal.campaign, sklearn.mixture
sys.path.insert(0, {tests!r})
from campaign.hyperbola import SPACE, reference, respond
from campaign.test_campaign import STOP
from graincal.campaign.stored.store import holds_campaign
from pathlib import Path

def slow(theta):
    time.sleep(0.02)
    return respond(theta)

def run(folder, workers):
    if holds_campaign(folder):
        gc.resume(folder, gc.PythonModel(slow))
    else:
        gc.calibrate(gc.PythonModel(slow), reference(), SPACE, method="iterative-bayesian", seed=4, stop=STOP, folder=folder, workers=workers)

folder, workers, *instants = Path(sys.argv[1]), int(sys.argv[2]), *map(float, sys.argv[3:])
for seconds in [*instants, None]:
    child = os.fork()  # what is imported once need not be imported again
    if child == 0:
        run(folder, workers)
        os._exit(0)
    if seconds is not None:
        time.sleep(seconds)
        os.kill(child, 9)
    print(os.waitpid(child, 0)[1], flush=True)
"""


@pytest.mark.parametrize("workers", [1, 2])
def test_killed_at_any_instant_it_ends_as_if_it_never_was(result, tmp_path, workers):
    script, folder = tmp_path / "script.py", tmp_path / "campaign"
    script.write_text(KILLED.format(tests=str(Path(__file__).parents[1])))
    # Random instants, the same in each run of the tests; all together shorter than the 1.2 s / workers that its evaluations last at least.
    instants = np.random.default_rng(workers).uniform(0.0, 0.3, 5) / workers
    assert sum(instants) < 1.0 / workers
    ended = subprocess.run([sys.executable, script, folder, str(workers), *map(str, instants)], capture_output=True, text=True, timeout=120)
    assert ended.stdout.split() == ["9"] * 5 + ["0"], ended.stderr
    assert_same(result, gc.Result.read(folder))
