"""Evaluations in processes of graincal's own, which end with their owner and outlive each other's crashes."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.connection import Connection
from typing import TypeVar

from graincal.data import Failure, InputError

Task = TypeVar("Task")
Outcome = TypeVar("Outcome")

_CRASHED = Failure("crashed", "the process that ran the evaluation ended abruptly: a crash in compiled code, or too little memory.")


def evaluate_in_processes(call: Callable[[Task], Outcome], tasks: Sequence[Task], count: int) -> Iterator[tuple[int, Outcome | Failure]]:
    """Run call(task) for each task in `count` processes and yield (index, outcome) in order of completion.

    A process that ends abruptly takes its pool down with it. Then the evaluations that were under way are run again, each in a process of its own:
    the one that fails again is a Failure of the kind "crashed", the others are unharmed, and the rest goes on in a new pool.
    Closing the iterator kills what is under way. Raises InputError where processes cannot be started.
    """
    waiting = deque(enumerate(tasks))
    while waiting:
        under_way: dict[int, Task] = {}
        try:
            with _Pool(min(count, len(waiting))) as pool:
                yield from _until_a_crash(pool, call, waiting, under_way, count)
        except BrokenProcessPool:
            for index, task in under_way.items():
                yield index, _run_alone(call, task)


def _until_a_crash(
    pool: ProcessPoolExecutor, call: Callable[[Task], Outcome], waiting: deque[tuple[int, Task]], under_way: dict[int, Task], count: int
) -> Iterator[tuple[int, Outcome]]:
    futures = {}
    while waiting or futures:
        # No more than run at once, so that a crash leaves few suspects.
        while waiting and len(futures) < count:
            index, task = waiting[0]
            futures[pool.submit(call, task)] = index
            under_way[index] = task
            waiting.popleft()
        for future in wait(futures, return_when=FIRST_COMPLETED).done:
            outcome = future.result()
            index = futures.pop(future)
            del under_way[index]
            yield index, outcome


def _run_alone(call: Callable[[Task], Outcome], task: Task) -> Outcome | Failure:
    try:
        with _Pool(1) as pool:
            return pool.submit(call, task).result()
    except BrokenProcessPool:
        return _CRASHED


class _Pool:
    """A pool whose processes live as long as their owner holds the other end of a pipe: they end with it, even if it is killed."""

    def __init__(self, count: int) -> None:
        # Fresh processes, not forks: those would copy locks that other threads hold.
        context = multiprocessing.get_context("spawn")
        reader, self._lifeline = context.Pipe(duplex=False)
        self._executor = ProcessPoolExecutor(count, mp_context=context, initializer=_live_while_open, initargs=(reader,))

    def __enter__(self) -> ProcessPoolExecutor:
        try:
            self._executor.submit(os.getpid).result()
        except BrokenProcessPool:
            raise InputError(
                'worker processes could not be started, as happens when a script that uses them is not guarded by: if __name__ == "__main__".'
            ) from None
        return self._executor

    def __exit__(self, exception, *_) -> None:
        if exception is not None:
            self._lifeline.close()
        self._executor.shutdown(cancel_futures=True)


def _live_while_open(lifeline: Connection) -> None:
    # Ctrl-C reaches every process of a terminal; what it means is the owner's affair.
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def watch() -> None:
        try:
            lifeline.recv_bytes()
        except (EOFError, OSError):
            pass
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
