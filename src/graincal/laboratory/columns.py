"""Which column of a file holds which quantity, in which unit and by which convention: only what is said, or the exact canonical name."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graincal.data import InputError
from graincal.laboratory.numbers import read_number
from graincal.laboratory.quantities import DIMENSIONS, SIGNED, STRAINS
from graincal.laboratory.table import Table
from graincal.laboratory.units import Unit, find_unit, known_units, split_header
from graincal.suggestion import did_you_mean

LARGEST_FRACTION = 0.5
"""Strains beyond it are taken for percent unless their unit is said."""


@dataclass(frozen=True)
class Conventions:
    """What is said of the columns, each by the name of its quantity; a single word for `strain` and `compression` speaks for all it applies to.
    A strain of which nothing is said is taken as logarithmic."""

    columns: Mapping[str, str]
    units: Mapping[str, str]
    strain: str | Mapping[str, str] | None
    compression: str | Mapping[str, str]

    def check_words(self, path: str, selectable: Collection[str]) -> None:
        """Refuse words that mean nothing, and columns for quantities that are not asked for: `selectable` are."""
        for key, option, words in (
            ("columns", self.columns, ()),
            ("units", self.units, ()),
            ("strain", self.strain if self.strain is not None else {}, ("logarithmic", "engineering")),
            ("compression", self.compression, ("positive", "negative")),
        ):
            if not isinstance(option, Mapping):
                if not words:
                    raise InputError(f"{path}: {key} must map names of quantities, such as axial_strain, to text, and is {option!r}.")
                option = {"all": option}
            for name, word in option.items():
                if words and word not in words:
                    raise InputError(f'{path}: {key} must be "{words[0]}" or "{words[1]}", not {word!r}{did_you_mean(word, words)}.')
                if not isinstance(word, str):
                    raise InputError(f"{path}: {key} of {name} must be text, not {word!r}.")
        self._check_names(path, "columns", self.columns, selectable)

    def check_names(self, path: str, quantities: Collection[str]) -> None:
        """Refuse conventions for quantities that are not read from the file: `quantities` are."""
        self._check_names(path, "units", self.units, quantities)
        self._check_names(path, "strain", self.strain, [name for name in quantities if name in STRAINS])
        self._check_names(path, "compression", self.compression, quantities)

    @staticmethod
    def _check_names(path: str, key: str, option: str | Mapping[str, str] | None, names: Collection[str]) -> None:
        for name in option if isinstance(option, Mapping) else ():
            if name not in names:
                expected = ", ".join(names) or "no quantity"
                raise InputError(f"{path}: {key} names '{name}'{did_you_mean(name, names)}, which is not read here, and one of {expected} was expected.")

    def leaves_measure_open(self, quantity: str) -> bool:
        """Whether it is a strain of which nothing is said."""
        return quantity in STRAINS and (self.strain is None or (isinstance(self.strain, Mapping) and quantity not in self.strain))

    def is_engineering(self, quantity: str) -> bool:
        word = self.strain.get(quantity, "logarithmic") if isinstance(self.strain, Mapping) else self.strain
        return quantity in STRAINS and word == "engineering"

    def is_reversed(self, quantity: str) -> bool:
        """Whether compression is negative. One word for all leaves ratios alone: they have no sign to turn."""
        if isinstance(self.compression, Mapping):
            return self.compression.get(quantity) == "negative"
        return quantity in SIGNED and self.compression == "negative"


@dataclass(frozen=True)
class Column:
    """A column found for a quantity."""

    quantity: str
    header: str
    index: int
    unit: Unit | None


def find_column(table: Table, quantity: str, conventions: Conventions) -> Column | None:
    """The column that is named for a quantity, else that of its canonical name; None where nothing was said and no column bears the name.

    Raises InputError for a named column that is missing, a name that two columns bear, and a unit that is unknown or of another dimension.
    """
    said = conventions.columns.get(quantity)
    wanted = " ".join((said or quantity).split())
    headers = dict(enumerate(table.header))
    found = [i for i, header in headers.items() if header == wanted] or [i for i, header in headers.items() if split_header(header)[0] == wanted]
    if not found and said is None:
        return None
    if not found:
        raise missing_column(table, f"'{said}' for {quantity}", said)
    if len(found) > 1:
        names = ", ".join(f"'{table.header[i]}'" for i in found)
        raise InputError(f"{table.path}: {len(found)} columns answer to '{wanted}' for {quantity} ({names}), and a single one was expected.")
    index = found[0]
    return Column(quantity, table.header[index], index, _unit(table, quantity, index, conventions.units.get(quantity)))


def missing_column(table: Table, wanted: str, name: str) -> InputError:
    """That there is no column of that name, which is said as `wanted`."""
    meant = did_you_mean(split_header(name)[0], [split_header(header)[0] for header in table.header])
    present = ", ".join(f"'{header}'" for header in table.header if header)
    return InputError(f"{table.path}: there is no column {wanted}{meant}, and those present are {present} (columns = {{ ... }} in a calibration file says which is which).")


def _unit(table: Table, quantity: str, index: int, said: str | None) -> Unit | None:
    printed = split_header(table.header[index])[1]
    if printed is None and index < len(table.units):
        printed = table.units[index]
    text = said if said is not None else printed
    if text is None:
        return None
    unit = find_unit(text)
    dimension = DIMENSIONS.get(quantity)
    if unit is None or dimension not in (None, unit.dimension):
        hint = " (a stress in a unit is named deviator_stress or axial_stress)" if unit is not None and quantity == "stress_ratio" else ""
        raise InputError(
            f"{table.path}: the unit of {quantity} is '{text}' in column '{table.header[index]}',"
            f" and one of {known_units(dimension)} was expected{hint}."
        )
    return unit


def read_columns(table: Table, columns: Collection[Column]) -> tuple[dict[str, NDArray[np.float64]], NDArray[np.bool_]]:
    """The printed numbers of each column, by quantity, and which rows hold all of them (T,); gaps are NaN.

    Raises InputError for a cell that is neither empty nor a finite number, and for a column without numbers.
    """
    values = {column.quantity: np.full(len(table.rows), np.nan) for column in columns}
    for column in columns:
        for at, row in enumerate(table.rows):
            try:
                values[column.quantity][at] = read_number(row.cell(column.index), table.decimal)
            except ValueError as error:
                raise InputError(f"{table.path}: column '{column.header}', line {row.line} {error}.") from None
        if np.all(np.isnan(values[column.quantity])):
            raise InputError(f"{table.path}: column '{column.header}' holds no numbers, and values of {column.quantity} were expected.")
    complete = ~np.any(np.isnan(np.stack(list(values.values()))), axis=0)
    if not np.any(complete):
        raise InputError(f"{table.path}: no row holds a number in each of the columns {', '.join(repr(column.header) for column in columns)}.")
    return values, complete


def to_plain(table: Table, column: Column, printed: NDArray[np.float64], lines: list[int], conventions: Conventions) -> NDArray[np.float64]:
    """Printed numbers (T,) in SI units or plain fractions, compression positive, strains logarithmic.

    An engineering strain e, of length or of volume, becomes -ln(1 - e). Raises InputError where a missing unit matters.
    """
    quantity, unit = column.quantity, column.unit
    place = f"{table.path}: column '{column.header}'"
    if unit is None and DIMENSIONS.get(quantity) == "pressure":
        raise InputError(f"{place} has no unit, and one of {known_units('pressure')} was expected, as '{column.header} [kPa]' or in units.")
    if unit is None and quantity in STRAINS and np.max(np.abs(printed)) > LARGEST_FRACTION:
        at = int(np.argmax(np.abs(printed)))
        raise InputError(
            f"{place} has no unit and reaches {printed[at]:g} on line {lines[at]}, if that is percent write '{column.header} [%]'"
            f' or units = {{ {quantity} = "%" }}, else "-".'
        )
    plain = printed * (unit.factor if unit else 1.0)
    if conventions.is_reversed(quantity):
        plain = -plain
    if conventions.is_engineering(quantity):
        if np.max(plain) >= 1.0:
            at = int(np.argmax(plain))
            raise InputError(f"{place} is an engineering strain of {plain[at]:g} on line {lines[at]}, and less than 1 was expected.")
        plain = -np.log1p(-plain)
    return plain + 0.0  # no negative zeros


def refuse_mixed_units(table: Table, columns: Collection[Column]) -> None:
    """One strain in percent and another without a unit: whichever is meant, the other reading is wrong by a factor of a hundred."""
    strains = [column for column in columns if column.quantity in STRAINS]
    scaled = next((column for column in strains if column.unit is not None and column.unit.factor != 1.0), None)
    bare = next((column for column in strains if column.unit is None), None)
    if scaled is not None and bare is not None:
        raise InputError(
            f"{table.path}: column '{bare.header}' has no unit while '{scaled.header}' is in {scaled.unit.symbol},"
            f" write '{bare.header} [{scaled.unit.symbol}]' or '{bare.header} [-]' (or in units)."
        )
