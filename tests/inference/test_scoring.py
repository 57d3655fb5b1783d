"""Scores of predictions, against distributions whose scores are known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import multivariate_normal, norm

from graincal import Reference
from graincal.inference.likelihood.scoring import score

CONTROL = np.linspace(0, 1, 400)


def test_a_band_of_the_right_spread_holds_what_it_says():
    # Responses that do not vary, and a test with errors of 0.1 that vary fast along the curve: 90 % of its states lie within the central 90 %.
    # 400 nearly independent states: four standard errors are 0.06.
    values = 1 + 0.1 * np.random.default_rng(2).standard_normal(len(CONTROL))
    reference = Reference(CONTROL, {"y": values}, measurement_errors={"y": 0.1})
    found = score(np.ones((40, len(CONTROL), 1)), reference)
    assert found.coverage["y"] == pytest.approx(0.9, abs=0.06)


def test_the_true_prediction_has_the_better_log_score():
    reference = Reference(CONTROL, {"y": 1 + CONTROL}, measurement_errors={"y": 0.05})
    scores = []
    for offset in (0.0, 0.05, 0.5):
        responses = (1 + CONTROL + offset)[None, :, None] + 0.02 * np.linspace(-1, 1, 21)[:, None, None]
        scores.append(score(responses, reference).log_score)
    assert scores[0] > scores[1] > scores[2]


def test_the_log_score_is_that_of_the_responses_own_gaussian():
    # Responses that differ along one shape by a Gaussian of sd 0.3, many of them: the reference is a draw of N(1, 0.09 v v^T + errors).
    control = np.linspace(0, 1, 25)
    shape, length = np.sin(3 * control), 0.1
    errors = 0.05**2 * np.exp(-np.abs(control[:, None] - control[None, :]) / length) + (1e-6 * 1.2) ** 2 * np.eye(len(control))
    reference = Reference(control, {"y": 1 + 0.2 * shape}, measurement_errors={"y": 0.05})
    amounts = norm.ppf((np.arange(4000) + 0.5) / 4000)
    found = score((1 + 0.3 * amounts[:, None] * shape)[:, :, None], reference, correlation_length=length, discrepancy=False)
    expected = multivariate_normal(np.ones(len(control)), errors + 0.09 * np.outer(shape, shape)).logpdf(reference.observables["y"])
    assert found.log_score * len(control) == pytest.approx(expected, abs=0.01)


def test_the_log_score_does_not_hang_on_the_luckiest_response():
    # A test of the same kind as the responses, thirty of them with a scatter of three errors along a few shapes: other thirty score it alike.
    control = np.linspace(0, 1, 50)
    shapes = np.array([np.sin(k * np.pi * control) for k in range(1, 8)])

    def responses(seed, count):
        return (1 + 0.06 * np.random.default_rng(seed).standard_normal((count, len(shapes))) @ shapes)[:, :, None]

    reference = Reference(control, {"y": responses(99, 1)[0, :, 0]}, measurement_errors={"y": 0.02})
    scores = [score(responses(seed, 30), reference).log_score * len(control) for seed in range(20)]
    # Seven variances that thirty responses know to a quarter of themselves: half the logarithm of each and its square move by an eighth, and about one in all.
    # By the mean of the responses' own probabilities the standard deviation is 43.
    assert np.std(scores) < 3


def test_a_discrepancy_widens_the_band_and_the_density():
    # Of a shape that no error of the device has, and no response.
    reference = Reference(CONTROL, {"y": 1 + 0.05 * np.sin(6 * CONTROL)}, measurement_errors={"y": 0.01})
    responses = np.ones((5, len(CONTROL), 1)) + 0.001 * np.arange(5)[:, None, None]
    exact, allowing = (score(responses, reference, correlation_length=0.01, discrepancy=allowed) for allowed in (False, True))
    assert exact.coverage["y"] < 0.5 < allowing.coverage["y"] and exact.log_score < allowing.log_score


def test_the_error_of_the_mean_is_that_of_the_paper():
    reference = Reference(CONTROL, {"y": np.full(len(CONTROL), 2.0)})
    assert score(np.full((3, len(CONTROL), 1), 2.1), reference).error == pytest.approx(5.0)
