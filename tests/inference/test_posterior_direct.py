"""The posterior by the evaluations' own responses, against posteriors that are known exactly."""

from __future__ import annotations

import numpy as np
import pytest

from graincal import ParameterSpace, Reference
from graincal.data import MeasurementError
from graincal.inference import PosteriorFilter, Stop

from .linear_curves import CONTROL, CORRELATION_LENGTH, curves, linear_case

EVALUATIONS = 20_000


def run(space, reference, model, *, seed=1, batch=4000, **options):
    """A filter of a deterministic model (N, n) -> (N, T, J), without an emulator."""
    stop = Stop(max_iterations=False, max_evaluations=EVALUATIONS)
    filter = PosteriorFilter(
        space,
        reference,
        emulator=False,
        first_batch=batch,
        batch=batch,
        correlation_length=CORRELATION_LENGTH,
        discrepancy=False,
        stop=stop,
        seed=seed,
        **options,
    )
    while not filter.finished:
        samples = filter.ask()
        filter.tell(samples, model(samples.theta))
    return filter


@pytest.mark.parametrize("noise", [0.005, 0.05, 0.2])
def test_a_linear_model_has_its_gaussian_posterior(noise):
    case = linear_case(noise)
    filter = run(case.space, case.reference, curves)
    posterior = filter.posterior

    weights = posterior.weights
    # Delta method: the variance of a self-normalised estimate of E f is sum w^2 (f - E f)^2 (Owen 2013, Eq. 9.9).
    centred = posterior.samples - case.mean
    mean_error = np.sqrt(weights**2 @ centred**2)
    assert np.all(np.abs(posterior.mean() - case.mean) <= 4 * mean_error)
    products = centred[:, :, None] * centred[:, None, :]
    found = np.tensordot(weights, products, axes=1)
    product_error = np.sqrt(np.tensordot(weights**2, (products - case.covariance) ** 2, axes=1))
    assert np.all(np.abs(found - case.covariance) <= 4 * product_error)
    # Standard errors that small say that the samples are where the posterior is.
    assert np.all(mean_error < 0.05 * case.deviation)
    assert filter.log_evidence == pytest.approx(case.log_evidence, abs=0.05)


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
    assert effective > 2000
    assert posterior.mean()[0] == pytest.approx(0.5, abs=4 * np.sqrt(1 / 12 / effective))
    assert posterior.std()[0] == pytest.approx(np.sqrt(1 / 12), rel=4 * np.sqrt(0.5 / effective))
    assert posterior.correlation()[0, 1] < -0.99
    # Across it, generalised least squares of s on 1 + x, under errors alike over the correlation length.
    kernel = np.exp(-np.abs(CONTROL[:, None] - CONTROL[None, :]) / CORRELATION_LENGTH)
    precision = (1 + CONTROL) @ np.linalg.solve(0.01**2 * kernel + (2e-6) ** 2 * np.eye(len(CONTROL)), 1 + CONTROL)
    total = posterior.samples.sum(axis=1)
    mean = posterior.weights @ total
    assert mean == pytest.approx(1.0, abs=4 / np.sqrt(precision * effective))
    assert np.sqrt(posterior.weights @ (total - mean) ** 2) == pytest.approx(1 / np.sqrt(precision), rel=4 * np.sqrt(0.5 / effective))


def linear(theta):
    return (theta @ np.stack([np.ones_like(CONTROL), CONTROL]))[:, :, None]


def test_failures_of_the_machine_are_as_if_they_had_never_been_asked():
    # One design, responses of 30 % lost: the posterior is that of the design without those rows.
    space = ParameterSpace({"a": (0, 2), "b": (-1, 1)})
    reference = Reference(CONTROL, {"y": 1 + 0.2 * CONTROL}, measurement_errors={"y": 0.3})
    options = dict(emulator=False, correlation_length=CORRELATION_LENGTH, seed=1)
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
    filter = PosteriorFilter(
        space, reference, first_batch=1000, emulator=False, correlation_length=CORRELATION_LENGTH, discrepancy=False, stop=Stop(max_iterations=1)
    )
    samples = filter.ask()
    impossible = samples.theta[:, 0] > 1
    filter.tell(samples, linear(samples.theta), infeasible=impossible)
    other = PosteriorFilter(
        space, reference, first_batch=1000, emulator=False, correlation_length=CORRELATION_LENGTH, discrepancy=False, stop=Stop(max_iterations=1)
    )
    other.tell(samples, linear(samples.theta))
    # They were asked, so that the evidence counts them.
    zeroed = np.where(impossible, 0, np.exp(other.weighed.log_weights))
    assert filter.log_evidence == pytest.approx(np.log(zeroed.mean()), abs=1e-10)
    assert filter.posterior.weights[impossible].max() == 0


def test_the_limit_that_nobody_sets_follows_from_what_fills_the_ranges():
    space = ParameterSpace({name: (0, 1) for name in "abcde"})
    reference = Reference(np.linspace(0, 1, 5), {"y": np.ones(5)})
    limits = [PosteriorFilter(space, reference, first_batch=first).most_evaluations for first in (None, 10, 20, 21, 68)]
    assert limits == [150, 150, 150, 210, 680]
    assert PosteriorFilter(space, reference, first_batch=68, stop=Stop(max_evaluations=300)).most_evaluations == 300
