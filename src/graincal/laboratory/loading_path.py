"""The position along a path of loading and unloading, by the stress that drives it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graincal.errors import InputError
from graincal.laboratory.addressing import MissingColumn
from graincal.laboratory.backbone import noise, through_zero
from graincal.laboratory.columns import Conventions
from graincal.laboratory.sources import Source, Values, find_source
from graincal.laboratory.table import Table
from graincal.positions import POSITION, positions, turning_points


@dataclass(frozen=True)
class PathSource(Source):
    """The source of a position: `stress` is that of the stress that drives the path from the confining pressure (Pa)."""

    stress: Source
    confining_pressure: float


START_DIGITS = 1e-6
WAVERS = (0.02, 0.1)
"""A stress that goes back by less than the one part of it has not turned around, and nor has one that is noisy, of less than some times its noise: of the other at the most."""
NOISES, MANY = 6.0, 100
"""How far noise goes back, of its standard deviation, which more rows than so many show."""
TURNS_APART = 2e-3
"""A path turns around where it is said to within this part of the stress: of so many digits."""


def source_of(table: Table, name: str, conventions: Conventions, confining_pressure: float | None, turns: Sequence[float] | None) -> Source:
    """Where a wanted quantity comes from; the position follows from the stress that drives its path."""
    if name != POSITION:
        return find_source(table, name, conventions, confining_pressure)
    if confining_pressure is None:
        raise InputError(f"{table.path}: the control is the position along the path, and the confining_pressure in Pa from which it counts was expected.")
    driver = "mean_stress" if "mean_stress" in conventions.columns and "axial_stress" not in conventions.columns else "axial_stress"
    try:
        stress = find_source(table, driver, conventions, None)
    except MissingColumn:
        stress = find_source(table, "mean_stress", conventions, None)
    headers = " and ".join(column.label for column in stress.columns)

    def make(values: Values) -> NDArray[np.float64]:
        path = through_zero(stress.make(values))
        within = wavering(path, turns or ())
        _refuse_other_turns(table, turns_of(path, confining_pressure, within), turns)
        return positions(path, confining_pressure, within)

    return PathSource(POSITION, stress.columns, make, f"position was computed from {stress.name}, column {headers}.", stress, confining_pressure)


def wavering(stress: NDArray[np.float64], turns: Sequence[float] = ()) -> float:
    """By how much, of ln σ, stresses (T,) above 0 go back without turning around: a small part, or what their noise does. Where the turns are said, less than what lies between two of them."""
    least, largest = WAVERS
    of_noise = NOISES * noise(np.log(stress)) if len(stress) > MANY else 0.0
    apart = np.abs(np.diff(np.log(turns))) / 2 if len(turns) > 1 else np.array([])
    return float(np.min(apart, initial=min(max(least, of_noise), largest)))


def turns_of(stress: NDArray[np.float64], start: float, within: float | None = None) -> tuple[float, ...]:
    """The stresses at which a laboratory's path (T,) from `start` turns around, all above 0 and in one unit."""
    found = turning_points(stress, start, wavering(stress) if within is None else within)
    # A start that is written with fewer digits than the file has is none that the path turns around at.
    return found[1:] if found and abs(found[0] / start - 1) < START_DIGITS else found


def _refuse_other_turns(table: Table, found: Sequence[float], turns: Sequence[float] | None) -> None:
    """Refuse a path that turns around elsewhere than is said: positions behind it would be of other stresses."""
    if turns is None or (len(found) <= len(turns) and np.allclose(found, turns[: len(found)], rtol=TURNS_APART)):
        return
    listed = [", ".join(f"{turn:g}" for turn in each) or "nowhere" for each in (found, turns)]
    raise InputError(f"{table.path}: the stress turns around at {listed[0]} Pa, and turns of the model says {listed[1]}: the same path was expected.")


def rows_of_path(source: PathSource, values: Values) -> tuple[NDArray[np.bool_], NDArray[np.bool_], list[str]]:
    """The rows (T,) from which the path is counted; the rows with a stress, whose logarithm there is; and what to say of rows before the path."""
    stress, confining_pressure = source.stress.make(values), source.confining_pressure
    begun = since(stress, confining_pressure)
    below = int(np.sum(~begun & (stress > 0)))
    notes = [f"{below} row{'s' * (below > 1)} dropped below the confining pressure of {confining_pressure:g} Pa, from which the path begins."] if below else []
    return begun, stress > 0, notes


def since(stress: NDArray[np.float64], confining_pressure: float) -> NDArray[np.bool_]:
    """The rows (T,) from the first on that has come to the pressure from which a path begins; all where none comes to it, for a path that only goes down."""
    reached = stress >= confining_pressure * (1 - TURNS_APART)
    return np.logical_or.accumulate(reached) if np.any(reached) else np.ones(len(stress), dtype=bool)
