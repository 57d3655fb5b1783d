"""What a test is expected to tell, against closed forms: responses that are linear in parameters whose present posterior is Gaussian."""

import numpy as np
import pytest
from scipy.stats import norm, qmc

from graincal import Reference
from graincal.inference.likelihood.error_model import error_model
from graincal.inference.likelihood.packings import PackingScatter
from graincal.inference.likelihood.packings_elsewhere import packings_elsewhere
from graincal.inference.posterior.gain import expected_gain

from .linear_curves import CONTROL, CORRELATION_LENGTH, DESIGN, curves

MEAN = np.array([1.0, 0.5, -0.3])
FACTOR = np.array([[0.04, 0, 0], [0.02, 0.05, 0], [-0.03, 0.01, 0.06]])
"""Of the present posterior's covariance."""
COVARIANCE = FACTOR @ FACTOR.T
TRUTHS, SAMPLES = 100, 2000


def draws(count, seed):
    """Of the present posterior, spread out."""
    return MEAN + norm.ppf(qmc.Sobol(3, seed=seed).random(count)) @ FACTOR.T


def exact(deviation):
    """Standard deviations (3,) after the test, and the mutual information in nats, for errors of this standard deviation that are alike along the curve."""
    kernel = np.exp(-np.abs(CONTROL[:, None] - CONTROL) / CORRELATION_LENGTH)
    told = DESIGN.T @ np.linalg.solve(deviation**2 * kernel, DESIGN)
    after = np.linalg.inv(np.linalg.inv(COVARIANCE) + told)
    return np.sqrt(np.diag(after)), 0.5 * np.linalg.slogdet(np.eye(3) + COVARIANCE @ told)[1]


def found(deviation, seed=1):
    theta = draws(128, seed)[:TRUTHS]
    responses = curves(theta)
    reference = Reference(CONTROL, {"y": responses.mean(axis=0)[:, 0]}, measurement_errors={"y": deviation})
    errors = error_model(reference, correlation_length=CORRELATION_LENGTH, discrepancy=False)
    return expected_gain(theta, responses, draws(2048, seed + 1)[:SAMPLES], reference, errors, np.random.default_rng(seed))


@pytest.mark.filterwarnings("ignore:The balance properties")
@pytest.mark.parametrize("deviation", [0.3, 0.03, 0.01])
def test_a_linear_test_of_a_gaussian_posterior_tells_what_it_does_exactly(deviation):
    after, information = exact(deviation)
    gain = found(deviation)
    # Its standard error is that of a hundred truths; three of them, and what weights of so many effective samples add to the log of a mean, half of one over their number.
    assert gain.mean_information == pytest.approx(information, abs=3 * gain.information_error + 0.5 / np.median(gain.effective_samples))
    # A standard deviation of n samples about their own mean is too small by 3 / (4 n); that now is known within 1 / sqrt(2 n); what the emulator does not know is a hundredth.
    share = after / np.sqrt(np.diag(COVARIANCE))
    tolerance = 3 * gain.share_errors + share * (0.01 + 0.75 / np.median(gain.effective_samples) + 1 / np.sqrt(2 * SAMPLES))
    assert np.all(np.abs(gain.shares - share) < tolerance)


def test_a_test_that_the_parameters_do_not_matter_to_tells_nothing():
    rng = np.random.default_rng(0)
    theta = draws(64, 1)
    # Runs that scatter, whatever the parameters.
    responses = 1 + 0.01 * rng.standard_normal((64, 1, 1)) * DESIGN[:, 2][None, :, None]
    reference = Reference(CONTROL, {"y": responses.mean(axis=0)[:, 0]}, measurement_errors={"y": 0.01})
    gain = expected_gain(theta, responses, draws(512, 2), reference, error_model(reference, discrepancy=False), rng)
    assert abs(gain.mean_information) < 3 * gain.information_error + 0.02
    assert np.all(gain.shares > 0.97)


def test_packings_differ_in_another_test_by_as_large_a_part_of_its_peaks():
    along = np.linspace(0, 1, 5)
    deviations = np.concatenate([0.02 * 4 * along, 0.05 * 0.1 * along])
    known = Reference(0.2 * (0.01 + along), {"stress_ratio": 1 + 3 * along, "volumetric_strain": 0.1 * along})
    scatter = PackingScatter(np.outer(deviations, deviations), 5.0, 6, 1.0)
    other = Reference(along + 0.1, {"stress_ratio": 1 + along, "pore_pressure": 1e5 * along})
    covariance = packings_elsewhere(scatter, known, along, other, along).covariance
    # At the end: 2 % of a peak of 2, and the root mean square of 2 and 5 % of a peak of 1e5.
    assert np.sqrt(covariance[4, 4]) == pytest.approx(0.02 * 2)
    assert np.sqrt(covariance[9, 9]) == pytest.approx(1e5 * np.sqrt((0.02**2 + 0.05**2) / 2))
    # The observable of both keeps that its states are wholly alike; nothing is known of the other together with it.
    assert covariance[4, 2] == pytest.approx(np.sqrt(covariance[4, 4] * covariance[2, 2]))
    assert np.all(covariance[:5, 5:] == 0)
    assert np.linalg.eigvalsh(covariance).min() > -1e-9 * covariance.max()
