"""Packings prepared to a void ratio, after Hartmann, Cheng, Thornton (2022), section 2.1.1: a cloud is compacted with stiff grains, friction is lowered
until the void ratio is the one asked for, and the packing is unloaded."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from graincal import _native
from graincal.data import InputError
from graincal.dem.grading import Grading, GrainSizes
from graincal.dem.packing import Packing

PROTOCOL = 2
"""Goes up when the same request would give another packing: what was cached before is then prepared anew."""

COMPACTION_PRESSURE, RELEASED_PRESSURE = 1e5, 1e2  # Pa
MODULUS = 1e9
"""Pa. Ten thousand times the compaction pressure: stiff enough, since the void ratio is measured once the pressure is gone, and overlaps with it."""
CLOUD_MODULUS = 1e8
"""Pa. Soft grains gather a cloud with long time steps; they are stiffened before friction is lowered."""
STIFFNESS_RATIO = 0.2
LOOSEST_FRICTION_ANGLE = 45.0  # degrees
DENSITY = 2650.0 * 1e3
"""kg/m^3, with the density scaling of the paper's tests."""
DAMPING = 0.5
CLOUD_SOLID_FRACTION = 0.25
VOID_RATIO_TOLERANCE, ACCEPTED = 5e-4, 2e-3
"""What is sought, and what is settled for where settling is too chaotic to meet that."""
RELEASE_RATE = 1e-3
"""1/s. Slow enough that the cell's own inertia does not carry it past the point where the grains part."""

MANY, FEW, FAR = 2000, 500, 0.05
"""A packing of more than MANY grains takes minutes until it is known what it packs to: FEW of its grading say before whether the void ratio is further than FAR from that."""

REACH_OF = 1000
"""Grains of which the reach of a grading is found, at the most: some seconds."""

_CHUNK = 200
_MAX_CHUNKS = 1000
_MAX_TRIALS = 12
_NARROW = 1.0  # degrees


class OutOfReach(InputError):
    """A void ratio that a grading does not pack to, with those that it does: `densest` and `loosest`."""

    def __init__(self, message: str, densest: float, loosest: float) -> None:
        super().__init__(message)
        self.densest, self.loosest = densest, loosest


@dataclass(frozen=True)
class Reach:
    """The void ratios that spheres of a grading pack to, found of a packing of `particles`: with all the friction there is, and without any."""

    densest: float
    loosest: float
    particles: int

    def holds(self, void_ratio: float) -> bool:
        """Whether the void ratio can be packed, within what is settled for."""
        return self.densest - ACCEPTED <= void_ratio <= self.loosest + ACCEPTED

    def void_ratio(self, relative_density: float) -> float:
        """The void ratio at a relative density (e_max - e)/(e_max - e_min) from 0 to 1."""
        return self.loosest - relative_density * (self.loosest - self.densest)

    def relative_density(self, void_ratio: float) -> float:
        """Of a void ratio, (e_max - e)/(e_max - e_min): 0 for the loosest, 1 for the densest, and beyond for one that cannot be packed."""
        return (self.loosest - void_ratio) / (self.loosest - self.densest)

    @property
    def in_words(self) -> str:
        """Such as "between 0.559 (densest) and 0.784 (loosest)"."""
        return f"between {self.densest:.3f} (densest) and {self.loosest:.3f} (loosest)"


def reach(particles: int, grading: str | Path | Grading | GrainSizes = "toyoura", seed: int = 1) -> Reach:
    """What a grading packs to: that of a request of `prepare` itself up to REACH_OF particles, and of more about.

    Takes seconds, and is cached as packings are. Raises InputError where so few grains of the grading make no packing.
    """
    grading = grading if isinstance(grading, (Grading, GrainSizes)) else Grading.named(grading)
    count = min(particles, REACH_OF)
    cached = _make_cache_folder() / f"{_fingerprint(count, 0.0, grading, seed)}.json"
    if cached.exists():
        return Reach(**json.loads(cached.read_text(encoding="utf-8")))
    try:
        loose = _loosest(count, 1.0, grading, seed)
        found = Reach(loose.with_friction(0.0).void_ratio, loose.void_ratio, count)
    except RuntimeError as error:
        raise InputError(f"what grading {grading.name} packs to could not be found of {count} particles: {error}; more particles may do.") from error
    with unfinished(cached) as beside:
        beside.write_text(json.dumps({"densest": found.densest, "loosest": found.loosest, "particles": found.particles}), encoding="utf-8")
    return found


