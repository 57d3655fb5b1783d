"""The posterior by the evaluations' own responses, against posteriors that are known exactly."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import cho_factor, cho_solve

from graincal import ParameterSpace, Reference
from graincal.data import MeasurementError
from graincal.inference import PosteriorFilter, Stop

CONTROL = np.linspace(0, 1, 30)
EVALUATIONS = 20_000


def run(space, reference, model, *, seed=1, batch=4000, **options):
    """A filter of a deterministic model (N, n) -> (N, T, J), without an emulator."""
    stop = Stop(max_iterations=False, max_evaluations=EVALUATIONS)
    filter = PosteriorFilter(space, reference, emulator=False, first_batch=batch, batch=batch, correlation_length=0.1, stop=stop, seed=seed, **options)
    while not filter.finished:
        samples = filter.ask()
        filter.tell(samples, model(samples.theta))
    return filter


@pytest.mark.parametrize("noise", [0.005, 0.05, 0.2])
def test_a_linear_model_has_its_gaussian_posterior(noise):
    # y = A theta + e: theta | y is Gaussian about the generalised least squares solution, and the evidence is that of y ~ N(A theta, Sigma)
    # integrated over a box wide enough (six standard deviations and more each way) to be all of space.
    design = np.stack([np.ones_like(CONTROL), CONTROL, np.sin(3 * CONTROL)], axis=1)
    truth = np.array([1.0, 0.5, -0.3])
    values = design @ truth
    deviation = noise * np.abs(values).max()
    reference = Reference(CONTROL, {"y": values + 0.5 * deviation * np.cos(9 * CONTROL)}, measurement_errors={"y": deviation})
    kernel = np.exp(-np.abs(CONTROL[:, None] - CONTROL[None, :]) / 0.1)
    covariance = deviation**2 * kernel + (1e-6 * np.abs(reference.values).max()) ** 2 * np.eye(len(CONTROL))
    factor = cho_factor(covariance, lower=True)
    exact_covariance = np.linalg.inv(design.T @ cho_solve(factor, design))
    exact_mean = exact_covariance @ design.T @ cho_solve(factor, reference.values[:, 0])
    exact_deviation = np.sqrt(np.diag(exact_covariance))
    # Its centre is not that of the posterior.
    space = ParameterSpace({name: (m - 7 * s, m + 9 * s) for name, m, s in zip("abc", exact_mean, exact_deviation)})
    residual = reference.values[:, 0] - design @ exact_mean
    log_peak = -0.5 * residual @ cho_solve(factor, residual) - np.log(np.diag(factor[0])).sum() - 0.5 * len(CONTROL) * np.log(2 * np.pi)
    exact_evidence = log_peak + 0.5 * np.linalg.slogdet(2 * np.pi * exact_covariance)[1] - space.log_volume

    filter = run(space, reference, lambda theta: (theta @ design.T)[:, :, None])
    posterior = filter.posterior

    weights = posterior.weights
    # Delta method: the variance of a self-normalised estimate of E f is sum w^2 (f - E f)^2 (Owen 2013, Eq. 9.9).
    centred = posterior.samples - exact_mean
    mean_error = np.sqrt(weights**2 @ centred**2)
    assert np.all(np.abs(posterior.mean() - exact_mean) <= 4 * mean_error)
    products = centred[:, :, None] * centred[:, None, :]
    found = np.tensordot(weights, products, axes=1)
    product_error = np.sqrt(np.tensordot(weights**2, (products - exact_covariance) ** 2, axes=1))
    assert np.all(np.abs(found - exact_covariance) <= 4 * product_error)
    # Standard errors that small say that the samples are where the posterior is.
    assert np.all(mean_error < 0.05 * exact_deviation)
    assert filter.log_evidence == pytest.approx(exact_evidence, abs=0.05)


def two_modes(theta):
    # (a - 1/2)^2 is the same on both sides of the middle.
    return np.stack([((theta[:, :1] - 0.5) ** 2) * (1 + CONTROL) + theta[:, 1:] * CONTROL**2], axis=2)


def test_two_equal_modes_share_the_mass():
    space = ParameterSpace({"a": (0, 1), "b": (0, 1)})
    truth = two_modes(np.array([[0.8, 0.4]]))[0, :, 0]
    reference = Reference(CONTROL, {"y": truth}, measurement_errors={"y": 0.01})
    shares = []
    for seed in range(20):
        posterior = run(space, reference, two_modes, seed=seed).posterior
        shares.append(posterior.weights[posterior.samples[:, 0] > 0.5].sum())
    assert min(shares) >= 0.3 and max(shares) <= 0.7
    assert 0.45 <= np.mean(shares) <= 0.55


def test_a_ridge_has_its_moments():
    # The response depends on a + b alone, so that the posterior is even along the ridge: with s = a + b narrow about 1, a is uniform on (0, 1).
    space = ParameterSpace({"a": (0, 1), "b": (0, 1)})
    reference = Reference(CONTROL, {"y": 1.0 + CONTROL}, measurement_errors={"y": MeasurementError(absolute=0.01)})
    posterior = run(space, reference, lambda theta: theta.sum(axis=1)[:, None, None] * (1 + CONTROL)[None, :, None]).posterior
    effective = 1 / np.sum(posterior.weights**2)
    assert posterior.mean()[0] == pytest.approx(0.5, abs=4 * np.sqrt(1 / 12 / effective))
    assert posterior.std()[0] == pytest.approx(np.sqrt(1 / 12), rel=4 * np.sqrt(0.5 / effective))
    assert posterior.correlation()[0, 1] < -0.99


def linear(theta):
    return (theta @ np.stack([np.ones_like(CONTROL), CONTROL]))[:, :, None]


def test_failures_of_the_machine_are_as_if_they_had_never_been_asked():
    # One design, responses of 30 % lost: the posterior is that of the design without those rows.
    space = ParameterSpace({"a": (0, 2), "b": (-1, 1)})
    reference = Reference(CONTROL, {"y": 1 + 0.2 * CONTROL}, measurement_errors={"y": 0.3})
    options = dict(emulator=False, correlation_length=0.1, seed=1)
    whole = PosteriorFilter(space, reference, first_batch=1000, stop=Stop(max_iterations=1), **options)
    samples = whole.ask()
    lost = np.random.default_rng(1).random(len(samples)) < 0.3
    whole.tell(samples, linear(samples.theta), failed=lost)
    # The weights of what is left, of a uniform proposal, are the likelihood alone.
    kept = PosteriorFilter(space, reference, first_batch=1000, stop=Stop(max_iterations=1), **options)
    kept.tell(samples, linear(samples.theta))
    left = kept.posterior.weights[~lost] / kept.posterior.weights[~lost].sum()
    np.testing.assert_allclose(whole.posterior.weights[~lost], left, rtol=1e-10)
    assert np.all(whole.posterior.weights[lost] == 0)
    # The evidence is the mean likelihood of those that came back.
    expected = np.log(np.mean(np.exp(kept.weighed.log_weights[~lost])))
    assert whole.log_evidence == pytest.approx(expected, abs=1e-10)


def test_infeasible_parameters_have_the_likelihood_zero():
    space = ParameterSpace({"a": (0, 2), "b": (-1, 1)})
    reference = Reference(CONTROL, {"y": 1 + 0.2 * CONTROL}, measurement_errors={"y": 0.3})
    filter = PosteriorFilter(space, reference, first_batch=1000, emulator=False, correlation_length=0.1, stop=Stop(max_iterations=1))
    samples = filter.ask()
    impossible = samples.theta[:, 0] > 1
    filter.tell(samples, linear(samples.theta), infeasible=impossible)
    other = PosteriorFilter(space, reference, first_batch=1000, emulator=False, correlation_length=0.1, stop=Stop(max_iterations=1))
    other.tell(samples, linear(samples.theta))
    # They were asked, so that the evidence counts them.
    zeroed = np.where(impossible, 0, np.exp(other.weighed.log_weights))
    assert filter.log_evidence == pytest.approx(np.log(zeroed.mean()), abs=1e-10)
    assert filter.posterior.weights[impossible].max() == 0
