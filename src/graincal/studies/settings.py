"""How a study's experiments are made: the data, the packings, and the paper's settings."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from graincal.campaign import Calibration, Experiment
from graincal.data import InputError, ParameterSpace, Reference
from graincal.dem.packing import Packing
from graincal.dem.preparation import prepare
from graincal.inference import Stop
from graincal.models import TriaxialTest
from graincal.models.economy import Accuracy
from graincal.studies import paper

VOID_RATIO = 0.68
OBSERVABLES = ("stress_ratio", "volumetric_strain")
BOTH = {"stress_ratio": 0.5, "volumetric_strain": 0.5}
STRESS_TRUSTED = {"stress_ratio": 0.2, "volumetric_strain": 0.8}
"""Variance shares of the paper's studies of particles and of several solutions: the smaller, the more an observable counts."""

OWN_PACKING_SEED = 1
ITERATIVE, SEQUENTIAL, POSTERIOR = "iterative-bayesian", "sequential-monte-carlo", "posterior"
ACCURACY: Accuracy = "standard"
TEST = "drained triaxial compression"

ITERATION_OF_ALPHA_ONE = len(paper.PARAMETERS) * math.log(len(paper.PARAMETERS))
"""The samples of an iteration for α = 1, before they are rounded (Eq. 4). The paper rounds them down: 160 at α = 20."""


class Missing(InputError):
    """A file that is not in the data folder; the message names it."""


@dataclass(frozen=True)
class Size:
    """How large the studies are.

    particles: instead of the packings of the paper, one of our own with so many grains. of_samples: times the paper's number of samples in an
    iteration. most_iterations: of the iterative filter. most_evaluations: of the method "posterior", False for its own end. repeats: runs at one and
    the same parameters.
    """

    particles: int | None = None
    of_samples: float = 1.0
    most_iterations: int = paper.MOST_ITERATIONS
    most_evaluations: int | Literal[False] = False
    repeats: int = 5


PAPER, QUICK = Size(), Size(particles=200, of_samples=0.2, most_iterations=4, most_evaluations=60, repeats=3)


@dataclass(frozen=True)
class Setup:
    """What studies are made with: the folder of data, how many seeds a short study has and a long one, and how large they are. large: whether the
    packing of 27,000 grains is run.
    """

    data: Path
    seeds: int = 3
    seeds_of_long: int = 1
    large: bool = False
    size: Size = PAPER
    workers: int | Literal["all"] = "all"

    @property
    def short(self) -> range:
        """The seeds of a study that takes at most an hour a seed."""
        return range(1, self.seeds + 1)

    @property
    def long(self) -> range:
        """Those of the others."""
        return range(1, self.seeds_of_long + 1)

    def packing(self, particles: int, own: bool = False) -> Packing:
        """The paper's packing of so many grains; `own`: or one that graincal prepares where the data folder has none. Raises Missing."""
        if self.size.particles:
            return prepare(self.size.particles, VOID_RATIO, seed=OWN_PACKING_SEED)
        if self.has_packing(particles) or not own:
            return Packing.read(self._file(_packing_file(particles)))
        return prepare(particles, VOID_RATIO, seed=OWN_PACKING_SEED)

    def has_packing(self, particles: int) -> bool:
        """Whether the data folder holds the paper's packing of so many grains."""
        return (self.data / _packing_file(particles)).is_file()

    def missing(self, reference: str | None, particles: int | None) -> str:
        """Which of the files that something needs the data folder lacks, in words; nothing where it has them all."""
        needed = [reference] + ([] if self.own_everywhere or particles is None else [_packing_file(particles)])
        absent = [name for name in needed if name and not (self.data / name).is_file()]
        return f"{' and '.join(absent)} {'is' if len(absent) == 1 else 'are'} not in the data folder" if absent else ""

    @property
    def own_everywhere(self) -> bool:
        """Whether all packings are graincal's, so that no number compares with the paper's."""
        return self.size.particles is not None

    def toyoura(self, pressure: float, shares: dict[str, float]) -> Reference:
        """Toyoura sand at a confining pressure in Pa. Raises Missing."""
        return Reference.read(self._file(f"toyoura_{pressure / 1e6:.1f}MPa.csv"), observables=shares)

    def synthetic(self, recorded: tuple[str, ...] = ()) -> Reference:
        """The paper's synthetic reference. recorded: observables that are not conditioned on. Raises Missing."""
        fitted = {name: share for name, share in BOTH.items() if name not in recorded}
        return Reference.read(self._file("synthetic_reference.csv"), observables=fitted, recorded=recorded, simulated=True)

    def test(self, particles: int, pressure: float, own: bool = False) -> TriaxialTest:
        """The paper's drained triaxial compression. Raises Missing."""
        return TriaxialTest(self.packing(particles, own), pressure, density_scaling=paper.DENSITY_SCALING, accuracy=ACCURACY)

    def by_the_paper(
        self,
        test: TriaxialTest,
        reference: Reference,
        *,
        seed: int,
        samples: int = 80,
        box: str = "mid",
        most_iterations: int = paper.MOST_ITERATIONS,
        method: str = ITERATIVE,
    ) -> Calibration:
        """A calibration by the paper's method and settings. samples: of one iteration; the paper's α is what gives as many (Eq. 4)."""
        options = {"alpha": self.size.of_samples * samples / ITERATION_OF_ALPHA_ONE}
        stop = Stop(
            s=paper.S_LIMIT,
            gl_error_increment=False,
            error=False,
            error_increment=False,
            max_iterations=min(self.size.most_iterations, most_iterations),
        )
        return Calibration(space(box), [Experiment(TEST, test, reference)], method, options, stop, seed, self.workers)

    def by_the_posterior(self, test: TriaxialTest, reference: Reference, *, seed: int, box: str = "mid", same_packing: bool = False) -> Calibration:
        """A calibration within the same ranges by the method "posterior" and its own rules.

        same_packing: the reference is a run on the test's own packing, so that what packings differ by is no error.
        """
        options = {"packing_scatter": False} if same_packing else {}
        stop = Stop(max_evaluations=self.size.most_evaluations)
        return Calibration(space(box), [Experiment(TEST, test, reference)], POSTERIOR, options, stop, seed, self.workers)

    def _file(self, name: str) -> Path:
        path = self.data / name
        if not path.is_file():
            raise Missing(f"{path}: there is no such file, and a study needs it.")
        return path


def space(box: str = "mid") -> ParameterSpace:
    """Table 2, with one of Table 7's ranges of log E."""
    whole = ParameterSpace.paper()
    ranges = {name: (low, high) for name, low, high in zip(whole.names, whole.low, whole.high)} | {"log_E": paper.BOXES[box]}
    return ParameterSpace(ranges, dict(zip(whole.names, whole.units)))


def _packing_file(particles: int) -> str:
    return f"packing_{particles}.csv"