def prepare(particles: int, void_ratio: float, grading: str | Path | Grading | GrainSizes = "toyoura", seed: int = 1) -> Packing:
    """A packing of `particles` spheres at `void_ratio`, in a periodic cell of about 1 : 1 : 2, nearly free of stress.

    Deterministic in `seed`, and cached in the user's cache folder ($GRAINCAL_CACHE, or graincal/packings in $XDG_CACHE_HOME or ~/.cache). Raises
    InputError for a void ratio that the grading cannot reach, with the range that it can (`OutOfReach`).
    """
    if particles < 2:
        raise InputError(f"particles must be at least 2, not {particles}.")
    if not (np.isfinite(void_ratio) and void_ratio > 0):
        raise InputError(f"void_ratio must be a positive number, not {void_ratio}.")
    grading = grading if isinstance(grading, (Grading, GrainSizes)) else Grading.named(grading)
    cached = _make_cache_folder() / f"{_fingerprint(particles, void_ratio, grading, seed)}.csv"
    if cached.exists():
        return Packing.read(cached)
    try:
        packing = _prepare(particles, void_ratio, grading, seed)
    except RuntimeError as error:
        raise InputError(
            f"no packing of {particles} particles of grading {grading.name} could be prepared with seed {seed}: {error}; more particles or another seed may do."
        ) from error
    try:
        write_whole(packing, cached, comment(void_ratio, grading.name, seed))
    except OSError as error:
        raise InputError(f"{cached.parent}: the packing cannot be cached here ({error.strerror}); name another folder by GRAINCAL_CACHE.") from None
    return packing


def comment(void_ratio: float, grading: str, seed: int) -> str:
    """What the first line of a prepared packing's file says."""
    return f"periodic packing prepared by graincal: grading {grading}, void ratio {void_ratio:g}, seed {seed}, metres"


def _prepare(particles: int, void_ratio: float, grading: Grading | GrainSizes, seed: int) -> Packing:
    if particles > MANY:
        _refuse_far_out_of_reach(void_ratio, grading, seed)
    packed = _lower_friction(_loosest(particles, void_ratio, grading, seed), void_ratio, grading).released
    return Packing(packed.positions, packed.radii, packed.edges, name=f"packing of {grading.name}")


def _loosest(particles: int, void_ratio: float, grading: Grading | GrainSizes, seed: int) -> _State:
    """The state of the largest friction angle; the cell is wide enough for the void ratio."""
    generator = np.random.default_rng(seed)
    radii = 0.5 * grading.diameters(particles, generator)
    _check_width(radii, void_ratio, grading)
    positions, edges = _cloud(radii, generator)
    simulation = _native.Simulation(positions, radii, edges, _law(LOOSEST_FRICTION_ANGLE, CLOUD_MODULUS), DENSITY)
    _compress(simulation)
    simulation.set_law(_law(LOOSEST_FRICTION_ANGLE))
    _compress(simulation)
    return _State(simulation)


def _refuse_far_out_of_reach(void_ratio: float, grading: Grading | GrainSizes, seed: int) -> None:
    """Raise OutOfReach where a small packing says that a large one is not worth the minutes."""
    try:
        small = _loosest(FEW, void_ratio, grading, seed)
        loosest, densest = small.void_ratio, small.with_friction(0.0).void_ratio
    except (InputError, RuntimeError):
        # Of wide gradings few grains are too few, and say nothing.
        return
    if not densest - FAR <= void_ratio <= loosest + FAR:
        raise _out_of_reach(void_ratio, grading, densest, loosest)


def _out_of_reach(void_ratio: float, grading: Grading | GrainSizes, densest: float, loosest: float) -> OutOfReach:
    message = f"void_ratio: {void_ratio:g} is out of reach for grading {grading.name}, which packs to between {densest:.3f} and {loosest:.3f}."
    return OutOfReach(message, densest, loosest)


