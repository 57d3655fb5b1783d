"""What a built-in test looks like, grain by grain: its packing at the start and at each state at rest, as files for ParaView."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graincal import _native
from graincal.data import InputError
from graincal.dem.vtk import write_contacts, write_particles, write_series
from graincal.files import unwritable
from graincal.models.economy import DENSITY
from graincal.models.proportion import for_engine, from_engine
from graincal.models.stress_path import StressPathTest

PARTICLES, CONTACTS, STATES = "particles.pvd", "contacts.pvd", "states.csv"


def write_pictures(test: StressPathTest, theta: NDArray[np.float64], at: ArrayLike, folder: Path) -> list[Path]:
    """Run a test at parameters (5,), in the order of its contact law, and write its pictures; return the paths of particles.pvd, contacts.pvd and states.csv.

    The run is step by step that of `test.simulate`. states.csv says which control value each picture is of; picture 0 is the packing as it was given, before any step.
    Raises InputError where the simulation fails, and where the folder cannot be written.
    """
    states, packing = test.states(at), test.first_packing
    simulation = _native.Simulation(
        packing.positions, packing.radii, packing.edges, test.contact_law(theta), float(for_engine(DENSITY * test.scaling, test.unit_of_stress)),
        precision=test.setting("precision"), economy=test.economy,
    )  # fmt: skip
    stages = test.stages_through(states)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        _write_state(folder, 0, simulation, test)
        for number in range(1, len(states) + 1):
            if not simulation.follow(stages, test.economy, test.step_limit):
                break
            _write_state(folder, number, simulation, test)
        pictures = range(len(states) + 1)
        for series, kind in ((PARTICLES, "particles"), (CONTACTS, "contacts")):
            write_series(folder / series, [_name(kind, number) for number in pictures], pictures)
        with (folder / STATES).open("w", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([("picture", test.control), (0, ""), *enumerate(states.tolist(), start=1)])
    except RuntimeError as error:
        raise InputError(f"The simulation gave no pictures: {error}.") from None
    except OSError as error:
        raise InputError(unwritable(folder, error)) from None
    return [folder / name for name in (PARTICLES, CONTACTS, STATES)]


def _write_state(folder: Path, number: int, simulation: Any, test: StressPathTest) -> None:
    edges, radii = simulation.edges, np.asarray(simulation.radii, dtype=np.float64)
    # Every grain where it is within the cell.
    positions = np.mod(np.linalg.solve(edges, np.asarray(simulation.positions, dtype=np.float64).T).T, 1) @ edges.T
    write_particles(folder / _name("particles", number), positions, radii)
    found = simulation.contacts()
    first, second, overlap, normal = (
        found["first"],
        found["second"],
        np.asarray(found["overlap"], dtype=np.float64),
        np.asarray(found["normal"], dtype=np.float64),
    )
    # To the image of the second that is touched, which may lie beyond the cell.
    begins = positions[first]
    ends = begins + normal * (radii[first] + radii[second] - overlap)[:, None]
    force = from_engine(np.linalg.norm(np.asarray(found["force"], dtype=np.float64), axis=1), test.unit_of_stress)
    write_contacts(folder / _name("contacts", number), begins, ends, {"force": force, "overlap": overlap, "normal": normal})


def _name(kind: str, number: int) -> str:
    return f"{kind}-{number:04}.vtp"
