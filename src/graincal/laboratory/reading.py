"""Reading a laboratory file into a reference."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Real
from os import PathLike

import numpy as np
from numpy.typing import NDArray

from graincal.data import InputError, MeasurementError, Reference
from graincal.laboratory.backbone import repeated, say_lines, spans, turned_back
from graincal.laboratory.columns import LARGEST_FRACTION, Column, Conventions, find_column, missing_column, read_columns, refuse_mixed_units, to_plain
from graincal.laboratory.quantities import DIMENSIONS, LARGEST_STRESS_RATIO, OBSERVABLES, SIGNED, STRAINS, STRESS_MEASURES, did_you_mean_observable
from graincal.laboratory.table import Table, read_table
from graincal.laboratory.units import split_header


def read_reference(
    path: str | PathLike[str],
    control: str = "axial_strain",
    observables: Sequence[str] | Mapping[str, float] = ("stress_ratio", "volumetric_strain"),
    *,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    strain: str | Mapping[str, str] | None = None,
    compression: str | Mapping[str, str] = "positive",
    unloading: str | None = None,
    until: float | None = None,
    confining_pressure: float | None = None,
    measurement_errors: Mapping[str, MeasurementError | float] | None = None,
    control_step: float | None = None,
    simulated: bool = False,
) -> Reference:
    """Read a laboratory file: delimited text with a header, in the order of the test.

    The file's delimiter, decimal mark and encoding are found out; what its columns mean is not guessed. A quantity is read from the column that
    `columns` names for it, or else from the one whose header is exactly its name, with or without a unit: `axial_strain [%]`.

    control, observables
        What the reference compares on and what it compares. A mapping gives each observable's variance share.
    columns
        Quantity -> header, with or without the header's unit. Beside the names in `control` and `observables`, the stress ratio σ1/σ3 may be
        given as `deviator_stress` (q = σ1 - σ3), as the effective `axial_stress` (σ1), both with `confining_pressure`, or as
        `deviator_to_mean_stress` (q/p, triaxial compression).
    units
        Quantity -> unit, where the header has none or a wrong one. Without any, a strain or ratio is a fraction; a stress must have one.
    strain, compression
        "logarithmic" or "engineering"; "positive" or "negative"; one word for all strains (and stresses), or quantity -> word.
        An engineering strain becomes -ln(1 - e), the volumetric one too. Strains of which nothing is said are taken as logarithmic, with a note.
    unloading
        "drop" keeps, of unload-reload loops, the backbone: rows whose control exceeds every earlier one. None refuses loops.
    until
        The last control that is compared, above 0, as the reference has it: a logarithmic strain, positive in compression, or Pa. The test ends for graincal
        where the control first exceeds it, as where a shear band has formed; what follows, unloading too, is left out. None keeps all.
    confining_pressure
        Pa; the constant lateral stress. Used only to make a stress ratio of q or σ1.
    measurement_errors
        Observable -> `MeasurementError`, or its standard deviation, in the reference's own units: fractions, σ1/σ3, Pa.
    control_step, simulated
        The step to which the control was read, in its own unit; whether the file is a simulation's.

    Rows with an empty cell in a column that is read are dropped, and so are rows where the control stands still (the first of them
    is kept); the reference's `notes` say how many and which, what was left out beyond `until`, and what was converted. Raises InputError for everything else.
    """
    table = read_table(path)
    shares = _observables(table.path, control, observables)
    wanted = (control, *shares)
    _refuse_not_positive(table.path, "confining_pressure", {"": confining_pressure})
    plain_errors = {name: error for name, error in (measurement_errors or {}).items() if not isinstance(error, MeasurementError)}
    _refuse_not_positive(table.path, "measurement_errors", plain_errors)
    _refuse_not_positive(table.path, "control_step", {"": control_step})
    _refuse_not_positive(table.path, "until", {"": until})
    if unknown := set(measurement_errors or {}) - set(shares):
        raise InputError(f"{table.path}: measurement_errors names '{min(unknown)}', and one of the observables {', '.join(shares)} was expected.")

    conventions = Conventions(columns or {}, units or {}, strain, compression)
    _refuse_another_name(table, shares, conventions)
    conventions.check_words(table.path, (*wanted, *(STRESS_MEASURES if "stress_ratio" in wanted else ())))
    sources = {name: _source(table, name, conventions) for name in wanted}
    found = list(sources.values())
    conventions.check_names(table.path, [column.quantity for column in found])
    refuse_mixed_units(table, found)

    printed, complete = read_columns(table, found)
    lines = [line for line, kept in zip(table.lines, complete, strict=True) if kept]
    plain = {column.quantity: to_plain(table, column, printed[column.quantity][complete], lines, conventions) for column in found}
    values = {
        name: plain[name] if column.quantity == name else _stress_ratio(table, column, plain[column.quantity], control, confining_pressure)
        for name, column in sources.items()
    }
    _refuse_wrong_way(table, sources[control], values[control], conventions)
    compared, cut = _until(table, control, values[control], lines, until)
    backbone, dropped = _backbone(table, control, values[control][compared], lines[compared], unloading)
    return Reference(
        values[control][compared][backbone],
        {name: values[name][compared][backbone] for name in shares},
        None if None in shares.values() else shares,
        measurement_errors,
        control_name=control,
        control_step=control_step or 0.0,
        simulated=simulated,
        notes=(
            *_gaps(table, printed, complete),
            *cut,
            *dropped,
            *_conversions(sources, conventions, confining_pressure),
            *_open_measures({quantity: column[compared] for quantity, column in plain.items()}, conventions),
        ),
    )


def _observables(path: str, control: str, observables: Sequence[str] | Mapping[str, float]) -> dict[str, float | None]:
    if isinstance(observables, str) or not observables:
        raise InputError(f"{path}: observables must list at least one name, such as stress_ratio, and is {observables!r}.")
    shares = dict(observables) if isinstance(observables, Mapping) else dict.fromkeys(observables)
    if control in shares:
        raise InputError(f"{path}: {control} is the control, and the observables must be other quantities.")
    _refuse_not_positive(path, "observables (variance shares)", shares)
    return shares


def _refuse_another_name(table: Table, observables: Mapping[str, float | None], conventions: Conventions) -> None:
    """Refuse an observable that is another name of a known one, where no column is its own: one that is named for it, or that bears the name while none is
    named for a stress that it may mean."""
    columns = conventions.columns if isinstance(conventions.columns, Mapping) else {}
    measured = [name for name in columns if name in STRESS_MEASURES and name not in observables] if "stress_ratio" not in observables else []
    for name in observables:
        borne = any(name in (header, split_header(header)[0]) for header in table.header)
        if name in DIMENSIONS or name in columns or (borne and not measured):
            continue
        if meant := did_you_mean_observable(name, OBSERVABLES):
            raise InputError(
                f"{table.path}: '{name}' is not an observable{meant}, and {', '.join(OBSERVABLES)} or another with a column of its name, or one in columns, was expected."
            )


def _refuse_not_positive(path: str, key: str, numbers: Mapping[str, float | None]) -> None:
    for name, number in numbers.items():
        if number is not None and (isinstance(number, bool) or not isinstance(number, Real) or not 0 < number < np.inf):
            raise InputError(f"{path}: {key}{' of ' + name if name else ''} must be a positive number, not {number!r}.")


def _source(table: Table, name: str, conventions: Conventions) -> Column:
    """The column that a wanted quantity comes from: its own, or for the stress ratio the one measure of stress that is there."""
    if name != "stress_ratio":
        column = find_column(table, name, conventions)
        if column is None:
            raise missing_column(table, name, name)
        return column
    names = ("stress_ratio", *STRESS_MEASURES)
    said = [measure for measure in names if measure in conventions.columns]
    found = [column for measure in said or names if (column := find_column(table, measure, conventions)) is not None]
    if not found:
        raise missing_column(table, "stress_ratio (nor " + ", ".join(STRESS_MEASURES) + ")", name)
    if len(found) > 1 and (said or found[0].quantity != "stress_ratio"):
        headers = ", ".join(f"'{column.header}'" for column in found)
        raise InputError(f"{table.path}: columns {headers} all give the stress ratio, name a single one in columns.")
    return found[0]


def _stress_ratio(
    table: Table, column: Column, stress: NDArray[np.float64], control: str, confining_pressure: float | None
) -> NDArray[np.float64]:
    measure = STRESS_MEASURES[column.quantity]
    place = f"{table.path}: column '{column.header}'"
    if measure.needs_confining_pressure:
        if confining_pressure is None:
            measured = column.quantity.replace("_", " ")
            raise InputError(f"{place} is a {measured}, and a confining_pressure in Pa was expected to make it a stress ratio.")
    elif np.max(stress) >= 3.0:
        raise InputError(f"{place} reaches a ratio q/p of {np.max(stress):g}, and less than 3 was expected, where the lateral stress vanishes.")
    if control == "axial_strain" and np.median(stress) < 0:
        raise InputError(
            f"{place} is mostly negative in compression, if that is its sign convention write compression = {{ {column.quantity} = \"negative\" }}."
        )
    ratio = measure.ratio(stress, confining_pressure)
    if measure.needs_confining_pressure and np.max(ratio) > LARGEST_STRESS_RATIO:
        raise InputError(
            f"{place} gives a stress ratio of {np.max(ratio):.3g} with confining_pressure = {confining_pressure:g} Pa,"
            f" and less than {LARGEST_STRESS_RATIO:g} was expected: the pressure or the column must be in another unit."
        )
    return ratio


def _refuse_wrong_way(table: Table, column: Column, control: NDArray[np.float64], conventions: Conventions) -> None:
    """Refuse a control of the wrong sign, and rows in reverse: neither is unloading."""
    name, end = column.quantity, float(control[-1])
    falls = len(control) > 1 and np.all(np.diff(control) <= 0) and end < control[0]
    rises = len(control) > 1 and np.all(np.diff(control) >= 0) and end > control[0]
    negative = -np.min(control) > np.max(control)
    if conventions.is_reversed(name):
        sign = f'leave {name} out of compression = "negative", which is said of it,'
    else:
        sign = 'write compression = "negative"' if name in SIGNED else f'write compression = {{ {name} = "negative" }}'
    if negative and rises and control[0] == np.min(control) and end <= 0 and name in STRAINS:
        raise InputError(f"{table.path}: {name} comes back from {control[0]:g} to {end:g}, and was expected to grow from the beginning of the test: {sign} and reverse the rows.")
    if negative and not rises:
        raise InputError(f"{table.path}: {name} goes down to {np.min(control):g}, and was expected to increase: if its sign is the other way round in this file, {sign}.")
    if falls:
        raise InputError(
            f"{table.path}: {name} falls throughout, from {control[0]:g} to {end:g}, and was expected to increase:"
            " the rows seem to stand in reverse, so put them in the order of the test."
        )


def _until(table: Table, name: str, control: NDArray[np.float64], lines: list[int], until: float | None) -> tuple[slice, list[str]]:
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


def _backbone(
    table: Table, name: str, control: NDArray[np.float64], lines: list[int], unloading: str | None
) -> tuple[NDArray[np.bool_], list[str]]:
    """The rows to keep (T,), and what to say of the others."""
    if unloading not in (None, "drop"):
        raise InputError(f"{table.path}: unloading must be \"drop\" or left out, not {unloading!r}.")
    back, still = turned_back(control), repeated(control)
    if np.any(back) and unloading is None:
        raise InputError(
            f"{table.path}: {name} turns back at {say_lines(spans(back, lines))}, where it was expected to increase:"
            ' unloading = "drop" leaves unload-reload loops out.'
        )
    notes = []
    if np.any(back):
        notes.append(f"{_rows(back)} dropped where {name} turned back: {say_lines(spans(back, lines))}.")
    if np.any(still):
        notes.append(f"{_rows(still)} dropped where {name} stood still: {say_lines(spans(still, lines))}.")
    return ~(back | still), notes


def _gaps(table: Table, printed: Mapping[str, NDArray[np.float64]], complete: NDArray[np.bool_]) -> list[str]:
    if np.all(complete):
        return []
    where = [quantity for quantity, numbers in printed.items() if np.any(np.isnan(numbers))]
    return [f"{_rows(~complete)} dropped for an empty cell, in {', '.join(where)}: {say_lines(spans(~complete, table.lines))}."]


def _conversions(sources: Mapping[str, Column], conventions: Conventions, confining_pressure: float | None) -> list[str]:
    notes = []
    for name, column in sources.items():
        if conventions.is_engineering(column.quantity):
            notes.append(f"{column.quantity} is given as engineering strain and was converted to logarithmic strain.")
        if conventions.is_reversed(column.quantity):
            notes.append(sign_change(column.quantity))
        if column.quantity != name:
            at = f" at a confining pressure of {confining_pressure:g} Pa" if STRESS_MEASURES[column.quantity].needs_confining_pressure else ""
            notes.append(f"{name} was computed from {column.quantity}, column '{column.header}'{at}.")
    return notes


def sign_change(quantity: str) -> str:
    """The note on a quantity whose sign was turned."""
    return f"{quantity} is given with compression negative, and its sign was changed."


def _open_measures(plain: Mapping[str, NDArray[np.float64]], conventions: Conventions) -> list[str]:
    """That a strain is taken as logarithmic because nothing is said of it, and what the other measure would make of it."""
    opened = [quantity for quantity in plain if conventions.leaves_measure_open(quantity)]
    if not opened:
        return []
    changes = []
    for quantity in opened:
        extreme = float(max(plain[quantity], key=abs))
        if extreme < 1:
            changes.append(f"{quantity} {extreme:.4g} would be {-np.log1p(-extreme):.4g}")
    words = " and ".join(opened) + (" is" if len(opened) == 1 else " are")
    instead = f' With strain = "engineering", {" and ".join(changes)}.' if changes else ""
    return [f"{words} taken as logarithmic, since the key strain does not say.{instead}"]


def _rows(chosen: NDArray[np.bool_]) -> str:
    count = int(np.sum(chosen))
    return f"{count} row{'s' if count > 1 else ''}"
