"""The stages of a machine's file, such as saturation, consolidation and shear: which rows belong to each, and the rows that are chosen."""

from __future__ import annotations

from bisect import bisect
from collections.abc import Sequence
from dataclasses import replace

from graincal.errors import InputError
from graincal.laboratory.table import Table
from graincal.laboratory.vocabulary import meaning
from graincal.suggestion import did_you_mean


def stage_column(table: Table) -> int | None:
    """The index of the column that says the stage of each row; None where there is none."""
    return next((index for index, header in enumerate(table.header) if meaning(header).quantity == "stage"), None)


def stages(table: Table) -> dict[str, list[int]]:
    """The rows (by index) of each stage, by its number or word as the file has it; empty for a file without a column of stages."""
    index = stage_column(table)
    if index is None:
        return {}
    found: dict[str, list[int]] = {}
    for at, row in enumerate(table.rows):
        if name := _name(row.cell(index)):
            found.setdefault(name, []).append(at)
    return found


def say_stages(table: Table) -> str:
    """The stages with their lines: `1 (lines 12-23), 2 (lines 24-37)`."""
    found = stages(table)
    return ", ".join(f"{name} (lines {_say_spans(_apart(rows, found), table.lines)})" for name, rows in found.items())


def _apart(rows: list[int], found: dict[str, list[int]]) -> list[tuple[int, int]]:
    """The first and last of the rows of a stage, for each stretch of them that others of `found` stand between."""
    others = sorted(at for each in found.values() if each is not rows for at in each)
    between = [bisect(others, at) for at in rows]
    starts = [at for at in range(len(rows)) if at == 0 or between[at] != between[at - 1]]
    return [(rows[first], rows[behind - 1]) for first, behind in zip(starts, [*starts[1:], len(rows)], strict=True)]


def _say_spans(spans: list[tuple[int, int]], lines: Sequence[int]) -> str:
    return " and ".join(f"{lines[first]}-{lines[last]}" for first, last in spans)


def choose_rows(table: Table, stage: str | int | None, rows: Sequence[int] | None) -> tuple[Table, list[str]]:
    """The table with the rows of a stage, or between a first and a last line of the file, and what to say of it.

    Raises InputError for a stage that the file has not, or has more than once, and for lines without rows.
    """
    if stage is not None and rows is not None:
        raise InputError(f"{table.path}: stage and rows are both given, and one of them was expected.")
    if stage is not None:
        found, name = stages(table), _name(str(stage))
        chosen = found.get(name) or next((rows for other, rows in found.items() if other.casefold() == name.casefold()), None)
        if chosen is None:
            known = f"one of the stages {say_stages(table)}" if found else "a file with a column of stages"
            raise InputError(f"{table.path}: stage is {stage!r}{did_you_mean(name, found)}, and {known} was expected.")
        if len(apart := _apart(chosen, found)) > 1:
            raise InputError(
                f"{table.path}: the stage {name} stands on lines {_say_spans(apart, table.lines)}, with others between them, and one stretch of lines was expected: --rows FIRST-LAST, or rows in the place of stage, chooses one."
            )
        return _kept(table, chosen, f"stage {name}")
    if rows is not None:
        first, last = _lines(table, rows)
        chosen = [at for at, line in enumerate(table.lines) if first <= line <= last]
        if len(chosen) < 2:
            raise InputError(
                f"{table.path}: rows = [{first}, {last}] holds {len(chosen)} rows of numbers, and at least two were expected between lines {table.lines[0]} and {table.lines[-1]}."
            )
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
    return str(int(float(text))) if text.replace(".", "", 1).isdecimal() and float(text).is_integer() else text
