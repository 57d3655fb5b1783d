"""The evaluations of a campaign: samples become tasks, and what these come to is stored."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import numpy as np

from graincal.campaign.asked.calibration import Calibration
from graincal.campaign.asked.experiment import Experiment
from graincal.campaign.asked.file_names import file_name
from graincal.campaign.found.by_hand import by_hand
from graincal.campaign.run.elsewhere import backend_elsewhere
from graincal.campaign.run.waiting import RunsWait
from graincal.campaign.stored.listener import Listener
from graincal.campaign.stored.store import Store
from graincal.campaign.stored.trouble import FolderError
from graincal.data import Failure, InputError, Response, Samples
from graincal.execution import Ended, Scheduler, Task
from graincal.inference.likelihood.early_stop import EarlyStop

FILES = "evaluations"
"""The folder within a campaign's that evaluations keep their files in, where they have some."""


def in_folder(calibration: Calibration, folder: Path) -> Calibration:
    """The calibration, whose evaluations keep their files in this folder: in one of each experiment's name, where there are several."""
    several = len(calibration.experiments) > 1
    places = [folder / file_name(each.name) if several else folder for each in calibration.experiments]
    try:
        return replace(calibration, experiments=[replace(each, model=each.model.in_folder(place)) for each, place in zip(calibration.experiments, places)])
    except OSError as error:
        raise FolderError.of(folder, error) from error


class Evaluation(NamedTuple):
    """By which a task is known: the iteration that its sample is of, the number of the experiment, and the sample's id."""

    iteration: int
    experiment: int
    id: int


NOT_STARTED = "not_started"
"""The kind of a failure for which no sample is to blame: there is no such program, or its inputs cannot be made."""


