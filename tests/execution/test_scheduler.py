"""One scheduler decides what runs when: the longest first, never more at once than there are workers, wherever it runs."""

import os
import signal
import threading
import time
from concurrent.futures import Executor, Future, ThreadPoolExecutor

import pytest

from graincal.data import Failure, InputError
from graincal.execution import LOST, Limit, Scheduler, Task, run, try_in_a_process

from .works import Work


def tasks(work, arguments, **options):
    return [Task(work, argument, name=argument, **options) for argument in arguments]


def outcomes(ended):
    return {each.task.name: each.outcome for each in ended}


def test_the_longest_begins_first_and_an_earlier_order_before_it():
    begun = []
    work = Work(begun.append)
    scheduler = Scheduler(1)
    gate = threading.Event()
    scheduler.submit([Task(Work(lambda _: gate.wait(30)), None)])
    scheduler.submit([Task(work, cost, cost=cost, order=(1,)) for cost in (1, 3, 2)] + [Task(work, 0, cost=0, order=(0,))])
    gate.set()
    for _ in range(5):
        scheduler.next()
    scheduler.close()
    assert begun == [0, 3, 2, 1]


@pytest.mark.parametrize("workers", [1, 3])
def test_never_more_at_once_than_there_are_workers(workers):
    lock, now, most = threading.Lock(), [0], [0]

    def counts(_):
        with lock:
            now[0] += 1
            most[0] = max(most[0], now[0])
        time.sleep(0.01)
        with lock:
            now[0] -= 1

    # Of two works, for instance two experiments.
    both = tasks(Work(counts), range(10)) + tasks(Work(counts), range(10, 20))
    assert len(list(run(both, workers))) == 20 and most[0] == workers


def test_what_work_raises_is_raised_and_nothing_more_is_begun():
    begun = []

    def breaks(argument):
        begun.append(argument)
        if argument == 1:
            raise ZeroDivisionError
        return argument

    with pytest.raises(ZeroDivisionError):
        list(run(tasks(Work(breaks), range(10), cost=1.0), 1))
    assert begun == [0, 1]


def test_threads_that_cannot_be_started_are_an_error_in_words(monkeypatch):
    start, left = threading.Thread.start, [2]

    def failing(thread):
        left[0] -= 1
        if left[0] < 0:
            raise RuntimeError("can't start new thread")
        start(thread)

    monkeypatch.setattr(threading.Thread, "start", failing)
    with pytest.raises(InputError, match=r"workers: only 2 threads could be started \(can't start new thread\)"):
        list(run(tasks(Work(lambda _: time.sleep(0.2)), range(8)), 8))


def test_closing_ends_what_can_be_ended_and_waits_for_nothing_else():
    started = threading.Barrier(3)

    class Endless(Work):
        def run(self, argument, stopped, watch):
            started.wait(30)
            while not stopped():
                time.sleep(0.01)

    scheduler = Scheduler(2)
    scheduler.submit([*tasks(Endless(None), [0]), *tasks(Work(lambda _: (started.wait(30), time.sleep(60))), [1])])
    started.wait(30)
    begun = time.monotonic()
    scheduler.close()
    assert time.monotonic() - begun < 10 and not list(scheduler.ended())


def test_a_rule_that_stops_runs_is_asked_on_threads_alone():
    class Watched(Work):
        def run(self, argument, stopped, watch):
            return watch(argument)

    (ended,) = run([Task(Watched(None), 7, watch=lambda response: response + 1)], 1)
    assert ended.outcome == 8
    with ThreadPoolExecutor(1) as executor:
        (ended,) = run([Task(Work(lambda argument: argument, executor=executor), 7, watch=lambda response: response + 1)], 1)
    assert ended.outcome == 7


class Inline(Executor):
    """Runs a task where it is handed over."""

    def submit(self, call, *arguments):
        future = Future()
        future.set_result(call(*arguments))
        return future


class Stubborn(Executor):
    """Its futures cannot be cancelled, and never end."""

    def submit(self, call, *arguments):
        future = Future()
        future.set_running_or_notify_cancel()
        return future


def test_an_executor_may_run_a_task_where_it_is_handed_over():
    work = Work(lambda argument: argument, executor=Inline())
    assert outcomes(run(tasks(work, range(3000)), "all")) == {number: number for number in range(3000)}


def test_an_executor_whose_futures_cannot_be_cancelled_ends_cleanly():
    scheduler = Scheduler("all")
    scheduler.submit(tasks(Work(None, executor=Stubborn()), range(3)))
    begun = time.monotonic()
    scheduler.close()
    assert time.monotonic() - begun < 5


@pytest.mark.parametrize(("workers", "most"), [("all", 8), (2, 2)])
def test_an_executor_is_handed_all_or_as_many_as_workers(workers, most):
    lock, handed = threading.Lock(), [0, 0]

    class Counts(ThreadPoolExecutor):
        def submit(self, *arguments):
            with lock:
                handed[0] += 1
                handed[1] = max(handed)
            future = super().submit(*arguments)
            future.add_done_callback(lambda _: handed.__setitem__(0, handed[0] - 1))
            return future

    with Counts(8) as executor:
        assert len(list(run(tasks(Work(lambda _: time.sleep(0.05), executor=executor), range(8)), workers))) == 8
    assert handed[1] <= most


