"""Stress paths of anybody's own: a table with a row for each stage."""

from __future__ import annotations

import csv
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from graincal import _native
from graincal.data import InputError
from graincal.dem.stress_path import AXIAL_RATE, ISOTROPIC_RATE, consolidation
from graincal.files import check_name, unreadable
from graincal.suggestion import did_you_mean

AXES = ("x", "y", "z")
COLUMNS = (*(f"{kind}_{axis}" for kind in ("stress", "strain", "rate") for axis in AXES), "record", "strain_origin")

_WORDS = {"yes": True, "no": False}


@dataclass(frozen=True)
class Goal:
    """What one axis is driven to: a stress in Pa or a logarithmic strain, at most at `largest_rate` in 1/s."""

    stress: bool
    target: float
    largest_rate: float


@dataclass(frozen=True)
class TableRow:
    """One stage: the goals of the axes x, y, z, held until the packing is at rest."""

    goals: tuple[Goal, Goal, Goal]
    record: bool = True
    strain_origin: bool = False


@dataclass(frozen=True)
class StressPathTable:
    """The stages of a stress path in their order, and the table's name. Stages are numbered from 1. Raises InputError where none is recorded."""

    rows: tuple[TableRow, ...]
    name: str = "table"

    def __post_init__(self) -> None:
        object.__setattr__(self, "rows", tuple(self.rows))
        if not any(row.record for row in self.rows):
            raise InputError(f"{self.name}: no stage is recorded, and at least one row with record = yes was expected.")

    @property
    def recorded(self) -> tuple[int, ...]:
        """The numbers of the stages that are recorded."""
        return tuple(number for number, row in enumerate(self.rows, start=1) if row.record)

    def stages(self, confining_pressure: float | None, as_given: Callable[[float], float] = float) -> list[_native.Stage]:
        """The stages for the engine, after isotropic consolidation to the confining pressure, if there is one.

        as_given: what the engine is given for a stress of the table in Pa, where it computes in another unit, that of the confining pressure.
        """
        stages = [] if confining_pressure is None else [consolidation(confining_pressure)]
        for row in self.rows:
            goals = [_native.AxisGoal(goal.stress, as_given(goal.target) if goal.stress else goal.target, goal.largest_rate) for goal in row.goals]
            stages.append(_native.Stage(goals, record=row.record, strain_origin=row.strain_origin))
        return stages

    @classmethod
    def restore(cls, rows: Sequence[Mapping[str, Any]], name: str) -> StressPathTable:
        """The table of which these are `dataclasses.asdict`, in JSON too."""
        return cls(tuple(TableRow(**{**row, "goals": tuple(Goal(**goal) for goal in row["goals"])}) for row in rows), name)

    @classmethod
    def read(cls, path: str | Path) -> StressPathTable:
        """Read a table: CSV whose header names some of COLUMNS, with a row for each stage; lines that begin with # are comments.

        Each row has, for each axis, either `stress_*` (Pa, above 0) or `strain_*` (a logarithmic fraction, compression positive), and may have `rate_*`,
        the axis' largest strain rate in 1/s (by default 1 for a stress and 0.1 for a strain), `record` (yes or no, yes by default) and `strain_origin`
        (yes or no, no by default: strains count from the end of that stage). Raises InputError with the line, stage and column of a mistake.
        """
        lines = _lines(Path(path))
        if not lines:
            raise InputError(f"{path}: a header with some of the columns {', '.join(COLUMNS)} was expected, and the file is empty.")
        _, header = lines.pop(0)
        for name in header:
            if name not in COLUMNS or header.count(name) > 1:
                what = "stands twice" if name in COLUMNS else f"is not known{did_you_mean(name, COLUMNS)}"
                raise InputError(f"{path}: column {name or 'without a name'} {what}, and each of {', '.join(COLUMNS)} at most once was expected.")
        rows = []
        for number, (line, cells) in enumerate(lines, start=1):
            place = f"{path}: line {line} (stage {number})"
            if len(cells) != len(header):
                raise InputError(f"{place} has {len(cells)} cells, and one for each of the {len(header)} columns was expected.")
            rows.append(_row(dict(zip(header, cells)), place))
        return cls(tuple(rows), str(path))


def _lines(path: Path) -> list[tuple[int, list[str]]]:
    """The lines that are neither empty nor comments, as cells, each with its number."""
    check_name(path, "the table of a stress path")
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(unreadable(path, error, "the table of a stress path")) from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: a text file in UTF-8 was expected.") from None
    kept = [(number, line) for number, line in enumerate(text.splitlines(), start=1) if line.strip(" ,") and not line.lstrip().startswith("#")]
    try:
        return [(number, [cell.strip() for cell in next(csv.reader([line]))]) for number, line in kept]
    except csv.Error:
        raise InputError(f"{path}: a table in CSV was expected.") from None


def _row(cells: dict[str, str], place: str) -> TableRow:
    first, second, third = (_goal(cells, axis, place) for axis in AXES)
    return TableRow((first, second, third), record=_word(cells, "record", True, place), strain_origin=_word(cells, "strain_origin", False, place))


def _goal(cells: dict[str, str], axis: str, place: str) -> Goal:
    given = [f"{kind}_{axis}" for kind in ("stress", "strain") if cells.get(f"{kind}_{axis}")]
    if len(given) != 1:
        said = "both are given" if given else "neither is given"
        raise InputError(f"{place}, columns stress_{axis} and strain_{axis}: {said}, and one of them was expected.")
    stress, target = given[0].startswith("stress"), _number(cells, given[0], place)
    if stress and target <= 0:
        raise InputError(f"{place}, column {given[0]}: a stress above 0 in Pa was expected, not {target:g}.")
    if not stress and abs(target) >= 1:
        raise InputError(f"{place}, column {given[0]}: a strain between -1 and 1, a fraction and not percent, was expected, not {target:g}.")
    column = f"rate_{axis}"
    rate = _number(cells, column, place) if cells.get(column) else (ISOTROPIC_RATE if stress else AXIAL_RATE)
    if rate <= 0:
        raise InputError(f"{place}, column {column}: a rate above 0 in 1/s was expected, not {rate:g}.")
    return Goal(stress, target, rate)


def _number(cells: dict[str, str], column: str, place: str) -> float:
    try:
        number = float(cells[column])
    except ValueError:
        number = np.nan
    if not np.isfinite(number):
        raise InputError(f'{place}, column {column}: a number was expected, not "{cells[column]}".')
    return number


def _word(cells: dict[str, str], column: str, default: bool, place: str) -> bool:
    if not (word := cells.get(column, "")):
        return default
    if word not in _WORDS:
        raise InputError(f'{place}, column {column}: yes or no was expected, not "{word}".')
    return _WORDS[word]
