"""Predictions by a posterior, of tests that it was not calibrated against."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from graincal import InputError, MeasurementError, Reference, calibrate, predict
from graincal.data import Failure, Response
from graincal.inference import Stop

from .as_tasks import model_of
from .hyperbola import SPACE, STRAIN, TRUTH, model, reference, respond

LACK = np.sqrt(0.25 * 0.01**2 + 0.5 * 0.02**2 + 0.25 * 0.04**2)
"""Of the peak: the standard deviation of what a model cannot reproduce of a measured test."""


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


def test_the_band_of_what_would_be_measured_is_the_one_that_the_score_looks_at(result):
    prediction = predict(result, model(), STRAIN, samples=10, workers=1)
    errors = {"stress_ratio": MeasurementError(absolute=0.05), "volumetric_strain": MeasurementError(relative=0.1)}
    held_out = Reference(STRAIN, reference().observables, measurement_errors=errors)
    found = prediction.against(held_out)
    for name, values in held_out.observables.items():
        low, high = prediction.measured_as(held_out).measured_interval(name)
        assert found.coverage[name] == np.mean((low <= values) & (values <= high))
    # At the start, where no response differs from another, the band is that of the error alone.
    (low, high), error = prediction.measured_as(held_out).measured_interval("stress_ratio"), np.hypot(0.05, LACK * prediction.mean("stress_ratio").max())
    assert (high - low)[0] == pytest.approx(2 * norm.ppf(0.95) * error, rel=1e-6) and np.all(high - low > np.ptp(prediction.interval("stress_ratio"), axis=0))


def test_what_a_band_holds_is_said(result):
    prediction = predict(result, model(), STRAIN, samples=10, workers=1)
    names = tuple(prediction.values)
    assert prediction.with_errors == reference().names
    assert "a measurement error of about 1 % of the peak of stress ratio" in prediction.band_in_words(names)
    stated = Reference(STRAIN, {"stress_ratio": reference().observables["stress_ratio"]}, measurement_errors={"stress_ratio": 0.05}, simulated=True)
    said = prediction.measured_as(stated).band_in_words(("stress_ratio", "volumetric_strain"))
    assert said == (
        "The band holds 90 % of what a test would measure, state by state: the responses of 10 parameter sets drawn from the posterior, with the measurement errors that are stated. "
        "No error is stated of volumetric strain: the band there holds 90 % of the responses alone."
    )
    np.testing.assert_array_equal(prediction.measured_as(stated).measured_interval("volumetric_strain"), prediction.interval("volumetric_strain"))
