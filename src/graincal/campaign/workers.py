"""Workers that go from one evaluation to the next, of whichever batch or experiment: none waits for the longest run of a batch."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator, Sequence
from functools import partial
from heapq import heappop, heappush
from math import inf
from queue import SimpleQueue
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.experiment import Experiment
from graincal.data import Failure, Response, Samples
from graincal.execution import CRASHED
from graincal.inference.early_stop import EarlyStop


PATIENCE = 1.0
"""Seconds that evaluations are given to end when no more are wanted."""


class Task(NamedTuple):
    """One evaluation. Tasks are taken in the order of their fields: the earliest batch first, then one experiment after the other, the longest run first."""

    iteration: int
    experiment: int
    shortness: float
    id: int


class Workers:
    """Threads, `count` of them at most, each with one evaluation at a time; they do not stop while whoever is told an outcome thinks about it."""

    def __init__(self, experiments: Sequence[Experiment], count: int, stops_early: bool) -> None:
        """stops_early: whether runs may be stopped (`give`): otherwise their states are not looked at."""
        self._experiments = experiments
        self._models = [experiment.one_by_one(partial(self._hopeless, number) if stops_early else None) for number, experiment in enumerate(experiments)]
        # What waits in an executor's queue is no work of this machine's.
        self._most = inf if all(model.queues for model in self._models) else count
        self._samples: dict[int, Samples] = {}
        self._early_stops: dict[int, EarlyStop] = {}
        self._waiting: list[Task] = []
        self._changed = threading.Condition()
        self._threads: list[threading.Thread] = []
        self._idle = self._under_way = 0
        self._closed = False
        self._outcomes: SimpleQueue[tuple[Task, Response | Failure | BaseException]] = SimpleQueue()
        self._crashed: list[Task] = []
        self._again: set[Task] = set()

    def give(self, iteration: int, experiment: int, samples: Samples, early_stop: EarlyStop | None = None) -> None:
        """Have samples of an iteration evaluated in an experiment. early_stop: when their runs may be stopped."""
        if early_stop:
            self._early_stops |= dict.fromkeys(samples.ids.tolist(), early_stop)
        lengths = self._experiments[experiment].expected_lengths(samples)
        tasks = []
        for row, (id, length) in enumerate(zip(samples.ids, lengths)):
            self._samples[int(id)] = samples.take([row])
            tasks.append(Task(iteration, experiment, -float(length), int(id)))
        self._put(tasks)

    def next(self) -> tuple[Task, Response | Failure]:
        """Wait for an evaluation to end. Raises what the model raised.

        One whose process ended abruptly is run again when nothing else is under way, for memory may have been short.
        """
        while True:
            if not self._under_way and self._crashed:
                task = self._crashed.pop()
                self._again.add(task)
                self._put([task])
            task, outcome = self._outcomes.get()
            self._under_way -= 1
            if isinstance(outcome, BaseException):
                raise outcome
            if outcome is not CRASHED or task in self._again:
                return task, outcome
            self._crashed.append(task)

    def ended(self) -> Iterator[tuple[Task, Response | Failure]]:
        """What has ended and was not asked for yet, without waiting."""
        while not self._outcomes.empty():
            task, outcome = self._outcomes.get()
            self._under_way -= 1
            if isinstance(outcome, Response) or (isinstance(outcome, Failure) and outcome is not CRASHED):
                yield task, outcome

    def close(self) -> None:
        """End what is under way, and begin nothing more."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        for model in self._models:
            model.stop()
        # Simulations that end now must not find the interpreter gone; whatever cannot be stopped is not waited for.
        patience = time.monotonic() + PATIENCE
        for thread in self._threads:
            thread.join(max(0.0, patience - time.monotonic()))

    def _put(self, tasks: Sequence[Task]) -> None:
        """All at once, so that the longest of them is the first to be taken."""
        self._under_way += len(tasks)
        with self._changed:
            for task in tasks:
                heappush(self._waiting, task)
            for _ in range(int(min(len(self._waiting) - self._idle, self._most - len(self._threads)))):
                # A function that never ends must not keep the interpreter from ending.
                self._threads.append(threading.Thread(target=self._work, daemon=True))
                self._threads[-1].start()
            self._changed.notify_all()

    def _work(self) -> None:
        while (task := self._take()) is not None:
            try:
                outcome = self._models[task.experiment].evaluate(self._samples[task.id])
            except BaseException as error:
                outcome = error
            self._outcomes.put((task, outcome))

    def _hopeless(self, experiment: int, id: int, states: NDArray[np.float64]) -> bool:
        return id in self._early_stops and self._early_stops[id].hopeless(experiment, id, states)

    def _take(self) -> Task | None:
        with self._changed:
            self._idle += 1
            self._changed.wait_for(lambda: self._waiting or self._closed)
            self._idle -= 1
            return None if self._closed else heappop(self._waiting)
