"""Evaluations in processes of graincal's own, which end with their owner, by a time-out if there is one, and outlive each other's crashes."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, ThreadPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing, contextmanager, suppress
from math import inf
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnContext
from multiprocessing.process import BaseProcess
from types import FrameType
from typing import Any, TypeVar

from graincal.data import Failure, InputError

Task = TypeVar("Task")
Outcome = TypeVar("Outcome")

CRASHED = Failure("crashed", "the process that ran the evaluation ended abruptly: a crash in compiled code, or too little memory.")
"""The outcome of an evaluation whose process ended abruptly."""


def evaluate_in_processes(
    call: Callable[[Task], Outcome],
    tasks: Sequence[Task],
    count: int,
    *,
    prepare: Callable[[], object] | None = None,
    timeout: float | None = None,
) -> Iterator[tuple[int, Outcome | Failure]]:
    """Run call(task) for each task in `count` processes and yield (index, outcome) in order of completion.

    prepare: called first in each process. timeout: the seconds that a call may take, `prepare` not counted; then its process is killed, with the
    processes that it started, and the outcome is a Failure of the kind "timed_out".
    An evaluation whose process ends abruptly is run again after all others, by itself, for memory may have been short: if it fails again, it is a
    Failure of the kind "crashed".
    Closing the iterator kills what is under way. Raises InputError where processes cannot be started.
    """
    crashed = []
    with closing(_evaluate(call, list(enumerate(tasks)), count, prepare, timeout)) as outcomes:
        for index, outcome in outcomes:
            if outcome is CRASHED:
                crashed.append((index, tasks[index]))
            else:
                yield index, outcome
    with closing(_evaluate(call, crashed, 1, prepare, timeout)) as outcomes:
        yield from outcomes


def _evaluate(
    call: Callable[[Task], Outcome],
    tasks: Sequence[tuple[int, Task]],
    count: int,
    prepare: Callable[[], object] | None,
    timeout: float | None,
) -> Iterator[tuple[int, Outcome | Failure]]:
    waiting = deque(tasks)
    workers = [_Worker(prepare, timeout) for _ in range(min(count, len(tasks)))]
    try:
        while waiting or any(worker.busy for worker in workers):
            for worker in workers:
                if waiting and not worker.busy:
                    worker.begin(call, *waiting.popleft())
            busy = [worker for worker in workers if worker.busy]
            # In this order: a process that becomes ready in between is an event.
            events = [event for worker in busy for event in worker.events]
            deadline = min(worker.deadline for worker in busy)
            wait(events, None if deadline == inf else max(0.0, deadline - time.monotonic()), FIRST_COMPLETED)
            for worker in busy:
                index, outcome = worker.index, worker.outcome()
                if outcome is not None:
                    yield index, outcome
    finally:
        # At once: each waits until its process has gone.
        with ThreadPoolExecutor(max(1, len(workers))) as ends:
            list(ends.map(_Worker.end, workers))


class Processes:
    """Processes that are kept from one evaluation to the next: as many as are called for at once.

    prepare and timeout as of `evaluate_in_processes`. Nothing is run again: the outcome of an evaluation whose process ends abruptly is `CRASHED`.
    """

    def __init__(self, prepare: Callable[[], object] | None = None, timeout: float | None = None) -> None:
        self._prepare, self._timeout = prepare, timeout
        self._workers: list[_Worker] = []
        self._idle: list[_Worker] = []
        self._lock = threading.Lock()
        self._stopped = False

    def run(self, call: Callable[[Task], Outcome], task: Task) -> Outcome | Failure:
        """call(task) in a process that is idle, or a new one; from any thread. Raises InputError where processes cannot be started."""
        with self._lock:
            if not self._idle:
                self._idle.append(_Worker(self._prepare, self._timeout))
                self._workers.append(self._idle[-1])
            worker = self._idle.pop()
        worker.begin(call, 0, task)
        if self._stopped:
            # In between: whoever stopped them has not seen this process.
            worker.end()
        while (outcome := worker.outcome()) is None:
            deadline = worker.deadline
            wait(worker.events, None if deadline == inf else max(0.0, deadline - time.monotonic()), FIRST_COMPLETED)
        with self._lock:
            self._idle.append(worker)
        return outcome

    def stop(self) -> None:
        """End all processes, and the evaluations that are under way."""
        self._stopped = True
        with self._lock:
            workers = list(self._workers)
        with ThreadPoolExecutor(max(1, len(workers))) as ends:
            list(ends.map(_Worker.end, workers))


class _Worker:
    """A process that runs one evaluation at a time; if it is lost, the next evaluation begins another."""

    def __init__(self, prepare: Callable[[], object] | None, timeout: float | None) -> None:
        self.index = -1
        self._prepare, self._timeout = prepare, timeout
        self._process: _Process | None = None
        self._future: Future | None = None
        self._begun = 0.0

    @property
    def busy(self) -> bool:
        """Whether an evaluation is under way."""
        return self._future is not None

    @property
    def events(self) -> list[Future]:
        """What the evaluation under way waits for: its end, and before that the start of its process."""
        return [self._future] if self._process.ready_at < inf else [self._process.started, self._future]

    @property
    def deadline(self) -> float:
        """When the evaluation under way is to be given up."""
        return inf if self._timeout is None else max(self._begun, self._process.ready_at) + self._timeout

    def begin(self, call: Callable[[Task], Outcome], index: int, task: Task) -> None:
        """Run an evaluation."""
        if self._process is None:
            self._process = _Process(self._prepare)
        self.index, self._begun = index, time.monotonic()
        try:
            self._future = self._process.executor.submit(call, task)
        except BrokenProcessPool:
            self._process.check()
            # It ended while it had nothing to do.
            self._lose()
            self.begin(call, index, task)

    def outcome(self) -> Outcome | Failure | None:
        """What the evaluation gave; None while it is under way."""
        if self._process.started.done():
            self._process.check()
        if self._future.done():
            finished, self._future = self._future, None
            try:
                return finished.result()
            except BrokenProcessPool:
                self._lose()
                return CRASHED
        if time.monotonic() < self.deadline:
            return None
        self._lose()
        return Failure("timed_out", f"the evaluation took longer than the time-out of {self._timeout:g} s.", {"seconds": self._timeout})

    def end(self) -> None:
        """End the process, and the evaluation that is under way."""
        # It may be lost in this moment.
        if (process := self._process) is not None:
            process.end(abruptly=self.busy)

    def _lose(self) -> None:
        self._process.end(abruptly=True)
        self._process = self._future = None


class _Process:
    """A process that lives as long as its owner holds the other end of a pipe: it ends with it, even if that is killed."""

    def __init__(self, prepare: Callable[[], object] | None) -> None:
        self._context = _OneProcess()
        reader, self._lifeline = self._context.Pipe(duplex=False)
        self.executor = ProcessPoolExecutor(1, mp_context=self._context, initializer=_live_while_open, initargs=(reader,))
        self.ready_at = inf
        try:
            with _sigint_later():
                # Before anything of the user's: whether a process can run at all.
                self._alive = self.executor.submit(os.getpid)
            self.started = self.executor.submit(_make_ready, prepare)
            self.started.add_done_callback(self._is_ready)
        except BaseException:
            # Ctrl-C, in between: nobody else knows of this process yet.
            self.end(abruptly=True)
            raise

    def _is_ready(self, _: Future) -> None:
        self.ready_at = time.monotonic()

    def check(self) -> None:
        """Raise what kept the process from starting."""
        try:
            self.started.result()
        except BrokenProcessPool:
            if self._alive.exception() is None:
                raise InputError(
                    "a worker process ended abruptly while it was made ready, before its first evaluation: importing the model's module ends "
                    "the process that it is imported in, by a crash in compiled code, an exit or too little memory."
                ) from None
            raise InputError(
                'worker processes could not be started, as happens when a script that uses them is not guarded by: if __name__ == "__main__".'
            ) from None

    def end(self, *, abruptly: bool) -> None:
        """Let the process end; abruptly, kill it with all that it started."""
        if abruptly:
            self._lifeline.close()
            # Compiled code that never comes back to Python does not see the pipe close, nor does a process that has not begun to look.
            self._context.kill()
        self.executor.shutdown(cancel_futures=True)


def _make_ready(prepare: Callable[[], object] | None) -> None:
    if prepare is not None:
        prepare()


class _OneProcess(SpawnContext):
    """A context that knows the one process that was begun in it: a fresh one, not a fork, which would copy locks that other threads hold."""

    process: BaseProcess | None = None

    def Process(self, *arguments: Any, **options: Any) -> BaseProcess:
        """Where an executor begins its process."""
        self.process = super().Process(*arguments, **options)
        return self.process

    def kill(self) -> None:
        """Kill the process with all that it started, however far it has come."""
        if self.process is None or not self.process.is_alive():
            return
        with suppress(ProcessLookupError):
            pid = self.process.pid
            # Until it leads a group of its own it is in that of its owner.
            end = os.killpg if os.getpgid(pid) == pid else os.kill
            end(pid, signal.SIGKILL)


@contextmanager
def _sigint_later() -> Iterator[None]:
    """What Ctrl-C means here it means at the end: broken off in between, a process would live on of which nobody knows.

    A process that is begun meanwhile does not hear Ctrl-C until it asks to: what it means is the owner's affair.
    """
    # Blocked in this thread, whose mask a process inherits, it still reaches the owner by another thread.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    # Handlers run in the main thread, and can be set there alone.
    handler = signal.getsignal(signal.SIGINT) if threading.current_thread() is threading.main_thread() else None
    heard: list[tuple[int, FrameType | None]] = []
    if callable(handler):
        signal.signal(signal.SIGINT, lambda *arguments: heard.append(arguments))
    try:
        yield
    finally:
        if callable(handler):
            signal.signal(signal.SIGINT, handler)
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        if heard:
            handler(*heard[0])


def _live_while_open(lifeline: Connection) -> None:
    # A group of its own, so that what an evaluation starts ends with it.
    os.setpgrp()
    # Ctrl-C, which was blocked until now, reaches every process of a terminal's group.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})

    def watch() -> None:
        try:
            lifeline.recv_bytes()
        except (EOFError, OSError):
            pass
        os.killpg(0, signal.SIGKILL)

    threading.Thread(target=watch, daemon=True).start()
