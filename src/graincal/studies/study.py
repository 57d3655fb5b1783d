"""What a study is: the cases that it runs, and what it makes of them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from graincal.campaign import Calibration, Result
from graincal.data import Response
from graincal.studies.records import Findings
from graincal.studies.settings import Setup
from graincal.studies.work import Calibrating, Running, Work


@dataclass(frozen=True)
class Case:
    """One setting of a study, with what is run for it: a calibration a seed, or plain runs. missing: the files that it lacks, in words; then nothing is run. after: what must have been run before."""

    setting: str
    work: tuple[Work, ...] = ()
    missing: str = ""
    after: tuple[Work, ...] = ()


class Done:
    """What was run, as far as it is there: the folder of each piece of work under one folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def folder_of(self, work: Work) -> Path:
        return self.folder / work.name

    def has(self, work: Work) -> bool:
        """Whether all of it was run."""
        return work.is_done(self.folder_of(work))

    def results(self, case: Case) -> list[Result]:
        """The calibrations of a case that are at their end."""
        return [work.read(self.folder_of(work)) for work in case.work if isinstance(work, Calibrating) and self.has(work)]

    def runs(self, case: Case) -> list[list[Response]]:
        """The runs of a case, at each of its parameters; nothing where they were not made."""
        found = [work.read(self.folder_of(work)) for work in case.work if isinstance(work, Running) and self.has(work)]
        return found[0] if found else []

    def repeats(self, case: Case) -> list[Response]:
        """Those of a case with one set of parameters."""
        return next(iter(self.runs(case)), [])


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
    return Case(setting, tuple(Calibrating(f"{name}-seed-{seed}", f"{setting}, seed {seed}", size, lambda seed=seed: make(seed)) for seed in seeds))
