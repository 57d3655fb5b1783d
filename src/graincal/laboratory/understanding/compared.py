"""Which quantities of a file are compared, on which control, and from which columns they are read."""

from __future__ import annotations

import numpy as np

from graincal.laboratory.backbone import through_zero
from graincal.laboratory.understanding.case import IN_WORDS, Case, NotUnderstood
from graincal.laboratory.understanding.seen import Seen
from graincal.positions import turning_points

HELD = 0.01
"""A lateral stress within this part of its first value is constant, and the stress ratio is taken at that value; else it is taken row by row."""
Columns = dict[str, Seen | tuple[Seen, ...]]
_SINGLE = ("deviator_stress", "axial_stress", "half_difference_stress")
"""What a stress ratio at a constant lateral stress is read from, the most direct first."""
_PAIRS = (
    ("axial_stress", "lateral_stress"), ("deviator_stress", "lateral_stress"), ("deviator_stress", "mean_stress"), ("half_difference_stress", "half_sum_stress"), ("half_difference_stress", "lateral_stress"),
    ("axial_stress", "mean_stress"), ("axial_stress", "deviator_stress"), ("axial_stress", "half_difference_stress"), ("lateral_stress", "mean_stress"), ("axial_stress", "half_sum_stress"),
    ("deviator_stress", "total_lateral_stress", "pore_pressure"), ("total_axial_stress", "total_lateral_stress", "pore_pressure"), ("deviator_stress", "total_mean_stress", "pore_pressure"),
    ("deviator_stress", "total_axial_stress", "pore_pressure"), ("half_difference_stress", "total_half_sum_stress", "pore_pressure"), ("half_difference_stress", "total_lateral_stress", "pore_pressure"),
)  # fmt: skip
"""What both effective stresses are read from."""


def observables_of(case: Case) -> tuple[str, tuple[str, ...]]:
    """The control and the observables of the kind of test."""
    if case.kind in ("oedometric", "isotropic"):
        return _compressed(case)
    control = "axial_extension" if case.extension else "axial_strain"
    if case.kind == "undrained":
        pore = case.column("pore_pressure") or case.column("excess_pore_pressure") or (case.state is not None and case.state.lateral is not None)
        second = ("excess_pore_pressure",) if pore else ()
        stress = ("deviatoric_stress",) if case.state is not None and case.state.deviator is not None else ("stress_ratio",) if case.column("stress_ratio") else ()
        return control, (*stress, *second)
    stress = ("stress_ratio",) if case.state is not None or case.column("stress_ratio") or case.column("deviator_to_mean_stress") else ()
    if case.kind == "constant-mean-stress" and stress and not set(_ratio(case)) - set(_SINGLE):
        # A deviator stress alone is none of a ratio where the lateral stress falls.
        stress = ("deviatoric_stress",)
    has_volume = case.summed or any(case.column(name) for name in ("volumetric_strain", "volume_change", "radial_strain"))
    volume = ("volumetric_strain",) if has_volume else ("void_ratio",) if case.void_ratio else ()
    return control, (*stress, *volume)


def _compressed(case: Case) -> tuple[str, tuple[str, ...]]:
    """Of an oedometer or an isotropic test: a position where the stress turns around, else the stress itself."""
    driver = "axial_stress" if case.kind == "oedometric" else "mean_stress"
    stress = driving_stress(case)
    control = "position" if turning_points(stress, float(stress[0])) else driver
    compared = "void_ratio" if case.void_ratio else "volumetric_strain" if case.column("volumetric_strain") else "axial_strain"
    return control, (compared,)


