"""A look at an unknown laboratory file: what it seems to hold, for a person to confirm. Nothing here is used by a calibration."""

from __future__ import annotations

import re
from dataclasses import dataclass
from os import PathLike

import numpy as np
from numpy.typing import NDArray

from graincal.laboratory.backbone import first_movement, repeated, spans, turned_back
from graincal.laboratory.numbers import read_number
from graincal.laboratory.quantities import DIMENSIONS, SIGNED, STRAINS, STRESS_MEASURES, guess
from graincal.laboratory.table import Table, read_table
from graincal.laboratory.units import UNITS, Unit, find_unit, known_units

STRESS_NAMES = ("stress_ratio", *STRESS_MEASURES)
_NUMBER = r"(?P<number>\d[\d.,]*(?:[eE][+-]?\d+)?)"
_CONFINING_PRESSURE = re.compile(
    r"(?:(?:confining|cell|lateral|radial|chamber)\s+(?:pressure|stress)|zelldruck|seitendruck|pression de confinement|contrainte de confinement|(?:σ|sigma)[_' ]*[3c])(?:\W*[\[(](?P<before>[^\d\])]+[²2]?)[\])])?\D*?"
    + _NUMBER + r"[\s\[(]*(?P<after>[A-Za-z][\w/²^]*)?",
    re.IGNORECASE,
)
_VOID_RATIO = re.compile(r"(?:void ratio|porenzahl|indice des vides)\D{0,12}?" + _NUMBER, re.IGNORECASE)


@dataclass(frozen=True)
class LaboratoryColumn:
    """A column: its header, what it seems to be, its range as printed, and lines where it has no number or one that would be refused.

    `unit_is_guessed` where the header has none and the values suggest one; `compression` is the sign convention that they suggest.
    `unusable` says of a column whose header names a quantity why it cannot be that; empty for all others.
    """

    header: str
    quantity: str | None
    unit: str | None
    unit_is_guessed: bool
    range: tuple[float, float] | None
    compression: str | None
    gaps: tuple[tuple[int, int], ...]
    refused: tuple[str, ...]
    unusable: str = ""


@dataclass(frozen=True)
class LaboratoryFile:
    """What a laboratory file seems to hold. `loops` and `standstills` are first and last lines where the axial strain turns back or stands still;
    `strain_measure`, `confining_pressure` (Pa) and `void_ratio` are None where the file does not say."""

    path: str
    encoding: str
    byte_order_mark: bool
    delimiter: str
    decimal: str
    header_line: int
    rows: int
    columns: tuple[LaboratoryColumn, ...]
    loops: tuple[tuple[int, int], ...]
    standstills: tuple[tuple[int, int], ...]
    strain_measure: str | None
    confining_pressure: float | None
    void_ratio: float | None

    def column(self, quantity: str) -> LaboratoryColumn | None:
        """The first column that seems to hold a quantity."""
        return next((column for column in self.columns if column.quantity == quantity), None)

    @property
    def reference(self) -> dict[str, LaboratoryColumn]:
        """The columns that a reference would be read from, by quantity: axial strain, the most direct measure of stress, volumetric strain; less
        what is not recognised."""
        stress = next((name for name in STRESS_NAMES if self.column(name)), "stress_ratio")
        return {name: column for name in ("axial_strain", stress, "volumetric_strain") if (column := self.column(name))}


def look(path: str | PathLike[str]) -> LaboratoryFile:
    """Look at a laboratory file. Raises InputError where it cannot be read as a table at all."""
    table = read_table(path)
    values, refused = zip(*(_numbers(table, index) for index in range(len(table.header))), strict=True)
    guesses, unusable = _guess_columns(table, values, refused)
    units = [unit or _unit_by_values(quantity, numbers, guesses, values) for (quantity, unit), numbers in zip(guesses, values, strict=True)]
    columns = tuple(
        LaboratoryColumn(
            header=table.header[index],
            quantity=quantity,
            unit=units[index].symbol if units[index] else None,
            unit_is_guessed=printed is None and units[index] is not None,
            range=(float(np.nanmin(values[index])) + 0.0, float(np.nanmax(values[index])) + 0.0) if _has_numbers(values[index]) else None,
            compression=_compression(quantity, values[index]),
            gaps=tuple(spans(np.isnan(values[index]), table.lines)) if quantity else (),
            refused=tuple(refused[index]),
            unusable=unusable[index],
        )
        for index, (quantity, printed) in enumerate(guesses)
    )
    loops, standstills = _turns(table, columns, values)
    return LaboratoryFile(
        path=table.path,
        encoding=table.encoding,
        byte_order_mark=table.byte_order_mark,
        delimiter=table.delimiter,
        decimal=table.decimal,
        header_line=table.header_line,
        rows=len(table.rows),
        columns=columns,
        loops=loops,
        standstills=standstills,
        strain_measure=_strain_measure(" ".join((*table.remarks, *table.header))),
        confining_pressure=_confining_pressure(table, columns, values),
        void_ratio=_void_ratio(table, columns, values),
    )


def _numbers(table: Table, index: int) -> tuple[NDArray[np.float64], list[str]]:
    """The column's numbers (T,), NaN where there is none, and what is refused among its cells."""
    numbers = np.full(len(table.rows), np.nan)
    refused = []
    for at, row in enumerate(table.rows):
        try:
            numbers[at] = read_number(row.cell(index), table.decimal)
        except ValueError as error:
            refused.append(f"line {row.line} {error}")
    return numbers, refused