class Evaluations:
    """Has samples evaluated in the experiments of a calibration, and keeps each outcome in the store when it comes. stored: is told of each.

    Where nothing could be started in an experiment so far, that is no outcome: `until_whole` raises an InputError with the reason, and when that is mended the same evaluations are waiting.
    """

    def __init__(self, calibration: Calibration, store: Store, listeners: Sequence[Listener] = (), stored: Callable[[], None] = lambda: None) -> None:
        self.calibration = calibration if store.folder is None else in_folder(calibration, store.folder / FILES)
        self.store, self.listeners, self._stored = store, listeners, stored
        self._scheduler = Scheduler(calibration.workers, backend_elsewhere(calibration, store, listeners))
        self._batches: dict[int, tuple[Samples, EarlyStop | None]] = {}
        self._under_way: Counter[int] = Counter()
        begun = {number for _, number, attempts, _ in store.runs() if attempts}
        self._not_started: dict[int, list[Ended]] = {number: [] for number in range(len(calibration.experiments)) if number not in begun}

    def until_whole(self, first: int, batches: Sequence[Samples], early_stops: Sequence[EarlyStop | None] = (None,)) -> None:
        """Have batches evaluated in all experiments, of which the first has this number, until that one is; the others go on meanwhile.

        A sample goes from one experiment to the next by itself, unless it fails or is stopped; to those who count, all that waits begins at once.
        Raises RunsWait where the first batch needs runs that are made by hand, when all others have ended.
        """
        for index, (samples, early_stop) in enumerate(zip(batches, early_stops, strict=True), first):
            self.store.ask(index, samples, len(self.calibration.experiments))
            if index not in self._batches:
                self._batches[index] = samples, early_stop
                self._give_batch(index, samples, early_stop)
        self._until_ended(first)
        for ended in chain.from_iterable(self._not_started.values()):
            experiment = self.calibration.experiments[_evaluation(ended).experiment]
            assert isinstance(ended.outcome, Failure), "what was not started gave nothing"
            raise InputError(f'experiment "{experiment.name}": no evaluation could be started: {ended.outcome.reason}')
        self._leave_to_hand(first)

    def of_one(self, iteration: int, number: int, samples: Samples, experiment: Experiment) -> None:
        """Have samples evaluated in one experiment, by whatever model it has here, to their ends. Raises InputError where none is to be run here."""
        if self.calibration.by_hand:
            folder = self.store.folder
            raise InputError(
                f"{folder}: runs on packings like that of {experiment.name} come next, which are prepared here and cannot be made by hand; graincal makes them by: graincal resume {shlex.quote(str(folder))}"
            )
        for listener in self.listeners:
            listener.evaluates_beside(len(samples))
        self._submit(iteration, self._tasks(iteration, number, samples, experiment))
        self._until_ended(iteration)

    def close(self) -> None:
        """End what is under way, and keep what has ended."""
        self._scheduler.close()
        for ended in self._scheduler.ended():
            self._record(ended)

    def _until_ended(self, iteration: int) -> None:
        while self._under_way[iteration]:
            self._next()

    def _leave_to_hand(self, iteration: int) -> None:
        """Raise RunsWait where runs of a batch are to be made by hand; all other runs, of batches asked for ahead too, end first."""
        waiting = [len(self.store.waiting(iteration, number)) for number in by_hand(self.calibration)]
        if not any(waiting):
            return
        while self._scheduler.left:
            self._next()
        raise RunsWait.of(self.store, self.calibration, iteration, sum(waiting))

    def _next(self) -> None:
        """Wait for an evaluation to end and keep its outcome. The sample goes from one experiment to the next, unless it fails or is stopped."""
        name, outcome = self._record(self._scheduler.next())
        if name.iteration in self._batches and isinstance(outcome, Response) and not outcome.stopped and (following := self._following(name)) is not None:
            samples, early_stop = self._batches[name.iteration]
            self._give(name.iteration, following, samples.take(samples.ids == name.id), early_stop)

    def _following(self, name: Evaluation) -> int | None:
        """The number of the experiment that a sample goes to from one; not one that is made by hand, or has been told already."""
        others = range(name.experiment + 1, len(self.calibration.experiments))
        return next((number for number in others if not self.calibration.is_by_hand(number) and self.store.outcome(name.id, number) is None), None)

    def _give_batch(self, index: int, samples: Samples, early_stop: EarlyStop | None) -> None:
        begun = np.zeros(len(samples), dtype=bool)
        for number, experiment in enumerate(self.calibration.experiments):
            waiting = np.isin(samples.ids, self.store.waiting(index, number))
            if waiting.any():
                for listener in self.listeners:
                    listener.experiment_begins(index, experiment.name, int(waiting.sum()), len(samples))
            if self.calibration.is_by_hand(number):
                # What graincal runs itself does not wait for it.
                continue
            self._give(index, number, samples.take(waiting & ~begun), early_stop)
            begun |= waiting

    def _give(self, iteration: int, number: int, samples: Samples, early_stop: EarlyStop | None) -> None:
        if len(samples):
            self._submit(iteration, self._tasks(iteration, number, samples, self.calibration.experiments[number], early_stop))

    def _submit(self, iteration: int, tasks: Sequence[Task]) -> None:
        self._under_way[iteration] += len(tasks)
        self._scheduler.submit(tasks)

    def _tasks(self, iteration: int, number: int, samples: Samples, experiment: Experiment, early_stop: EarlyStop | None = None) -> list[Task]:
        def hopeless(id: int, response: Response) -> bool:
            return early_stop is not None and early_stop.hopeless(number, id, experiment.so_far(response))

        tasks = experiment.tasks(self.calibration.space.seen_by(number, samples))
        names = [Evaluation(iteration, number, int(id)) for id in samples.ids]
        return [
            replace(task, name=name, order=(iteration, number), watch=partial(hopeless, name.id) if early_stop else None) for name, task in zip(names, tasks)
        ]

    def _record(self, ended: Ended) -> tuple[Evaluation, Response | Failure]:
        """Keep an outcome, after those that were held back."""
        name = _evaluation(ended)
        self._under_way[name.iteration] -= 1
        if name.experiment in self._not_started:
            if isinstance(ended.outcome, Failure) and ended.outcome.kind == NOT_STARTED:
                self._not_started[name.experiment].append(ended)
                return name, ended.outcome
            for each in self._not_started.pop(name.experiment):
                self._keep(each)
        return name, self._keep(ended)

    def _keep(self, ended: Ended) -> Response | Failure:
        name = _evaluation(ended)
        experiment = self.calibration.experiments[name.experiment]
        outcome = experiment.compared(ended.outcome)
        self.store.record(name.id, name.experiment, outcome, ended.attempts)
        self._stored()
        for listener in self.listeners:
            listener.evaluated(name.id, experiment.name, outcome)
        return outcome


def _evaluation(ended: Ended) -> Evaluation:
    assert isinstance(ended.task.name, Evaluation), "`_tasks` names them so"
    return ended.task.name
