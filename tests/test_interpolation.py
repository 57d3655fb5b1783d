"""Responses between their states: exact at them, shape-preserving between, leg by leg where the path turns around."""

import numpy as np
import pytest

from graincal import Failure, Response
from graincal.interpolation import interpolate

STRAIN = np.array([0.0, 0.0005, 0.001, 0.002, 0.004, 0.008, 0.012, 0.016, 0.02])


def response(control=STRAIN, details=None, **columns):
    return Response(control, columns, details or {})


def hyperbola(strain):
    return 1 + 3 * strain / (0.003 + strain)


def test_a_response_is_what_its_states_are_at_them():
    noise = np.random.default_rng(1).standard_normal(len(STRAIN))
    at = STRAIN[[0, 3, 3, 8]] * (1 + 1e-12)
    met = interpolate(response(noise=noise), at)
    np.testing.assert_array_equal(met.values["noise"], noise[[0, 3, 3, 8]])
    np.testing.assert_array_equal(met.control, at)


def test_it_rises_where_the_states_rise_and_makes_no_peak():
    at = np.linspace(0, 0.02, 500)
    steep = np.where(STRAIN > 0.003, 1.0, 0.0)
    met = interpolate(response(ratio=hyperbola(STRAIN), step=steep), at)
    # Fritsch and Carlson (1980): monotone between monotone states.
    assert np.all(np.diff(met.values["ratio"]) > 0) and np.all(np.diff(met.values["step"]) >= 0)
    assert met.values["step"].min() == 0 and met.values["step"].max() == 1
    # The states of a triaxial test are close enough for its curve: three thousandths of the ratio.
    assert np.abs(met.values["ratio"] / hyperbola(at) - 1).max() < 3e-3


def test_what_lies_beyond_the_states_is_a_failure_with_both_ranges():
    for at in ([0.0, 0.021], [-0.001, 0.01]):
        missed = interpolate(response(ratio=hyperbola(STRAIN)), np.array(at))
        assert isinstance(missed, Failure) and missed.reason == f"the response covers the control values 0 to 0.02, and {at[0]:g} to {at[1]:g} were asked for."


def test_a_path_that_turns_around_is_followed_leg_by_leg():
    control = np.array([0.0, 1.0, 2.0, 1.0, 0.0, 1.0])
    stiffness = np.array([0.0, 1.0, 2.0, 1.5, 1.0, 1.5])
    at = np.array([0.5, 2.0, 1.5, 0.0, 0.5])
    met = interpolate(response(control, stress=stiffness), at)
    # Straight legs with edges between them.
    np.testing.assert_allclose(met.values["stress"], [0.5, 2.0, 1.75, 1.0, 1.25], rtol=1e-12)
    down = interpolate(response(-STRAIN, ratio=hyperbola(STRAIN)), -np.array([0.001, 0.003]))
    up = interpolate(response(ratio=hyperbola(STRAIN)), np.array([0.001, 0.003]))
    np.testing.assert_allclose(down.values["ratio"], up.values["ratio"], rtol=1e-12)


def test_stresses_are_met_over_their_logarithms():
    pressure = np.array([1e4, 3e4, 1e5, 1e6])
    compressed = Response(pressure, {"mean_stress": pressure, "void_ratio": 0.8 - 0.1 * np.log10(pressure / 1e4)}, {}, "mean_stress", 1e4, ("mean_stress",))
    met = interpolate(compressed, np.array([2e4, 5e5]))
    np.testing.assert_allclose(met.values["void_ratio"], 0.8 - 0.1 * np.log10([2, 50]), rtol=1e-12)
    turned = Response(np.array([1e4, 1e5, 1e4]), {"void_ratio": np.array([0.8, 0.7, 0.75])}, {}, "mean_stress", 1e4, ("mean_stress",))
    np.testing.assert_allclose(interpolate(turned, np.array([1e5, np.sqrt(1e9)])).values["void_ratio"], [0.7, 0.725], rtol=1e-12)


def test_a_mark_is_held_on_both_sides():
    flagged = np.array([0, 0, 1, 0, 0, 0, 0, 0, 0.0])
    met = interpolate(response(flagged=flagged), np.array([0.00025, 0.0007, 0.001, 0.0015, 0.002, 0.003]))
    np.testing.assert_array_equal(met.values["flagged"], [0, 1, 1, 1, 0, 0])


def test_a_stopped_response_gives_the_rows_that_no_further_state_would_change():
    whole, at = hyperbola(STRAIN), np.linspace(0, 0.02, 101)
    final = interpolate(response(ratio=whole), at).values["ratio"]
    for states in range(1, len(STRAIN)):
        met = interpolate(response(STRAIN[:states], {"stopped": 1}, ratio=whole[:states]), at)
        np.testing.assert_array_equal(met.values["ratio"], final[: len(met.control)])
        assert len(met.control) == (np.sum(at <= STRAIN[states - 2] + 1e-12) if states > 2 else 0)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_beside_a_value_that_is_no_number_there_is_none(value):
    ratio = hyperbola(STRAIN)
    ratio[4] = value
    at = np.array([0.0, 0.0007, 0.003, 0.005, 0.01])
    met = interpolate(response(ratio=ratio), at)
    np.testing.assert_array_equal(np.isfinite(met.values["ratio"]), [True, True, False, False, True])
    # Each stretch of numbers is a curve by itself.
    alone = interpolate(response(STRAIN[:4], ratio=ratio[:4]), at[:2])
    np.testing.assert_array_equal(met.values["ratio"][:2], alone.values["ratio"])
