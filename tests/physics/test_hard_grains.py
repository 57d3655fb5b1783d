"""Hard grains in float32: a modulus of 1e11 Pa under 0.5 MPa, where overlaps are 1e-5 of a radius, the smallest of the paper's ranges.

Positions of float32 would leave such an overlap two of its digits. Both precisions keep them in float64, and what float32 rounds are forces: it must find the same
packing under pressure, take as many steps, and shear within the scatter of replicates. Two means of n replicates are expected a floor / sqrt(n) apart, where the
floor is that of two single runs: 2.6 of that are allowed, as in test_embedded_yade.py. The numbers of steps scatter by 3 %, and means of nine by 1.4 % of each other:
5 % are 2.6 of those too.
"""

import numpy as np
import pytest

from graincal import demo
from graincal.models.economy import PRECISIONS

from .curves import Replicates, mean_curve, replicate_floor, sample_error

THETA = (11.0, 0.227, 28.1, 0.079, 0.569)
PRESSURE = 0.5e6
SCALINGS = tuple(range(996, 1005))
STRAINS = 0.002 * np.arange(11)


@pytest.fixture(scope="module")
def curves():
    """precision -> the curves of nine replicates."""
    runs, packing = Replicates(), demo.packing()
    for name in PRECISIONS:
        for scaling in SCALINGS:
            runs.start((name, scaling), packing, THETA, STRAINS, PRESSURE, scaling, precision=name)
    yield {name: [runs.values((name, scaling)) for scaling in SCALINGS] for name in PRECISIONS}
    runs.stop()


def test_the_packing_under_pressure_is_the_same(curves):
    # Pressures are met to a thousandth, and strains with them; few contacts are so lightly loaded that they come and go with the last of the motion.
    strains = {name: [np.log((1 + demo.packing().void_ratio) / (1 + curve["void_ratio"][0])) for curve in curves[name]] for name in PRECISIONS}
    assert np.all(np.array(strains["float64"]) > 1e-5)
    assert np.allclose(strains["float32"], np.mean(strains["float64"]), rtol=2e-3, atol=0)
    contacts = [curve["contacts"][0] for name in PRECISIONS for curve in curves[name]]
    assert np.ptp(contacts) <= 0.005 * np.mean(contacts)


def test_it_is_sheared_within_the_scatter_of_replicates(curves):
    double, single = (curves[name] for name in PRECISIONS)
    floor = np.mean([replicate_floor(double), replicate_floor(single)])
    assert sample_error(mean_curve(double), mean_curve(single)) <= 2.6 * floor / np.sqrt(len(SCALINGS))
    assert np.mean([curve["steps"][-1] for curve in single]) == pytest.approx(np.mean([curve["steps"][-1] for curve in double]), rel=0.05)
