"""The columns of a laboratory file as they are seen: what each header says, its unit, and its numbers."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from graincal.errors import InputError
from graincal.laboratory.addressing import column_index, refuse_shared
from graincal.laboratory.numbers import read_number
from graincal.laboratory.quantities import DIMENSIONS, READABLE, TOTAL
from graincal.laboratory.table import Table
from graincal.laboratory.units import UNITS, Unit, find_unit, known_units
from graincal.laboratory.vocabulary import Meaning, meaning
from graincal.suggestion import did_you_mean

KNOWN_HERE = (*READABLE, "back_pressure", "initial_void_ratio")
ALIASES = {
    "confining_pressure": "lateral_stress",
    "total_confining_pressure": "total_lateral_stress",
    "q": "deviator_stress",
    "deviatoric_stress": "deviator_stress",
    "p": "mean_stress",
    "e": "void_ratio",
}
"""What may be written for a quantity where a column is named."""
_TENSOR = re.compile(r"(?P<what>s|sig|sigma|stress|e|eps|epsilon|strain)_?(?P<axis>11|22|33|xx|yy|zz)")
SAME = 0.01
"""Columns that are called the same are so within this part of their largest number: of another unit, or of fewer digits."""
_AXES = {"11": 0, "22": 1, "33": 2, "xx": 0, "yy": 1, "zz": 2}


@dataclass(frozen=True, eq=False)
class Seen:
    """A column: its place and header, what it is taken for, its unit (None without one), its numbers (T,) with NaN for gaps, and what is refused among its cells.

    said: whether a person named it. alone: whether no other column bears its name; label: what it is called in a message. unusable: why a column whose header names a quantity is not taken for it; empty for all others.
    """

    index: int
    header: str
    meaning: Meaning
    unit: Unit | None
    values: NDArray[np.float64]
    digits: float
    refused: tuple[str, ...]
    said: bool = False
    unusable: str = ""
    alone: bool = True
    label: str = ""

    @property
    def quantity(self) -> str:
        """What it is taken for; empty for nothing."""
        return "" if self.unusable else self.meaning.quantity or ""

    @property
    def place(self) -> str | int:
        """How a calibration file names it."""
        return self.header if self.header and self.alone else self.index + 1

    @property
    def has_numbers(self) -> bool:
        return not np.all(np.isnan(self.values))

    @property
    def plain(self) -> NDArray[np.float64]:
        """In SI units or as a fraction; as printed where no unit is known."""
        return self.values * (self.unit.factor if self.unit else 1.0)

    @property
    def last_digit(self) -> float:
        """The step between its printed numbers, in the unit of `plain`."""
        return self.digits * (self.unit.factor if self.unit else 1.0)


def see(table: Table, said: Mapping[str, tuple[str | int, str | None]]) -> list[Seen]:
    """The columns of a table; `said`: quantity -> place and unit, of those that a person names. Raises InputError for a name or a unit that is unknown."""
    places: dict[int, tuple[str, str | None]] = {}
    asked: dict[str, int] = {}
    for name, (place, unit) in said.items():
        quantity = ALIASES.get(name, name)
        if quantity not in KNOWN_HERE:
            raise InputError(f"--column names '{name}'{did_you_mean(name, KNOWN_HERE)}, and one of {', '.join(KNOWN_HERE)} was expected.")
        if quantity in asked:
            raise InputError(f"--column names {quantity} twice{f', once as {name}' * (name != quantity)}, and each quantity once was expected.")
        asked[quantity] = column_index(table, place, quantity=quantity, second=quantity != "axial_strain")
        places[asked[quantity]] = quantity, unit
    refuse_shared(table, asked)
    columns = [_seen(table, index, unit_is_said=index in places and places[index][1] is not None) for index in range(len(table.header))]
    for index, (quantity, unit) in places.items():
        columns[index] = _as_said(table, columns[index], quantity, unit)
    if said:
        taken = {column.quantity for column in columns if column.said}
        # A measure of stress that a person names is the only one that is looked at, but for what it is combined with.
        columns = [
            column if column.said or column.quantity not in taken else replace(column, unusable=f"{column.quantity}, but another column was named for it")
            for column in columns
        ]
    return _without_doubles(table, columns)


def one(columns: list[Seen], quantity: str) -> Seen | None:
    """The column of a quantity, if there is one."""
    return next((column for column in columns if column.quantity == quantity), None)


def _seen(table: Table, index: int, unit_is_said: bool) -> Seen:
    """unit_is_said: by a person, so that those that stand in the file do not matter."""
    header = table.header[index]
    names = meaning(header) if header else Meaning(None)
    unit, unknown = names.unit, names.unknown_unit
    below = table.units[index] if index < len(table.units) else ""
    if unit is None and below:
        unit = find_unit(below)
        unknown = "" if unit else below
    elif unit is not None and not unit_is_said and (other := find_unit(below)) not in (None, unit, PLAIN) and names.quantity in KNOWN_HERE:
        raise InputError(
            f"{table.path}: column {table.label(index)} is in {unit.symbol} by its header and in {other.symbol} by the unit below, and one of them was expected (--column {names.quantity}={index + 1}:UNIT says which)."
        )
    values, digits, refused = _numbers(table, index)
    if names.quantity in TOTAL and names.effective is False:
        names = replace(names, quantity=TOTAL[names.quantity])
    column = Seen(index, header, names, unit, values, digits, tuple(refused), alone=list(table.header).count(header) == 1, label=table.label(index))
    return _usable(table, column, "" if unit_is_said else unknown)


_BY_DIMENSION = {
    ("volume_change", "fraction"): "volumetric_strain", ("volumetric_strain", "volume"): "volume_change",
    ("axial_displacement", "fraction"): "axial_strain", ("axial_strain", "length"): "axial_displacement",
}  # fmt: skip
"""What a header means whose unit is of the other measure: a change of volume in % is a volumetric strain, an axial deformation in mm a displacement."""


def _usable(table: Table, column: Seen, unknown: str) -> Seen:
    """With why it cannot be what its header names. Raises InputError for a unit that is stated and not known."""
    quantity = column.meaning.quantity
    if quantity not in KNOWN_HERE:
        return column
    dimension = DIMENSIONS[quantity]
    if not column.has_numbers:
        return replace(column, unusable=f"{quantity}, but {f'its numbers cannot be read: {column.refused[0]}' if column.refused else 'it holds no numbers'}")
    if unknown:
        raise InputError(
            f"{table.path}: column {column.label} is in '{unknown}', which is not a unit that is known, and one of {known_units(dimension)} was expected "
            f"(--column {quantity}={column.index + 1}:UNIT says another)."
        )
    if column.unit is not None and (meant := _BY_DIMENSION.get((quantity, column.unit.dimension))):
        return replace(column, meaning=replace(column.meaning, quantity=meant))
    if column.unit is not None and column.unit.dimension != dimension:
        return replace(
            column, unusable=f"{quantity}, but '{column.unit.symbol}' is a unit of {column.unit.dimension}, and one of {known_units(dimension)} was expected"
        )
    return column


def _as_said(table: Table, column: Seen, quantity: str, unit: str | None) -> Seen:
    found = find_unit(unit) if unit is not None else column.unit
    dimension = DIMENSIONS[quantity]
    if unit is not None and (found is None or found.dimension != dimension):
        raise InputError(f"--column {quantity}: '{unit}' is not a unit of it, and one of {known_units(dimension)} was expected.")
    if found is not None and found.dimension != dimension:
        found = None
    if not column.has_numbers:
        raise InputError(f"{table.path}: column {column.label} holds no numbers, and values of {quantity} were expected.")
    return replace(column, meaning=Meaning(quantity, found, "", True if quantity in TOTAL else None), unit=found, said=True, unusable="")


def _without_doubles(table: Table, columns: list[Seen]) -> list[Seen]:
    """Each quantity once: the first column that has it. Raises InputError where the file holds several curves."""
    seen: dict[tuple, Seen] = {}
    columns, doubles = _cell_apart(columns), []
    differing: list[tuple[Seen, Seen]] = []
    kept: list[Seen] = []
    for column in columns:
        key = (column.quantity, column.meaning.effective)
        if column.quantity in KNOWN_HERE and key in seen:
            doubles.append(column)
            column = replace(column, unusable=f"{column.quantity}, but {seen[key].label} is taken for that")
            differing += [(seen[key], doubles[-1])] if _differ(seen[key], doubles[-1]) else []
        elif column.quantity in KNOWN_HERE:
            seen[key] = column
        kept.append(column)
    twice = {column.meaning.quantity for column in doubles}
    if "axial_strain" in twice and len(twice) > 1:
        listed = ", ".join(f"{column.index + 1} {column.header or '(no name)'}" for column in columns)
        raise InputError(
            f"{table.path}: the file seems to hold several curves, and its columns are {listed}: --column axial_strain=..., --column deviator_stress=... choose one by the numbers of its columns."
        )
    if differing:
        first, second = differing[0]
        raise InputError(
            f"{table.path}: columns {first.index + 1} {first.label} and {second.index + 1} {second.label} can both be {first.quantity.replace('_', ' ')}, and their numbers differ: "
            f"--column {first.quantity}={first.index + 1} or {second.index + 1} says which is read."
        )
    return kept


def _cell_apart(columns: list[Seen]) -> list[Seen]:
    """A cell pressure beside another lateral stress that it exceeds is the total one."""
    lateral = [column for column in columns if column.quantity == "lateral_stress" and column.meaning.effective is None and not column.said]
    other = next((column for column in lateral if not column.meaning.cell), None)
    totals = {
        column.index
        for column in lateral
        if other is not None
        and column.meaning.cell
        and _differ(column, other)
        and np.nanmedian(_in_one_unit(column, other)[0]) > np.nanmedian(_in_one_unit(column, other)[1])
    }
    return [
        replace(column, meaning=replace(column.meaning, quantity="total_lateral_stress", effective=False)) if column.index in totals else column
        for column in columns
    ]


def _differ(one: Seen, other: Seen) -> bool:
    """Whether two columns that are called the same are of different numbers."""
    first, second = _in_one_unit(one, other)
    both = ~np.isnan(first + second)
    return not np.any(both) or bool(np.max(np.abs(first - second)[both]) > SAME * max(np.max(np.abs(first[both])), np.max(np.abs(second[both]))))


def _in_one_unit(one: Seen, other: Seen) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The numbers of two columns, as they are printed where one of them has no unit."""
    return (one.plain, other.plain) if one.unit and other.unit else (one.values, other.values)


