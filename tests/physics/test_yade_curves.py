"""Whole triaxial tests to 20 % strain against YADE's, on the packings of Hartmann, Cheng, Thornton (2022).

A shear of 20 % is chaotic: YADE's own replicates, whose density scaling differs by a thousandth, are 0.1 % (soft rough grains) to 3 % apart by Eq. 5-6. Means
of three are compared, and may differ by 1.5 times that floor: they would differ by 0.6 of it if both engines drew from one population. Where replicates
hardly scatter 1.5 % are allowed: YADE's servo has the inertia of the particles' mass in kg, which graincal's equals on packing_2000 alone, and that alone
moves the volumetric strain of soft grains by 0.2 %.
"""

import numpy as np
import pytest

from .conftest import CASES, YADE_SCALINGS
from .curves import COMPARED, error, mean_curve, replicate_floor, sample_error

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module", params=CASES)
def compared(request, yade_cases, triaxial_runs):
    """YADE's replicates and graincal's, of one case."""
    case = yade_cases[request.param]
    ours = [triaxial_runs.values((request.param, scaling)) for scaling in YADE_SCALINGS]
    for curve in (*case.replicates, *ours):
        assert np.allclose(curve["axial_strain"], case.strains, rtol=0, atol=1e-6)
    return case.replicates, ours


def test_the_mean_curve_agrees_within_the_replicate_floor(compared):
    yades, ours = compared
    yade, our = mean_curve(yades), mean_curve(ours)
    found = {name: round(error(yade, our, name), 2) for name in COMPARED}
    assert sample_error(yade, our) <= max(1.5 * replicate_floor(yades), 1.5), found


def test_the_fabric_agrees(compared):
    # Replicates of YADE are up to 0.5 % apart in the coordination number, and 3 % in the anisotropy of contacts.
    yade, our = map(mean_curve, compared)
    assert error(yade, our, "coordination_number") <= 2
    assert error(yade, our, "a_c") <= 5


def test_our_replicates_scatter_as_yades_do(compared):
    # Each floor is a mean of three distances that three runs span, and known no better than to a factor of two or three.
    yades, ours = map(replicate_floor, compared)
    assert yades / 3 <= ours <= 3 * yades
