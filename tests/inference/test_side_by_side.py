"""Components of an emulator by several threads."""

import multiprocessing
import threading

import numpy as np
import pytest

from graincal import Reference
from graincal.inference.emulator import side_by_side as threads
from graincal.inference.emulator.emulator import Emulator
from graincal.inference.emulator.process import Process
from graincal.inference.emulator.side_by_side import WORTH_A_THREAD, by_at_most, side_by_side


@pytest.fixture
def many_cores(monkeypatch):
    monkeypatch.setattr(threads, "available_cores", lambda: 4)


def names(numbers):
    """Of the threads that work is done by."""
    together = threading.Barrier(2, timeout=10)

    def name(item):
        if numbers >= WORTH_A_THREAD:
            together.wait()
        return item, threading.current_thread().name

    return side_by_side(name, range(2), numbers)


def test_large_work_is_done_by_several_threads_in_order(many_cores):
    done = names(WORTH_A_THREAD)
    assert [item for item, _ in done] == [0, 1] and len({name for _, name in done}) == 2


def test_small_work_and_one_thread_need_none(many_cores):
    here = threading.current_thread().name
    assert names(WORTH_A_THREAD - 1) == [(0, here), (1, here)]
    with by_at_most(1):
        assert side_by_side(lambda item: threading.current_thread().name, range(2), WORTH_A_THREAD) == [here, here]


def test_an_error_of_one_is_raised(many_cores):
    with pytest.raises(ZeroDivisionError):
        side_by_side(lambda item: 1 / item, [1, 0], WORTH_A_THREAD)


def in_a_fork(queue):
    queue.put(side_by_side(lambda item: item + 1, range(3), WORTH_A_THREAD))


def test_a_fork_has_threads_of_its_own(many_cores):
    side_by_side(lambda item: item, range(3), WORTH_A_THREAD)
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    process = context.Process(target=in_a_fork, args=(queue,), daemon=True)
    process.start()
    assert queue.get(timeout=30) == [1, 2, 3]
    process.join(30)


def emulated(count):
    """An emulator of curves at 200 points by at most so many threads: its predictions and draws."""
    rng = np.random.default_rng(1)
    unit, control = rng.random((200, 3)), np.linspace(0, 1, 20)
    curves = np.sin(3 * control * (1 + unit[:, :1])) + unit[:, 1:2] * control**2 + unit[:, 2:] * np.exp(-control)
    reference = Reference(control, {"y": curves[0]})
    with by_at_most(count):
        emulator = Emulator(unit, curves[..., None], reference)
        points = rng.random((500, 3))
        return [*emulator.predict(points), emulator.draw(points[:200], 5, np.random.default_rng(2)), emulator.powers]


def test_the_digits_do_not_depend_on_the_number_of_threads(many_cores):
    for one, several in zip(emulated(1), emulated(4)):
        np.testing.assert_array_equal(one, several)


def test_predictions_in_parts_are_those_of_all_at_once():
    rng = np.random.default_rng(3)
    unit = rng.random((300, 2))
    process = Process(unit, np.sin(5 * unit[:, 0]) * unit[:, 1] + 0.01 * rng.standard_normal(300))
    points = rng.random((1500, 2))
    covariance = process.kernel.covariance(points, unit)
    known = process.kernel.covariance(unit, unit) + (process.nugget + 1e-10) * np.eye(300)
    mean, variance = process.predict(points)
    np.testing.assert_allclose(mean, covariance @ np.linalg.solve(known, process.values), atol=1e-6)
    expected = process.kernel.variance - np.sum(covariance * np.linalg.solve(known, covariance.T).T, axis=1)
    np.testing.assert_allclose(variance, expected, atol=1e-6 * process.kernel.variance)
