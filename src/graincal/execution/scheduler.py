"""Decides which task runs when: the longest first, never more at once than there are workers, wherever each of them runs."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable, Generator, Hashable, Iterator, Sequence
from contextlib import suppress
from heapq import heappop, heappush
from itertools import count
from math import inf
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Literal, NamedTuple, Protocol

from graincal.data import Failure, Response
from graincal.execution.cores import number_of_workers
from graincal.execution.executor import OnExecutor
from graincal.execution.interrupts import interrupts_later
from graincal.execution.processes import CRASHED, Processes
from graincal.execution.task import LOST, Task
from graincal.execution.threads import Done, Threads

if TYPE_CHECKING:
    from graincal.execution.elsewhere import Elsewhere


class Backend(Protocol):
    """Runs the tasks that it is handed, all at once, and tells `done(task, outcome)` from any thread."""

    def submit(self, tasks: Sequence[Task]) -> None: ...

    def stop(self) -> None: ...


HEARS = 0.5
"""Seconds within which a signal is heard."""

RETRIES = 3
"""How often a task is run again that was lost."""


class Ended(NamedTuple):
    """A task that has ended: its outcome, and how often it was run."""

    task: Task
    outcome: Response | Failure
    attempts: int


class Scheduler:
    """Runs tasks from whichever batch, experiment or model, on the backends that these need.

    workers: that run at once on this machine; an executor runs as many as it will where "all" is asked for, and otherwise as many as that. Work goes on while whoever is told an outcome thinks about it. A task whose process
    ended abruptly is run once more when nothing else is under way, for memory may have been short: only then is that its outcome. One that was lost (a failure of the kind `LOST`) is run again up to three times, and
    everything else that a task comes to is its outcome. elsewhere: makes the backend of all tasks whose work has no executor of its own; without it they run on this machine.
    """

    def __init__(self, workers: int | Literal["all"], elsewhere: Callable[[Done], Elsewhere] | None = None) -> None:
        self._local, self._remote = _Pool(number_of_workers(workers)), _Pool(inf if workers == "all" else number_of_workers(workers))
        self._elsewhere = elsewhere
        self._backends: dict[object, Backend] = {}
        self._outcomes: SimpleQueue[tuple[Task, Response | Failure | BaseException]] = SimpleQueue()
        self._lock = threading.Lock()
        self._number = count()
        self._attempts: dict[Task, int] = {}
        self._crashed: list[Task] = []
        self._left = 0
        self._closed = False
        self._filling = threading.local()

    def submit(self, tasks: Sequence[Task]) -> None:
        """Have these run: all at once, so that the longest of them is the first to begin."""
        with self._lock:
            self._left += len(tasks)
            for task in tasks:
                self._put(task)
        self._fill()

    @property
    def left(self) -> int:
        """How many tasks were submitted whose ends were not asked for yet."""
        return self._left

    def next(self) -> Ended:
        """Wait for a task to end. Raises what its work raised."""
        while True:
            # A Ctrl-C that comes just before a wait without end begins would be heard after it.
            with suppress(Empty):
                return self._told(*self._outcomes.get(timeout=HEARS))

    def ended(self) -> Iterator[Ended]:
        """Those that have ended and were not asked for yet, without waiting; not those whose work raised something."""
        while not self._outcomes.empty():
            task, outcome = self._outcomes.get()
            if not isinstance(outcome, BaseException):
                yield self._told(task, outcome)

    def close(self) -> None:
        """End what is under way, as far as it can be ended, and begin nothing more."""
        with self._lock:
            self._closed = True
            backends = list(self._backends.values())
        # A second Ctrl-C is heard when nothing is left behind.
        with interrupts_later():
            for backend in backends:
                backend.stop()

    def _told(self, task: Task, outcome: Response | Failure | BaseException) -> Ended:
        self._left -= 1
        if isinstance(outcome, BaseException):
            raise outcome
        return Ended(task, outcome, self._attempts.pop(task))

    def _put(self, task: Task) -> None:
        self._pool(task).put((task.order, -task.cost, next(self._number), task))

    def _pool(self, task: Task) -> _Pool:
        return self._local if task.work.executor is None and self._elsewhere is None else self._remote

    def _fill(self) -> None:
        """Begin what may begin. An executor may run a task where it is handed over: what ends meanwhile is gone on with by the loop that is running already."""
        if getattr(self._filling, "now", False):
            return
        self._filling.now = True
        try:
            while begun := self._take():
                backend, task = begun
                try:
                    backend.submit([task])
                except Exception as error:
                    # Perhaps in a thread of a backend, where nobody would hear of it.
                    self._done(task, error)
        finally:
            self._filling.now = False

    def _take(self) -> tuple[Backend, Task] | None:
        with self._lock:
            if self._closed:
                return None
            if self._crashed and not any(pool.busy for pool in (self._local, self._remote)):
                self._put(self._crashed.pop())
            for pool in (self._local, self._remote):
                if (task := pool.take()) is not None:
                    self._attempts[task] = self._attempts.get(task, 0) + 1
                    return self._backend(task), task
            return None

    def _backend(self, task: Task) -> Backend:
        work = task.work
        key = work.executor if work.executor is not None else self._elsewhere if self._elsewhere is not None else work.key if work.own_process else None
        if key not in self._backends:
            if work.executor is not None:
                self._backends[key] = OnExecutor(work.executor, self._done)
            elif self._elsewhere is not None:
                self._backends[key] = backend = self._elsewhere(self._done)
                self._remote.most = min(self._remote.most, backend.holds)
            else:
                self._backends[key] = Processes(work, self._done) if work.own_process else Threads(self._done)
        return self._backends[key]

    def _done(self, task: Task, outcome: Response | Failure | BaseException) -> None:
        with self._lock:
            self._pool(task).give_back(task)
            # Whoever hears of it ends all, and nothing more is begun meanwhile.
            self._closed = self._closed or isinstance(outcome, BaseException)
            if outcome is CRASHED and self._attempts[task] == 1:
                self._crashed.append(task)
            elif isinstance(outcome, Failure) and outcome.kind == LOST and self._attempts[task] <= RETRIES:
                self._put(task)
            else:
                self._outcomes.put((task, outcome))
        self._fill()


class _Pool:
    """Tasks that wait for places, of which there are so many, and how many are taken."""

    def __init__(self, most: float) -> None:
        self.most = most
        self._taken = 0.0
        # By each task that runs: `most` may change while it does.
        self._places_of: dict[Task, float] = {}
        self._waiting: list[tuple] = []
        self._running: Counter[Hashable] = Counter()
        self._held: dict[Hashable, list[tuple]] = {}

    @property
    def busy(self) -> bool:
        return bool(self._taken or self._waiting)

    def put(self, entry: tuple) -> None:
        """Have a task wait: the last of what it is sorted by."""
        heappush(self._waiting, entry)

    def take(self) -> Task | None:
        """The first task that waits, with the places that it takes; None where these are not free. Those whose limit is reached stand aside until one like them ends."""
        while self._waiting and self._taken + self._places(task := self._waiting[0][-1]) <= self.most:
            entry, limit = heappop(self._waiting), task.limit
            if limit is not None and self._running[limit.name] >= limit.most:
                heappush(self._held.setdefault(limit.name, []), entry)
                continue
            self._places_of[task] = self._places(task)
            self._taken += self._places_of[task]
            if limit is not None:
                self._running[limit.name] += 1
            return task
        return None

    def give_back(self, task: Task) -> None:
        """A task has ended: its places are free."""
        self._taken -= self._places_of.pop(task)
        if task.limit is not None:
            self._running[task.limit.name] -= 1
            if held := self._held.get(task.limit.name):
                heappush(self._waiting, heappop(held))

    def _places(self, task: Task) -> float:
        return min(task.cores, self.most)


def run(tasks: Sequence[Task], workers: int | Literal["all"] = "all") -> Generator[Ended]:
    """Run tasks to their ends, in the order in which these come. Closing the iterator ends what is under way."""
    scheduler = Scheduler(workers)
    try:
        scheduler.submit(tasks)
        while scheduler.left:
            yield scheduler.next()
    finally:
        scheduler.close()
