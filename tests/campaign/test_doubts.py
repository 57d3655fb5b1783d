"""What is noted is seldom meant; what is common is not noted."""

import numpy as np
import pytest

from graincal import Experiment, Reference
from graincal.campaign import Calibration
from graincal.campaign.file.doubts import doubts as found
from graincal.data import MeasurementError
from graincal.models.contact_laws import unusual_parameters
from graincal.notation.text import duration

from .hyperbola import SPACE, STRAIN, model

PEAK = 1 + 3 * STRAIN / (0.02 + STRAIN) + 120 * STRAIN * np.exp(-STRAIN / 0.03)
HARDENING = 1 + 3 * STRAIN / (0.02 + STRAIN)
DENSE = 0.1 * STRAIN - 0.4 * STRAIN**2


def doubts(calibration):
    """What is said, in words."""
    return list(map(str, found(calibration)))


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


def test_a_sign_that_was_turned_is_to_be_turned_back():
    for name in ("volumetric_strain", "volume_change"):
        reference = Reference(STRAIN, {"volumetric_strain": -0.05 * STRAIN}, read_as=(name,), turned=(name,))
        (doubt,) = doubts(Calibration(SPACE, [Experiment("x", model(), reference)], workers=1))
        assert doubt.endswith(f'needs compression = {{ {name} = "positive" }}.')


@pytest.mark.parametrize(("stress_ratio", "noted"), [(1 + (HARDENING - 1) / 400, True), (HARDENING, False), (1 - (HARDENING - 1) / 10, False)])
def test_a_stress_ratio_that_stays_at_one_is_noted(stress_ratio, noted):
    reference = Reference(STRAIN, {"stress_ratio": stress_ratio})
    assert any("is the unit of the stress right" in doubt for doubt in doubts(Calibration(SPACE, [Experiment("x", model(), reference)], workers=1))) == noted


@pytest.mark.parametrize(("error", "noted"), [(0.05, True), (0.0005, False)])
def test_errors_in_percent_are_noted(error, noted):
    reference = Reference(STRAIN, {"volumetric_strain": DENSE}, measurement_errors={"volumetric_strain": error})
    said = [
        doubt
        for doubt in doubts(Calibration(SPACE, [Experiment("x", model(), reference)], workers=1))
        if "volumetric_strain is said to be measured to 0.05" in doubt
    ]
    assert bool(said) == noted
    reference = Reference(STRAIN, {"volumetric_strain": DENSE}, control_step=100 * error)
    assert (
        any("axial_strain is said to be measured to 5" in doubt for doubt in doubts(Calibration(SPACE, [Experiment("x", model(), reference)], workers=1)))
        == noted
    )


@pytest.mark.parametrize(("error", "noted"), [(1.0, True), (0.05, False)])
def test_relative_errors_in_percent_are_noted(error, noted):
    reference = Reference(STRAIN, {"volumetric_strain": DENSE}, measurement_errors={"volumetric_strain": MeasurementError(relative=error)})
    said = " ".join(doubts(Calibration(SPACE, [Experiment("x", model(), reference)], workers=1)))
    assert ("volumetric_strain is said to be measured to 1 of each value, which is 100 %" in said) == noted


def test_degrees_that_look_like_radians_are_noted():
    assert unusual_parameters({"phi": (0.5,), "fixed.phi": (30.0,), "parameters.phi": (0.1, 1.0), "nu": (0.2,)}) == [
        "phi = 0.5 is in degrees; if 0.5 rad is meant, write 28.65.",
        "parameters.phi = 0.1 to 1 is in degrees; if 0.1 to 1 rad is meant, write 5.73 to 57.3.",
    ]
    # Smooth grains are none.
    assert unusual_parameters({"phi": (0.0,)}) == []


def test_a_time_span_can_follow_about():
    assert [duration(seconds) for seconds in (1e-6, 0.04, 0.337, 0.99, 59, 120, 7200)] == ["0.01 s", "0.04 s", "0.3 s", "1 s", "59 s", "2 min", "2.0 h"]
