"""What laboratories measure: canonical names, their dimensions, and how stresses of a triaxial sample follow from one another."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

STRAINS = ("axial_strain", "volumetric_strain", "radial_strain")
COMPRESSED = {"axial_displacement": "axial_strain", "volume_change": "volumetric_strain"}
"""What becomes an engineering strain when it is divided by the sample's height or volume."""
POROSITIES = ("porosity", "specific_volume")
"""Other measures of the void ratio: n = e/(1 + e) and v = 1 + e."""
VOID_RATIOS = ("void_ratio", *POROSITIES)

# A triaxial stress state has three unknowns, the effective axial and lateral stresses σa', σr' and the pore pressure u. Each stress that is measured is a sum of them, with these weights.
STRESS_FORMS: dict[str, tuple[float, float, float]] = {
    "axial_stress": (1, 0, 0),
    "lateral_stress": (0, 1, 0),
    "mean_stress": (1 / 3, 2 / 3, 0),
    "half_sum_stress": (1 / 2, 1 / 2, 0),
    "deviator_stress": (1, -1, 0),
    "half_difference_stress": (1 / 2, -1 / 2, 0),
    "total_axial_stress": (1, 0, 1),
    "total_lateral_stress": (0, 1, 1),
    "total_mean_stress": (1 / 3, 2 / 3, 1),
    "total_half_sum_stress": (1 / 2, 1 / 2, 1),
    "pore_pressure": (0, 0, 1),
}
TOTAL = {
    "axial_stress": "total_axial_stress",
    "lateral_stress": "total_lateral_stress",
    "mean_stress": "total_mean_stress",
    "half_sum_stress": "total_half_sum_stress",
}
"""The total stress that belongs to each effective one."""
OF_CAMBRIDGE_AND_MIT = {"mean_stress": "half_sum_stress", "total_mean_stress": "total_half_sum_stress", "deviator_stress": "half_difference_stress"}
"""What p and q are in the one convention, (σa + 2σr)/3 and σa - σr, and in the other, (σa + σr)/2 and (σa - σr)/2."""

STRESSES = tuple(STRESS_FORMS)
SIGNED = (*STRAINS, *COMPRESSED, *(stress for stress in STRESSES if stress != "pore_pressure"))
"""What changes its sign with the convention of the file; a pore pressure does not."""
DIMENSIONS = (
    dict.fromkeys((*STRAINS, *POROSITIES, "stress_ratio", "deviator_to_mean_stress", "void_ratio", "initial_void_ratio"), "fraction")
    | dict.fromkeys((*STRESSES, "excess_pore_pressure", "back_pressure", "confining_pressure"), "pressure")
    | {"axial_displacement": "length", "volume_change": "volume"}
)
"""The dimension that a known quantity must have; a quantity of any other name may have any."""
OBSERVABLES = ("stress_ratio", "volumetric_strain", "void_ratio", "radial_strain")
"""What is mostly compared."""
READABLE = (*STRAINS, *COMPRESSED, "stress_ratio", "deviator_to_mean_stress", "void_ratio", *POROSITIES, *STRESSES, "excess_pore_pressure")
"""All that a column can be read as."""


@dataclass(frozen=True)
class StressMeasure:
    """How the stress ratio σ1/σ3 follows from one measured stress at a constant lateral stress (Pa)."""

    needs_confining_pressure: bool
    ratio: Callable[[NDArray[np.float64], float], NDArray[np.float64]]


STRESS_MEASURES = {
    "deviator_stress": StressMeasure(True, lambda q, confining: 1.0 + q / confining),
    "axial_stress": StressMeasure(True, lambda sigma_1, confining: sigma_1 / confining),
    # q = σ1 - σ3 and p = (σ1 + 2 σ3)/3; beyond q/p = 3 the lateral stress would be tension.
    "deviator_to_mean_stress": StressMeasure(False, lambda eta, _: (3.0 + 2.0 * eta) / (3.0 - eta)),
}

LARGEST_STRESS_RATIO = 100.0
"""No soil comes near; a larger one is a confining pressure in another unit than pascals."""
SHEARED = 0.05
"""How far from 1 the stress ratio of a sheared sample comes at the least, somewhere in its test: soils fail at 2 to 5."""


def unsheared(lowest: float, highest: float) -> str | None:
    """What is to be said of a stress ratio that stays at 1, between its lowest and its highest value; None for one that does not."""
    if max(abs(lowest - 1), abs(highest - 1)) > SHEARED:
        return None
    return f"the stress ratio stays between {lowest:.4g} and {highest:.4g}, as if the sample were never sheared: is the unit of the stress right, and the confining pressure?"
