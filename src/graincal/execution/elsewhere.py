"""Tasks in worker processes elsewhere: what a cluster's nodes and somebody's executor have in common."""

from __future__ import annotations

import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import suppress
from math import inf
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any
from uuid import uuid4

from graincal import build
from graincal.data import Failure, InputError, Response
from graincal.execution.away import Place, Unknown, evaluate, look
from graincal.execution.processes import CRASHED
from graincal.execution.task import LOST, Task, Work
from graincal.execution.threads import Done
from graincal.notation.printable import as_text

Say = Callable[[str], None]
"""Is told something worth knowing, as a sentence, from any thread."""

_LOOKS = 1.0
"""Seconds between two looks at what is under way."""

TRIES = 3
"""Of the first worker to say where it is."""

ENDS = 120.0
"""Seconds within which all that was taken must have been given back."""

SEEN = ".seen"
"""A file in the campaign's folder, by which a worker knows that it sees that folder."""


class Elsewhere(ABC):
    """A backend: worker processes that somebody else starts, on other machines too. A work is sent to each of them once.

    Before anything is evaluated the first worker says where it is: it must see `folder`, which the campaign is kept in, where something is kept there by whoever runs an evaluation (`needs_folder`).
    What its machine has of another graincal is said. It stops no run early.
    """

    without_folder = ", or `scratch` of the models, which are run on the node's own disk then"
    """What else would do where a node does not see the campaign's folder, as the end of a sentence."""

    own_process = False
    """Whether a work that asks for a process of its own has one there."""

    def __init__(self, done: Done, folder: Path, say: Say, *, needs_folder: bool) -> None:
        self._done, self._folder, self._say, self._needs_folder = done, folder, say, needs_folder
        self._campaign = uuid4().hex
        self._works: dict[str, Work] = {}
        self._under_way: dict[Task, Future] = {}
        # Those that wait until the first worker has said where it is; None from then on.
        self._held: list[Task] | None = []
        self._thread: threading.Thread | None = None
        self._failed: BaseException | None = None
        self._tries = 0
        self._finished: SimpleQueue[tuple[Task | None, Future] | None] = SimpleQueue()
        self._lock = threading.RLock()
        self._stopped = threading.Event()

    holds: float = inf
    """The tasks that can be under way at once, as far as it is known."""

    def begin(self) -> None:
        """Take what is needed. In the thread that all that is taken belongs to, and in which it is given back."""

    @abstractmethod
    def hand_over(self, function: Callable, *arguments: Any) -> Future:
        """Have a function run by a worker. Raises what keeps it from being sent."""

    def looked(self, place: Place) -> None:
        """Is told where the first worker is."""

    @abstractmethod
    def meaning(self, error: BaseException) -> Failure | BaseException:
        """What an exception is that came in the place of an outcome: a Failure, or what ends the campaign."""

    def look_after(self) -> None:
        """Is called about every second. Raises what ends the campaign."""

    @abstractmethod
    def end(self) -> None:
        """End what is under way, and give back what was taken."""

    def submit(self, tasks: Sequence[Task]) -> None:
        """Hand these over. From any thread. Raises what has ended the backend."""
        with self._lock:
            if self._failed is not None:
                raise self._failed
            if self._held is not None:
                self._held += tasks
                if self._thread is None:
                    self._thread = threading.Thread(target=self._watch, name="graincal elsewhere", daemon=True)
                    self._thread.start()
                return
        for task in tasks:
            self._send(task, with_work=False)

    def stop(self) -> None:
        """End what is under way; nothing is told of it any more."""
        self._stopped.set()
        self._finished.put(None)
        if self._thread is not None:
            self._thread.join(ENDS)

    @property
    def under_way(self) -> list[Task]:
        """In the order in which they were handed over."""
        with self._lock:
            return list(self._under_way)

    def give_up(self, task: Task, reason: str) -> None:
        """A task whose end is not waited for any longer: it is lost, and what comes of it later is not heard."""
        with self._lock:
            if self._under_way.pop(task, None) is None:
                return
        self._tell(task, Failure(LOST, reason))

    def fail(self, error: BaseException) -> None:
        """Nothing more can be evaluated: whoever asked hears of this."""
        with self._lock:
            tasks = [*(self._held or ()), *self._under_way]
            self._held, self._under_way, self._failed = None, {}, error
        for task in tasks:
            self._tell(task, error)

    @property
    def waits_for_the_first(self) -> bool:
        """Whether no worker has said yet where it is."""
        return self._held is not None

    def look_first(self) -> None:
        """Ask the first worker where it is, or another one where no answer came. Raises InputError where that was asked often enough."""
        if self._tries == TRIES:
            raise InputError(f"no worker has answered, of {TRIES} that were asked where they are.")
        self._tries += 1
        seen = self._folder / SEEN
        seen.touch()
        future = self.hand_over(look, str(seen))
        future.add_done_callback(lambda future: self._finished.put((None, future)))

    def _send(self, task: Task, *, with_work: bool) -> None:
        work = task.work
        key = f"{self._campaign} {work.key}"
        with self._lock:
            # Kept, so that no other work can ever have its key.
            work = self._works.setdefault(key, work)
            future = self.hand_over(evaluate, key, work if with_work else None, task.argument, self.own_process)
            self._under_way[task] = future
        future.add_done_callback(lambda future: self._finished.put((task, future)))

    def _watch(self) -> None:
        try:
            self.begin()
            self.look_first()
            while not self._stopped.is_set():
                self._hear()
                self.look_after()
        except BaseException as error:
            self.fail(error)
        # Also where it failed: nobody else gives back what was taken.
        self._stopped.wait()
        self.end()

    def _hear(self) -> None:
        """What has finished, for a second at most."""
        until = time.monotonic() + _LOOKS
        with suppress(Empty):
            while not self._stopped.is_set() and (left := until - time.monotonic()) > 0:
                if (finished := self._finished.get(timeout=left)) is not None:
                    task, future = finished
                    self._looked(future) if task is None else self._ended(task, future)

    def _looked(self, future: Future) -> None:
        """The first worker has said where it is, or could not. Raises InputError where nothing can be evaluated there."""
        if not self.waits_for_the_first:
            return
        error = future.exception()
        if error is not None:
            meant = self.meaning(error)
            if isinstance(meant, BaseException):
                raise meant
            # Its block is gone.
            self.look_first()
            return
        place: Place = future.result()
        if not place.sees and self._needs_folder:
            raise InputError(
                f"{self._folder}: this folder is not seen from the node {place.node}; a folder on a file system that the nodes share was expected{self.without_folder}."
            )
        self.looked(place)
        self._compare(place)
        with self._lock:
            held, self._held = self._held or [], None
        for task in held:
            self._send_or_tell(task, with_work=False)

    def _send_or_tell(self, task: Task, *, with_work: bool) -> None:
        try:
            self._send(task, with_work=with_work)
        except Exception as error:
            self._tell(task, error)

    def _compare(self, place: Place) -> None:
        here = build.describe()
        if differing := [f"{name} {place.graincal.get(name)} instead of {value}" for name, value in here.items() if place.graincal.get(name) != value]:
            self._say(f"The node {place.node} has {', '.join(differing)}: figures may differ in the last digits from those of this machine.")

    def _ended(self, task: Task, future: Future) -> None:
        with self._lock:
            if self._under_way.get(task) is not future:
                # Of an attempt that was given up.
                return
            del self._under_way[task]
        error = future.exception()
        outcome = self.meaning(error) if error is not None else future.result()
        if isinstance(outcome, Unknown):
            self._send_or_tell(task, with_work=True)
            return
        # As it is known here.
        self._tell(task, CRASHED if isinstance(outcome, Failure) and outcome == CRASHED else outcome)

    def _tell(self, task: Task, outcome: Response | Failure | BaseException) -> None:
        if not self._stopped.is_set():
            self._done(task, outcome)


