"""Which quantities of a file are compared, on which control, and from which columns they are read."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from graincal.errors import InputError
from graincal.laboratory.backbone import through_zero
from graincal.laboratory.loading_path import since, turns_of
from graincal.laboratory.quantities import STRESS_FORMS
from graincal.laboratory.stresses import weights
from graincal.laboratory.understanding.case import IN_WORDS, Case, NotUnderstood
from graincal.laboratory.understanding.seen import Seen

HELD = 0.01
"""A lateral stress within this part of its first value is constant, and the stress ratio is taken at that value; else it is taken row by row."""
MOST_TURNS = 50
"""A path that turns around more often is of noise, or of cycles that no calibration follows."""
Columns = dict[str, Seen | tuple[Seen, ...]]
_DIRECT = (
    "deviator_stress", "axial_stress", "lateral_stress", "half_difference_stress", "mean_stress", "half_sum_stress",
    "total_axial_stress", "total_lateral_stress", "total_mean_stress", "total_half_sum_stress", "pore_pressure",
)  # fmt: skip
"""Stresses, those that others are read from by preference first."""


def observables_of(case: Case) -> tuple[str, tuple[str, ...]]:
    """The control and the observables of the kind of test. Raises NotUnderstood where the file has nothing to compare."""
    if case.kind in ("oedometric", "isotropic"):
        return _compressed(case)
    control, observables = _sheared(case)
    if not observables:
        stresses = ", ".join(column.label for column in case.columns if column.quantity in STRESS_FORMS)
        raise NotUnderstood(
            f"{case.table.path}: the stresses of columns {stresses or '(none)'} give neither the deviator stress nor the pore pressure, and one of them was expected of {IN_WORDS[case.kind]}: --column deviator_stress=COLUMN:UNIT and so on say which is which."
        )
    return control, observables


def _sheared(case: Case) -> tuple[str, tuple[str, ...]]:
    """Of a test in which the sample is sheared."""
    control = "axial_extension" if case.extension else "axial_strain"
    if case.kind == "undrained":
        second = ("excess_pore_pressure",) if _excess(case) else ()
        stress = ("deviatoric_stress",) if _of_stresses(case, "deviator_stress") else ("stress_ratio",) if case.column("stress_ratio") else ()
        return control, (*stress, *second)
    stress = ("stress_ratio",) if _ratio(case) else ()
    if case.kind == "constant-mean-stress" and stress and not _has_both(case) and case.state is not None:
        # A deviator stress alone is none of a ratio where the lateral stress falls.
        stress = ("deviatoric_stress",) if _of_stresses(case, "deviator_stress") else ()
    has_volume = case.summed or any(case.column(name) for name in ("volumetric_strain", "volume_change", "radial_strain"))
    volume = ("volumetric_strain",) if has_volume else ("void_ratio",) if case.void_ratio else ()
    return control, (*stress, *volume)


def _compressed(case: Case) -> tuple[str, tuple[str, ...]]:
    """Of an oedometer or an isotropic test: a position where the stress turns around, else the stress itself."""
    driver = "axial_stress" if case.kind == "oedometric" else "mean_stress"
    stress = driving_stress(case)
    start = case.known.confining_pressure or float(stress[0])
    turns = turns_of(stress[since(stress, start)], start)
    if len(turns) > MOST_TURNS:
        raise InputError(
            f"{case.table.path}: the {driver.replace('_', ' ')} turns around {len(turns)} times, and a loading with a few cycles was expected: --rows FIRST-LAST chooses a part of it, or its noise has to be smoothed."
        )
    control = "position" if turns else driver
    compared = "void_ratio" if case.void_ratio else "volumetric_strain" if case.column("volumetric_strain") else "axial_strain"
    return control, (compared,)


def driving_stress(case: Case) -> np.ndarray:
    """The axial or mean stress (T,) of a compression test from its first above 0 on, Pa."""
    state = case.state
    stress = None if state is None else state.mean if case.kind == "isotropic" and state.mean is not None else state.axial
    if stress is None:
        column = case.column("mean_stress") or case.column("lateral_stress") or case.column("axial_stress")
        stress = np.abs(column.plain) if column is not None else np.empty(0)
    stress = through_zero(stress[~np.isnan(stress)])
    if not np.any(stress > 0):
        raise NotUnderstood(
            f"{case.table.path}: no column is known as {'an effective axial' if case.kind == 'oedometric' else 'a mean effective'} stress above 0, which drives {IN_WORDS[case.kind]}: --column {'axial' if case.kind == 'oedometric' else 'mean'}_stress=COLUMN:UNIT says which is."
        )
    return stress[stress > 0]


def chosen_columns(case: Case, control: str, observables: tuple[str, ...]) -> Columns:
    """The columns that are read, by what each is read as."""
    found: Columns = {}
    if control in ("axial_strain", "axial_extension"):
        assert case.shortening is not None, "it is the control where there is one"
        found[case.shortening.quantity] = case.shortening
    if case.kind in ("oedometric", "isotropic"):
        found |= _driver(case)
    for name in observables:
        if name == "stress_ratio":
            found |= _ratio(case)
        elif name == "deviatoric_stress":
            found |= _of_stresses(case, "deviator_stress")
        elif name == "excess_pore_pressure":
            found |= _excess(case)
        elif name == "volumetric_strain" and case.summed:
            found[name] = case.summed
        elif name == "volumetric_strain":
            column = case.column("volumetric_strain") or case.column("volume_change") or case.column("radial_strain")
            assert column is not None, "it is compared where a column gives it"
            found[column.quantity] = column
        elif name == "void_ratio":
            assert case.void_ratio is not None, "it is compared where a column gives it"
            found[case.void_ratio.quantity] = case.void_ratio
        elif name == "axial_strain" and case.shortening is not None:
            found[case.shortening.quantity] = case.shortening
        elif name == "axial_strain":
            raise NotUnderstood(
                f"{case.table.path}: no column is known as a void ratio or a strain, which {IN_WORDS[case.kind]} is compared by: --column void_ratio=COLUMN or --column axial_strain=COLUMN:UNIT says which is."
            )
    return found


def _driver(case: Case) -> Columns:
    if case.kind == "oedometric":
        return _of_stresses(case, "axial_stress")
    # All stresses of an isotropic test are the mean one.
    column = next((column for name in ("mean_stress", "lateral_stress", "axial_stress") if (column := case.column(name))), None)
    return {"mean_stress": column} if column else _of_stresses(case, "mean_stress")


def _of_stresses(case: Case, *wanted: str, held: tuple[str, ...] = ()) -> Columns:
    """The fewest columns of stresses from which all the wanted ones follow, where those in `held` are known to be constant; none where they do not."""
    there: dict[str, Seen] = {}
    for column in case.columns:
        if case.state is not None and column.index in case.state.quantities:
            there.setdefault(case.state.quantities[column.index][0], column)
    names = [name for name in _DIRECT if name in there]
    constant = [STRESS_FORMS[name] for name in held]
    for count in (1, 2, 3):
        for chosen in combinations(names, count):
            forms = [*(STRESS_FORMS[name] for name in chosen), *constant]
            if all(weights(STRESS_FORMS[name], forms) is not None for name in wanted):
                return {name: there[name] for name in chosen}
    return {}


def _excess(case: Case) -> Columns:
    """What an excess pore pressure is read from: the pore pressure, or what the effective lateral stress loses while the total one is held."""
    column = case.column("excess_pore_pressure")
    return {column.quantity: column} if column else _of_stresses(case, "pore_pressure") or _of_stresses(case, "lateral_stress")


def is_held(case: Case) -> bool:
    """Whether the effective lateral stress is constant, so that the stress ratio is one at the confining pressure."""
    lateral = case.state.lateral if case.state is not None else None
    if lateral is None:
        return True
    first = lateral[~np.isnan(lateral)][0]
    return bool(np.nanmax(np.abs(lateral - first)) <= HELD * abs(first))


def _has_both(case: Case) -> bool:
    """Whether both effective stresses are known."""
    return case.state is not None and case.state.lateral is not None and case.state.axial is not None


def _ratio(case: Case) -> Columns:
    """What the stress ratio is read from; nothing where the file has none."""
    at_constant = _of_stresses(case, "axial_stress", held=("lateral_stress",))
    if _has_both(case):
        plain = is_held(case) and len(at_constant) == 1 and not case.bare_stresses and case.kind == "triaxial"
        return at_constant if plain else _of_stresses(case, "axial_stress", "lateral_stress")
    for name in ("stress_ratio", "deviator_to_mean_stress"):
        if column := case.column(name):
            return {name: column}
    return at_constant
