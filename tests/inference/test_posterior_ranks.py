"""Whether posteriors mean what they say: ranks of truths that were drawn from the prior (Talts et al. 2018)."""

from __future__ import annotations

import numpy as np
import pytest

from graincal import ParameterSpace, Reference
from graincal.inference import PosteriorFilter, Stop
from graincal.inference.likelihood.error_model import CORRELATION_LENGTHS
from graincal.inference.likelihood.likelihood import log_likelihood, marginal
from graincal.inference.sampling.ranks import UniformBand, rank

CONTROL = np.linspace(0, 1, 25)
SPACE = ParameterSpace({"limit": (1, 3), "stiffness": (0.3, 1.3)})
DEVIATION, DRAWS, REPETITIONS = 0.15, 49, 250
# Fewer of those that draw a second batch from a mixture fitted to the first, which takes ten times as long.
ADAPTIVE = 80


def curves(theta):
    """A curve that bends towards a limit, nonlinear in its stiffness: (N, T, 1)."""
    limit, stiffness = theta.T[:, :, None]
    return (limit * (1 - np.exp(-CONTROL * 10**stiffness / 2)))[:, :, None]


def shrunk(samples, weights):
    mean = weights @ samples
    return mean + 0.8 * (samples - mean)


def repeat(repetitions, **options):
    """Ranks of limit, stiffness and log likelihood, (repetitions, 2, 3): by the posterior, and by it shrunk to 0.8 of its standard deviation."""
    apart = np.abs(CONTROL[:, None] - CONTROL[None, :])
    found = []
    for number in range(repetitions):
        rng = np.random.default_rng([number, 3])
        truth = SPACE.from_unit(rng.random((1, 2)))
        noise = np.linalg.cholesky(np.exp(-apart / rng.choice(CORRELATION_LENGTHS))) @ rng.standard_normal(len(CONTROL))
        reference = Reference(CONTROL, {"y": curves(truth)[0, :, 0] + DEVIATION * noise}, measurement_errors={"y": DEVIATION})
        filter = PosteriorFilter(SPACE, reference, emulator=False, discrepancy=False, seed=number, **options)
        while not filter.finished:
            samples = filter.ask()
            filter.tell(samples, curves(samples.theta))
        posterior, (errors,) = filter.posterior, filter.errors

        def quantities(theta):
            return np.column_stack([theta, marginal(log_likelihood(curves(theta), reference, errors), errors.log_prior)])

        known = quantities(truth)[0]
        theta, weights = posterior.samples, posterior.weights
        found.append([rank(known, quantities(each), weights, DRAWS, rng) for each in (theta, shrunk(theta, weights))])
    return np.array(found)


@pytest.fixture(scope="module")
def ranks():
    return repeat(REPETITIONS, first_batch=2000, stop=Stop(max_iterations=1))


def band(repetitions):
    # Three quantities: each may leave its band by chance in one case of three hundred, and all of them together in one of a hundred.
    return UniformBand.of(repetitions, DRAWS, 1 - 0.01 / 3, np.random.default_rng(1))


def test_ranks_of_the_truth_are_uniform(ranks):
    assert [band(REPETITIONS).holds(ranks[:, 0, quantity]) for quantity in range(3)] == [True] * 3


def test_they_are_where_half_of_the_evaluations_are_of_a_fitted_mixture():
    ranks = repeat(ADAPTIVE, first_batch=300, batch=300, stop=Stop(max_iterations=2))
    assert [band(ADAPTIVE).holds(ranks[:, 0, quantity]) for quantity in range(3)] == [True] * 3


def test_a_posterior_that_is_too_sure_is_refused(ranks):
    # A deviation of 0.8 of what it should be puts 31 % of truths, not 20 %, in the outer tenths of the samples; 250 ranks tell 20 % to 2.5 %.
    assert not all(band(REPETITIONS).holds(ranks[:, 1, quantity]) for quantity in range(3))


def test_the_band_holds_uniform_ranks_as_often_as_it_says():
    # A thousand sets, of which one in ten leaves: four standard errors of 0.0095.
    band = UniformBand.of(100, 19, 0.9, np.random.default_rng(1))
    rng = np.random.default_rng(2)
    kept = np.mean([band.holds(rng.integers(20, size=100)) for _ in range(1000)])
    # Ranks are whole numbers, so that the band's probability is that of a step at or above what was asked.
    assert 0.9 - 0.038 <= kept <= 0.96


def test_ranks_count_weighted_samples_below_the_truth():
    # Below 0.5 lie samples of weight 0.25 and below 2 all of them: a binomial of 400 draws has a standard deviation of 8.7.
    values = np.array([[0.0, 0.0], [1.0, 1.0]])
    found = rank(np.array([0.5, 2.0]), values, np.array([0.25, 0.75]), 400, np.random.default_rng(1))
    assert abs(found[0] - 100) <= 35 and found[1] == 400
