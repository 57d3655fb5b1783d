"""What studies run: calibrations and plain runs, each in a folder of its own, so that studies share them, interrupted ones continue, and none is made twice."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graincal.campaign import Calibration, Experiment, Listener
from graincal.campaign.asked.experiment import no_reference
from graincal.campaign.found.run_library import Library
from graincal.campaign.found.runs import known_runs
from graincal.campaign.run.exploring import fill, for_library, points_of
from graincal.campaign.run.running import begin_or_resume
from graincal.campaign.stored.asked import SPENT
from graincal.campaign.stored.provenance import provenance
from graincal.campaign.stored.store import Store, holds_campaign
from graincal.data import InputError, ParameterSpace, Response
from graincal.inference.sampling.samples import replicates
from graincal.models import TriaxialTest
from graincal.result import Result
from graincal.studies.settings import OBSERVABLES, TEST

Parameters = Sequence[ArrayLike] | NDArray[np.float64]
"""Of several runs, (K, n)."""


class Work(ABC):
    """Something to run, which a folder under `name` holds: the same name is the same work, in whatever study. title: for people. size: about how much
    it is, in particle-steps.
    """

    name: str
    title: str
    size: float

    @abstractmethod
    def go_on(self, folder: Path, listeners: Sequence[Listener]) -> None:
        """Begin with it, or go on to its end. Raises InputError where the folder holds something else."""

    @abstractmethod
    def refuse_other(self, folder: Path) -> None:
        """Raise InputError where the folder holds work of other settings, other data or other parameters than are asked for now.

        What was begun by this very build was asked by it.
        """

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

    def made_with(self, folder: Path) -> dict[str, str]:
        """What it was begun with; nothing where it was not."""
        if not holds_campaign(folder):
            return {}
        with closing(Store.open(folder)) as store:
            return store.provenance


@dataclass(frozen=True, eq=False)
class Calibrating(Work):
    """A calibration. make: what is asked; called when it is begun, for a packing may have to be prepared. runs_of: the folder of another one on the
    same model, whose runs it learns from.
    """

    name: str
    title: str
    size: float
    make: Callable[[], Calibration]
    runs_of: Path | None = None

    def go_on(self, folder: Path, listeners: Sequence[Listener]) -> None:
        self.refuse_other(folder)
        workers = self.make().workers if holds_campaign(folder) else None
        begin_or_resume(folder, self.make, [self.runs_of] if self.runs_of else [], listeners, workers)

    def refuse_other(self, folder: Path) -> None:
        if not holds_campaign(folder):
            return
        with closing(Store.open(folder)) as store:
            if store.provenance != provenance() and not store.keeps(self._asked()):
                raise _other(folder)

    def _asked(self) -> Calibration:
        asked = self.make()
        return asked if self.runs_of is None else replace(asked, known=known_runs([self.runs_of], asked))

    def read(self, folder: Path) -> Result:
        """What it found."""
        return Result.read(folder)


@dataclass(frozen=True, eq=False)
class Running(Work):
    """Runs of a test at parameters theta (K, n), `times` times each, to an axial strain.

    theta: called when they are begun, for they may follow from other work. workers: runs at once.
    """

    name: str
    title: str
    size: float
    make: Callable[[], TriaxialTest]
    theta: Callable[[], Parameters]
    times: int
    space: ParameterSpace
    to: float = 0.2
    workers: int | Literal["all"] = "all"

    @property
    def _points(self) -> NDArray[np.float64]:
        """(K times, n). Raises InputError where there are no parameters to run."""
        found = self.theta()
        if not len(found):
            raise InputError(f"{self.title}: there are no parameters to run, for what they follow from found none.")
        return np.concatenate([replicates(np.asarray(theta, dtype=np.float64), self.times, self.space) for theta in found])

    def _asked(self) -> Calibration:
        test = self.make()
        return Calibration(self.space, [Experiment(TEST, test, no_reference(test, self.to, OBSERVABLES))], workers=self.workers)

    def go_on(self, folder: Path, listeners: Sequence[Listener]) -> None:
        fill(self._asked(), folder, listeners=listeners, points=self._points)

    def refuse_other(self, folder: Path) -> None:
        if not holds_campaign(folder):
            return
        with closing(Store.open(folder)) as store:
            # Parameters follow from other work, whatever it was made with.
            points = points_of(store)
            same = points is not None and np.array_equal(points, self._points)
            if not same or (store.provenance != provenance() and not store.keeps(for_library(self._asked()))):
                raise _other(folder)

    def read(self, folder: Path) -> list[list[Response]]:
        """What the runs at each of the parameters gave, without those that failed."""
        (outcomes,) = Library.read(folder).outcomes
        return [[run for run in outcomes[first : first + self.times] if isinstance(run, Response)] for first in range(0, len(outcomes), self.times)]


def _other(folder: Path) -> InputError:
    return InputError(
        f"{folder}: this was made by other settings, other data or other parameters than are asked for now, so it is left out. "
        "Remove this folder, and it is made again; or give reproduce another one."
    )
