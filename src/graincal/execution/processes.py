"""Worker processes that end with their owner and outlive each other's crashes."""

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


class WorkerProcesses:
    """`count` processes, started when first used and kept from one batch to the next.

    A process that ends abruptly takes the pool down with it. Then those evaluations that were under way are run again, each in a process of its
    own: the one that fails again is a Failure of the kind "crashed", the others are unharmed, and the rest goes on in a new pool.
    """

    def __init__(self, count: int) -> None:
        self.count = count
        self._pool: _Pool | None = None

    def evaluate_each(self, call: Callable[[Task], Outcome], tasks: Sequence[Task]) -> Iterator[tuple[int, Outcome | Failure]]:
        """Run call(task) for each task and yield (index, outcome) in order of completion. Closing the iterator kills what is under way."""
        waiting = deque(enumerate(tasks))
        while waiting:
            self._pool = self._pool or _Pool(self.count)
            running = {}
            try:
                # No more than run at once, so that a crash leaves few suspects.
                while waiting or running:
                    while waiting and len(running) < self.count:
                        index, task = waiting[0]
                        running[self._pool.executor.submit(call, task)] = index, task
                        waiting.popleft()
                    for future in wait(running, return_when=FIRST_COMPLETED).done:
                        outcome = future.result()
                        index, _ = running.pop(future)
                        yield index, outcome
            except BrokenProcessPool:
                self._kill()
                for index, task in running.values():
                    yield index, _run_alone(call, task)
            except BaseException:
                self._kill()
                raise

    def _kill(self) -> None:
        self._pool.kill()
        self._pool = None


def _run_alone(call: Callable[[Task], Outcome], task: Task) -> Outcome | Failure:
    pool = _Pool(1)
    try:
        return pool.executor.submit(call, task).result()
    except BrokenProcessPool:
        return _CRASHED
    finally:
        pool.kill()


class _Pool:
    """Processes that live as long as their owner holds the other end of a pipe: they end with it, even if it is killed."""

    def __init__(self, count: int) -> None:
        # Fresh processes, not forks: those would copy locks that other threads hold.
        context = multiprocessing.get_context("spawn")
        reader, self._lifeline = context.Pipe(duplex=False)
        self.executor = ProcessPoolExecutor(count, mp_context=context, initializer=_live_while_open, initargs=(reader,))
        try:
            self.executor.submit(os.getpid).result()
        except BrokenProcessPool:
            raise InputError(
                "worker processes could not be started, as happens when a script that uses them is not guarded by: if __name__ == \"__main__\"."
            ) from None

    def kill(self) -> None:
        self._lifeline.close()
        self.executor.shutdown(wait=False, cancel_futures=True)


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