def test_a_process_that_crashes_is_run_once_more_by_itself():
    work = Work("crashes", own_process=True)
    ended = list(run(tasks(work, ["crash", "a", "b", "c"]), 2))
    by_name = {each.task.name: each for each in ended}
    assert by_name["crash"].outcome.kind == "crashed" and by_name["crash"].attempts == 2
    assert ended[-1].task.name == "crash" and all(by_name[name].attempts == 1 for name in "abc")


def test_what_a_process_cannot_send_is_a_failure():
    ended = outcomes(run(tasks(Work("unsendable", own_process=True), [1]), 1))
    assert isinstance(ended[1], Failure) and "cannot be sent" in ended[1].reason


def test_a_thread_that_goes_on_and_processes_left_behind_hold_nothing_up():
    begun = time.monotonic()
    ended = outcomes(run(tasks(Work("leaves_behind", own_process=True), [1]), 1))
    assert time.monotonic() - begun < 30
    child = int(ended[1])
    for _ in range(100):
        try:
            os.kill(child, 0)
        except ProcessLookupError:
            break
        # It may be dead and not buried: nobody's child but the machine's.
        with open(f"/proc/{child}/stat") as stat:
            if stat.read().split()[2] == "Z":
                break
        time.sleep(0.1)
    else:
        os.kill(child, signal.SIGKILL)
        pytest.fail("a process that an evaluation started outlives it")


def test_a_process_that_is_killed_while_it_is_made_ready_costs_one_attempt(tmp_path, monkeypatch):
    monkeypatch.setenv("KILLED_ONCE", str(tmp_path / "killed"))
    (ended,) = run(tasks(Work("killed_once", own_process=True), [5]), 1)
    assert ended.outcome == 5 and ended.attempts == 2


def test_what_always_ends_its_process_is_said_with_both_causes():
    with pytest.raises(InputError, match="importing the model's module ends the process.*or the process was killed from outside"):
        list(run(tasks(Work("always_killed", own_process=True), [5]), 1))
    with pytest.raises(InputError, match="while it was made ready"):
        try_in_a_process(Work("always_killed", own_process=True))


class AtOnce:
    """Counts how many run at once, by name."""

    def __init__(self):
        self.lock, self.now, self.most = threading.Lock(), {}, {}

    def __call__(self, name):
        with self.lock:
            self.now[name] = self.now.get(name, 0) + 1
            self.most[name] = max(self.most.get(name, 0), self.now[name])
        time.sleep(0.01)
        with self.lock:
            self.now[name] -= 1


@pytest.mark.parametrize(("workers", "most"), [(1, 1), (4, 2), (5, 2), (6, 3)])
def test_a_task_of_several_cores_takes_as_many_places_and_all_of_them_where_there_are_fewer(workers, most):
    counts = AtOnce()
    list(run([Task(Work(counts), "two", cores=2) for _ in range(12)], workers))
    assert counts.most == {"two": most}


def test_no_more_like_each_other_run_at_once_than_their_limit_and_others_do_not_wait_for_them():
    counts, others = AtOnce(), AtOnce()
    licensed = [Task(Work(counts), "licensed", limit=Limit("licence", 2), cost=2.0) for _ in range(12)]
    ended = [each.task.argument for each in run(licensed + [Task(Work(others), "other") for _ in range(12)], 4)]
    assert counts.most == {"licensed": 2} and others.most["other"] >= 2
    assert len(ended) == 24 and "other" in ended[:6]


def test_what_is_lost_is_run_again_three_times_and_what_failed_by_itself_is_not():
    left, failed = {"lost twice": 2, "lost for ever": 100}, []

    def loses(name):
        if name == "fails":
            failed.append(name)
            return Failure("crashed", "by itself")
        left[name] -= 1
        return Failure(LOST, "the node is gone") if left[name] >= 0 else name

    ended = {each.task.name: each for each in run(tasks(Work(loses), ["lost twice", "lost for ever", "fails"]), 2)}
    assert ended["lost twice"].outcome == "lost twice" and ended["lost twice"].attempts == 3
    assert ended["lost for ever"].outcome.kind == "lost" and ended["lost for ever"].attempts == 4
    assert ended["fails"].attempts == 1 and failed == ["fails"]


def test_what_is_lost_while_all_is_closed_is_no_outcome():
    gate, begun = threading.Event(), threading.Event()

    def loses(_):
        begun.set()
        gate.wait(30)
        return Failure(LOST, "killed")

    scheduler = Scheduler(1)
    scheduler.submit(tasks(Work(loses), [1]))
    begun.wait(30)
    closing = threading.Thread(target=scheduler.close)
    closing.start()
    gate.set()
    closing.join(30)
    assert list(scheduler.ended()) == []
