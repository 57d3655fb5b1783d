"""Tasks on threads of this process: the engine's, and functions that cannot be sent anywhere else."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from queue import SimpleQueue

from graincal.data import Failure, InputError, Response
from graincal.execution.task import Task

Done = Callable[[Task, "Response | Failure | BaseException"], None]
"""Is told what a task came to, from any thread: its outcome, or what its work raised."""

PATIENCE = 1.0
"""Seconds that evaluations are given to end when no more are wanted."""


class Threads:
    """A backend: at most as many threads as tasks were handed over at once; each runs one task at a time."""

    def __init__(self, done: Done) -> None:
        self._done = done
        self._waiting: SimpleQueue[Task | None] = SimpleQueue()
        self._threads: list[threading.Thread] = []
        self._open = 0
        self._lock = threading.Lock()
        self._stopped = threading.Event()

    def submit(self, tasks: Sequence[Task]) -> None:
        """Have these run at once: whoever submits them counts how many there are. From any thread. Raises InputError where the system gives no thread, and runs none of them then."""
        with self._lock:
            self._open += len(tasks)
            for _ in range(self._open - len(self._threads)):
                # A function that never ends must not keep the interpreter from ending.
                thread = threading.Thread(target=self._work, daemon=True)
                try:
                    thread.start()
                except RuntimeError as error:
                    self._open -= len(tasks)
                    raise InputError(
                        f"workers: only {len(self._threads)} threads could be started ({error}), and a number that the system has room for was expected."
                    ) from None
                self._threads.append(thread)
        for task in tasks:
            self._waiting.put(task)

    def stop(self) -> None:
        """End what is under way, as far as it can be ended; nothing is told of it any more."""
        self._stopped.set()
        for _ in self._threads:
            self._waiting.put(None)
        # Simulations that end now must not find the interpreter gone; whatever cannot be stopped is not waited for.
        patience = time.monotonic() + PATIENCE
        for thread in self._threads:
            if thread is not threading.current_thread():
                thread.join(max(0.0, patience - time.monotonic()))

    def run(self, task: Task) -> Response | Failure:
        """The task's outcome, in a thread of this backend."""
        run = getattr(task.work, "run", None)
        return task.work(task.argument) if run is None else run(task.argument, self._stopped.is_set, task.watch)

    def _work(self) -> None:
        while (task := self._waiting.get()) is not None:
            outcome: Response | Failure | BaseException
            try:
                outcome = self.run(task)
            except BaseException as error:
                outcome = error
            with self._lock:
                self._open -= 1
            if not self._stopped.is_set():
                self._done(task, outcome)
