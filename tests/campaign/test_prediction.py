"""Predictions by a posterior, of tests that it was not calibrated against."""

from __future__ import annotations

import numpy as np
import pytest

from graincal import InputError, Reference, calibrate, predict
from graincal.data import Failure, Response
from graincal.inference import Stop

from .as_tasks import model_of
from .hyperbola import SPACE, STRAIN, TRUTH, model, reference, respond


@pytest.fixture(scope="module")
def result():
    return calibrate(model(), reference(), SPACE, method="iterative-bayesian", seed=1, workers=1, stop=Stop(max_iterations=4))


def test_the_mean_of_a_prediction_is_near_the_truth(result):
    prediction = predict(result, model(), STRAIN, samples=20, workers=1)
    expected = respond(TRUTH)
    for name, values in prediction.values.items():
        assert values.shape == (20, len(STRAIN))
        low, high = prediction.interval(name)
        assert np.all(low <= high)
        # The posterior of a fourth iteration is narrow about the truth: within a tenth of the observable's peak.
        assert np.abs(prediction.mean(name) - expected[name]).max() < 0.1 * np.abs(expected[name]).max()
    found = prediction.against(reference())
    assert set(found.coverage) == set(reference().names) and found.error < 10


def test_draws_follow_the_seed(result):
    first, again, other = (predict(result, model(), STRAIN, samples=10, seed=seed, workers=1) for seed in (3, 3, 4))
    np.testing.assert_array_equal(first.theta, again.theta)
    assert not np.array_equal(first.theta, other.theta)


def test_failures_are_left_out_and_counted(result):
    # Every second evaluation has no response.
    half_fails = model_of(lambda samples, at: Failure("diverged", "It blew up.") if samples.ids[0] % 2 else Response(at, respond(samples.theta[0])))
    prediction = predict(result, half_fails, STRAIN, samples=10, workers=1)
    assert len(prediction.failures) == 5 and len(prediction.theta) == 5


def test_what_cannot_be_predicted_is_said(result):
    with pytest.raises(InputError, match="none of the 4 .* It blew up"):
        predict(result, model_of(lambda *_: Failure("diverged", "It blew up.")), STRAIN, samples=4, workers=1)
    with pytest.raises(InputError, match="at least two"):
        predict(result, model(), STRAIN, samples=1)
    elsewhere = Reference(STRAIN[1:], {name: values[1:] for name, values in reference().observables.items()})
    with pytest.raises(InputError, match="own axial_strain"):
        predict(result, model(), STRAIN, samples=4, workers=1).against(elsewhere)
