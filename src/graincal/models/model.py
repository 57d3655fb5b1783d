"""What a model is: it describes evaluations, and whoever asks has them run."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Literal

from numpy.typing import ArrayLike

from graincal.data import Response, Samples
from graincal.execution import Ended, Outcomes, Task, run


class Model(ABC):
    """Whatever can say how samples are evaluated: what derives from this class and has `tasks`."""

    law: str | None = None
    """The name of a contact law (`contact_laws.LAWS`) whose parameters the model takes; None for models that have others."""

    @abstractmethod
    def tasks(self, samples: Samples, at: ArrayLike) -> Sequence[Task]:
        """A task for each sample, in their order, whose response covers the control values `at` (T,). A response is on states of the model's own, the same for each sample, or on `at` itself.

        Raises InputError for what no sample can mend, also when there are no samples.
        """

    def check(self, at: ArrayLike, samples: Samples) -> None:
        """Raise InputError for what no sample can mend, before anything is run; samples: none of them, by the names of a calibration's."""
        self.tasks(samples, at)

    def in_folder(self, folder: Path) -> Model:
        """The same model, whose evaluations keep their files in this folder; asked before any of them is under way. Most keep none."""
        return self

    def evaluate(
        self, samples: Samples, at: ArrayLike, workers: int | Literal["all"] | None = None, watch: Callable[[int, Response], bool] | None = None
    ) -> Outcomes:
        """Evaluate each sample and yield (row, Response or Failure) in order of completion.

        at (T,): control values that the response must cover. workers: evaluations at once, all cores by default. watch(id, response): is shown the first states of a sample's run each time that there is one more, from several
        threads, and stops it by returning True, where the model can be watched. Closing the iterator stops what is under way. Raises InputError as `tasks` does.
        """
        tasks = [
            replace(task, name=row, watch=partial(watch, int(id)) if watch else None)
            for row, (id, task) in enumerate(zip(samples.ids, self.tasks(samples, at)))
        ]
        return _outcomes(run(tasks, workers or "all"))


def _outcomes(ended: Generator[Ended]) -> Outcomes:
    try:
        for each in ended:
            assert isinstance(each.task.name, int), "`evaluate` names a task by its row"
            yield each.task.name, each.outcome
    finally:
        # Not left to the garbage collector: what is under way is stopped now.
        ended.close()