@dataclass
class _State:
    """A packing at rest under the compaction pressure, and the same let go of it: its void ratio is what counts."""

    simulation: _native.Simulation

    @cached_property
    def released(self) -> _native.Simulation:
        simulation = self.simulation.copy()
        _release(simulation)
        return simulation

    @property
    def void_ratio(self) -> float:
        return self.released.void_ratio

    def with_friction(self, angle: float) -> _State:
        """The state compressed anew under another friction angle in degrees."""
        simulation = self.simulation.copy()
        simulation.set_law(_law(angle))
        _compress(simulation)
        return _State(simulation)


def _lower_friction(start: _State, void_ratio: float, grading: Grading | GrainSizes) -> _State:
    """Search for the friction angle that packs to the void ratio. Each trial starts from the densest state that is still too loose, so that friction
    only ever falls."""
    loosest, densest = start.void_ratio, start.with_friction(0.0).void_ratio
    if not densest - VOID_RATIO_TOLERANCE <= void_ratio <= loosest + VOID_RATIO_TOLERANCE:
        raise _out_of_reach(void_ratio, grading, densest, loosest)
    loose, high, low = start, LOOSEST_FRICTION_ANGLE, 0.0
    while loose.void_ratio - void_ratio > VOID_RATIO_TOLERANCE:
        if high - low < _NARROW:
            # The packing collapses at this angle: no friction holds it at the void ratio, so it is stopped on its way.
            return _arrest(loose, low, high, void_ratio)
        angle = 0.5 * (high + low)
        trial = loose.with_friction(angle)
        if trial.void_ratio >= void_ratio - VOID_RATIO_TOLERANCE:
            loose, high = trial, angle
        else:
            low = angle
    return loose


def _arrest(start: _State, collapsing: float, holding: float, void_ratio: float) -> _State:
    """Let the packing collapse under one friction angle in degrees and bring back one that holds it on the way.

    The angles of the search come first. A small packing has few states that they hold, and may have none near the void ratio, or not collapse from
    where it is: then it collapses under half the angle or without friction, and is held by all the friction there is. The closest state met is returned,
    if it is within `ACCEPTED`."""
    met: list[_State] = []
    for collapse, hold in ((collapsing, holding), (0.5 * collapsing, LOOSEST_FRICTION_ANGLE), (0.0, LOOSEST_FRICTION_ANGLE)):
        met += _stopped_on_the_way(start, collapse, hold, void_ratio)
        closest = min(met, key=lambda state: abs(state.void_ratio - void_ratio))
        if abs(closest.void_ratio - void_ratio) <= ACCEPTED:
            return closest
    raise RuntimeError(f"the closest packing met has a void ratio of {closest.void_ratio:.4f}, further than {ACCEPTED:g} from {void_ratio:g}")


def _stopped_on_the_way(start: _State, collapsing: float, holding: float, void_ratio: float) -> list[_State]:
    """The states met in a bisection on where the collapse is stopped. Settling is chaotic, so it may end beside the void ratio."""
    met = [start, start.with_friction(collapsing)]
    loosest, densest = (state.simulation.void_ratio for state in met)
    for _ in range(_MAX_TRIALS):
        turn = 0.5 * (loosest + densest)
        simulation = start.simulation.copy()
        simulation.set_law(_law(collapsing))
        while simulation.void_ratio > turn and simulation.steps < met[1].simulation.steps:
            simulation.run(5, DAMPING)
        held = _State(simulation).with_friction(holding)
        met.append(held)
        if abs(held.void_ratio - void_ratio) <= VOID_RATIO_TOLERANCE:
            break
        if held.void_ratio > void_ratio:
            loosest = turn
        else:
            densest = turn
    return met


def _compress(simulation: _native.Simulation) -> None:
    """Drive all axes to the compaction pressure until it is held, forces balance and the kinetic energy is below a thousandth of the elastic."""
    simulation.set_goals([_native.AxisGoal(stress=True, target=COMPACTION_PRESSURE, largest_rate=1.0)] * 3)
    simulation.run(_CHUNK, DAMPING)
    still = np.zeros((len(simulation.radii), 3))
    for _ in range(_MAX_CHUNKS):
        simulation.run(_CHUNK, DAMPING)
        held = np.all(np.abs(simulation.stress_diagonal / COMPACTION_PRESSURE - 1) < 1e-2)
        if held and simulation.unbalanced_force < 1e-2:
            if simulation.kinetic_energy < 1e-3 * simulation.elastic_energy:
                return
            # What moves still are grains that touch nothing, and no force would ever damp them.
            simulation.set_velocities(still)
            simulation.set_spins(still)
    raise RuntimeError(f"the packing did not come to rest within {_CHUNK * _MAX_CHUNKS} steps")


