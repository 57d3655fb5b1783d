"""A soil in two formulas: the stress ratio rises along a hyperbola, the volume contracts first and dilates after."""

import numpy as np

AXIAL_STRAIN = np.linspace(0, 0.15, 16)
"""The strains of reference.csv. (A model that has others of its own names them in the calibration file: control = [...].)"""


def drained_triaxial(theta):
    """Stress ratio and volumetric strain at AXIAL_STRAIN, and a quantity of interest besides."""
    strength, reference_strain, dilatancy = theta
    mobilised = AXIAL_STRAIN / (reference_strain + AXIAL_STRAIN)
    return {
        "stress_ratio": 1 + strength * mobilised,
        "volumetric_strain": 0.15 * reference_strain * mobilised - dilatancy * AXIAL_STRAIN * mobilised,
        "friction_angle": np.degrees(np.arcsin(strength * mobilised / (2 + strength * mobilised))),
    }
