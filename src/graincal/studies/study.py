"""What a study is: the cases that it runs, and what it makes of them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import ClassVar

from graincal.campaign import Calibration
from graincal.data import Response
from graincal.result import Result
from graincal.studies.records import Findings
from graincal.studies.settings import Setup
from graincal.studies.work import Calibrating, Running, Work


@dataclass(frozen=True)
class Case:
    """One setting of a study, with what is run for it: a calibration a seed, or plain runs. missing: why it cannot be run, as the files that it
    lacks, in words; then nothing is. after: what must be at its end before it is begun.
    """

    setting: str
    work: tuple[Work, ...] = ()
    missing: str = ""
    after: tuple[Work, ...] = ()


@dataclass
class Done:
    """What was run, as far as it is there: the folder of each piece of work under one folder. other: names of work there that is not what is asked
    for, and counts as not run.
    """

    folder: Path
    other: set[str] = field(default_factory=set)
    _results: dict[str, Result] = field(default_factory=dict)
    _runs: dict[str, list[list[Response]]] = field(default_factory=dict)
    """Of work at its end, which does not change any more."""

    def folder_of(self, work: Work) -> Path:
        return self.folder / work.name

    def has(self, work: Work) -> bool:
        """Whether all of it was run."""
        return work.name not in self.other and (work.name in self._results or work.name in self._runs or work.is_done(self.folder_of(work)))

    def results(self, case: Case) -> list[Result]:
        """The calibrations of a case that are at their end."""
        return [self._calibrated(work) for work in case.work if isinstance(work, Calibrating) and self.has(work)]

    def runs(self, case: Case) -> list[list[Response]]:
        """The runs of a case, at each of its parameters; nothing where they were not made."""
        found = [self._run(work) for work in case.work if isinstance(work, Running) and self.has(work)]
        return found[0] if found else []

    def repeats(self, case: Case) -> list[Response]:
        """Those of a case with one set of parameters."""
        return next(iter(self.runs(case)), [])

    def all_runs(self, case: Case) -> list[Response]:
        """Those at all of its parameters, one after the other."""
        return [run for many in self.runs(case) for run in many]

    def _calibrated(self, work: Calibrating) -> Result:
        if work.name not in self._results:
            self._results[work.name] = work.read(self.folder_of(work))
        return self._results[work.name]

    def _run(self, work: Running) -> list[list[Response]]:
        if work.name not in self._runs:
            self._runs[work.name] = work.read(self.folder_of(work))
        return self._runs[work.name]


class Study(ABC):
    """One of the paper's studies. name: on the command line. where: its place in the paper. question: what it asks, in a sentence."""

    name: ClassVar[str]
    title: ClassVar[str]
    where: ClassVar[str]
    question: ClassVar[str]

    @abstractmethod
    def cases(self, setup: Setup, done: Done) -> Sequence[Case]:
        """What it runs, in its order, and what it cannot. done: what of it was run, for work that follows from other work's results."""

    @abstractmethod
    def findings(self, setup: Setup, done: Done) -> Findings:
        """What it makes of the cases that were run, and of all that the paper printed."""


def calibrations(setting: str, name: str, make: Callable[[int], Calibration], seeds: Iterable[int], size: float, missing: str = "") -> Case:
    """A case of calibrations that differ in their seed. name: of their folders. size: of one, in particle-steps."""
    if missing:
        return Case(setting, missing=missing)
    return Case(setting, tuple(Calibrating(f"{name}-seed-{seed}", f"{setting}, seed {seed}", size, partial(make, seed)) for seed in seeds))
