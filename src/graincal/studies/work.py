"""What studies run: calibrations and plain runs, each in a folder of its own, so that they are shared, gone on with, and never made twice."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from graincal.campaign import Calibration, Experiment, Listener, Result, begin, resume
from graincal.campaign.exploring import fill, no_reference
from graincal.campaign.library import Library
from graincal.campaign.runs import known_runs
from graincal.campaign.store import SPENT, Store, holds_campaign
from graincal.data import InputError, ParameterSpace, Response
from graincal.inference.samples import replicates
from graincal.models import TriaxialTest
from graincal.studies.settings import OBSERVABLES, TEST


class Work(ABC):
    """Something to run, which a folder under `name` holds: the same name is the same work, in whatever study. title: for people. size: about how much it is, in particle-steps."""

    name: str
    title: str
    size: float

    @abstractmethod
    def go_on(self, folder: Path, listeners: Sequence[Listener]) -> None:
        """Begin with it, or go on to its end. Raises InputError where the folder holds something else."""

    def is_done(self, folder: Path) -> bool:
        """Whether the folder holds all of it."""
        if not holds_campaign(folder):
            return False
        with closing(Store.open(folder)) as store:
            return store.meta("stopped_by") is not None

    def seconds(self, folder: Path) -> float:
        """The wall time that it has taken so far."""
        if not holds_campaign(folder):
            return 0.0
        with closing(Store.open(folder)) as store:
            return float(store.meta(SPENT) or 0)

    def runs(self, folder: Path) -> tuple[int, float]:
        """How many runs were made, and the seconds that they took, each on one core."""
        if not holds_campaign(folder):
            return 0, 0.0
        with closing(Store.open(folder)) as store:
            seconds = [seconds for _, _, attempts, seconds in store.runs() if attempts]
        return len(seconds), float(sum(each or 0.0 for each in seconds))


@dataclass(frozen=True, eq=False)
class Calibrating(Work):
    """A calibration. make: what is asked; called when it is begun, for a packing may have to be prepared. runs_of: the folder of another one on the same model, whose runs it learns from."""

    name: str
    title: str
    size: float
    make: Callable[[], Calibration]
    runs_of: Path | None = None

    def go_on(self, folder: Path, listeners: Sequence[Listener]) -> None:
        asked = self.make()
        if self.runs_of is not None:
            asked = replace(asked, known=known_runs([self.runs_of.resolve()], asked))
        if not holds_campaign(folder):
            begin(asked, folder, listeners)
            return
        with closing(Store.open(folder)) as store:
            _refuse_other(folder, store, asked)
        resume(folder, workers=asked.workers, listeners=listeners)

    def read(self, folder: Path) -> Result:
        """What it found."""
        return Result.read(folder)


@dataclass(frozen=True, eq=False)
class Running(Work):
    """Runs of a test at parameters theta (K, n), `times` times each, to an axial strain. theta: called when they are begun, for they may follow from other work."""

    name: str
    title: str
    size: float
    make: Callable[[], TriaxialTest]
    theta: Callable[[], Sequence[Sequence[float]]]
    times: int
    space: ParameterSpace
    to: float = 0.2

    @property
    def _points(self) -> NDArray[np.float64]:
        return np.concatenate([replicates(np.asarray(theta, dtype=np.float64), self.times, self.space) for theta in self.theta()])

    def go_on(self, folder: Path, listeners: Sequence[Listener]) -> None:
        experiment = Experiment(TEST, self.make(), no_reference(self.to, OBSERVABLES))
        fill(Calibration(self.space, [experiment]), folder, listeners=listeners, points=self._points)

    def read(self, folder: Path) -> list[list[Response]]:
        """What the runs at each of the parameters gave, without those that failed."""
        (outcomes,) = Library.read(folder).outcomes
        return [[run for run in outcomes[first : first + self.times] if isinstance(run, Response)] for first in range(0, len(outcomes), self.times)]


def _refuse_other(folder: Path, store: Store, calibration: Calibration) -> None:
    if not store.keeps(calibration):
        raise InputError(f"{folder}: this was made by other settings or other data than these; reproduce needs a folder of its own.")
