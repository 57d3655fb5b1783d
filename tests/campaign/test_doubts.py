"""What is noted is seldom meant; what is common is not noted."""

import numpy as np
import pytest

from graincal import Experiment, Reference
from graincal.campaign import Calibration
from graincal.campaign.doubts import doubts
from graincal.cli.text import duration

from .hyperbola import SPACE, STRAIN, model

PEAK = 1 + 3 * STRAIN / (0.02 + STRAIN) + 120 * STRAIN * np.exp(-STRAIN / 0.03)
HARDENING = 1 + 3 * STRAIN / (0.02 + STRAIN)
DENSE = 0.1 * STRAIN - 0.4 * STRAIN**2


@pytest.mark.parametrize(
    ("stress_ratio", "volumetric_strain", "noted"),
    [
        (PEAK, DENSE, False),
        (PEAK, -DENSE, True),
        (HARDENING, 0.05 * STRAIN, False),
        # A loose sample contracts throughout; turned, it would dilate without ever having a peak.
        (HARDENING, -0.05 * STRAIN, True),
        # A very dense sample may dilate from its first recorded state on.
        (PEAK, -0.3 * STRAIN, False),
    ],
)
def test_a_volumetric_strain_is_noted_where_its_sign_looks_turned(stress_ratio, volumetric_strain, noted):
    reference = Reference(STRAIN, {"stress_ratio": stress_ratio, "volumetric_strain": volumetric_strain})
    assert any("dilates first" in doubt for doubt in doubts(Calibration(SPACE, [Experiment("x", model(), reference)], workers=1))) == noted


def test_a_time_span_can_follow_about():
    assert [duration(seconds) for seconds in (1e-6, 0.04, 0.337, 0.99, 59, 120, 7200)] == ["0.01 s", "0.04 s", "0.3 s", "1 s", "59 s", "2 min", "2.0 h"]