def _numbers(table: Table, index: int) -> tuple[NDArray[np.float64], float, list[str]]:
    """The column's numbers (T,), NaN where there is none; the step of its last printed digit; and what is refused among its cells."""
    numbers, refused, decimals = np.full(len(table.rows), np.nan), [], 0
    for at, row in enumerate(table.rows):
        cell = row.cell(index)
        try:
            numbers[at] = read_number(cell, table.decimal)
        except ValueError as error:
            refused.append(f"line {row.line} {error}")
            continue
        mantissa, _, exponent = cell.casefold().partition("e")
        if at < 2000 and table.decimal in mantissa:
            decimals = max(decimals, len(mantissa.partition(table.decimal)[2]) - (int(exponent) if exponent.lstrip("+-").isdecimal() else 0))
    return numbers, 10.0**-decimals, refused


def tensors(columns: list[Seen]) -> dict[str, list[Seen]] | None:
    """The three normal stresses and strains of a simulation's recorder, by "stress" and "strain", each in the order of the axes; None where they are not all there."""
    found: dict[str, dict[int, Seen]] = {"stress": {}, "strain": {}}
    for column in columns:
        if column.has_numbers and (name := _TENSOR.fullmatch(column.header.split(" ")[0].casefold())):
            found["strain" if name["what"].startswith(("e", "strain")) else "stress"][_AXES[name["axis"]]] = column
    return {what: [axes[k] for k in range(3)] for what, axes in found.items() if len(axes) == 3} if all(len(axes) == 3 for axes in found.values()) else None


def named(column: Seen, quantity: str, unit: Unit | None = None) -> Seen:
    """The column, taken for a quantity, an effective stress if it is one."""
    return replace(column, meaning=Meaning(quantity, unit or column.unit, "", True), unit=unit or column.unit, unusable="")


PLAIN = UNITS["-"]
