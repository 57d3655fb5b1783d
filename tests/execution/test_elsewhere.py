"""Tasks in worker processes elsewhere: a work is sent once, what is lost runs again, and nothing is left behind."""

import os
import signal
import time
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import active_children, get_context
from pathlib import Path

import numpy as np
import pytest

from graincal.data import Failure, InputError, Response
from graincal.execution import LOST, Scheduler, Task
from graincal.execution.away import _works
from graincal.execution.elsewhere import OnNamedExecutor
from graincal.models.function_work import FunctionWork

AT = np.array([0.1, 0.2])


def answers(theta):
    """In the process of this number."""
    return {"stress_ratio": theta[0] * AT, "process": [os.getpid(), os.getpid()]}


def kills_itself(theta):
    os.kill(os.getpid(), signal.SIGKILL)


def takes_an_hour(theta):
    Path(os.fsdecode(bytes(theta.astype(np.uint8)))).write_text(str(os.getpid()))
    time.sleep(3600)


class Counting(FunctionWork):
    """Counts how often it is sent."""

    sent = 0

    def __getstate__(self):
        Counting.sent += 1
        return super().__getstate__()


def outcomes(scheduler, tasks):
    scheduler.submit(tasks)
    try:
        ended = [scheduler.next() for _ in tasks]
        return {each.task.name: each for each in ended}
    finally:
        scheduler.close()


def by(executor, folder, said=None, **options):
    options.setdefault("needs_folder", True)
    return lambda done: OnNamedExecutor(executor, done, folder, (said if said is not None else []).append, **options)


def test_a_work_is_sent_to_each_process_once(tmp_path):
    Counting.sent = 0
    executor = ProcessPoolExecutor(2, mp_context=get_context("spawn"))
    work = Counting(answers, None, AT)
    found = outcomes(Scheduler(2, by(executor, tmp_path)), [Task(work, np.array([float(n)]), name=n) for n in range(30)])
    assert all(isinstance(each.outcome, Response) and each.outcome.values["stress_ratio"][0] == 0.1 * n for n, each in found.items())
    processes = {each.outcome.values["process"][0] for each in found.values()}
    assert os.getpid() not in processes
    # Two that begin at once may both be told that a process does not hold the work.
    assert len(processes) <= Counting.sent <= 4


def test_a_worker_that_does_not_see_the_folder_evaluates_nothing(tmp_path):
    seen = tmp_path / "campaign"
    seen.mkdir()

    class Elsewhere(ThreadPoolExecutor):
        def submit(self, function, *arguments):
            (seen / ".seen").unlink(missing_ok=True)
            return super().submit(function, *arguments)

    begun = []
    with pytest.raises(InputError, match="this folder is not seen from the node .*; a folder on a file system that the nodes share was expected, or `scratch`"):
        outcomes(Scheduler(1, by(Elsewhere(1), seen)), [Task(FunctionWork(begun.append, None, AT), np.zeros(1))])
    assert not begun
    found = outcomes(Scheduler(1, by(Elsewhere(1), seen, needs_folder=False)), [Task(FunctionWork(answers, None, AT), np.zeros(1))])
    assert isinstance(found[None].outcome, Response)


def test_another_graincal_there_is_said(tmp_path, monkeypatch):
    said = []
    monkeypatch.setattr(
        "graincal.execution.elsewhere.build.describe", lambda calls=iter([{"instruction set": "x86-64-v4"}, {"instruction set": "x86-64-v3"}]): next(calls)
    )
    outcomes(Scheduler(1, by(ThreadPoolExecutor(1), tmp_path, said)), [Task(FunctionWork(answers, None, AT), np.zeros(1))])
    assert len(said) == 1 and "has instruction set x86-64-v4 instead of x86-64-v3: figures may differ in the last digits" in said[0]


def test_what_the_executor_raises_ends_the_campaign_in_words(tmp_path):
    executor = ProcessPoolExecutor(1, mp_context=get_context("spawn"))
    with pytest.raises(InputError, match=r"run.executor: it gave up an evaluation \(BrokenProcessPool: "):
        outcomes(Scheduler(1, by(executor, tmp_path)), [Task(FunctionWork(kills_itself, None, AT), np.zeros(1))])


def test_processes_that_are_under_way_end_with_it(tmp_path):
    executor = ProcessPoolExecutor(1, mp_context=get_context("spawn"))
    scheduler, began = Scheduler("all", by(executor, tmp_path)), tmp_path / "began"
    scheduler.submit([Task(FunctionWork(takes_an_hour, None, AT), np.frombuffer(os.fsencode(began), dtype=np.uint8).astype(float), name=n) for n in range(3)])
    until = time.monotonic() + 60
    while not (began.exists() and began.read_text()) and time.monotonic() < until:
        time.sleep(0.1)
    scheduler.close()
    until = time.monotonic() + 60
    while (left := [process.pid for process in active_children()]) and time.monotonic() < until:
        time.sleep(0.1)
    assert int(began.read_text()) not in left


@pytest.mark.parametrize(("lost", "attempts", "kind"), [(3, 4, None), (9, 4, LOST)])
def test_what_is_lost_runs_again_three_times_at_most(tmp_path, lost, attempts, kind):
    class Loses(OnNamedExecutor):
        left = lost

        def meaning(self, error):
            return Failure(LOST, "its node is gone.")

        def hand_over(self, function, *arguments):
            if function.__name__ == "evaluate" and self.left:
                self.left -= 1
                future = Future()
                future.set_exception(ConnectionError())
                return future
            return super().hand_over(function, *arguments)

    make = lambda done: Loses(ThreadPoolExecutor(1), done, tmp_path, print, needs_folder=True)  # noqa: E731
    (ended,) = outcomes(Scheduler(1, make), [Task(FunctionWork(answers, None, AT), np.zeros(1))]).values()
    assert ended.attempts == attempts and getattr(ended.outcome, "kind", None) == kind


def test_an_outcome_of_an_attempt_that_was_given_up_is_not_heard(tmp_path):
    class GivesUp(OnNamedExecutor):
        given_up = False

        def look_after(self):
            for task in self.under_way:
                if not self.given_up:
                    self.given_up = True
                    self.give_up(task, "no outcome came.")

    calls = []

    def slow_at_first(theta):
        calls.append(time.monotonic())
        time.sleep(2.5 if len(calls) == 1 else 0.1)
        return {"stress_ratio": AT * len(calls)}

    make = lambda done: GivesUp(ThreadPoolExecutor(2), done, tmp_path, print, needs_folder=True)  # noqa: E731
    scheduler = Scheduler(1, make)
    (ended,) = outcomes(scheduler, [Task(FunctionWork(slow_at_first, None, AT), np.zeros(1))]).values()
    assert ended.attempts == 2 and len(calls) == 2 and ended.outcome.values["stress_ratio"][0] == 0.2


def test_a_process_keeps_those_works_that_it_was_last_asked_for(tmp_path):
    _works.clear()
    works = [FunctionWork(answers, None, AT * n) for n in range(1, 12)]
    outcomes(Scheduler(1, by(ThreadPoolExecutor(1), tmp_path)), [Task(work, np.zeros(1), name=n, order=(n,)) for n, work in enumerate(works)])
    assert [work for work, _ in _works.values()] == works[-8:]
