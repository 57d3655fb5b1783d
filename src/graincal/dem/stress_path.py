"""Stress paths as stages for the engine.

Each begins with isotropic compression to a confining pressure, from whose end strains count, and goes on with one recorded state for each value asked for.
The axial direction is z. Stresses are in Pa, strains logarithmic fractions, both positive in compression; an axial strain below zero is extension.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from graincal import _native

Values = Sequence[float] | NDArray[np.float64]
"""What a path is driven to, one after the other."""

ISOTROPIC_RATE = 1.0
"""Largest strain rate while a stress is sought, 1/s."""
AXIAL_RATE = 0.1
"""Strain rate of axial loading, 1/s."""


def drained_triaxial(confining_pressure: float, axial_strains: Values) -> list[_native.Stage]:
    """The drained triaxial test of Hartmann, Cheng, Thornton (2022): a recorded state at each axial strain, with the lateral stresses held."""
    held = _stress(confining_pressure)
    return [consolidation(confining_pressure), *(_native.Stage([held, held, _strain(strain)], record=True) for strain in axial_strains)]


def constant_mean_stress(confining_pressure: float, axial_strains: Values) -> list[_native.Stage]:
    """Triaxial shearing in which the lateral stresses make up for the axial one, so that the mean of the three stays the confining pressure."""
    held = _stress(confining_pressure)
    sheared = (_native.Stage([held, held, _strain(strain)], record=True, mean_stress=True) for strain in axial_strains)
    return [consolidation(confining_pressure), *sheared]


def undrained_triaxial(confining_pressure: float, axial_strains: Values) -> list[_native.Stage]:
    """Triaxial shearing at constant volume, as of a saturated sample that cannot drain: each lateral strain is minus half the axial one.

    The lateral axes move at half the axial rate, so that all three arrive together and the volume is constant on the way too: to 3/4 ε r dt for a
    stage of strain ε, rate r and time step dt (a step adds its strain where the logarithm is meant), of the order of 1e-7 for a stage of 1 %.
    """
    stages = [consolidation(confining_pressure)]
    for strain in axial_strains:
        lateral = _strain(-0.5 * strain, 0.5 * AXIAL_RATE)
        stages.append(_native.Stage([lateral, lateral, _strain(strain)], record=True))
    return stages


def oedometric(confining_pressure: float, axial_strains: Values) -> list[_native.Stage]:
    """One-dimensional compression to each axial strain, without lateral strain."""
    return [consolidation(confining_pressure), *(_native.Stage([_strain(0), _strain(0), _strain(strain)], record=True) for strain in axial_strains)]


def oedometric_to_stresses(confining_pressure: float, axial_stresses: Values) -> list[_native.Stage]:
    """One-dimensional compression to each axial stress, up and down in the order given, without lateral strain."""
    loaded = (_native.Stage([_strain(0), _strain(0), _stress(stress, AXIAL_RATE)], record=True) for stress in axial_stresses)
    return [consolidation(confining_pressure), *loaded]


def isotropic(confining_pressure: float, pressures: Values) -> list[_native.Stage]:
    """Isotropic compression to each pressure, up and down in the order given.

    Strains are small from one pressure to the next, and the rate is that of axial loading: at ISOTROPIC_RATE the stresses overshoot, which a sample
    remembers (1e-3 of void ratio in a cycle that is reversible otherwise).
    """
    return [consolidation(confining_pressure), *(_native.Stage([_stress(pressure, AXIAL_RATE)] * 3, record=True) for pressure in pressures)]


def consolidation(confining_pressure: float) -> _native.Stage:
    """Isotropic compression that every path begins with: it is not recorded, and strains count from its end."""
    return _native.Stage([_stress(confining_pressure)] * 3, strain_origin=True)


def _stress(target: float, largest_rate: float = ISOTROPIC_RATE) -> _native.AxisGoal:
    return _native.AxisGoal(stress=True, target=float(target), largest_rate=largest_rate)


def _strain(target: float, largest_rate: float = AXIAL_RATE) -> _native.AxisGoal:
    return _native.AxisGoal(stress=False, target=float(target), largest_rate=largest_rate)