def driving_stress(case: Case) -> np.ndarray:
    """The axial or mean stress (T,) of a compression test from its first above 0 on, Pa."""
    state = case.state
    stress = state.mean if case.kind == "isotropic" and state.mean is not None else state.axial if state.axial is not None else None
    if stress is None:
        column = case.column("mean_stress") or case.column("lateral_stress") or case.column("axial_stress")
        stress = np.abs(column.plain) if column is not None else np.empty(0)
    stress = through_zero(stress[~np.isnan(stress)])
    if not np.any(stress > 0):
        raise NotUnderstood(f"{case.table.path}: no column is known as {'an effective axial' if case.kind == 'oedometric' else 'a mean effective'} stress above 0, which drives {IN_WORDS[case.kind]}: --column {'axial' if case.kind == 'oedometric' else 'mean'}_stress=COLUMN:UNIT says which is.")
    return stress[stress > 0]


def chosen_columns(case: Case, control: str, observables: tuple[str, ...]) -> Columns:
    """The columns that are read, by what each is read as."""
    found: Columns = {}
    if control in ("axial_strain", "axial_extension"):
        found[case.shortening.quantity] = case.shortening
    if case.kind in ("oedometric", "isotropic"):
        found |= _driver(case)
    for name in observables:
        if name == "stress_ratio":
            found |= _ratio(case)
        elif name == "deviatoric_stress":
            found |= _of_stress(case, ("deviator_stress",), ("half_difference_stress",), ("axial_stress", "lateral_stress"), ("total_axial_stress", "total_lateral_stress"))
        elif name == "excess_pore_pressure":
            column = case.column("excess_pore_pressure") or case.column("pore_pressure")
            found |= {column.quantity: column} if column else _of_stress(case, ("lateral_stress",), *_PAIRS)
        elif name == "volumetric_strain" and case.summed:
            found[name] = case.summed
        elif name == "volumetric_strain":
            column = case.column("volumetric_strain") or case.column("volume_change") or case.column("radial_strain")
            found[column.quantity] = column
        elif name == "void_ratio":
            found[case.void_ratio.quantity] = case.void_ratio
        elif name == "axial_strain" and case.shortening is not None:
            found[case.shortening.quantity] = case.shortening
        elif name == "axial_strain":
            raise NotUnderstood(f"{case.table.path}: no column is known as a void ratio or a strain, which {IN_WORDS[case.kind]} is compared by: --column void_ratio=COLUMN or --column axial_strain=COLUMN:UNIT says which is.")
    return found


def _driver(case: Case) -> Columns:
    if case.kind == "oedometric":
        return _of_stress(case, ("axial_stress",), *_PAIRS, ("total_axial_stress", "pore_pressure"))
    for names in (("mean_stress",), ("lateral_stress",), ("axial_stress",)):
        if column := case.column(names[0]):
            # All stresses of an isotropic test are the mean one.
            return {"mean_stress": column}
    return _of_stress(case, *_PAIRS)


def _of_stress(case: Case, *choices: tuple[str, ...]) -> Columns:
    """The columns of the first choice that the file has all of."""
    for names in choices:
        columns = [case.column(name) or (case.column("back_pressure") if name == "pore_pressure" else None) for name in names]
        if all(columns):
            return dict(zip(names, columns))
    return {}


def is_held(case: Case) -> bool:
    """Whether the effective lateral stress is constant, so that the stress ratio is one at the confining pressure."""
    lateral = case.state.lateral if case.state is not None else None
    if lateral is None:
        return True
    first = lateral[~np.isnan(lateral)][0]
    return bool(np.nanmax(np.abs(lateral - first)) <= HELD * abs(first))


def _ratio(case: Case) -> Columns:
    """What the stress ratio is read from."""
    single = next((name for name in _SINGLE if case.column(name)), None)
    if case.state is not None and case.state.lateral is not None and case.state.axial is not None:
        if is_held(case) and single and not case.bare_stresses and case.kind == "triaxial":
            return {single: case.column(single)}
        if pair := _of_stress(case, *_PAIRS):
            return pair
    for name in ("stress_ratio", "deviator_to_mean_stress"):
        if column := case.column(name):
            return {name: column}
    return {single: case.column(single)} if single else {}


