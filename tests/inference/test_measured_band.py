"""The band of what a test would measure, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from graincal import InputError, MeasurementError, Reference
from graincal.inference.likelihood.measured_band import central_interval, measured_deviations

CONTROL = np.linspace(0, 1, 11)


def test_one_response_has_the_interval_of_its_error():
    means, deviations = np.array([[2.0, -1.0]]), np.array([[0.5, 0.1]])
    half = norm.ppf(0.95) * deviations[0]
    np.testing.assert_allclose(central_interval(means, deviations), [means[0] - half, means[0] + half], rtol=1e-9)


def test_of_two_far_modes_each_end_is_a_tenth_of_one():
    low, high = central_interval(np.array([0.0, 1000.0]), np.ones(2))
    assert (low, high) == pytest.approx((norm.ppf(0.1), 1000 + norm.ppf(0.9)), rel=1e-9)


def test_many_responses_of_a_normal_spread_have_the_interval_of_both_variances():
    # 0.3 and 0.4 make 0.5. 4000 quantiles stand for the first: the ends are known to a part of their spacing.
    means = 0.3 * norm.ppf((np.arange(4000) + 0.5) / 4000)
    assert central_interval(means, np.full(4000, 0.4)) == pytest.approx([0.5 * norm.ppf(0.05), 0.5 * norm.ppf(0.95)], rel=1e-3)


@pytest.mark.parametrize("size", [0.0, 1e-9])
@pytest.mark.parametrize("count", [2, 19, 20, 30])
def test_without_errors_it_is_that_of_the_responses(size, count):
    means = np.random.default_rng(1).normal(size=(count, 5))
    # The shares beyond are 1 in 20 exactly: of twenty, the ends lie between the first two and the last two.
    ordered, beyond = np.sort(means, axis=0), count / 20
    places = [int(beyond) - 1, int(beyond)] if count == 20 else [int(beyond)] * 2
    expected = [ordered[places].mean(axis=0), ordered[[-1 - place for place in places]].mean(axis=0)]
    np.testing.assert_allclose(central_interval(means, np.full(means.shape, size)), expected, atol=1e-8)


def test_errors_are_of_each_response_and_of_the_slope():
    curves = np.array([CONTROL, 3 * CONTROL])
    error = MeasurementError(absolute=0.01, relative=0.02, step=0.05, noise=0.03)
    # A simulation has no part that the model cannot reproduce. The mean response rises by 2.
    like = Reference([0.0, 1.0], {"y": [0.0, 7.0]}, measurement_errors={"y": error}, control_step=0.06, simulated=True)
    found = measured_deviations(CONTROL, {"y": curves, "other": curves}, like, "axial_strain")
    assert set(found) == {"y"}
    variances = 0.01**2 + (0.02 * curves) ** 2 + 0.05**2 / 12 + 0.03**2 + (2 * 0.06) ** 2 / 12
    np.testing.assert_allclose(found["y"], np.sqrt(variances), rtol=1e-6)
    # The step is one of another control.
    found = measured_deviations(CONTROL, {"y": curves}, like, "axial_extension")
    np.testing.assert_allclose(found["y"], np.sqrt(variances - (2 * 0.06) ** 2 / 12), rtol=1e-6)


def test_an_error_that_is_not_stated_is_a_part_of_the_peak_and_what_the_model_lacks_too():
    curves = np.array([CONTROL, 3 * CONTROL])
    like = Reference([0.0, 1.0], {"y": [0.0, 7.0]})
    found = measured_deviations(CONTROL, {"y": curves}, like, "axial_strain", discrepancy=False)
    np.testing.assert_allclose(found["y"], 0.01 * 2, rtol=1e-6)
    found = measured_deviations(CONTROL, {"y": curves}, like, "axial_strain")
    np.testing.assert_allclose(found["y"], 2 * np.sqrt(0.01**2 + 0.25 * 0.01**2 + 0.5 * 0.02**2 + 0.25 * 0.04**2), rtol=1e-6)


def test_what_is_not_known_has_no_band_and_a_control_increases():
    curves = np.array([CONTROL, 3 * CONTROL])
    curves[1, 4] = np.nan
    like = Reference([0.0, 1.0], {"y": [0.0, 7.0]})
    found = central_interval(curves, measured_deviations(CONTROL, {"y": curves}, like, "axial_strain")["y"])
    assert np.isnan(found).all(axis=0).tolist() == [k == 4 for k in range(11)]
    with pytest.raises(InputError, match="must increase"):
        measured_deviations(CONTROL[::-1], {"y": curves}, like, "axial_strain")
