"""Which column of a file holds which quantity, in which unit and by which convention: only what is said, or the exact canonical name."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graincal.errors import InputError
from graincal.laboratory.addressing import column_index
from graincal.laboratory.numbers import read_number, shown
from graincal.laboratory.quantities import COMPRESSED, DIMENSIONS, POROSITIES, SIGNED, STRAINS
from graincal.laboratory.table import Table
from graincal.laboratory.units import Unit, find_unit, known_units, split_header
from graincal.suggestion import did_you_mean

LARGEST_FRACTION = 0.5
"""Strains beyond it are taken for percent unless their unit is said."""

Key = tuple[str, int]
"""A quantity and the index of the column that it is read from."""
Place = str | int | Sequence[str | int]
"""A column: its header, or the group above it and its header; its number, from 1; its letter, as spreadsheets have it. Or several, which are summed."""


@dataclass(frozen=True)
class Conventions:
    """What is said of the columns, each by the name of its quantity; a single word for `strain` and `compression` speaks for all it applies to.
    A strain of which nothing is said is taken as logarithmic. volume (m³) and height (m) are the sample's, where a change of volume or of height is printed."""

    columns: Mapping[str, Place]
    units: Mapping[str, str]
    strain: str | Mapping[str, str] | None
    compression: str | Mapping[str, str]
    volume: float | None = None
    height: float | None = None

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
                    raise InputError(f'{path}: {key} must be "{words[0]}" or "{words[1]}", not {word!r}{did_you_mean(str(word), words)}.')
                if not (isinstance(word, str) or (key == "columns" and _is_place(word))):
                    raise InputError(f"{path}: {key} of {name} must be text{' or a number above 0' * (key == 'columns')}, not {word!r}.")
        self._check_names(path, "columns", self.columns, selectable)

    def check_names(self, path: str, quantities: Collection[str]) -> None:
        """Refuse conventions for quantities that are not read from the file: `quantities` are."""
        self._check_names(path, "units", self.units, quantities)
        self._check_names(path, "strain", self.strain, [name for name in quantities if name in STRAINS])
        self._check_names(path, "compression", self.compression, quantities)

    @staticmethod
    def _check_names(path: str, key: str, option: str | Mapping[str, Place] | None, names: Collection[str]) -> None:
        for name in option if isinstance(option, Mapping) else ():
            if name not in names:
                expected = ", ".join(names) or "no quantity"
                raise InputError(f"{path}: {key} names '{name}'{did_you_mean(name, names)}, which is not read here, and one of {expected} was expected.")

    def leaves_measure_open(self, quantity: str) -> bool:
        """Whether it is a strain of which nothing is said."""
        return quantity in STRAINS and (self.strain is None or (isinstance(self.strain, Mapping) and quantity not in self.strain))

    def is_engineering(self, quantity: str) -> bool:
        if quantity in COMPRESSED:
            return True
        word = self.strain.get(quantity, "logarithmic") if isinstance(self.strain, Mapping) else self.strain
        return quantity in STRAINS and word == "engineering"

    def is_reversed(self, quantity: str) -> bool:
        """Whether compression is negative. One word for all leaves ratios alone: they have no sign to turn."""
        if isinstance(self.compression, Mapping):
            return self.compression.get(quantity) == "negative"
        return quantity in SIGNED and self.compression == "negative"


def _is_place(said: object) -> bool:
    if isinstance(said, (list, tuple)):
        return bool(said) and all(isinstance(each, (str, int)) and _is_place(each) for each in said)
    return isinstance(said, str) or (isinstance(said, int) and not isinstance(said, bool) and said > 0)


@dataclass(frozen=True)
class Column:
    """A column found for a quantity."""

    quantity: str
    header: str
    index: int
    unit: Unit | None

    @property
    def key(self) -> tuple[str, int]:
        """What its values are kept under: a column may be read as more than one quantity."""
        return self.quantity, self.index

    @property
    def label(self) -> str:
        """The column in a message, behind the word column: its header, or its number."""
        return f"'{shown(self.header)}'" if self.header else str(self.index + 1)


def find_column(table: Table, quantity: str, conventions: Conventions) -> Column | None:
    """The column that is named for a quantity, else that of its canonical name; None where nothing was said and no column bears the name.

    Raises InputError for a named column that is missing, a name that two columns bear, several columns, and a unit that is unknown or of another dimension.
    """
    found = find_columns(table, quantity, conventions)
    if len(found) > 1:
        raise InputError(f"{table.path}: columns has {len(found)} columns for {quantity}, and a single one was expected; only strains are summed.")
    return found[0] if found else None


def find_columns(table: Table, quantity: str, conventions: Conventions) -> list[Column]:
    """As `find_column`, of a quantity that may be the sum of several; none where nothing was said and no column bears the name."""
    said = conventions.columns.get(quantity)
    if said is None:
        borne = [i for i, header in enumerate(table.header) if quantity == header] or [
            i for i, header in enumerate(table.header) if split_header(header)[0] == quantity
        ]
        if not borne:
            return []
        if len(borne) > 1:
            names = ", ".join(f"'{table.header[i]}'" for i in borne)
            raise InputError(f"{table.path}: {len(borne)} columns answer to '{quantity}' for {quantity} ({names}), and a single one was expected.")
        indices = borne
    else:
        places = [said] if isinstance(said, (str, int)) else said
        indices = [column_index(table, place, quantity=quantity, second=quantity not in ("axial_strain", "axial_displacement")) for place in places]
    return [Column(quantity, table.header[index], index, _unit(table, quantity, index, conventions.units.get(quantity))) for index in indices]