class OnNamedExecutor(Elsewhere):
    """A backend: a `concurrent.futures.Executor` that a calibration names, such as Dask's or MPI's, and which ends with the campaign. A work's function runs in the executor's own workers: what these do of a crash is theirs."""

    def __init__(self, executor: Executor, done: Done, folder: Path, say: Say, *, needs_folder: bool) -> None:
        super().__init__(done, folder, say, needs_folder=needs_folder)
        self._executor = executor

    def hand_over(self, function: Callable, *arguments: Any) -> Future:
        return self._executor.submit(function, *arguments)

    def meaning(self, error: BaseException) -> BaseException:
        """Whatever the executor raises ends the campaign, which can be gone on with."""
        if isinstance(error, InputError):
            return error
        return InputError(f"run.executor: it gave up an evaluation ({type(error).__name__}: {as_text(error)}).")

    def end(self) -> None:
        with self._lock:
            futures = list(self._under_way.values())
        if futures and isinstance(self._executor, ProcessPoolExecutor):
            # Python would wait for what they run, and for what waits in their queue, at the end of this process.
            for process in list((self._executor._processes or {}).values()):
                process.kill()
        else:
            for future in futures:
                future.cancel()
        # Workers that have nothing to do end at once, and are not left to the end of the process.
        self._executor.shutdown(wait=not futures)
