"""Stress paths as stages for the engine."""

from __future__ import annotations

from collections.abc import Sequence

from graincal import _native

ISOTROPIC_RATE = 1.0
"""Largest strain rate while a stress is sought, 1/s."""
AXIAL_RATE = 0.1
"""Strain rate of axial loading, 1/s."""


def drained_triaxial(confining_pressure: float, axial_strains: Sequence[float]) -> list[_native.Stage]:
    """The drained triaxial test of Hartmann, Cheng, Thornton (2022): isotropic compression to `confining_pressure` (Pa), then one recorded state at
    each of `axial_strains` (logarithmic, compression positive) with the lateral stresses held. The axial direction is z."""
    held = _native.AxisGoal(stress=True, target=confining_pressure, largest_rate=ISOTROPIC_RATE)
    stages = [_native.Stage([held, held, held], strain_origin=True)]
    for strain in axial_strains:
        axial = _native.AxisGoal(stress=False, target=float(strain), largest_rate=AXIAL_RATE)
        stages.append(_native.Stage([held, held, axial], record=True))
    return stages
