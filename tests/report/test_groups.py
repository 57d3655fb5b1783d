"""Groups of parameter values, on clouds whose number is known."""

import numpy as np
import pytest

from graincal.data import ParameterSpace
from graincal.inference import Posterior
from graincal.inference.sampling.groups import find_groups

SPACE = ParameterSpace({f"p{k}": (0, 10) for k in range(5)})
SIGMA = 0.2


def posterior(clouds, seed, weigh=lambda rng, count: rng.exponential(size=count)):
    """Normal clouds about centres (n,), of so many samples each, with weights that scatter."""
    rng = np.random.default_rng(seed)
    theta = np.concatenate([np.asarray(centre) + SIGMA * rng.standard_normal((count, 5)) for centre, count in clouds])
    weights = weigh(rng, len(theta))
    return Posterior(SPACE.names, theta, weights / weights.sum())


def apart(distance):
    """Two centres, so many standard deviations from each other."""
    return [5, 5, 5, 5, 5], [5 + distance * SIGMA, 5, 5, 5, 5]


def test_two_clouds_are_found_with_their_shares_and_centres():
    first, second = apart(10)
    groups = find_groups(SPACE, found := posterior([(first, 100), (second, 50)], seed=1))
    # What carries less than 1 % of the largest weight, here 5 times the mean, is left out: less than 5 % of that of 5 % of the samples.
    assert [group.share for group in groups] == pytest.approx([found.weights[:100].sum(), found.weights[100:].sum()], abs=0.05 * 0.05)
    # The centre of 50 samples, worth half as many under exponential weights, is known to sigma / 25^0.5; five times that in each of ten coordinates.
    assert groups[0].centre == pytest.approx(first, abs=SIGMA) and groups[1].centre == pytest.approx(second, abs=SIGMA)


def test_of_very_many_samples_the_groups_are_the_same():
    # 20,000 distances by 20,000 would be 3 GB.
    first, second = apart(10)
    groups = find_groups(SPACE, posterior([(first, 14_000), (second, 6_000)], seed=1, weigh=lambda rng, count: np.ones(count)))
    # The mean of 6,000 samples is known to sigma / 77, and all of them are on the right side of the middle between two clouds 10 sigma apart.
    assert [group.share for group in groups] == pytest.approx([0.7, 0.3], abs=1e-4)
    assert groups[0].centre == pytest.approx(first, abs=SIGMA / 10) and groups[1].centre == pytest.approx(second, abs=SIGMA / 10)


def test_one_cloud_is_no_groups():
    assert sum(bool(find_groups(SPACE, posterior([([5] * 5, 80)], seed))) for seed in range(20)) <= 1


def test_clouds_that_run_into_each_other_are_one():
    first, second = apart(3)
    assert sum(bool(find_groups(SPACE, posterior([(first, 50), (second, 50)], seed))) for seed in range(10)) <= 1


def test_a_bent_ridge_is_one():
    x = np.linspace(-4, 4, 200)
    rng = np.random.default_rng(1)
    theta = 5 + np.stack([x, 0.25 * x**2, *(SIGMA * rng.standard_normal((3, 200)))], axis=1)
    assert find_groups(SPACE, Posterior(SPACE.names, theta, np.full(200, 1 / 200))) == ()


def test_a_handful_of_samples_tells_no_groups():
    first, second = apart(20)
    # All the weight on seven and seven of 80; then a stray sample with a fifth of it beside a cloud.
    few = posterior([(first, 40), (second, 40)], 2, weigh=lambda rng, count: np.where(np.arange(count) % 40 < 7, 1.0, 1e-6))
    assert find_groups(SPACE, few) == ()
    stray = posterior([(first, 80), (second, 1)], 2, weigh=lambda rng, count: np.where(np.arange(count) < 80, 0.01, 0.2))
    assert find_groups(SPACE, stray) == ()


def test_small_weights_do_not_make_a_group():
    first, second = apart(20)
    light = posterior([(first, 80), (second, 40)], 3, weigh=lambda rng, count: np.where(np.arange(count) < 80, 1.0, 0.1))
    assert find_groups(SPACE, light) == ()
