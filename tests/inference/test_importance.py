"""What weights say of themselves."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import genpareto

from graincal.inference.sampling.importance import in_variances, pareto_k


def test_the_shape_of_a_tail_is_that_of_other_programs():
    # By arviz-stats 0.8.0, which has the estimate of Zhang and Stephens (2009) with the prior of Vehtari et al. (2024) too.
    rng = np.random.default_rng(7)
    for count, spread, expected in ((100, 0.5, 0.4342608566540899), (1000, 1.0, 0.006551659281471193), (1000, 3.0, 1.0847310804032906)):
        assert pareto_k(spread * rng.standard_normal(count)) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("k", [0.1, 0.5, 0.9])
def test_the_shape_of_a_tail_is_found(k):
    weights = genpareto.rvs(k, size=20000, random_state=np.random.default_rng(1))
    assert pareto_k(np.log(weights)) == pytest.approx(k, abs=0.1)


def test_weights_of_next_to_nothing_overflow_nothing():
    with np.errstate(over="raise", divide="raise", invalid="raise"):
        assert pareto_k(np.linspace(-740, 0, 200)) > 1 and pareto_k(np.concatenate([np.full(200, -745.0), np.linspace(-744.9, 0, 30)])) > 1


def test_few_weights_and_equal_ones_have_no_tail():
    assert np.isnan(pareto_k(np.zeros(20))) and pareto_k(np.zeros(100)) == -np.inf


def test_what_a_few_samples_far_off_count_in_a_variance():
    # A percent of the probability lies eight deviations off in the first coordinate, and the third does not vary.
    rng, part, away = np.random.default_rng(2), 0.01, 8.0
    points = np.column_stack([rng.standard_normal((200_000, 2)), np.full(200_000, 0.5)])
    points[:1000, 0] += away
    weights = np.concatenate([np.full(1000, part / 1000), np.full(199_000, (1 - part) / 199_000)])
    parts = in_variances(points, weights)
    np.testing.assert_allclose(parts.sum(axis=0), [1, 1])
    of_variance = part * (1 + (away - part * away) ** 2) / (1 + part * (1 - part) * away**2)
    np.testing.assert_allclose(parts[:1000].sum(axis=0), [of_variance, part], rtol=0.02, atol=0.002)
