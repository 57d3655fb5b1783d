"""A Gaussian process of one number, the coordinates it is over, and what may be expected of a likelihood under it, against other ways to the same."""

from __future__ import annotations

from copy import copy

import numpy as np
import pytest
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel

from graincal import Reference
from graincal.inference.emulator.emulator import Emulator
from graincal.inference.emulator.process import JITTER, Kernel, Process
from graincal.inference.emulator.warping import even_powers, warped
from graincal.inference.likelihood.error_model import error_model
from graincal.inference.likelihood.likelihood import ReducedLikelihood


@pytest.fixture(scope="module")
def process():
    rng = np.random.default_rng(0)
    unit = rng.random((30, 2))
    return unit, Process(unit, np.sin(5 * unit[:, 0]) + unit[:, 1] + 0.02 * rng.standard_normal(30))


def test_it_predicts_what_scikit_learn_does(process):
    unit, fitted = process
    variance, lengths, nugget = fitted.kernel
    kernel = ConstantKernel(variance) * Matern(lengths, nu=1.5) + WhiteKernel(nugget)
    peer = GaussianProcessRegressor(kernel, alpha=JITTER, optimizer=None).fit(unit, fitted.values)
    points = np.random.default_rng(1).random((50, 2))
    mean, std = peer.predict(points, return_std=True)
    ours, variance = fitted.predict(points)
    np.testing.assert_allclose(ours, mean, atol=1e-8)
    np.testing.assert_allclose(variance + fitted.nugget, std**2, atol=1e-8)
    # But for the constant that it leaves out.
    constant = 0.5 * len(unit) * np.log(2 * np.pi)
    surprise, slope = fitted.surprise(unit)
    assert -surprise - constant == pytest.approx(peer.log_marginal_likelihood_value_, abs=1e-6)
    step = np.zeros_like(unit)
    step[3, 1] = 1e-5
    assert slope[3, 1] == pytest.approx((fitted.surprise(unit + step)[0] - fitted.surprise(unit - step)[0]) / 2e-5, rel=1e-5)


def test_its_kernel_is_the_most_probable(process):
    unit, fitted = process

    def surprise(kernel):
        # With what kernels are thought to be before there is a value.
        numbers = np.log([kernel.variance, *kernel.lengths, kernel.nugget])
        away = (numbers - np.log([3, 1, 1, 1e-3])) / np.log([10, 3, 3, 30])
        other = copy(fitted)
        other.kernel = kernel
        return other.surprise(unit)[0] + 0.5 * away @ away

    variance, lengths, nugget = fitted.kernel
    for factor in (0.8, 1.25):
        for other in (Kernel(factor * variance, lengths, nugget), Kernel(variance, lengths * [factor, 1], nugget), Kernel(variance, lengths, factor * nugget)):
            assert surprise(other) > surprise(fitted.kernel)


def test_draws_at_several_points_have_its_covariance(process):
    _, fitted = process
    points = np.array([[0.5, 0.5], [0.52, 0.5], [0.9, 0.1]])
    drawn = fitted.drawn(points, np.random.default_rng(2).standard_normal((20000, len(points))))
    variance = fitted.predict(points)[1]
    np.testing.assert_allclose(drawn.var(axis=0), variance, rtol=4 * np.sqrt(2 / 20000))
    # Neighbours move together.
    assert np.corrcoef(drawn[:, 0], drawn[:, 1])[0, 1] > 0.5


def test_a_response_that_is_steep_at_the_lower_end_is_stretched_there_and_predicted_better():
    rng = np.random.default_rng(3)
    unit, new = rng.random((40, 2)), rng.random((500, 2))

    def response(points):
        return np.log(points[:, 0] + 0.02) + 0.3 * points[:, 1]

    plain = Process(unit, response(unit))
    powers = even_powers([plain], unit, np.ones(2))
    assert powers[0] < 0.7
    even = Process(warped(unit, powers), response(unit))
    error = [np.sqrt(np.mean((p.predict(x)[0] - response(new)) ** 2)) for p, x in ((plain, new), (even, warped(new, powers)))]
    assert error[1] < 0.7 * error[0]


def test_runs_that_differ_by_roundings_are_runs_at_one_point():
    apart = warped(np.array([[0.0], [1e-9], [2e-9]]), np.array([0.2]))
    assert np.ptp(apart) == 0


def test_the_log_likelihood_expected_is_that_of_draws():
    rng = np.random.default_rng(4)
    unit, strain = rng.random((12, 2)), np.linspace(0, 0.2, 15)
    responses = (unit[:, :1] * strain / (0.02 + strain) + unit[:, 1:] * strain)[..., None]
    reference = Reference(strain, {"q": responses[0, :, 0] + 0.01}, measurement_errors={"q": 0.02})
    emulator = Emulator(unit, responses, reference)
    mean, variance = emulator.predict(rng.random((4, 2)))
    variance = variance + 0.05
    for length in (0.1, None):
        errors = error_model(reference, correlation_length=length)
        likelihood = ReducedLikelihood.of(reference, errors, emulator.centre, emulator.basis, np.diag(emulator.truncation))
        draws = mean + np.sqrt(variance) * rng.standard_normal((20000, *mean.shape))
        logs = likelihood(draws.reshape(-1, mean.shape[1]), np.zeros((20000 * len(mean), mean.shape[1]))).reshape(20000, -1)
        error = 4 * logs.std(axis=0) / np.sqrt(20000)
        expected = likelihood.expected(mean, variance)
        # Exactly for one hypothesis, and at most for several.
        assert np.all(expected <= logs.mean(axis=0) + error)
        if errors.size == 1:
            assert np.all(expected >= logs.mean(axis=0) - error)
        assert np.all(expected <= likelihood(mean, variance))
        np.testing.assert_allclose(likelihood.expected(mean, 0 * variance), likelihood(mean, 0 * variance))
