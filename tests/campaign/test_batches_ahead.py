"""A campaign that asks for batches ahead: no worker waits for the longest run of a batch, and nothing of what is found depends on who ran what when."""

from __future__ import annotations

import os
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import graincal as gc
from graincal.campaign.file.config import read_calibration
from graincal.campaign.found.status import status
from graincal.campaign.stored.store import Store
from graincal.models import Model

from .as_tasks import as_tasks, model_of
from .hyperbola import SPACE, STRAIN, THE_PAPERS, respond, write_calibration
from .test_campaign import assert_same
from .test_posterior_campaign import infeasible, measured

THREE_BATCHES = gc.Stop(max_iterations=3, posterior_shift=False)


def calibrate(function=infeasible, **options):
    given = {"method": "posterior", "seed": 6, "stop": THREE_BATCHES, "ahead": 1, "workers": 1} | options
    return gc.calibrate(
        function if isinstance(function, list) else gc.PythonModel(function), None if isinstance(function, list) else measured(), SPACE, **given
    )


@pytest.fixture(scope="module")
def result(fewer_draws):
    return calibrate()


def test_limits_hold(result):
    assert list(np.bincount(result.iteration)) == [8, 4, 4, 3] and result.stopped_by == "max_iterations"
    np.testing.assert_array_equal(result.attempts, 1)


def test_run_times_and_workers_change_nothing(result):
    def slow(theta):
        time.sleep(0.002 * 50 ** theta[0])
        return infeasible(theta)

    for workers in (3, 40):
        found = calibrate(slow, workers=workers)
        assert_same(result, found)
        assert found.learnt == result.learnt
        np.testing.assert_array_equal(found.posterior.weights, result.posterior.weights)


def test_a_worker_goes_on_to_the_next_batch_while_the_longest_run_of_one_goes_on(result):
    first, second = result.samples[7], {tuple(theta) for theta in result.samples[8:12]}
    begun = threading.Event()

    def waits(theta):
        if tuple(theta) in second:
            begun.set()
        if np.array_equal(theta, first):
            # A campaign that finished a batch before the next would wait here in vain.
            assert begun.wait(60)
        return infeasible(theta)

    found = calibrate(waits, workers=2)
    assert_same(result, found)
    assert found.failures == result.failures


def test_a_killed_campaign_ends_as_if_it_never_was(result, tmp_path):
    calls, one_at_a_time = tmp_path / "calls", threading.Lock()

    def deadly(theta):
        """Some calls kill the process: in the first batch, among those ahead of the second, and among the runs at the answer."""
        with one_at_a_time:
            # Another thread's call between the two would hide the one that is counted.
            with calls.open("a") as file:
                file.write(".")
            if calls.stat().st_size in (5, 16, 24):
                os._exit(9)
        time.sleep(0.001 * 20 ** theta[1])
        return infeasible(theta)

    for _ in range(3):
        child = os.fork()
        if child == 0:
            try:
                if (tmp_path / "campaign").exists():
                    gc.resume(tmp_path / "campaign", gc.PythonModel(deadly))
                else:
                    calibrate(deadly, folder=tmp_path / "campaign", workers=3)
            finally:
                # Whatever happened, the child does not go on with the tests.
                os._exit(0)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 9
        found = status(tmp_path / "campaign")
        # The earliest batch may be whole, and the filter learning from it, where the call that kills is of one ahead.
        asked = Store.open(tmp_path / "campaign").counts()["samples"]
        assert found["state"] == "interrupted" and found["evaluations"] < asked
    killed = gc.resume(tmp_path / "campaign", gc.PythonModel(infeasible), workers=2)
    assert_same(result, killed)
    assert killed.learnt == result.learnt
    np.testing.assert_array_equal(killed.posterior.weights, result.posterior.weights)
    np.testing.assert_array_equal(gc.Result.read(tmp_path / "campaign").posterior.weights, result.posterior.weights)


def test_it_goes_on_by_other_limits_as_if_they_had_been_its_own(result, tmp_path):
    calibrate(stop=gc.Stop(max_iterations=2, posterior_shift=False), folder=tmp_path)
    assert_same(result, gc.resume(tmp_path, gc.PythonModel(infeasible), max_iterations=3))
    for limit in (1, 2):
        with pytest.raises(gc.InputError, match=f"it would have ended after {limit} of the 4 batches that are begun"):
            gc.resume(tmp_path, gc.PythonModel(infeasible), max_iterations=limit)


def test_a_sample_that_fails_in_one_experiment_is_left_out_of_the_next():
    def experiments(called):
        def other(theta):
            called.append(tuple(theta))
            return respond(theta)

        return [gc.Experiment("one", gc.PythonModel(infeasible), measured()), gc.Experiment("other", gc.PythonModel(other), measured())]

    one, many, stop = [], [], gc.Stop(max_iterations=2)
    found = calibrate(experiments(one), stop=stop, workers=1)
    assert_same(found, calibrate(experiments(many), stop=stop, workers=6))
    assert 0 < found.failures and sorted(one) == sorted(many) == sorted(map(tuple, found.samples[~found.failed]))


