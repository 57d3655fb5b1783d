"""What is refused of a file that is read as a test: options of it that cannot be, and values that contradict them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graincal.errors import InputError
from graincal.laboratory.columns import Column, Conventions, Key
from graincal.laboratory.quantities import DIMENSIONS, OBSERVABLES, SIGNED, STRAINS, STRESS_MEASURES
from graincal.laboratory.sources import EXTENSION, Source
from graincal.laboratory.stresses import WANTED
from graincal.laboratory.table import Table
from graincal.laboratory.units import split_header
from graincal.laboratory.vocabulary import did_you_mean_observable


def refuse_wrong_errors(path: str, errors: Mapping[str, Any], observables: Mapping[str, float | None]) -> None:
    deviations: dict[str, Any] = {name: error for name, error in errors.items() if isinstance(error, Real)}
    refuse_not_positive(path, "measurement_errors", deviations)
    if unknown := set(errors) - set(observables):
        raise InputError(f"{path}: measurement_errors names '{min(unknown)}', and one of the observables {', '.join(observables)} was expected.")


def refuse_another_name(table: Table, observables: Sequence[str], conventions: Conventions) -> None:
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


def refuse_not_positive(path: str, key: str, numbers: Mapping[str, float | None]) -> None:
    for name, number in numbers.items():
        if number is not None and (isinstance(number, bool) or not isinstance(number, Real) or not 0 < number < np.inf):
            raise InputError(f"{path}: {key}{' of ' + name if name else ''} must be a positive number, not {number!r}.")


def refuse_tension(table: Table, source: Source | None, plain: Mapping[Key, NDArray[np.float64]], control: str, conventions: Conventions) -> None:
    """Refuse a stress that is mostly negative while the sample is compressed: its sign is turned."""
    for column in source.columns if source and control == "axial_strain" else ():
        if column.quantity in STRESS_MEASURES and np.median(plain[column.key]) < 0:
            turned = conventions.is_reversed(column.quantity)
            way = "its sign was turned, as compression says; if that is wrong" if turned else "if that is its sign convention"
            word = "positive" if turned else "negative"
            raise InputError(
                f'{table.path}: column {column.label} is mostly negative in compression, {way} write compression = {{ {column.quantity} = "{word}" }}.'
            )


def refuse_wrong_way(table: Table, column: Column, control: NDArray[np.float64], conventions: Conventions, control_name: str) -> None:
    """Refuse a control of the wrong sign, and rows in reverse: neither is unloading."""
    if control_name == EXTENSION and np.max(control) < -np.min(control):
        raise InputError(
            f"{table.path}: axial_extension goes down to {np.min(control):g}, and was expected to increase: the sample is shortened in this file, or the sign of column {column.label} is turned."
        )
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
        raise InputError(
            f"{table.path}: {name} comes back from {control[0]:g} to {end:g}, and was expected to grow from the beginning of the test: {sign} and reverse the rows."
        )
    if negative and not rises:
        raise InputError(
            f"{table.path}: {name} goes down to {np.min(control):g}, and was expected to increase: if its sign is the other way round in this file, {sign}."
        )
    if falls:
        raise InputError(
            f"{table.path}: {name} falls throughout, from {control[0]:g} to {end:g}, and was expected to increase:"
            " the rows seem to stand in reverse, so put them in the order of the test."
        )
