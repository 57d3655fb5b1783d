"""Reading a laboratory file into SI units and fractions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graincal.errors import InputError
from graincal.laboratory.backbone import outrun, repeated, say_lines, spans, turned_back
from graincal.laboratory.columns import LARGEST_FRACTION, Column, Conventions, Key, Place, read_columns, refuse_mixed_units, to_plain
from graincal.laboratory.loading_path import rows_of_path, source_of, turns_of
from graincal.laboratory.quantities import DIMENSIONS, OBSERVABLES, SIGNED, STRAINS, STRESS_FORMS, STRESS_MEASURES, VOID_RATIOS
from graincal.laboratory.sources import EXTENSION, Source, instead, refuse_contradictions
from graincal.laboratory.stages import choose_rows
from graincal.laboratory.stresses import WANTED
from graincal.laboratory.table import Table, read_table
from graincal.laboratory.units import split_header
from graincal.laboratory.vocabulary import did_you_mean_observable
from graincal.positions import POSITION
from graincal.suggestion import did_you_mean


@dataclass(frozen=True, eq=False)
class Test:
    """What a laboratory file was read as: what a `graincal.Reference` is made of, whose words these are."""

    control: NDArray[np.float64]
    observables: Mapping[str, NDArray[np.float64]]
    variance_shares: Mapping[str, float] | None
    measurement_errors: Mapping[str, Any] | None
    control_name: str
    control_step: float
    simulated: bool
    recorded: Mapping[str, NDArray[np.float64]]
    read_as: tuple[str, ...]
    cut: bool
    at_pressure: tuple[str, ...]
    turned: tuple[str, ...]
    idle: tuple[str, ...]
    notes: tuple[str, ...]


def read_test(
    path: str | PathLike[str],
    control: str = "axial_strain",
    observables: Sequence[str] | Mapping[str, float] = ("stress_ratio", "volumetric_strain"),
    *,
    columns: Mapping[str, Place] | None = None,
    units: Mapping[str, str] | None = None,
    strain: str | Mapping[str, str] | None = None,
    compression: str | Mapping[str, str] = "positive",
    unloading: str | None = None,
    until: float | None = None,
    confining_pressure: float | None = None,
    turns: Sequence[float] | None = None,
    measurement_errors: Mapping[str, Any] | None = None,
    control_step: float | None = None,
    simulated: bool = False,
    stage: str | int | None = None,
    rows: Sequence[int] | None = None,
    zero: Sequence[str] = (),
    sample_volume: float | None = None,
    sample_height: float | None = None,
    sheet: str | int | None = None,
    encoding: str | None = None,
    recorded: Sequence[str] = (),
) -> Test:
    """Read a laboratory file: delimited text, a spreadsheet or AGS4 data, in the order of the test.

    The file's delimiter, decimal mark and encoding are found out; what its columns mean is not guessed. A quantity is read from the column that
    `columns` names for it, or else from the one whose header is exactly its name, with or without a unit: `axial_strain [%]`.

    control, observables
        What the reference compares on and what it compares. A mapping gives each observable's variance share. The control `axial_extension` is minus
        the axial strain; `position` is that along a path of loading and unloading: the sum of |Δ ln σ| of the axial stress, or the mean stress, from
        `confining_pressure` on. Rows without stress have no position and are left out.
    recorded
        Names of what is read in the same way and not fitted: see `Reference`.
    columns
        Quantity -> header, with or without the header's unit, or the group above it with it; or the column's number, from 1, or its letter; or, for a strain,
        a list of columns that are summed. Beside the names in `control` and `observables`, the stress ratio σ1/σ3 may be
        given as `deviator_stress` (q = σ1 - σ3), as the effective `axial_stress` (σ1), both with `confining_pressure`, or as
        `deviator_to_mean_stress` (q/p, triaxial compression). Two effective stresses of `axial_stress`, `lateral_stress`, `mean_stress` (Cambridge p),
        `half_sum_stress` and `half_difference_stress` (MIT s and t) and `deviator_stress`, or total ones (`total_axial_stress`, ...) with `pore_pressure`,
        give the stress ratio row by row, and `deviatoric_stress`, `mean_stress`, `lateral_stress`. `excess_pore_pressure` may be given as `pore_pressure`, less its
        first value; the void ratio as `porosity` or `specific_volume`; strains as `volume_change` or `axial_displacement` with the sample's volume or height.
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
        Pa; the constant lateral stress, or that from which a position counts. Used only to make a stress ratio of q or σ1, and positions.
    turns
        Pa; the stresses at which a path that a position counts along is said to turn around: another path in the file is refused. None for any.
    measurement_errors
        Observable -> `MeasurementError`, or its standard deviation, in the reference's own units: fractions, σ1/σ3, Pa.
    stage, rows, zero
        The stage of a machine's file, by its number or word, or the first and last line to be read; and the quantities that are counted from the first row that is read.
    sample_volume, sample_height
        m³ and m, of the sample when a change of volume or height is nothing.
    sheet, encoding
        The sheet of a spreadsheet, or the group of AGS4 data; how the text is encoded. Without them, they are found out.
    control_step, simulated
        The step to which the control was read, in its own unit; whether the file is a simulation's.

    Rows with an empty cell in a column that is read are dropped, and so are rows where the control stands still (the first of them
    is kept, or the last where it is a stress); the reference's `notes` say how many and which, what was left out beyond `until`, and what was converted. Raises InputError for everything else.
    """
    table = read_table(path, encoding=encoding, sheet=sheet)
    table, chosen = choose_rows(table, stage, rows)
    shares = _observables(table.path, control, observables, recorded)
    wanted = (control, *shares, *recorded)
    positive = {"confining_pressure": confining_pressure, "control_step": control_step, "until": until, "sample_volume": sample_volume, "sample_height": sample_height}
    for key, number in positive.items():
        _refuse_not_positive(table.path, key, {"": number})
    _refuse_wrong_errors(table.path, measurement_errors or {}, shares)

    conventions = Conventions(columns or {}, units or {}, strain, compression, sample_volume, sample_height)
    _refuse_another_name(table, wanted[1:], conventions)
    conventions.check_words(table.path, selectable(wanted))
    sources = {name: source_of(table, name, conventions, confining_pressure, turns) for name in wanted}
    found = list({column.key: column for source in sources.values() for column in source.columns}.values())
    conventions.check_names(table.path, [column.quantity for column in found])
    refuse_mixed_units(table, found)

    printed, complete = read_columns(table, found)
    lines = _chosen(table.lines, complete)
    plain = {column.key: to_plain(table, column, printed[column.key][complete], lines, conventions) for column in found}
    plain = _counted_from_the_first(table.path, zero, found, plain)
    refuse_contradictions(table, found, plain)
    _refuse_tension(table, sources.get("stress_ratio"), plain, control, conventions)
    values, plain, lines, notes = _values(sources, plain, lines, confining_pressure)
    _refuse_wrong_way(table, sources[control].columns[0], values[control], conventions, control)
    compared, cut = _until(table, control, values[control], lines, until)
    backbone, dropped = _backbone(table, control, values[control][compared], lines[compared], unloading)
    return Test(
        values[control][compared][backbone],
        {name: values[name][compared][backbone] for name in shares},
        None if None in shares.values() else shares,
        measurement_errors,
        control_name=control,
        control_step=control_step or 0.0,
        simulated=simulated,
        recorded={name: values[name][compared][backbone] for name in recorded},
        read_as=tuple(dict.fromkeys(column.quantity for column in found)),
        cut=compared.stop is not None,
        at_pressure=tuple(name for name, source in sources.items() if source.at_pressure),
        turned=tuple(dict.fromkeys(column.quantity for column in found if conventions.is_reversed(column.quantity))),
        idle=tuple(cut) if compared.stop is None else (),
        notes=(
            *chosen,
            *_gaps(table, found, printed, complete),
            *notes,
            *cut,
            *dropped,
            *_conversions(sources, found, conventions),
            *_open_measures({column.quantity: plain[column.key][compared] for column in found}, conventions),
        ),
    )


def selectable(wanted: Sequence[str]) -> tuple[str, ...]:
    """The quantities whose columns may be named: what is wanted, and what some of it may be computed from."""
    from_stresses = {"stress_ratio", POSITION, *WANTED, "excess_pore_pressure"} & set(wanted)
    others = [other for name in wanted for other in instead(name)] + ["radial_strain", *VOID_RATIOS] * ("volumetric_strain" in wanted)
    ratios = list(STRESS_MEASURES) if "stress_ratio" in wanted else []
    return tuple(dict.fromkeys((*wanted, *ratios, *others, *(STRESS_FORMS if from_stresses else ()))))


def _counted_from_the_first(
    path: str, zero: Sequence[str], found: Sequence[Column], plain: Mapping[Key, NDArray[np.float64]]
) -> dict[Key, NDArray[np.float64]]:
    """The values (T,) by column, those of the quantities in `zero` less their first: logarithmic strains of the sample as it is in the first row."""
    names = [column.quantity for column in found]
    for name in zero:
        if name not in names or name in STRESS_FORMS:
            raise InputError(f"{path}: zero names '{name}'{did_you_mean(name, names)}, and some of {', '.join(name for name in names if name not in STRESS_FORMS)} were expected.")
    return {column.key: plain[column.key] - plain[column.key][0] * (column.quantity in zero) for column in found}


def _observables(path: str, control: str, observables: Sequence[str] | Mapping[str, float], recorded: Sequence[str]) -> dict[str, float | None]:
    if isinstance(observables, str) or not observables:
        raise InputError(f"{path}: observables must list at least one name, such as stress_ratio, and is {observables!r}.")
    shares = dict(observables) if isinstance(observables, Mapping) else dict.fromkeys(observables)
    if isinstance(recorded, str):
        raise InputError(f"{path}: recorded must list names, such as volumetric_strain, and is {recorded!r}.")
    if control in (*shares, *recorded):
        raise InputError(f"{path}: {control} is the control, and the observables must be other quantities.")
    if twice := [name for name in recorded if name in shares]:
        raise InputError(f"{path}: {twice[0]} is an observable, which is fitted, and cannot be recorded without being fitted too.")
    _refuse_not_positive(path, "observables (variance shares)", shares)
    return shares


def _values(
    sources: Mapping[str, Source], plain: Mapping[Key, NDArray[np.float64]], lines: list[int], confining_pressure: float | None
) -> tuple[dict[str, NDArray[np.float64]], Mapping[Key, NDArray[np.float64]], list[int], list[str]]:
    """The wanted quantities (T,) by name, the plain values and the lines of their rows, and what to say of the rows that a path of loading leaves out."""
    path = sources.get(POSITION)
    if path is None:
        return {name: source.make(plain) for name, source in sources.items()}, plain, lines, []
    begun, loaded, before = rows_of_path(path, plain, confining_pressure)
    since_begun, kept = {key: column[begun] for key, column in plain.items()}, loaded[begun]
    # The path goes through rows without stress, which then are left out.
    values = {name: source.make(since_begun)[kept] for name, source in sources.items()}
    notes = [*_unloaded(lines, loaded), *before]
    return values, {key: column[kept] for key, column in since_begun.items()}, _chosen(lines, begun & loaded), notes


def _refuse_wrong_errors(path: str, errors: Mapping[str, Any], observables: Mapping[str, float | None]) -> None:
    _refuse_not_positive(path, "measurement_errors", {name: error for name, error in errors.items() if isinstance(error, Real)})
    if unknown := set(errors) - set(observables):
        raise InputError(f"{path}: measurement_errors names '{min(unknown)}', and one of the observables {', '.join(observables)} was expected.")


def _refuse_another_name(table: Table, observables: Sequence[str], conventions: Conventions) -> None:
    """Refuse an observable that is another name of a known one, where no column is its own: one that is named for it, or that bears the name while none is
    named for a stress that it may mean."""
    columns = conventions.columns if isinstance(conventions.columns, Mapping) else {}
    measured = [name for name in columns if name in STRESS_MEASURES and name not in observables] if "stress_ratio" not in observables else []
    for name in observables:
        borne = any(name in (header, split_header(header)[0]) for header in table.header)
        if name in DIMENSIONS or name in WANTED or name in columns or (borne and not measured):
            continue
        if meant := did_you_mean_observable(name, OBSERVABLES):
            raise InputError(
                f"{table.path}: '{name}' is not an observable{meant}, and {', '.join(OBSERVABLES)} or another with a column of its name, or one in columns, was expected."
            )


def _refuse_not_positive(path: str, key: str, numbers: Mapping[str, float | None]) -> None:
    for name, number in numbers.items():
        if number is not None and (isinstance(number, bool) or not isinstance(number, Real) or not 0 < number < np.inf):
            raise InputError(f"{path}: {key}{' of ' + name if name else ''} must be a positive number, not {number!r}.")


def _refuse_tension(table: Table, source: Source | None, plain: Mapping[Key, NDArray[np.float64]], control: str, conventions: Conventions) -> None:
    """Refuse a stress that is mostly negative while the sample is compressed: its sign is turned."""
    for column in source.columns if source and control == "axial_strain" else ():
        if column.quantity in STRESS_MEASURES and np.median(plain[column.key]) < 0:
            turned = conventions.is_reversed(column.quantity)
            way = "its sign was turned, as compression says; if that is wrong" if turned else "if that is its sign convention"
            word = "positive" if turned else "negative"
            raise InputError(f'{table.path}: column {column.label} is mostly negative in compression, {way} write compression = {{ {column.quantity} = "{word}" }}.')


def _refuse_wrong_way(table: Table, column: Column, control: NDArray[np.float64], conventions: Conventions, control_name: str) -> None:
    """Refuse a control of the wrong sign, and rows in reverse: neither is unloading."""
    if control_name == EXTENSION and np.max(control) < -np.min(control):
        raise InputError(f"{table.path}: axial_extension goes down to {np.min(control):g}, and was expected to increase: the sample is shortened in this file, or the sign of column {column.label} is turned.")
    if control_name != column.quantity:
        return
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


def _gaps(table: Table, found: Sequence[Column], printed: Mapping[Key, NDArray[np.float64]], complete: NDArray[np.bool_]) -> list[str]:
    if np.all(complete):
        return []
    where = [column.quantity for column in found if np.any(np.isnan(printed[column.key]))]
    return [f"{_rows(~complete)} dropped for an empty cell, in {', '.join(where)}: {say_lines(spans(~complete, table.lines))}."]


def _unloaded(lines: list[int], loaded: NDArray[np.bool_]) -> list[str]:
    if np.all(loaded):
        return []
    return [f"{_rows(~loaded)} dropped where the stress is 0, which has no position: {say_lines(spans(~loaded, lines))}."]


def _chosen(lines: list[int], kept: NDArray[np.bool_]) -> list[int]:
    return [line for line, keep in zip(lines, kept, strict=True) if keep]


def _conversions(sources: Mapping[str, Source], found: Sequence[Column], conventions: Conventions) -> list[str]:
    notes = []
    for column in {column.quantity: column for column in found}.values():
        if conventions.is_engineering(column.quantity):
            notes.append(f"{column.quantity} is given as engineering strain and was converted to logarithmic strain.")
        if conventions.is_reversed(column.quantity):
            notes.append(f"{column.quantity} is given with compression negative, and its sign was changed.")
    return notes + [source.note for source in sources.values() if source.note]


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
