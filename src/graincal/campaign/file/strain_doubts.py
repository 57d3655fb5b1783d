"""Strains that no test has: in another unit, of another sign, or of another test."""

from __future__ import annotations

import numpy as np

from graincal.campaign.asked.doubt import Doubt
from graincal.campaign.asked.tested import AT_REST, Tested

SMALLEST, LARGEST = 0.003, 0.7
"""How far shear tests go in axial strain. Sand has not failed at the lower; no apparatus has the travel for the upper."""
LARGEST_VOLUMETRIC = 0.3
LEAST_CHANGE = 2e-4
"""A drained sample that was sheared by SHEARED of axial strain has changed its volume by more, somewhere."""
SHEARED = 0.01
LARGEST_UNDRAINED = 0.005
"""Volumetric strain that an undrained test may seem to have, by its membrane."""
BACK = -0.005
"""Axial strain down to which seating and the zero of a gauge explain what is below 0."""


def strain_doubts(tested: Tested) -> list[Doubt]:
    """What is to be said of the axial, the volumetric and the radial strain."""
    return [*_axial(tested), *_volumetric(tested), *_radial(tested)]


def _axial(tested: Tested) -> list[Doubt]:
    if not tested.by_strain:
        return []
    name, first, last = tested.reference.control_name, float(tested.control[0]), float(np.abs(tested.control).max())
    said = []
    if tested.shear and last < SMALLEST and not tested.reference.cut:
        text = f"{name} goes to {last:.4g}, {100 * last:.3g} %, and a shear test goes to some percent: is it too small by 100, as a strain in percent that is divided by 100 once more?"
        said.append(Doubt("strain-too-small", f"{text} Where the test is as short as that, accept it."))
    if last > LARGEST:
        said.append(
            Doubt(
                "strain-too-large",
                f'{name} goes to {last:.4g}, {100 * last:.4g} %, which no test reaches: is it in percent? units = {{ {name} = "%" }} says so.',
            )
        )
    if first < BACK:
        said.append(
            Doubt(
                "negative-strain", f"{name} begins at {first:.4g}, and 0 was expected at the beginning of shear: strains count from the end of consolidation."
            )
        )
    elif first < -AT_REST:
        said.append(Doubt("starts-below-zero", f"{name} begins at {first:.4g}, slightly below 0: the zero of the gauge, or seating."))
    return said


def _volumetric(tested: Tested) -> list[Doubt]:
    values = tested.observable("volumetric_strain")
    if values is None:
        return []
    largest, axial = float(np.abs(values).max()), float(np.abs(tested.control).max()) if tested.by_strain else np.inf
    at = tested.at(int(np.argmax(np.abs(values))))
    if tested.undrained:
        if largest <= LARGEST_UNDRAINED:
            return []
        return [
            Doubt(
                "volume-changes",
                f'volumetric_strain reaches {largest:.3g} at {at}, and an undrained test keeps its volume: is this test drained, kind = "triaxial"?',
            )
        ]
    if largest > LARGEST_VOLUMETRIC:
        return [Doubt("strain-too-large", f"volumetric_strain reaches {largest:.3g} at {at}, which no sand does: is it too large by 100, in percent?")]
    if tested.drained_shear and largest < LEAST_CHANGE and axial >= SHEARED:
        text = f"volumetric_strain stays within {largest:.2g} up to an axial strain of {axial:.3g}: either it is an undrained test, or its unit is wrong"
        return [Doubt("strain-too-small", f"{text} (too small by 100?).")]
    if tested.by_strain and tested.kind != "table" and largest > 1.1 * axial + LARGEST_UNDRAINED:
        text = f"volumetric_strain reaches {largest:.3g} at {at} and the axial strain {axial:.3g}: a sample changes its volume by less than its height. Is one of them in percent?"
        return [Doubt("volumetric-beyond-axial", text)]
    return []


def _radial(tested: Tested) -> list[Doubt]:
    values = tested.observable("radial_strain")
    if values is None or not tested.shear:
        return []
    largest, axial = float(np.abs(values).max()), float(np.abs(tested.control).max())
    if largest > max(LARGEST, 1.5 * axial + LARGEST_UNDRAINED):
        return [Doubt("strain-too-large", f"radial_strain reaches {largest:.3g} where the axial strain reaches {axial:.3g}: is it in percent?")]
    if largest < LEAST_CHANGE and axial >= SHEARED:
        return [Doubt("strain-too-small", f"radial_strain stays within {largest:.2g} up to an axial strain of {axial:.3g}: is it too small by 100?")]
    return []