def test_functions_by_name_run_in_processes_that_are_kept(result, tmp_path):
    # A late call ends its process, once, whichever of the two comes first: its evaluation is run again.
    (tmp_path / "soil_by_name.py").write_text(
        """
import os, pathlib
import numpy as np
import graincal as gc
here = pathlib.Path(__file__).parent
STRAIN = np.linspace(0, 0.2, 11)

def respond(theta):
    with (here / "processes").open("a") as file:
        file.write(f"{os.getpid()}\\n")
    if len((here / "processes").read_text().split()) >= 6:
        try:
            (here / "crashed").touch(exist_ok=False)
        except FileExistsError:
            pass
        else:
            os._exit(1)
    strength, dilatancy = theta
    if theta.sum() > 1.5:
        return gc.Failure("infeasible", "no such soil.")
    return {"stress_ratio": 1 + 3 * strength * STRAIN / (0.02 + STRAIN), "volumetric_strain": 0.1 * STRAIN - dilatancy * STRAIN**2, "void_ratio": 0.7 + dilatancy * STRAIN}
"""
    )
    model = gc.PythonModel("soil_by_name:respond", folder=tmp_path, timeout=60)
    found = gc.calibrate(model, measured(), SPACE, method="posterior", seed=6, stop=THREE_BATCHES, ahead=1, workers=2)
    assert_same(result, found)
    processes = (tmp_path / "processes").read_text().split()
    # Two, and one instead of that which crashed.
    assert len(processes) == len(found.samples) + 1 and len(set(processes)) <= 3
    assert not any(_is_alive(int(process)) for process in processes)


def test_a_time_out_is_a_failure(tmp_path):
    (tmp_path / "sleeper.py").write_text(
        "import time\nimport numpy as np\ndef respond(theta):\n    time.sleep(60 * (theta[0] > 0.8))\n    return {'y': theta[0] * np.arange(3.0)}\n"
    )
    space, reference = gc.ParameterSpace({"a": (0, 1)}), gc.Reference(np.arange(3.0), {"y": 0.4 * np.arange(3.0)})
    model = gc.PythonModel("sleeper:respond", folder=tmp_path, timeout=3)
    found = gc.calibrate(model, reference, space, method="posterior", stop=gc.Stop(max_iterations=1), ahead=1, workers=2)
    np.testing.assert_array_equal(found.failed, found.samples[:, 0] > 0.8)
    assert found.failed.any() and {kind for kind, *_ in found.failure_kinds()} == {"timed_out"}


def test_an_executor_is_handed_all_that_waits(result):
    # The twelve samples of the first two batches meet, or the campaign breaks off.
    together, count = threading.Barrier(12), iter(range(1000))

    def counted(theta):
        if next(count) < 12:
            together.wait(60)
        return infeasible(theta)

    with ThreadPoolExecutor(12) as executor:
        model = gc.PythonModel(counted, executor=executor)
        assert_same(result, gc.calibrate(model, measured(), SPACE, method="posterior", seed=6, stop=THREE_BATCHES, ahead=1, workers="all"))


def test_any_model_is_asked_for_single_samples():
    plain = model_of(lambda samples, at: gc.Response(at, respond(samples.theta[0])))
    found = gc.calibrate(plain, measured(), SPACE, method="posterior", stop=gc.Stop(max_iterations=1), ahead=1, workers=2)
    assert len(found.samples) == 11 and not found.failures


def test_the_longest_run_of_a_batch_begins_first_and_the_next_batch_after_it(result):
    begun = []

    def tell(model, samples, at):
        begun.append(int(samples.ids[0]))
        (theta,) = samples.theta
        return gc.Response(at, respond(theta)) if theta.sum() <= 1.5 else gc.Failure("infeasible", "no such soil.")

    class Telling(Model):
        def tasks(self, samples, at):
            return [replace(task, cost=float(theta[0])) for task, theta in zip(as_tasks(tell)(self, samples, at), samples.theta)]

    assert_same(result, gc.calibrate(Telling(), measured(), SPACE, method="posterior", seed=6, stop=THREE_BATCHES, ahead=1, workers=1))
    # A batch is handed over as one, and the single worker takes it in order.
    of_batch = [[id for id in begun if low <= id < high] for low, high in ((0, 8), (8, 12))]
    for ids in of_batch:
        lengths = result.samples[ids, 0]
        assert np.all(np.diff(lengths) <= 0)
    assert sorted(begun[:8]) == list(range(8))


def test_what_a_model_leaves_out_is_the_trouble_of_its_evaluations():
    def wrong(theta):
        return {"stress_ratio": STRAIN}

    found = calibrate(wrong, workers=3)
    assert found.stopped_by == "failures" and all(kind == "output" for kind, _, _ in found.failure_kinds())


def test_the_file_says_how_many_batches(tmp_path):
    option = (THE_PAPERS, 'method = "posterior"\nahead = 1')
    stop = ("s = false\ngl_error_increment = false\nerror = false\nerror_increment = false", "")
    assert read_calibration(write_calibration(tmp_path, option, stop)).new_filter().ahead == 1
    with pytest.raises(gc.InputError, match=r"filter.ahead must be a whole number, not negative, not -1\.$"):
        read_calibration(write_calibration(tmp_path, (option[0], option[1].replace("1", "-1")), stop))
    with pytest.raises(gc.InputError, match='filter.ahead is an option of method = "posterior"'):
        read_calibration(write_calibration(tmp_path, ("alpha = 10", "ahead = 1")))


def _is_alive(process):
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True
