"""Tasks in processes of graincal's own, which end with their owner, by a time-out if there is one, and outlive each other's crashes."""

from __future__ import annotations

import os
import signal
import threading
import time
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, ThreadPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from math import inf
from multiprocessing.connection import Connection
from multiprocessing.connection import wait as wait_for
from multiprocessing.context import SpawnContext
from multiprocessing.process import BaseProcess
from multiprocessing.resource_tracker import ensure_running
from typing import Any

from graincal.data import Failure, InputError, Response
from graincal.execution.interrupts import ENDING, interrupts_later
from graincal.execution.task import Task, Work
from graincal.execution.threads import PATIENCE, Done, Threads
from graincal.notation.printable import as_text

CRASHED = Failure("crashed", "the process that ran the evaluation ended abruptly: a crash in compiled code, or too little memory.")
"""The outcome of an evaluation whose process ended abruptly."""


class Processes(Threads):
    """A backend for the tasks of one work: as many processes as tasks were handed over at once, each of which runs one task at a time, and is kept for the next.

    An evaluation that takes longer than the work's `timeout`, `prepare` not counted, is ended with the processes that it started: a Failure of the kind "timed_out". Nothing is run again: the outcome of one whose process
    ends abruptly is `CRASHED`. It stops no run early. What processes cannot be started for is raised, an InputError.
    """

    def __init__(self, work: Work, done: Done) -> None:
        super().__init__(done)
        self._work_of_all = work
        self._workers: list[_Worker] = []
        self._idle: list[_Worker] = []
        self._unready: set[Task] = set()

    def run(self, task: Task) -> Response | Failure:
        """The task's outcome, from a process that is idle, or a new one."""
        with self._lock:
            if not self._idle:
                self._idle.append(_Worker(self._work_of_all))
                self._workers.append(self._idle[-1])
            worker = self._idle.pop()
        try:
            return self._outcome(worker, task)
        except _NotReady as why:
            # As under a short memory: the task is run again when nothing else is under way.
            if task in self._unready:
                raise InputError(str(why)) from None
            self._unready.add(task)
            return CRASHED
        finally:
            with self._lock:
                self._idle.append(worker)

    def stop(self) -> None:
        """End all processes, and the evaluations that are under way."""
        self._stopped.set()
        with self._lock:
            workers = list(self._workers)
        with ThreadPoolExecutor(max(1, len(workers))) as ends:
            list(ends.map(_Worker.end, workers))
        super().stop()

    def _outcome(self, worker: _Worker, task: Task) -> Response | Failure:
        worker.begin(task.argument)
        if self._stopped.is_set():
            # In between: whoever stopped them has not seen this process.
            worker.end()
        while (outcome := worker.outcome()) is None:
            deadline = worker.deadline
            wait(worker.events, None if deadline == inf else max(0.0, deadline - time.monotonic()), FIRST_COMPLETED)
        return outcome


def try_in_a_process(work: Work) -> None:
    """Make a process ready for the work, and end it. Raises InputError for what keeps it from that."""
    process = _Process(work)
    try:
        process.started.exception()
        process.check()
    except _NotReady as why:
        raise InputError(str(why)) from None
    finally:
        process.end(abruptly=False)


class _NotReady(Exception):
    """A process ended before its first evaluation. The message says what may be the cause."""


class _Worker:
    """A process that runs one evaluation at a time; if it is lost, the next evaluation begins another."""

    def __init__(self, work: Work) -> None:
        self._work, self._timeout = work, work.timeout
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
        process, future = self._under_way
        return [future] if process.ready_at < inf else [process.started, future]

    @property
    def deadline(self) -> float:
        """When the evaluation under way is to be given up."""
        process, _ = self._under_way
        return inf if self._timeout is None else max(self._begun, process.ready_at) + self._timeout

    @property
    def _under_way(self) -> tuple[_Process, Future]:
        assert self._process is not None and self._future is not None, "asked of a worker that is busy"
        return self._process, self._future

    def begin(self, argument: Any) -> None:
        """Run an evaluation."""
        if self._process is None:
            self._process = _Process(self._work)
        self._begun = time.monotonic()
        try:
            self._future = self._process.executor.submit(_evaluate, argument)
        except BrokenProcessPool:
            self._check()
            # It ended while it had nothing to do.
            self._lose()
            self.begin(argument)

    def outcome(self) -> Response | Failure | None:
        """What the evaluation gave; None while it is under way."""
        process, future = self._under_way
        if process.started.done():
            self._check()
        if future.done():
            self._future = None
            try:
                return future.result()
            except BrokenProcessPool:
                self._lose()
                return CRASHED
            except BaseException as error:
                # What the evaluation gave cannot be sent, or cannot be read here.
                return Failure(
                    "error", f"what the evaluation returned cannot be sent to the process that asked for it ({type(error).__name__}: {as_text(error)})."
                )
        if self._timeout is None or time.monotonic() < self.deadline:
            return None
        self._lose()
        return Failure("timed_out", f"the evaluation took longer than the time-out of {self._timeout:g} s.", {"seconds": self._timeout})

    def end(self) -> None:
        """End the process, and the evaluation that is under way."""
        # It may be lost in this moment.
        if (process := self._process) is not None:
            process.end(abruptly=self.busy)

    def _check(self) -> None:
        """Raise what kept the process from starting; the next evaluation begins another."""
        assert self._process is not None, "a process was begun"
        try:
            self._process.check()
        except BaseException:
            self._lose()
            raise

    def _lose(self) -> None:
        assert self._process is not None, "a process was begun"
        self._process.end(abruptly=True)
        self._process = self._future = None


