"""The stages of a machine's file, such as saturation, consolidation and shear: which rows belong to each, and the rows that are chosen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from graincal.data import InputError
from graincal.laboratory.table import Table
from graincal.laboratory.vocabulary import meaning
from graincal.suggestion import did_you_mean


def stage_column(table: Table) -> int | None:
    """The index of the column that says the stage of each row; None where there is none."""
    return next((index for index, header in enumerate(table.header) if meaning(header).quantity == "stage"), None)


def stages(table: Table) -> dict[str, list[int]]:
    """The rows (by index) of each stage, by its number or word as the file has it; empty for a file without a column of stages."""
    index, found = stage_column(table), {}
    for at, row in enumerate(table.rows) if index is not None else ():
        if name := _name(row.cell(index)):
            found.setdefault(name, []).append(at)
    return found


def say_stages(table: Table) -> str:
    """The stages with their lines: `1 (lines 12-23), 2 (lines 24-37)`."""
    lines = table.lines
    return ", ".join(f"{name} (lines {lines[rows[0]]}-{lines[rows[-1]]})" for name, rows in stages(table).items())


def choose_rows(table: Table, stage: str | int | None, rows: Sequence[int] | None) -> tuple[Table, list[str]]:
    """The table with the rows of a stage, or between a first and a last line of the file, and what to say of it.

    Raises InputError for a stage that the file has not, and for lines without rows.
    """
    if stage is not None and rows is not None:
        raise InputError(f"{table.path}: stage and rows are both given, and one of them was expected.")
    if stage is not None:
        found, name = stages(table), _name(str(stage))
        chosen = found.get(name) or next((rows for other, rows in found.items() if other.casefold() == name.casefold()), None)
        if chosen is None:
            known = f"one of the stages {say_stages(table)}" if found else "a file with a column of stages"
            raise InputError(f"{table.path}: stage is {stage!r}{did_you_mean(name, found)}, and {known} was expected.")
        return _kept(table, chosen, f"stage {name}")
    if rows is not None:
        first, last = _lines(table, rows)
        chosen = [at for at, line in enumerate(table.lines) if first <= line <= last]
        if len(chosen) < 2:
            raise InputError(f"{table.path}: rows = [{first}, {last}] holds {len(chosen)} rows of numbers, and at least two were expected between lines {table.lines[0]} and {table.lines[-1]}.")
        return _kept(table, chosen, f"lines {first} to {last}")
    return table, []


def _kept(table: Table, chosen: list[int], what: str) -> tuple[Table, list[str]]:
    left = len(table.rows) - len(chosen)
    notes = [f"{len(chosen)} rows of {what} were read, and {left} others left out."] if left else []
    return replace(table, rows=tuple(table.rows[at] for at in chosen)), notes


def _lines(table: Table, rows: Sequence[int]) -> tuple[int, int]:
    lines = list(rows) if isinstance(rows, (list, tuple)) else []
    if len(lines) != 2 or not all(isinstance(line, int) and not isinstance(line, bool) for line in lines) or not 0 < lines[0] < lines[1]:
        raise InputError(f"{table.path}: rows must be the first and the last line to be read, such as [38, 53], not {rows!r}.")
    return lines[0], lines[1]


def _name(cell: str) -> str:
    """A stage's name; a whole number as it is written without decimals."""
    text = " ".join(cell.split())
    return str(int(float(text))) if text.replace(".", "", 1).isdigit() and float(text).is_integer() else text