def _has_numbers(values: NDArray[np.float64]) -> bool:
    return not np.all(np.isnan(values))


def _guess_columns(
    table: Table, values: tuple[NDArray[np.float64], ...], refused: tuple[list[str], ...]
) -> tuple[list[tuple[str | None, Unit | None]], list[str]]:
    """Quantity and printed unit of each column, and why it is not the quantity that its header names; a quantity goes to the first column that has
    numbers and a unit that can be its own."""
    guesses: list[tuple[str | None, Unit | None]] = []
    unusable = []
    for index, header in enumerate(table.header):
        quantity, unit = guess(header)
        if unit is None and index < len(table.units):
            unit = find_unit(table.units[index])
        why = ""
        if quantity is not None and not _has_numbers(values[index]):
            why = f"its numbers cannot be read: {refused[index][0]}" if refused[index] else "it holds no numbers"
        elif unit is not None and DIMENSIONS.get(quantity) not in (None, unit.dimension):
            why = f"'{unit.symbol}' is a unit of {unit.dimension}, and one of {known_units(DIMENSIONS[quantity])} was expected"
        elif quantity is not None and quantity in (before := [other for other, _ in guesses]):
            why = f"'{table.header[before.index(quantity)]}' is taken for that"
        guesses.append((None if why else quantity, unit))
        unusable.append(f"{quantity}, but {why}" if why else "")
    return guesses, unusable


def _unit_by_values(
    quantity: str | None, numbers: NDArray[np.float64], guesses: list[tuple[str | None, Unit | None]], values: tuple[NDArray[np.float64], ...]
) -> Unit | None:
    """The unit that the values suggest: strains beyond a half are percent, and strains share a unit; soil is sheared at some 10 kPa to 10 MPa."""
    if quantity in STRAINS:
        printed = [unit for other, unit in guesses if other in STRAINS and unit is not None]
        largest = max(np.nanmax(np.abs(column)) for (other, _), column in zip(guesses, values, strict=True) if other in STRAINS)
        return printed[0] if printed else UNITS["%" if largest > 0.5 else "-"]
    if DIMENSIONS.get(quantity) == "fraction":
        return UNITS["-"]
    if DIMENSIONS.get(quantity) == "pressure":
        largest = np.nanmax(np.abs(numbers))
        return UNITS["Pa" if largest > 2e4 else "kPa" if largest > 10 else "MPa"]
    return None


def _compression(quantity: str | None, values: NDArray[np.float64]) -> str | None:
    """The sign convention that the values suggest: a triaxial test compresses, and its sample contracts before it dilates."""
    if quantity not in SIGNED or quantity == "radial_strain":
        return None
    values = values[~np.isnan(values)]
    telling = first_movement(values) if quantity == "volumetric_strain" else values[np.argmax(np.abs(values))]
    return "negative" if telling < 0 else "positive"


def _turns(
    table: Table, columns: tuple[LaboratoryColumn, ...], values: tuple[NDArray[np.float64], ...]
) -> tuple[tuple[tuple[int, int], ...], tuple[tuple[int, int], ...]]:
    for column, numbers in zip(columns, values, strict=True):
        if column.quantity == "axial_strain":
            there = ~np.isnan(numbers)
            strain = numbers[there] * (-1.0 if column.compression == "negative" else 1.0)
            lines = [line for line, kept in zip(table.lines, there, strict=True) if kept]
            return tuple(spans(turned_back(strain), lines)), tuple(spans(repeated(strain), lines))
    return (), ()


def _strain_measure(said: str) -> str | None:
    if re.search(r"\b(logarithmic|log|true|natural|hencky) (\w+ )?strain", said, re.IGNORECASE):
        return "logarithmic"
    if re.search(r"\b(engineering|nominal) (\w+ )?strain", said, re.IGNORECASE):
        return "engineering"
    return None


def _confining_pressure(table: Table, columns: tuple[LaboratoryColumn, ...], values: tuple[NDArray[np.float64], ...]) -> float | None:
    """Pascals: what a remark says, else the first value of a column of confining pressure."""
    for remark in table.remarks:
        found = _CONFINING_PRESSURE.search(remark)
        unit = find_unit(found["before"] or found["after"] or "") if found else None
        if unit is not None and unit.dimension == "pressure" and (value := _float(found["number"])):
            return value * unit.factor
    column, first = _first_value("confining_pressure", columns, values)
    return abs(first) * UNITS[column.unit].factor if first else None


def _void_ratio(table: Table, columns: tuple[LaboratoryColumn, ...], values: tuple[NDArray[np.float64], ...]) -> float | None:
    """What a remark says, else the first value of a column of void ratios."""
    found = [value for remark in table.remarks if (said := _VOID_RATIO.search(remark)) and (value := _float(said["number"]))]
    return found[0] if found else _first_value("void_ratio", columns, values)[1]


def _first_value(
    quantity: str, columns: tuple[LaboratoryColumn, ...], values: tuple[NDArray[np.float64], ...]
) -> tuple[LaboratoryColumn | None, float | None]:
    for column, numbers in zip(columns, values, strict=True):
        if column.quantity == quantity:
            return column, float(numbers[~np.isnan(numbers)][0])
    return None, None


def _float(text: str) -> float | None:
    """A number in a remark, unless its comma may part thousands."""
    text = text.rstrip(".,")
    try:
        return None if re.search(r",\d{3}(\D|$)", text) else float(text.replace(",", "."))
    except ValueError:
        return None
