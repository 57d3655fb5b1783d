"""Reading a laboratory file into SI units and fractions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graincal.errors import InputError
from graincal.laboratory.columns import Column, Conventions, Key, Place, read_columns, refuse_mixed_units, to_plain
from graincal.laboratory.kept_rows import backbone_of, chosen_lines, said_of_gaps, said_of_unloaded, up_to
from graincal.laboratory.loading_path import PathSource, rows_of_path, source_of
from graincal.laboratory.quantities import STRESS_FORMS, STRESS_MEASURES, VOID_RATIOS
from graincal.laboratory.refusals import refuse_another_name, refuse_not_positive, refuse_tension, refuse_wrong_errors, refuse_wrong_way
from graincal.laboratory.sources import Source, instead, refuse_contradictions
from graincal.laboratory.stages import choose_rows
from graincal.laboratory.stresses import WANTED
from graincal.laboratory.table import Table, read_table
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
    _refuse_wrong_numbers(
        table.path,
        shares,
        measurement_errors or {},
        confining_pressure=confining_pressure,
        control_step=control_step,
        until=until,
        sample_volume=sample_volume,
        sample_height=sample_height,
    )

    conventions = Conventions(columns or {}, units or {}, strain, compression, sample_volume, sample_height)
    refuse_another_name(table, wanted[1:], conventions)
    conventions.check_words(table.path, selectable(wanted))
    sources, found = _columns(table, wanted, conventions, confining_pressure, turns)
    values, plain, lines, notes = _rows_read(table, sources, found, conventions, zero, confining_pressure, control)
    refuse_wrong_way(table, sources[control].columns[0], values[control], conventions, control)
    compared, cut = up_to(table, control, values[control], lines, until)
    backbone, dropped = backbone_of(table, control, values[control][compared], lines[compared], unloading)
    given = {name: share for name, share in shares.items() if share is not None}
    return Test(
        values[control][compared][backbone],
        {name: values[name][compared][backbone] for name in shares},
        given if len(given) == len(shares) else None,
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
            *notes,
            *cut,
            *dropped,
            *_conversions(sources, found, conventions),
            *_open_measures({column.quantity: plain[column.key][compared] for column in found}, conventions),
        ),
    )


def _refuse_wrong_numbers(path: str, shares: Mapping[str, float | None], measurement_errors: Mapping[str, Any], **numbers: float | None) -> None:
    for key, number in numbers.items():
        refuse_not_positive(path, key, {"": number})
    refuse_wrong_errors(path, measurement_errors, shares)


def _columns(
    table: Table, wanted: Sequence[str], conventions: Conventions, confining_pressure: float | None, turns: Sequence[float] | None
) -> tuple[dict[str, Source], list[Column]]:
    """What each wanted quantity is made of, and all columns that are read for that."""
    sources = {name: source_of(table, name, conventions, confining_pressure, turns) for name in wanted}
    found = list({column.key: column for source in sources.values() for column in source.columns}.values())
    conventions.check_names(table.path, [column.quantity for column in found])
    refuse_mixed_units(table, found)
    return sources, found


def _rows_read(
    table: Table,
    sources: Mapping[str, Source],
    found: Sequence[Column],
    conventions: Conventions,
    zero: Sequence[str],
    confining_pressure: float | None,
    control: str,
) -> tuple[dict[str, NDArray[np.float64]], Mapping[Key, NDArray[np.float64]], list[int], list[str]]:
    """As `_values`, of the rows without a gap; the notes say of the others too."""
    printed, complete = read_columns(table, found)
    lines = chosen_lines(table.lines, complete)
    plain = {column.key: to_plain(table, column, printed[column.key][complete], lines, conventions) for column in found}
    plain = _counted_from_the_first(table.path, zero, found, plain)
    refuse_contradictions(table, found, plain)
    refuse_tension(table, sources.get("stress_ratio"), plain, control, conventions)
    values, plain_read, lines_read, notes = _values(sources, plain, lines)
    return values, plain_read, lines_read, [*said_of_gaps(table, found, printed, complete), *notes]


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
            raise InputError(
                f"{path}: zero names '{name}'{did_you_mean(name, names)}, and some of {', '.join(name for name in names if name not in STRESS_FORMS)} were expected."
            )
    return {column.key: plain[column.key] - plain[column.key][0] * (column.quantity in zero) for column in found}


def _observables(path: str, control: str, observables: Sequence[str] | Mapping[str, float], recorded: Sequence[str]) -> dict[str, float | None]:
    if isinstance(observables, str) or not observables:
        raise InputError(f"{path}: observables must list at least one name, such as stress_ratio, and is {observables!r}.")
    shares: dict[str, float | None] = dict(observables) if isinstance(observables, Mapping) else dict.fromkeys(observables)
    if isinstance(recorded, str):
        raise InputError(f"{path}: recorded must list names, such as volumetric_strain, and is {recorded!r}.")
    if control in (*shares, *recorded):
        raise InputError(f"{path}: {control} is the control, and the observables must be other quantities.")
    if twice := [name for name in recorded if name in shares]:
        raise InputError(f"{path}: {twice[0]} is an observable, which is fitted, and cannot be recorded without being fitted too.")
    refuse_not_positive(path, "observables (variance shares)", shares)
    return shares


def _values(
    sources: Mapping[str, Source], plain: Mapping[Key, NDArray[np.float64]], lines: list[int]
) -> tuple[dict[str, NDArray[np.float64]], Mapping[Key, NDArray[np.float64]], list[int], list[str]]:
    """The wanted quantities (T,) by name, the plain values and the lines of their rows, and what to say of the rows that a path of loading leaves out."""
    path = sources.get(POSITION)
    if not isinstance(path, PathSource):
        return {name: source.make(plain) for name, source in sources.items()}, plain, lines, []
    begun, loaded, before = rows_of_path(path, plain)
    since_begun, kept = {key: column[begun] for key, column in plain.items()}, loaded[begun]
    # The path goes through rows without stress, which then are left out.
    values = {name: source.make(since_begun)[kept] for name, source in sources.items()}
    notes = [*said_of_unloaded(lines, loaded), *before]
    return values, {key: column[kept] for key, column in since_begun.items()}, chosen_lines(lines, begun & loaded), notes


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
