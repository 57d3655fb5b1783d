"""Exploring a posterior whose likelihood costs nothing, against integrals that are known."""

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import truncnorm

from graincal import ParameterSpace
from graincal.inference.sampling.defensive import PRIOR_SHARE, DefensiveMixture
from graincal.inference.sampling.explore import _tempered, explore
from graincal.inference.sampling.proposal import ProposalOutsideBox, TruncatedMixture
from graincal.inference.sampling.tempering import TemperedSample, temper

SPACE = ParameterSpace({name: (0, 1) for name in "abcde"})
BROAD, NARROW = (0.35, 0.12), (0.75, 0.004)
# The narrow mode has e^3 times the broad one's probability in a volume of e^-17 times: it is next to nothing at lower powers of the likelihood.
LOG_SHARES = np.array([0.0, 3.0])


def log_likelihood(unit):
    logs = []
    for (centre, width), share in zip((BROAD, NARROW), LOG_SHARES):
        logs.append(share - 0.5 * np.sum(((unit - centre) / width) ** 2, axis=1) - unit.shape[1] * np.log(width * np.sqrt(2 * np.pi)))
    return logsumexp(logs, axis=0)


def about(centre, width, seed=0):
    """A density about the place, from too few samples to be right."""
    theta = np.clip(np.random.default_rng(seed).normal(centre, width, (60, 5)), 0, 1)
    return DefensiveMixture.fitted(SPACE, theta, np.full(60, 1 / 60), np.random.default_rng(seed))


@pytest.mark.parametrize("seed", range(4))
def test_a_narrow_mode_near_which_fewer_data_led_is_not_lost(seed):
    lost = temper(log_likelihood, SPACE, 1024, np.random.default_rng(seed))
    assert np.all(lost.unit.mean(axis=1) < 0.6), "tempering finds it by itself, and this test says nothing"
    found = explore(SPACE, log_likelihood, np.random.default_rng(seed), near=about(0.752, 0.006))
    assert not found.tempered
    assert found.log_evidence == pytest.approx(logsumexp(LOG_SHARES), abs=0.1)
    assert found.weights[found.theta.mean(axis=1) > 0.6].sum() == pytest.approx(np.exp(3) / (1 + np.exp(3)), abs=0.02)


def test_a_density_far_from_the_posterior_does_no_harm():
    def broad(unit):
        return -0.5 * np.sum(((unit - BROAD[0]) / BROAD[1]) ** 2, axis=1) - 5 * np.log(BROAD[1] * np.sqrt(2 * np.pi))

    found = explore(SPACE, broad, np.random.default_rng(1), near=about(*NARROW))
    assert found.effective_samples > 400 and found.log_evidence == pytest.approx(0, abs=0.05)
    np.testing.assert_allclose(found.weights @ found.theta, BROAD[0], atol=0.02)


def test_a_density_that_cannot_be_drawn_from_is_left_out():
    far = DefensiveMixture(SPACE, TruncatedMixture(SPACE, np.ones(1), np.full((1, 5), 3.0), 1e-4 * np.eye(5)[None]))
    with pytest.raises(ProposalOutsideBox):
        far.draw(1, np.random.default_rng(1))
    found = explore(SPACE, lambda unit: -0.5 * np.sum(((unit - 0.4) / 0.1) ** 2, axis=1), np.random.default_rng(1), near=far)
    assert not found.tempered and found.effective_samples > 1000


def test_draws_that_no_mixture_fits_stand_where_tempering_has_lost_what_they_found(monkeypatch):
    # As if a mode of 20 times the broad one's probability fitted no mixture.
    monkeypatch.setattr("graincal.inference.sampling.explore.TOO_FEW", 10**6)
    found = explore(SPACE, log_likelihood, np.random.default_rng(0), near=about(0.752, 0.006))
    assert not found.tempered and found.log_evidence == pytest.approx(logsumexp(LOG_SHARES), abs=0.1)
    alike = explore(SPACE, lambda unit: -0.5 * np.sum(((unit - 0.4) / 0.1) ** 2, axis=1), np.random.default_rng(0))
    assert alike.tempered


def test_tempered_samples_of_two_explorations_count_as_their_evidences_say():
    samples = [TemperedSample(np.full((4, 5), place), np.zeros(4), evidence, np.empty((0, 5))) for place, evidence in ((0.2, 0.0), (0.8, np.log(3.0)))]
    found = _tempered(SPACE, samples, DefensiveMixture(SPACE))
    assert found.log_evidence == pytest.approx(np.log(2.0))
    np.testing.assert_allclose(found.weights @ found.theta, 0.65)


def test_the_posterior_that_is_reported_knows_what_lies_far_out():
    # Three percent of the probability lie far from the rest, and make most of the variance.
    share, core, far = 0.03, (0.3, 0.03), truncnorm(-3.5, 1.5, 0.7, 0.2)

    def log_density(unit):
        near = -0.5 * np.sum(((unit - core[0]) / core[1]) ** 2, axis=1) - 5 * np.log(core[1] * np.sqrt(2 * np.pi))
        return np.logaddexp(np.log1p(-share) + near, np.log(share) + far.logpdf(unit).sum(axis=1))

    mean = (1 - share) * core[0] + share * far.mean()
    std = np.sqrt((1 - share) * (core[1] ** 2 + (core[0] - mean) ** 2) + share * (far.var() + (far.mean() - mean) ** 2))

    def off(last):
        found = [explore(SPACE, log_density, np.random.default_rng(seed), near=about(*core), thorough=False, last=last) for seed in range(6)]
        # What is drawn from next is the density that was fitted, without the larger uniform part of these draws.
        assert all(each.proposal.prior_share == PRIOR_SHARE for each in found)
        deviations = [np.sqrt(each.weights @ (each.theta - each.weights @ each.theta) ** 2) for each in found]
        return np.sqrt(np.mean((np.array(deviations) / std - 1) ** 2))

    assert off(last=True) < 0.03 and off(last=False) > 0.08


def test_a_small_part_far_out_that_a_dozen_draws_meet_is_drawn_from_until_it_is_known(monkeypatch):
    share, core, far = 0.03, (0.3, 0.03), (0.75, 0.08)

    def log_density(unit):
        parts = [
            np.log(part) - 0.5 * np.sum(((unit - mean) / width) ** 2, axis=1) - 5 * np.log(width) for part, (mean, width) in ((1 - share, core), (share, far))
        ]
        return np.logaddexp(*parts) - 2.5 * np.log(2 * np.pi)

    std = np.sqrt((1 - share) * core[1] ** 2 + share * far[1] ** 2 + share * (1 - share) * (far[0] - core[0]) ** 2)

    def off():
        found = [explore(SPACE, log_density, np.random.default_rng(seed), near=about(*core), thorough=False, last=True) for seed in range(6)]
        deviations = [np.sqrt(each.weights @ (each.theta - each.weights @ each.theta) ** 2) for each in found]
        return np.sqrt(np.mean((np.array(deviations) / std - 1) ** 2))

    with_rounds = off()
    monkeypatch.setattr("graincal.inference.sampling.explore.SPREAD_ROUNDS", 0)
    assert with_rounds < 0.03 and off() > 0.1