def _unit(table: Table, quantity: str, index: int, said: str | None) -> Unit | None:
    printed = split_header(table.header[index])[1]
    if printed is None and index < len(table.units):
        printed = table.units[index] or None
    text = said if said is not None else printed
    if text is None:
        return None
    unit = find_unit(text)
    dimension = DIMENSIONS.get(quantity)
    if unit is None or dimension not in (None, unit.dimension):
        hint = " (a stress in a unit is named deviator_stress or axial_stress)" if unit is not None and quantity == "stress_ratio" else ""
        raise InputError(
            f"{table.path}: the unit of {quantity} is '{shown(text)}' in column {repr(shown(table.header[index])) if table.header[index] else index + 1},"
            f" and one of {known_units(dimension)} was expected{hint}."
        )
    return unit


def read_columns(table: Table, columns: Collection[Column]) -> tuple[dict[Key, NDArray[np.float64]], NDArray[np.bool_]]:
    """The printed numbers of each column, by its key, and which rows hold all of them (T,); gaps are NaN.

    Raises InputError for a cell that is neither empty nor a finite number, and for a column without numbers.
    """
    values = {column.key: np.full(len(table.rows), np.nan) for column in columns}
    for column in columns:
        for at, row in enumerate(table.rows):
            try:
                values[column.key][at] = read_number(row.cell(column.index), table.decimal)
            except ValueError as error:
                raise InputError(f"{table.path}: column {column.label}, line {row.line} {error}.") from None
        if np.all(np.isnan(values[column.key])):
            raise InputError(f"{table.path}: column {column.label} holds no numbers, and values of {column.quantity} were expected.")
    complete = ~np.any(np.isnan(np.stack(list(values.values()))), axis=0)
    if not np.any(complete):
        raise InputError(f"{table.path}: no row holds a number in each of the columns {', '.join(column.label for column in columns)}.")
    return values, complete


def to_plain(table: Table, column: Column, printed: NDArray[np.float64], lines: list[int], conventions: Conventions) -> NDArray[np.float64]:
    """Printed numbers (T,) in SI units or plain fractions, compression positive, strains logarithmic.

    An engineering strain e, of length or of volume, becomes -ln(1 - e). Raises InputError where a missing unit matters.
    """
    quantity, unit = column.quantity, column.unit
    place = f"{table.path}: column {column.label}"
    if unit is None and (dimension := DIMENSIONS.get(quantity)) in _USUAL:
        raise InputError(
            f"{place} has no unit, and one of {known_units(dimension)} was expected, as '{column.header or quantity} [{_USUAL[dimension]}]' or in units."
        )
    if unit is None and quantity in STRAINS and np.max(np.abs(printed)) > LARGEST_FRACTION:
        at = int(np.argmax(np.abs(printed)))
        raise InputError(
            f"{place} has no unit and reaches {printed[at]:g} on line {lines[at]}, if that is percent write '{column.header} [%]'"
            f' or units = {{ {quantity} = "%" }}, else "-".'
        )
    plain = _of_the_sample(place, quantity, printed * (unit.factor if unit else 1.0), conventions)
    if conventions.is_reversed(quantity):
        plain = -plain
    if conventions.is_engineering(quantity):
        if np.max(plain) >= 1.0:
            at = int(np.argmax(plain))
            raise InputError(f"{place} is an engineering strain of {plain[at]:g} on line {lines[at]}, and less than 1 was expected.")
        plain = -np.log1p(-plain)
    return _void_ratio(place, quantity, plain) + 0.0  # no negative zeros


_USUAL = {"pressure": "kPa", "volume": "mm3", "length": "mm"}
"""Of the dimensions that must have a unit, the one that is shown as an example."""


def _of_the_sample(place: str, quantity: str, plain: NDArray[np.float64], conventions: Conventions) -> NDArray[np.float64]:
    """A change of height or volume as a part of the sample's; other quantities as they are."""
    if quantity not in COMPRESSED:
        return plain
    key, whole, unit = ("sample_height", conventions.height, "m") if quantity == "axial_displacement" else ("sample_volume", conventions.volume, "m³")
    if whole is None:
        raise InputError(f"{place} is read as {quantity}, and {key} in {unit} was expected, by which it becomes a strain.")
    return plain / whole


def _void_ratio(place: str, quantity: str, plain: NDArray[np.float64]) -> NDArray[np.float64]:
    """A porosity n or a specific volume v as the void ratio n/(1 - n) or v - 1; other quantities as they are."""
    if quantity not in POROSITIES:
        return plain
    low, high = (0.0, 1.0) if quantity == "porosity" else (1.0, np.inf)
    if np.min(plain) <= low or np.max(plain) >= high:
        raise InputError(
            f"{place} is read as {quantity} and goes from {np.min(plain):g} to {np.max(plain):g}, and values {'between 0 and 1' if quantity == 'porosity' else 'above 1'} were expected."
        )
    return plain / (1 - plain) if quantity == "porosity" else plain - 1


def refuse_mixed_units(table: Table, columns: Collection[Column]) -> None:
    """One strain in percent and another without a unit: whichever is meant, the other reading is wrong by a factor of a hundred."""
    strains = [column for column in columns if column.quantity in STRAINS]
    scaled = next(((column, column.unit.symbol) for column in strains if column.unit is not None and column.unit.factor != 1.0), None)
    bare = next((column for column in strains if column.unit is None), None)
    if scaled is not None and bare is not None:
        raise InputError(
            f"{table.path}: column '{bare.header}' has no unit while '{scaled[0].header}' is in {scaled[1]},"
            f" write '{bare.header} [{scaled[1]}]' or '{bare.header} [-]' (or in units)."
        )
