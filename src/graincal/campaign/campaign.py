"""The loop of a calibration: ask the filter, evaluate, store, tell."""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import closing
from functools import partial
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from graincal.campaign.calibration import Calibration, Filter
from graincal.campaign.curves import file_name, write_curve
from graincal.campaign.learnt import Learnt
from graincal.campaign.listener import Listener
from graincal.campaign.packings import study_packings
from graincal.campaign.replay import tell
from graincal.campaign.result import Result
from graincal.campaign.store import OUT_OF_TIME, SPENT, Store
from graincal.campaign.trouble import FolderError
from graincal.campaign.workers import Workers
from graincal.data import Failure, Response, Samples
from graincal.inference import PosteriorFilter
from graincal.inference.early_stop import EarlyStop

CURVES = "curves"

OFTEN = 30.0
"""Seconds after which it is stored anew how long a campaign has run: what a kill loses of the clock."""


class Campaign:
    """A calibration as it runs, on a store that holds nothing of it yet, or some, or all.

    There is no other way to resume than to run: the filter is a function of what it is told, so it asks again for what the store holds, is told
    that, and goes on to what is waiting.
    """

    def __init__(self, calibration: Calibration, store: Store, listeners: Sequence[Listener] = ()) -> None:
        self.calibration = calibration
        self.store = store
        self.listeners = tuple(listeners)
        self._batches_given = 0
        self._began, self._spent_before = time.monotonic(), float(store.meta(SPENT) or 0)
        self._noted = self._began

    def run(self) -> Result:
        """Go on to the end."""
        for listener in self.listeners:
            listener.begins(self.calibration)
        try:
            return self._to_the_end()
        finally:
            self.store.spend(self._spent)

    def _to_the_end(self) -> Result:
        filter = self.calibration.new_filter(self.store.look)
        if getattr(filter, "ahead", 0):
            # Evaluations in threads go on while the filter limits the threads of linear algebra, which holds for all of a process: their last digits
            # would depend on when they run, if it did not hold all the time.
            with threadpool_limits(1), closing(
                Workers(self.calibration.experiments, self.calibration.number_of_workers, filter.early_stop)
            ) as workers:
                try:
                    return self._run(filter, workers)
                finally:
                    for task, outcome in workers.ended():
                        self._record(task.id, task.experiment, outcome)
        return self._run(filter)

    def _run(self, filter: Filter, workers: Workers | None = None) -> Result:
        """workers: of a filter that asks for batches ahead; others' batches are evaluated as a whole."""
        known = len(self.store.iterations())
        while not filter.finished:
            index = len(filter.iterations)
            samples = filter.under_way[0]
            if workers:
                self._evaluate_ahead(index, filter.under_way, filter.early_stops, workers)
            else:
                self.store.ask(index, samples, len(self.calibration.experiments))
                self.evaluate(index, samples, filter.early_stops[0])
            self._look_at_the_clock(filter, index, replayed=index < known)
            tell(filter, samples, self.store, self.calibration.experiments)
            if isinstance(filter, PosteriorFilter) and filter.places is not None:
                study_packings(filter, self.calibration, self.store, self.listeners)
            learnt, looks = (Learnt.of(filter), filter.take_looks()) if isinstance(filter, PosteriorFilter) else (None, [])
            self.store.complete(filter.iterations[-1], learnt, looks)
            replayed = index < known
            if self.store.folder and (filter.finished or not replayed):
                write_curves(Result(self.store, self.calibration), self.store.folder / CURVES)
            for listener in self.listeners:
                listener.iteration_ends(filter.iterations[-1], replayed, learnt)
                if learnt and not learnt.predicts and not replayed:
                    listener.remark(
                        f"The emulator trained after batch {index} predicts runs no better than their mean does, and is dropped: the next batch, where one is asked for, is drawn where the runs themselves fit."
                    )
        self.store.stop(filter.stopped_by, filter.stopped_because)
        for listener in self.listeners:
            listener.stops(filter.stopped_by, filter.stopped_because)
        return Result(self.store, self.calibration)

    @property
    def _spent(self) -> float:
        """Seconds of wall time, of all sittings."""
        return self._spent_before + time.monotonic() - self._began

    def _look_at_the_clock(self, filter: Filter, index: int, replayed: bool) -> None:
        """Have the filter end with the iteration of this number where the time is over, or was when it ran."""
        hours = self.calibration.stop.hours
        if not replayed and hours is not False and self._spent >= 3600 * hours:
            self.store.keep(OUT_OF_TIME, str(index))
        if self.store.meta(OUT_OF_TIME) == str(index):
            filter.end("hours", f"the limit of {hours:g} hours is over")

    def evaluate(self, iteration: int, samples: Samples, early_stop: EarlyStop | None = None) -> None:
        """Evaluate what is waiting, one experiment after the other; a sample that fails or is stopped in one is left out of the next."""
        for number, experiment in enumerate(self.calibration.experiments):
            waiting = samples.take(np.isin(samples.ids, self.store.waiting(iteration, number)))
            if not len(waiting):
                continue
            for listener in self.listeners:
                listener.experiment_begins(iteration, experiment.name, len(waiting), len(samples))
            self.store.begin(waiting.ids, number)
            # Closed at once if storing fails: what is under way must not go on behind an error.
            hopeless = partial(early_stop.hopeless, number) if early_stop else None
            with closing(experiment.evaluate(self.calibration.space.seen_by(number, waiting), self.calibration.number_of_workers, hopeless)) as outcomes:
                for row, outcome in outcomes:
                    self._record(int(waiting.ids[row]), number, outcome)

    def _evaluate_ahead(self, first: int, batches: Sequence[Samples], early_stops: Sequence[EarlyStop | None], workers: Workers) -> None:
        """Have all batches under way evaluated, of which the first has this number, until that one is.

        A sample goes from one experiment to the next by itself, unless it fails or is stopped; to those who count, all that waits begins at once.
        """
        count = len(self.calibration.experiments)
        for index, samples in enumerate(batches, first):
            self.store.ask(index, samples, count)
            if index < self._batches_given:
                continue
            self._batches_given = index + 1
            begun = np.zeros(len(samples), dtype=bool)
            for number, experiment in enumerate(self.calibration.experiments):
                waiting = np.isin(samples.ids, self.store.waiting(index, number))
                if waiting.any():
                    for listener in self.listeners:
                        listener.experiment_begins(index, experiment.name, int(waiting.sum()), len(samples))
                self._give(workers, index, number, samples.take(waiting & ~begun), early_stops[index - first])
                begun |= waiting
        while any(len(self.store.waiting(first, number)) for number in range(count)):
            task, outcome = workers.next()
            self._record(task.id, task.experiment, outcome)
            if isinstance(outcome, Response) and not outcome.stopped and task.experiment + 1 < count:
                samples = batches[task.iteration - first]
                self._give(workers, task.iteration, task.experiment + 1, samples.take(samples.ids == task.id), early_stops[task.iteration - first])

    def _give(self, workers: Workers, iteration: int, number: int, samples: Samples, early_stop: EarlyStop | None) -> None:
        if len(samples):
            self.store.begin(samples.ids, number)
            workers.give(iteration, number, self.calibration.space.seen_by(number, samples), early_stop)

    def _record(self, id: int, number: int, outcome: Response | Failure) -> None:
        self.store.record(id, number, outcome)
        if time.monotonic() - self._noted > OFTEN:
            self._noted = time.monotonic()
            self.store.spend(self._spent)
        for listener in self.listeners:
            listener.evaluated(id, self.calibration.experiments[number].name, outcome)


def write_curves(result: Result, folder: Path) -> None:
    """The responses of the best and of the most probable sample, or the mean of the runs at the answer, a file for each experiment."""
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise FolderError.of(folder, error) from error
    for number, experiment in enumerate(result.experiments):
        curves = {}
        if result.best:
            curves["best"] = result.response(result.best.sample, number)
        if result.answer is None and result.most_probable:
            curves["most_probable"] = result.response(result.most_probable.sample, number)
        if result.answer and (mean := result.mean_response(result.answer, number)):
            curves["answer"] = mean
        for word, curve in curves.items():
            write_curve(folder / f"{file_name(experiment.name)}_{word}.csv", curve, experiment.reference.control_name)
