import numpy as np
import pytest

from graincal.data import Reference
from graincal.inference.likelihood.errors import curve_error, gl_error, observable_errors, sample_errors

REFERENCE = Reference([0, 1, 2], {"stress": [1, 2, 5], "strain": [0, -1, -3]})


def test_eq_5_sums_absolute_differences_over_all_states_the_first_included():
    response = np.array(
        [
            [[1, 0], [2, -1], [5, -3]],  # exact
            [[2, 0.1], [2, -1], [4, -2.9]],  # stress off by 1 and 1 of 8, strain by 0.1 and 0.1 of 4
        ]
    )
    assert np.allclose(observable_errors(response, REFERENCE), [[0, 0], [25, 5]], rtol=1e-14)


def test_eq_5_serves_any_curve():
    """Off by 1 and 2 of 1 + 2 + 5, alone and beside an exact one."""
    curve = np.array([1.0, 2.0, 5.0])
    assert curve_error(curve + [1, 0, -2], curve) == pytest.approx(37.5, rel=1e-14)
    assert curve_error(np.array([curve + [1, 0, -2], curve]), curve) == pytest.approx([37.5, 0], rel=1e-14)
    assert curve_error(curve, 0 * curve) == np.inf and np.isnan(curve_error(0 * curve, 0 * curve))


def test_eq_6_counts_observables_by_the_inverse_of_their_variance_shares():
    """Shares 0.2 and 0.8: four to one for the first, (4 * 5 + 1 * 10) / 5 = 6; equal shares: 7.5."""
    errors = np.array([[5.0, 10.0]])
    assert sample_errors(errors, np.array([0.2, 0.8])) == pytest.approx(6.0, rel=1e-14)
    assert sample_errors(errors, np.array([0.5, 0.5])) == pytest.approx(7.5, rel=1e-14)


def test_eq_6_runs_over_the_pairs_of_all_experiments():
    """Two experiments with shares 0.5, 0.5 and 0.2, 0.8: (2*1 + 2*2 + 5*3 + 1.25*4) / 10.25."""
    errors = np.array([[1.0, 2.0, 3.0, 4.0]])
    assert sample_errors(errors, np.array([0.5, 0.5, 0.2, 0.8])) == pytest.approx(26 / 10.25, rel=1e-14)


def test_eq_7_is_the_weighted_mean_and_leaves_failures_out():
    assert gl_error(np.array([0.25, 0.75, 0.0]), np.array([4.0, 8.0, np.nan])) == pytest.approx(7.0, rel=1e-14)


def test_a_response_that_is_no_number_has_no_error_and_one_too_large_to_add_up_an_infinite_one():
    response = np.array([[[1, 0], [np.nan, -1], [5, -3]], [[1, 0], [1.7e308, -1], [1.7e308, -3]]])
    errors = observable_errors(response, REFERENCE)
    assert np.isnan(errors[0, 0]) and errors[1, 0] == np.inf and np.all(errors[:, 1] == 0)
