"""Which rows of a test are kept, and what is said of the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from graincal.errors import InputError
from graincal.laboratory.backbone import outrun, repeated, say_lines, spans, turned_back
from graincal.laboratory.columns import LARGEST_FRACTION, Column, Key
from graincal.laboratory.loading_path import turns_of
from graincal.laboratory.quantities import STRAINS
from graincal.laboratory.table import Table
from graincal.positions import POSITION


def up_to(table: Table, name: str, control: NDArray[np.float64], lines: list[int], until: float | None) -> tuple[slice, list[str]]:
    """The rows up to the first whose control (T,) exceeds `until`, and what to say of the others."""
    if until is None:
        return slice(None), []
    # A value that is printed in percent may come out in its last digit above the fraction that was meant.
    beyond = np.flatnonzero(control > until * (1 + 1e-12))
    if not beyond.size:
        largest = float(np.max(control))
        if name in STRAINS and until > LARGEST_FRACTION:
            raise InputError(
                f"{table.path}: until = {until:g} leaves nothing out, where {name} goes to {largest:.4g}, and a fraction was expected; if {until:g} % is meant, write {until / 100:g}."
            )
        return slice(None), [f"nothing is left out by until = {until:g}, which no row lies beyond: {name} goes to {largest:.4g}."]
    first = int(beyond[0])
    kept = int(np.sum(~(turned_back(control[:first]) | repeated(control[:first])))) if first else 0
    if kept < 2:
        left = "a single row" if kept else "no row"
        raise InputError(
            f"{table.path}: until = {until:g} leaves {left}, where {name} goes from {np.min(control):.4g} to {np.max(control):.4g}, and one that leaves at least two was expected."
        )
    rest = np.arange(len(control)) >= first
    return slice(first), [f"{_rows(rest)} left out beyond until = {until:g}, where {name} goes on to {np.max(control):.4g}: {say_lines(spans(rest, lines))}."]


def backbone_of(table: Table, name: str, control: NDArray[np.float64], lines: list[int], unloading: str | None) -> tuple[NDArray[np.bool_], list[str]]:
    """The rows to keep (T,), and what to say of the others."""
    if unloading not in (None, "drop"):
        raise InputError(f'{table.path}: unloading must be "drop" or left out, not {unloading!r}.')
    back, still = turned_back(control), repeated(control)
    is_stress = name in (POSITION, "axial_stress", "mean_stress")
    wavers = is_stress and (name == POSITION or not turns_of(loaded := control[control > 0], loaded[0]) if np.any(control > 0) else False)
    if np.any(back) and unloading is None and not wavers:
        raise InputError(
            f"{table.path}: {name} turns back at {say_lines(spans(back, lines))}, where it was expected to increase:"
            ' unloading = "drop" leaves unload-reload loops out.'
        )
    kept = ""
    if is_stress:
        # Under a stress that is held the sample goes on to settle: what it comes to counts.
        kept, going = ", before the last row at the same stress", np.flatnonzero(~back | wavers)
        still = np.zeros(len(control), dtype=bool)
        still[going[:-1]] = control[going[1:]] == control[going[:-1]]
        back = outrun(control) & ~still if wavers else back
    notes = []
    if np.any(back):
        notes.append(f"{_rows(back)} dropped where {name} {'wavers' if wavers else 'turned back'}: {say_lines(spans(back, lines))}.")
    if np.any(still):
        notes.append(f"{_rows(still)} dropped where {name} stood still{kept}: {say_lines(spans(still, lines))}.")
    return ~(back | still), notes


def said_of_gaps(table: Table, found: Sequence[Column], printed: Mapping[Key, NDArray[np.float64]], complete: NDArray[np.bool_]) -> list[str]:
    if np.all(complete):
        return []
    where = [column.quantity for column in found if np.any(np.isnan(printed[column.key]))]
    return [f"{_rows(~complete)} dropped for an empty cell, in {', '.join(where)}: {say_lines(spans(~complete, table.lines))}."]


def said_of_unloaded(lines: list[int], loaded: NDArray[np.bool_]) -> list[str]:
    if np.all(loaded):
        return []
    return [f"{_rows(~loaded)} dropped where the stress is 0, which has no position: {say_lines(spans(~loaded, lines))}."]


def chosen_lines(lines: list[int], kept: NDArray[np.bool_]) -> list[int]:
    return [line for line, keep in zip(lines, kept, strict=True) if keep]


def _rows(chosen: NDArray[np.bool_]) -> str:
    count = int(np.sum(chosen))
    return f"{count} row{'s' if count > 1 else ''}"
