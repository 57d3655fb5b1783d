"""Which columns a quantity of a reference comes from, and how: its own, or others that it follows from."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from graincal.errors import InputError
from graincal.laboratory.addressing import missing_column
from graincal.laboratory.columns import Column, Conventions, Key, find_column, find_columns
from graincal.laboratory.quantities import COMPRESSED, LARGEST_STRESS_RATIO, POROSITIES, STRESS_FORMS, STRESS_MEASURES, VOID_RATIOS
from graincal.laboratory.stresses import WANTED, contradiction, weights
from graincal.laboratory.table import Table

Values = Mapping[Key, NDArray[np.float64]]
LARGEST_CONTRADICTION = 0.02
"""Of the largest stress: columns of one test agree within their digits and the small corrections of a laboratory."""
EXTENSION = "axial_extension"


@dataclass(frozen=True)
class Source:
    """Where a wanted quantity comes from: `make` gives it, (T,), of the plain values of the columns by their keys. `note`: how, empty for its own column. `at_pressure`: whether a constant lateral
    stress goes into it."""

    name: str
    columns: tuple[Column, ...]
    make: Callable[[Values], NDArray[np.float64]]
    note: str
    at_pressure: bool = field(default=False, kw_only=True)


def find_source(table: Table, name: str, conventions: Conventions, confining_pressure: float | None) -> Source:
    """The source of a wanted quantity. Raises InputError where the file, with what is said of it, has none."""
    if name == "stress_ratio":
        return _stress_ratio(table, conventions, confining_pressure)
    if (own := find_columns(table, name, conventions)) and not _is_asked_of_stresses(name, conventions):
        return _own(name, own)
    for other in instead(name):
        if columns := find_columns(table, other, conventions):
            return _from(name, other, columns)
    if name == "excess_pore_pressure" and (pore := _stress(table, "pore_pressure", conventions, None)):
        make_pore = pore.make
        return Source(
            name, pore.columns, lambda values: (u := make_pore(values)) - u[0], f"excess_pore_pressure counts from the first row that is read{_of(pore)}."
        )
    if name == "excess_pore_pressure" and (held := _stress(table, "lateral_stress", conventions, None)):
        make_lateral = held.make
        note = f"excess_pore_pressure was computed from {_listed(held.columns)}: what the effective lateral stress loses while the total one is held."
        return Source(name, held.columns, lambda values: (lateral := make_lateral(values))[0] - lateral, note)
    if (
        name == "volumetric_strain"
        and (radial := find_columns(table, "radial_strain", conventions))
        and (axial := find_columns(table, "axial_strain", conventions))
    ):
        note = f"volumetric_strain was computed from axial_strain and radial_strain, columns {axial[0].label} and {radial[0].label}."
        return Source(name, (axial[0], radial[0]), lambda values: values[axial[0].key] + 2 * values[radial[0].key], note)
    if name == "volumetric_strain" and (ratio := _void_ratio(table, conventions)):
        note = f"volumetric_strain was computed from {ratio.quantity}, column {ratio.label}, and counts from the first row that is read."
        return Source(name, (ratio,), lambda values: np.log((1 + (e := values[ratio.key])[0]) / (1 + e)) + 0.0, note)
    if name in WANTED and (stress := _stress(table, name, conventions, confining_pressure)):
        return stress
    raise missing_column(table, name, name)


def _void_ratio(table: Table, conventions: Conventions) -> Column | None:
    """The column that is named for a void ratio, a porosity or a specific volume; None where nothing was said."""
    return next((find_column(table, name, conventions) for name in VOID_RATIOS if name in conventions.columns), None)


def instead(name: str) -> tuple[str, ...]:
    """Other quantities that a wanted one is read from by itself."""
    if name == "void_ratio":
        return POROSITIES
    if name == EXTENSION:
        return ("axial_strain", "axial_displacement")
    if name == "deviatoric_stress":
        return ("deviator_stress",)
    return tuple(printed for printed, strain in COMPRESSED.items() if strain == name)


def _own(name: str, columns: list[Column]) -> Source:
    if len(columns) == 1:
        return Source(name, tuple(columns), lambda values: values[columns[0].key], "")
    headers = ", ".join(column.label for column in columns)
    return Source(name, tuple(columns), lambda values: np.sum([values[column.key] for column in columns], axis=0), f"{name} is the sum of columns {headers}.")


def _from(name: str, other: str, columns: list[Column]) -> Source:
    """A quantity that follows from a single other one, which `to_plain` has already made of it but for the sign of extension."""
    sign = -1.0 if name == EXTENSION else 1.0
    note = "" if name == "deviatoric_stress" else f"{name} was computed from {other}, column {columns[0].label}."
    return Source(name, tuple(columns), lambda values: sign * values[columns[0].key] + 0.0, note)


def _of(source: Source) -> str:
    return f", and was computed from {_listed(source.columns)}" if len(source.columns) > 1 else ""


def _listed(columns: tuple[Column, ...]) -> str:
    names = [column.quantity for column in columns]
    headers = " and ".join([", ".join(column.label for column in columns[:-1]), columns[-1].label]) if len(columns) > 1 else columns[0].label
    return f"{', '.join(names)}, column{'s' * (len(columns) > 1)} {headers}"


def _is_asked_of_stresses(name: str, conventions: Conventions) -> bool:
    return name in WANTED and name not in conventions.columns and any(stress in conventions.columns for stress in STRESS_FORMS)


def _stress(table: Table, name: str, conventions: Conventions, confining_pressure: float | None) -> Source | None:
    """A stress that follows from the columns that are named for stresses, or bear their names, and where these do not suffice from a constant lateral stress."""
    columns = stress_columns(table, conventions)
    for with_pressure in (False, True) if confining_pressure else (False,):
        forms = [STRESS_FORMS[column.quantity] for column in columns] + [STRESS_FORMS["lateral_stress"]] * with_pressure
        if (found := weights(WANTED[name], forms)) is not None:
            return _weighted(name, columns, found, confining_pressure if with_pressure else None)
    return None


def _weighted(name: str, columns: list[Column], found: NDArray[np.float64], confining_pressure: float | None) -> Source:
    used = [(column, weight) for column, weight in zip(columns, found) if abs(weight) > 1e-12]
    constant = found[-1] * confining_pressure if confining_pressure else 0.0

    def make(values: Values) -> NDArray[np.float64]:
        return sum((weight * values[column.key] for column, weight in used), np.full(len(next(iter(values.values()))), constant))

    kept = tuple(column for column, _ in used)
    at = f" at a confining pressure of {confining_pressure:g} Pa" if constant else ""
    return Source(name, kept, make, f"{name} was computed from {_listed(kept)}{at}." if kept else "", at_pressure=bool(constant))


def stress_columns(table: Table, conventions: Conventions) -> list[Column]:
    """The columns that are named for stresses; where none is, those that bear the exact names."""
    said = [name for name in STRESS_FORMS if name in conventions.columns]
    return [column for name in said or STRESS_FORMS if (column := find_column(table, name, conventions))]


def refuse_contradictions(table: Table, columns: Sequence[Column], values: Values) -> None:
    """Refuse stresses that are said twice and differ."""
    stresses = {column.quantity: values[column.key] for column in columns if column.quantity in STRESS_FORMS}
    if len(stresses) > 1 and (by := contradiction(stresses)) > LARGEST_CONTRADICTION:
        headers = ", ".join(column.label for column in columns if column.quantity in stresses)
        raise InputError(
            f"{table.path}: the stresses {', '.join(stresses)} of columns {headers} contradict one another by {100 * by:.2g} % of the largest, and stresses of one test were expected."
        )


def _stress_ratio(table: Table, conventions: Conventions, confining_pressure: float | None) -> Source:
    """σ1/σ3: its own column, or one measure of stress at a constant lateral stress, or the two stresses of each row."""
    names = ("stress_ratio", *STRESS_MEASURES)
    pairs = [name for name in STRESS_FORMS if name in conventions.columns]
    said = [measure for measure in names if measure in conventions.columns]
    if "stress_ratio" not in said and "deviator_to_mean_stress" not in said and len(pairs) > 1 or pairs and not said:
        return _two_stresses(table, conventions, confining_pressure)
    found = [column for measure in said or names if (column := find_column(table, measure, conventions)) is not None]
    if not found:
        raise missing_column(table, "stress_ratio (nor " + ", ".join(STRESS_MEASURES) + ")", "stress_ratio")
    if len(found) > 1 and (said or found[0].quantity != "stress_ratio"):
        headers = ", ".join(column.label for column in found)
        raise InputError(f"{table.path}: columns {headers} all give the stress ratio, name a single one in columns.")
    column = found[0]
    if column.quantity == "stress_ratio":
        return _own("stress_ratio", found[:1])
    measure = STRESS_MEASURES[column.quantity]
    if measure.needs_confining_pressure and find_column(table, "lateral_stress", conventions):
        return _two_stresses(table, replace_columns(conventions, {column.quantity, "lateral_stress"}), confining_pressure)
    at = f" at a confining pressure of {confining_pressure:g} Pa" if measure.needs_confining_pressure and confining_pressure else ""
    note = f"stress_ratio was computed from {column.quantity}, column {column.label}{at}."
    return Source("stress_ratio", (column,), lambda values: _measured_ratio(table, column, values[column.key], confining_pressure), note, at_pressure=bool(at))


def replace_columns(conventions: Conventions, names: set[str]) -> Conventions:
    """The conventions with columns of these names said to be what they are called."""
    return Conventions(
        {**{name: name for name in names}, **conventions.columns},
        conventions.units,
        conventions.strain,
        conventions.compression,
        conventions.volume,
        conventions.height,
    )


def _two_stresses(table: Table, conventions: Conventions, confining_pressure: float | None) -> Source:
    axial, lateral = (_stress(table, name, conventions, confining_pressure) for name in ("axial_stress", "lateral_stress"))
    columns = tuple(dict.fromkeys((*(axial.columns if axial else ()), *(lateral.columns if lateral else ()))))
    if axial is None or lateral is None or not columns:
        given = ", ".join(column.label for column in stress_columns(table, conventions))
        raise InputError(
            f"{table.path}: the stresses of columns {given} do not give both effective stresses, and two of axial_stress, lateral_stress, mean_stress and deviator_stress, "
            "or total ones with pore_pressure, or a confining_pressure in Pa, were expected."
        )

    def make(values: Values) -> NDArray[np.float64]:
        below = lateral.make(values)
        if np.min(below) <= 0:
            raise InputError(
                f"{table.path}: the effective lateral stress falls to {np.min(below):g} Pa, computed from {_listed(columns)}, and one above 0 was expected for a stress ratio."
            )
        ratio = axial.make(values) / below
        _refuse_too_large(table, columns[0], ratio, None)
        return ratio

    at = f" at a confining pressure of {confining_pressure:g} Pa" if confining_pressure and not lateral.columns else ""
    return Source(
        "stress_ratio",
        columns,
        make,
        f"stress_ratio was computed from {_listed(columns)}{at or ', row by row'}.",
        at_pressure=axial.at_pressure or lateral.at_pressure,
    )


def _measured_ratio(table: Table, column: Column, stress: NDArray[np.float64], confining_pressure: float | None) -> NDArray[np.float64]:
    measure, place = STRESS_MEASURES[column.quantity], f"{table.path}: column {column.label}"
    if measure.needs_confining_pressure:
        if confining_pressure is None:
            measured = column.quantity.replace("_", " ")
            raise InputError(f"{place} is a {measured}, and a confining_pressure in Pa was expected to make it a stress ratio.")
    elif np.max(stress) >= 3.0:
        raise InputError(f"{place} reaches a ratio q/p of {np.max(stress):g}, and less than 3 was expected, where the lateral stress vanishes.")
    # Where none is given, none is looked at.
    ratio = measure.ratio(stress, np.nan if confining_pressure is None else confining_pressure)
    _refuse_too_large(table, column, ratio, confining_pressure if measure.needs_confining_pressure else None)
    return ratio


def _refuse_too_large(table: Table, column: Column, ratio: NDArray[np.float64], confining_pressure: float | None) -> None:
    if np.max(ratio) > LARGEST_STRESS_RATIO:
        by = f" with confining_pressure = {confining_pressure:g} Pa" if confining_pressure else ""
        raise InputError(
            f"{table.path}: column {column.label} gives a stress ratio of {np.max(ratio):.3g}{by},"
            f" and less than {LARGEST_STRESS_RATIO:g} was expected: the pressure or the column must be in another unit."
        )
