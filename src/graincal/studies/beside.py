"""A table of a study as the paper prints it: the paper's numbers, ours, and what runs at the same parameters differ by."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby

import numpy as np

from graincal.notation import numbers
from graincal.report.tables import Table as Shown
from graincal.studies.found import labels
from graincal.studies.records import Row, Table
from graincal.studies.settings import ITERATIVE

PAPER, FLOOR = "the paper", "runs at the same parameters"


def beside(table: Table) -> Shown:
    """A column a quantity; of each setting the paper's row, and ours below it: the median over seeds, and their range where there are several. Below
    each group of settings that have one floor there is that floor.
    """
    quantities, shown = tuple(dict.fromkeys(row.quantity for row in table.rows)), labels()
    settings = {name: [row for row in table.rows if row.setting == name] for name in dict.fromkeys(row.setting for row in table.rows)}
    floors = {name: {row.quantity: row.floor for row in rows if row.floor is not None and np.isfinite(row.floor)} for name, rows in settings.items()}
    lines = []
    for _, group in groupby(settings, key=lambda name: tuple(sorted(floors[name].items()))):
        for name in group:
            of_setting = _setting(settings[name], quantities)
            lines += [(shown.get(name, name) if number == 0 else "", *line) for number, line in enumerate(of_setting)]
        if floor := floors[name]:
            lines.append((FLOOR, "differ by", *_cells(floor, quantities, 3)))
    return Shown(("setting", "", *(shown.get(name, name) for name in quantities)), tuple(lines), figures=2)


def _setting(rows: Sequence[Row], quantities: Sequence[str]) -> list[tuple[str, ...]]:
    """The lines of one setting: the paper's, and one for each method of ours."""
    lines = []
    if printed := {row.quantity: row.paper for row in rows if row.paper is not None}:
        lines.append((PAPER, *(f"{printed[name]:.5g}" if name in printed else "–" for name in quantities)))
    for method in dict.fromkeys(row.method for row in rows):
        ours = {row.quantity: row for row in rows if row.method == method}
        if any(row.ours for row in ours.values()):
            remark = next((f", {row.remark}" for row in ours.values() if row.remark), "")
            lines.append((_by(method) + remark, *(_ours(ours.get(name)) for name in quantities)))
        elif method in ("", ITERATIVE):
            missing = next((row.missing for row in ours.values() if row.missing), "")
            lines.append((f"graincal: {f'skipped, for {missing}' if missing else 'not run'}", *("–" for _ in quantities)))
    return lines


def _by(method: str) -> str:
    return "graincal" if method in ("", ITERATIVE) else f"graincal, {method}"


def _cells(found: Mapping[str, float], quantities: Sequence[str], digits: int) -> tuple[str, ...]:
    return tuple(numbers.value(found[name], digits) if name in found else "–" for name in quantities)


def _ours(row: Row | None) -> str:
    """The median, and the range where seeds differ."""
    if row is None or not np.isfinite(row.median):
        return "–"
    if all(value == int(value) for value in row.ours if np.isfinite(value)):
        # A count, or what was given.
        return f"{row.median:g}" if row.low == row.high else f"{row.median:g} ({row.low:g} to {row.high:g})"
    middle = numbers.value(row.median, 4)
    return middle if len(row.ours) < 2 or row.low == row.high else f"{middle} ({numbers.between(row.low, row.high)})"