class _Process:
    """A process that lives as long as its owner holds the other end of a pipe: it ends with it, even if that is killed."""

    def __init__(self, work: Work) -> None:
        self._context = _OneProcess()
        self._ending, self._ended = threading.Lock(), False
        reader, self._lifeline = self._context.Pipe(duplex=False)
        with interrupts_later():
            # Python's own helper, of which there is one for all, is to live as long as its owner: through a logout, too.
            ensure_running()
        self.executor = ProcessPoolExecutor(1, mp_context=self._context, initializer=_live_while_open, initargs=(reader,))
        self.ready_at = inf
        try:
            with interrupts_later():
                # Before anything of the user's: whether a process can run at all.
                self._alive = self.executor.submit(os.getpid)
            self.started = self.executor.submit(_make_ready, work)
            self.started.add_done_callback(self._is_ready)
        except BaseException:
            # Ctrl-C, in between: nobody else knows of this process yet.
            self.end(abruptly=True)
            raise

    def _is_ready(self, _: Future) -> None:
        self.ready_at = time.monotonic()

    def check(self) -> None:
        """Raise what kept the process from starting: `_NotReady` where it ended abruptly."""
        try:
            self.started.result()
        except BrokenProcessPool:
            if self._alive.exception() is None:
                raise _NotReady(
                    "a worker process ended abruptly while it was made ready, before its first evaluation: either importing the model's module ends the process that it is imported in, by a crash in compiled code or an exit, "
                    "or the process was killed from outside, as happens where memory is short."
                ) from None
            raise InputError(
                'worker processes could not be started, as happens when a script that uses them is not guarded by: if __name__ == "__main__".'
            ) from None

    def end(self, *, abruptly: bool) -> None:
        """Let the process end, and kill what it leaves behind: threads that go on, and processes that it started. Abruptly, kill it at once."""
        # Once: where evaluations are stopped, the thread that waits for one finds its process lost meanwhile.
        with self._ending:
            if self._ended:
                return
            self._ended = True
            if not abruptly:
                self.executor.shutdown(wait=False, cancel_futures=True)
                self._context.wait(PATIENCE)
            self._context.kill()
            # Compiled code that never comes back to Python does not see the pipe close, nor does a process that has not begun to look.
            self._lifeline.close()
            self.executor.shutdown(cancel_futures=True)


_work: Work | None = None
"""In a process of `Processes`: what its evaluations share, which is sent once."""


def _make_ready(work: Work) -> None:
    global _work
    work.prepare()
    _work = work


def _evaluate(argument: Any) -> Response | Failure:
    assert _work is not None, "the process was made ready"
    return _work(argument)


class _OneProcess(SpawnContext):
    """A context that knows the one process that was begun in it: a fresh one, not a fork, which would copy locks that other threads hold."""

    process: BaseProcess | None = None

    def Process(self, *arguments: Any, **options: Any) -> BaseProcess:  # type: ignore[override]  # typeshed has it as a class, and it is a method
        """Where an executor begins its process."""
        self.process = super().Process(*arguments, **options)
        return self.process

    def wait(self, seconds: float) -> None:
        """Give the process so long to end."""
        if self.process is not None and self.process.pid is not None:
            wait_for([self.process.sentinel], seconds)

    def kill(self) -> None:
        """Kill the process with all that it started, however far it has come, or what is left of these where it has ended."""
        if self.process is None or (pid := self.process.pid) is None:
            return
        with suppress(ProcessLookupError, PermissionError):
            # A group of its own outlives it as long as there is somebody in it.
            os.killpg(pid, signal.SIGKILL)
            return
        with suppress(ProcessLookupError, ValueError):
            # Until it leads a group of its own it is in that of its owner.
            if self.process.is_alive():
                os.kill(pid, signal.SIGKILL)


def _live_while_open(lifeline: Connection) -> None:
    # A group of its own, so that what an evaluation starts ends with it.
    os.setpgrp()
    # These were blocked until now, and reach every process of a terminal's group or of a batch system's job: the owner ends this one.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for number in (signal.SIGTERM, signal.SIGHUP):
        # Not ignored, which programs that an evaluation starts would inherit.
        signal.signal(number, lambda *arguments: None)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDING)

    def watch() -> None:
        try:
            lifeline.recv_bytes()
        except (EOFError, OSError):
            pass
        os.killpg(0, signal.SIGKILL)

    threading.Thread(target=watch, daemon=True).start()
