import numpy as np
import pytest

from graincal.data import InputError
from graincal.inference import Posterior

POINTS = np.array([[0.0, 10.0], [1.0, 30.0], [4.0, 20.0], [9.0, 99.0]])
WEIGHTS = np.array([0.5, 0.3, 0.2, 0.0])
POSTERIOR = Posterior(("a", "b"), POINTS, WEIGHTS)


def test_moments_of_the_parameters_by_eq_3():
    """a: mean 0.3 + 0.8 = 1.1, mean square 0.3 + 3.2 = 3.5; b: mean 5 + 9 + 4 = 18, mean square 50 + 270 + 80 = 400."""
    assert np.allclose(POSTERIOR.mean(), [1.1, 18.0], rtol=1e-14)
    assert np.allclose(POSTERIOR.std(), np.sqrt([3.5 - 1.1**2, 400 - 18.0**2]), rtol=1e-13)


def test_moments_of_a_quantity_of_interest_by_eq_3_without_those_that_failed():
    curves = np.array([[1.0, 2.0, 3.0], [2.0, 2.0, 5.0], [3.0, 2.0, 1.0], [np.nan] * 3])
    assert np.allclose(POSTERIOR.mean(curves), [0.5 + 0.6 + 0.6, 2.0, 1.5 + 1.5 + 0.2], rtol=1e-14)
    assert np.allclose(POSTERIOR.std(curves)[:2], [np.sqrt(0.5 * 0.49 + 0.3 * 0.09 + 0.2 * 1.69), 0.0], atol=1e-14)
    assert POSTERIOR.mean(curves[:, 0]) == pytest.approx(1.7, rel=1e-14)


def test_the_interval_holds_its_probability_of_a_known_density():
    """A uniform density carrying weights 2 b has the quantile sqrt(p); 20,000 points put it to 1 / sqrt(20000) = 0.007, and 4 of those are allowed."""
    rng = np.random.default_rng(5)
    points = rng.random((20_000, 1))
    posterior = Posterior(("b",), points, points[:, 0] / points.sum())
    for probability in (0.5, 0.9, 0.95):
        expected = np.sqrt([(1 - probability) / 2, (1 + probability) / 2])
        assert np.abs(posterior.interval(probability)[:, 0] - expected).max() < 0.028


def test_the_interval_of_few_points_by_hand():
    """Cumulated weights of b in ascending order: 10: 0.5, 20: 0.7, 30: 1.0. 99 has no weight."""
    assert np.array_equal(POSTERIOR.interval(0.5), [[0, 10], [1, 30]])
    assert np.array_equal(POSTERIOR.interval(0.2), [[0, 10], [1, 20]])


@pytest.mark.parametrize("probability", [0, 1, 90])
def test_an_interval_needs_a_probability(probability):
    with pytest.raises(InputError, match="between 0 and 1"):
        POSTERIOR.interval(probability)


def test_correlation_is_that_of_repeated_points():
    """Weights 0.5, 0.3, 0.2 are the points five, three and two times."""
    copies = np.repeat(POINTS, [5, 3, 2, 0], axis=0)
    assert np.allclose(POSTERIOR.correlation(), np.corrcoef(copies.T), rtol=1e-13)


def test_a_parameter_that_does_not_vary_has_no_correlation():
    posterior = Posterior(("a", "b"), np.array([[0.0, 3.0], [1.0, 3.0]]), np.array([0.5, 0.5]))
    assert np.array_equal(np.isnan(posterior.correlation()), [[False, True], [True, True]])


def test_a_quantity_of_interest_of_other_length_is_refused():
    with pytest.raises(InputError, match="each of the 4 samples"):
        POSTERIOR.mean(np.ones(3))
