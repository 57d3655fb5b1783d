"""Evaluations on an executor that somebody hands over: threads, processes, Dask, Parsl, MPI."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, as_completed
from typing import TypeVar

Task = TypeVar("Task")
Outcome = TypeVar("Outcome")


def evaluate_each(call: Callable[[Task], Outcome], tasks: Sequence[Task], executor: Executor) -> Iterator[tuple[int, Outcome]]:
    """Run call(task) for each task on the executor and yield (index, outcome) in order of completion.

    Closing the iterator cancels what has not begun. What the executor itself raises (a function that cannot be sent, lost workers) is raised.
    """
    futures = {executor.submit(call, task): index for index, task in enumerate(tasks)}
    try:
        for future in as_completed(futures):
            yield futures[future], future.result()
    finally:
        for future in futures:
            future.cancel()
