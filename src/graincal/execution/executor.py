"""Tasks on an executor that somebody hands over: threads, processes, Dask, MPI."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from concurrent.futures import Executor, Future
from functools import partial

from graincal.data import Failure, Response
from graincal.execution.task import Task
from graincal.execution.threads import Done


class OnExecutor:
    """A backend: a `concurrent.futures.Executor`, which stays its owner's. What it raises itself (a function that cannot be sent, lost workers) is what a task came to. It stops no run early."""

    def __init__(self, executor: Executor, done: Done) -> None:
        self._executor, self._done = executor, done
        self._futures: set[Future] = set()
        self._stopped = threading.Event()

    def submit(self, tasks: Sequence[Task]) -> None:
        """Hand these over. From any thread."""
        for task in tasks:
            try:
                future = self._executor.submit(task.work, task.argument)
            except Exception as error:
                self._done(task, error)
                continue
            self._futures.add(future)
            future.add_done_callback(partial(self._ended, task))

    def stop(self) -> None:
        """Cancel what has not begun; what cannot be cancelled is not waited for, and nothing is told of it any more."""
        self._stopped.set()
        for future in list(self._futures):
            future.cancel()

    def _ended(self, task: Task, future: Future) -> None:
        self._futures.discard(future)
        if self._stopped.is_set():
            return
        outcome: Response | Failure | BaseException
        try:
            outcome = future.result()
        except BaseException as error:
            outcome = error
        self._done(task, outcome)