def _release(simulation: _native.Simulation) -> None:
    """Open the cell slowly until the pressure is all but gone. Whoever loads the packing starts from its positions alone, at rest."""
    simulation.restart_strain()
    simulation.set_goals([_native.AxisGoal(stress=False, target=-0.1, largest_rate=RELEASE_RATE)] * 3)
    for _ in range(_CHUNK * _MAX_CHUNKS):
        simulation.run(5, DAMPING)
        if simulation.stress_diagonal.mean() < RELEASED_PRESSURE:
            return
    raise RuntimeError(f"the packing did not let go of its pressure within {5 * _CHUNK * _MAX_CHUNKS} steps")


def _check_width(radii: NDArray[np.float64], void_ratio: float, grading: Grading | GrainSizes) -> None:
    """The cell must hold its largest grains with room for a neighbour on either side, also where it is packed densest."""
    needed = 5.2 * radii.max()
    side = (4 / 3 * np.pi * np.sum(radii**3) * (1 + min(void_ratio, 0.5)) / 2) ** (1 / 3)
    if side < needed:
        enough = int(np.ceil(len(radii) * (needed / side) ** 3 / 10) * 10)
        raise InputError(
            f"particles: {len(radii)} of grading {grading.name} fill a cell only {side / (2 * radii.max()):.1f} of its largest grains wide; about {enough} are needed."
        )


def _law(friction_angle: float, modulus: float = MODULUS) -> _native.LinearLaw:
    return _native.LinearLaw(modulus, STIFFNESS_RATIO, float(np.tan(np.radians(friction_angle))), 0.0, 0.0)


def _cloud(radii: NDArray[np.float64], generator: np.random.Generator) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Spheres thrown at random into a periodic cell of 1 : 1 : 2 without touching, the largest first: positions (N, 3) and edges (3, 3)."""
    volume = 4 / 3 * np.pi * np.sum(radii**3) / CLOUD_SOLID_FRACTION
    side = (volume / 2) ** (1 / 3)
    lengths = np.array([side, side, 2 * side])
    positions = np.empty((len(radii), 3))
    placed = np.zeros(len(radii), dtype=bool)
    for grain in np.argsort(-radii, kind="stable"):
        while True:
            centre = generator.random(3) * lengths
            apart = positions[placed] - centre
            apart -= lengths * np.round(apart / lengths)
            if np.all(np.sum(apart**2, axis=1) > (radii[placed] + radii[grain]) ** 2):
                break
        positions[grain] = centre
        placed[grain] = True
    return positions, np.diag(lengths)


def _cache_folder() -> Path:
    if chosen := os.environ.get("GRAINCAL_CACHE"):
        return Path(chosen)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "graincal" / "packings"


def _make_cache_folder() -> Path:
    folder = _cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: packings cannot be cached here ({error.strerror}); name another folder by GRAINCAL_CACHE.") from None
    return folder


def _fingerprint(particles: int, void_ratio: float, grading: Grading | GrainSizes, seed: int) -> str:
    request = json.dumps([PROTOCOL, particles, void_ratio, *grading.identity, seed])
    return hashlib.sha256(request.encode()).hexdigest()[:24]


def write_whole(packing: Packing, path: Path, comment: str) -> None:
    """Write a packing so that nobody ever reads half of it. Raises OSError where that is not possible."""
    with unfinished(path) as beside:
        packing.write(beside, comment)


@contextmanager
def unfinished(path: Path) -> Iterator[Path]:
    """A place beside the path to write to, which is moved there once it is written. Raises OSError where that is not possible."""
    beside = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        yield beside
        os.replace(beside, path)
    finally:
        beside.unlink(missing_ok=True)
