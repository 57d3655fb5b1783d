"""Parameters that somebody chose to run, and the file that they stand in."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graincal.data import InputError, ParameterSpace
from graincal.files import unreadable


def checked_points(points: ArrayLike, space: ParameterSpace) -> NDArray[np.float64]:
    """Points of a space, (N, n) in the order of its names. Raises InputError for anything else, and for a point that the prior holds impossible."""
    try:
        found = np.atleast_2d(np.array(points, dtype=np.float64))
    except (TypeError, ValueError):
        found = np.empty((0, 0))
    if found.ndim != 2 or len(found) < 1 or found.shape[1] != space.size or not np.all(np.isfinite(found)):
        raise InputError(f"points must be rows of {space.size} numbers, {', '.join(space.names)}.")
    if not np.all(inside := space.contains(found)):
        row = int(np.argmin(inside))
        broken = [constraint.source for constraint in space.constraints if not constraint.holds(found[[row]])[0]] if space.in_ranges(found[[row]])[0] else []
        raise InputError(
            f'point {1 + row} lies where "{broken[0]}" does not hold.' if broken else f"point {1 + row} lies outside the ranges of the parameters."
        )
    return found


def read_points(path: Path, space: ParameterSpace) -> NDArray[np.float64]:
    """The points of a CSV file with a column for each parameter, by its name, (N, n). Other columns are left out. Raises InputError for what is none."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = list(csv.reader(line for line in file if line.strip() and not line.startswith("#")))
    except OSError as error:
        raise InputError(unreadable(path, error, "a table of points")) from None
    except (UnicodeDecodeError, csv.Error):
        raise InputError(f"{path}: a table of points in CSV was expected.") from None
    names = [name.strip() for name in rows[0]] if rows else []
    if missing := [name for name in space.names if name not in names]:
        raise InputError(f"{path}: a column for {', '.join(missing)} is missing; its header has {', '.join(names) or 'nothing'}.")
    columns = [names.index(name) for name in space.names]
    try:
        return checked_points([[float(row[column]) for column in columns] for row in rows[1:]], space)
    except (ValueError, IndexError) as error:
        said = str(error) if isinstance(error, InputError) else f"each row must hold a number for each of {', '.join(space.names)}."
        raise InputError(f"{path}: {said}") from None
