"""A simulation's recorder, with stresses and strains of three axes: which axis is loaded, and the triaxial test that they are."""

from __future__ import annotations

import numpy as np

from graincal.laboratory.understanding.case import Case, extreme
from graincal.laboratory.understanding.seen import PLAIN, named, tensors
from graincal.laboratory.units import UNITS

PASCALS = 2e4
"""Stresses above it are in Pa: in kPa they would be above 20 MPa, which crushes sand."""


def decide_axes(case: Case) -> None:
    """Take the columns of a recorder for axial and lateral ones; nothing where the file is of another kind, or a person named its columns."""
    found = tensors(case.columns)
    if found is None:
        return
    strains, stresses = found["strain"], found["stress"]
    named_axis = [axis for axis, column in enumerate(strains) if column.said and column.quantity == "axial_strain"]
    axial = named_axis[0] if named_axis else _loaded([extreme(column.values) for column in strains])
    if axial is None or (any(column.said for column in case.columns) and not named_axis):
        return
    others = [axis for axis in range(3) if axis != axial]
    first = abs(float(stresses[axial].values[0]))
    # Consolidation is isotropic: of the two lateral stresses, the one that is the axial one at the start.
    lateral = min(others, key=lambda axis: abs(abs(float(stresses[axis].values[0])) - first))
    largest = max(abs(extreme(column.values)) for column in stresses)
    unit = UNITS["Pa"] if largest > PASCALS else None
    for column, quantity, of in ((strains[axial], "axial_strain", PLAIN), (stresses[axial], "axial_stress", unit), (stresses[lateral], "lateral_stress", unit)):
        if not column.said:
            case.replace(named(column, quantity, of))
    if case.column("volumetric_strain") is None:
        case.summed = tuple(named(column, "volumetric_strain", PLAIN) for column in strains)
    if not named_axis:
        case.decide(
            "axial_strain",
            strains[axial].header,
            f"of the strains {', '.join(column.header for column in strains)} this one goes another way than both others, so that its axis is the loaded one",
        )
    if unit is not None and not stresses[axial].said:
        case.decide("units.axial_stress", "Pa", f"stresses of a simulation to {largest:.4g} are no kPa, in which they would crush the grains")


def _loaded(ends: list[float]) -> int | None:
    """The axis whose strain ends on the other side of 0 than both others, or is by far the largest."""
    for axis, end in enumerate(ends):
        others = [other for k, other in enumerate(ends) if k != axis]
        if end != 0 and all(np.sign(other) != np.sign(end) for other in others):
            return axis
    order = np.argsort(np.abs(ends))[::-1]
    return int(order[0]) if abs(ends[order[0]]) > 3 * abs(ends[order[1]]) else None
