"""A first look by a cheaper model: it saves evaluations, and where it is wrong it does not mislead."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import qmc

from graincal import InputError
from graincal.inference import PosteriorFilter, Stop
from graincal.inference.emulator.emulator import Emulator
from graincal.inference.posterior.first_look import FirstLook

from .linear_curves import CORRELATION_LENGTH, curves, linear_case
from .test_posterior_emulated import BOX, finish, measured, test_curves

test_curves.__test__ = False

TRUTH = np.array([0.4, 0.6, 0.5, 0.3])


def cheap_curves(theta):
    """Off by a tenth: weaker, and the more so the more it dilates."""
    off = 1 - 0.1 * (0.5 + np.atleast_2d(theta)[:, 3:4, None])
    return off * test_curves(theta)


def look(model, count=100):
    theta = BOX.from_unit(qmc.Halton(BOX.size, seed=5).random(count))
    return FirstLook(theta, (model(theta),))


def test_responses_are_predicted_better_with_it():
    reference, rng = measured(TRUTH), np.random.default_rng(1)
    unit, new = rng.random((20, BOX.size)), rng.random((200, BOX.size))
    first = look(cheap_curves)
    cheap = Emulator(BOX.to_unit(first.theta), first.responses[0], reference)
    errors = []
    for cheaper in (None, cheap):
        emulator = Emulator(unit, test_curves(unit), reference, cheaper=cheaper)
        mean, _ = emulator.predict(new)
        errors.append(np.sqrt(np.mean((emulator.curves(mean, 2) - test_curves(new)) ** 2, axis=(0, 1))))
    assert np.all(errors[1] < 0.5 * errors[0])


def test_a_joint_draw_has_the_mean_and_the_variance_that_are_predicted():
    first, rng = look(cheap_curves, 40), np.random.default_rng(2)
    reference, unit = measured(TRUTH), rng.random((15, BOX.size))
    emulator = Emulator(unit, test_curves(unit), reference, cheaper=Emulator(BOX.to_unit(first.theta), first.responses[0], reference))
    points = rng.random((6, BOX.size))
    mean, variance = emulator.predict(points)
    drawn = emulator.draw(points, 4000, rng)
    assert drawn.shape == (4000, *mean.shape) and mean.shape[1] == emulator.basis.shape[1]
    # Four standard errors of a mean and of a variance of 4,000 draws.
    assert np.all(np.abs(drawn.mean(axis=0) - mean) <= 4 * np.sqrt(variance / 4000) + 1e-9)
    assert np.all(np.abs(drawn.var(axis=0) - variance) <= 4 * variance * np.sqrt(2 / 4000) + 1e-9)


def test_the_first_batch_is_drawn_where_it_fits():
    spread = []
    for first in (None, look(cheap_curves)):
        filter = PosteriorFilter(BOX, measured(TRUTH), first_look=first, first_batch=200, seed=2)
        spread.append(np.sqrt(np.mean((BOX.to_unit(filter.ask().theta) - TRUTH) ** 2, axis=0)))
    # Of the prior and of where the first look fits, a tenth and more of it wide: stiffness and strength are what the curves tell best.
    assert np.all(spread[1][:2] < 0.75 * spread[0][:2])


@pytest.mark.parametrize("shift", [0.0, 0.15])
def test_the_posterior_is_that_of_the_model_itself(shift):
    case = linear_case(0.05)
    theta = case.space.from_unit(qmc.Halton(case.space.size, seed=3).random(60))
    # One model that is cheap but right, and one whose parameters mean something else.
    first = FirstLook(theta, (curves(theta + shift * (case.space.high - case.space.low)),))
    stop = Stop(posterior_shift=False, max_iterations=False, max_evaluations=60)
    filter = finish(PosteriorFilter(case.space, case.reference, correlation_length=CORRELATION_LENGTH, first_look=first, stop=stop), curves)
    assert np.all(np.abs(filter.posterior.mean() - case.mean) <= 0.25 * case.deviation)
    ratio = filter.posterior.std() / case.deviation
    assert 0.8 <= ratio.min() and ratio.max() <= 1.25
    assert filter.log_evidence == pytest.approx(case.log_evidence, abs=0.5)
    # Of differences that are nothing but roundings no emulator predicts more than their mean: what counts is the response.
    assert filter.emulation.predicts


def test_it_has_to_be_of_the_same_parameters_and_references():
    first = look(cheap_curves, 10)
    for wrong, said in (
        (FirstLook(first.theta[:, :3], first.responses), "the same parameters"),
        (FirstLook(first.theta, (first.responses[0][:, :-1],)), "the same parameters, experiments and observables as the calibration, at the states"),
        (FirstLook(first.theta + 5, first.responses), "at least two evaluations within the parameters' ranges, and it has 0"),
    ):
        with pytest.raises(InputError, match=said):
            PosteriorFilter(BOX, measured(TRUTH), first_look=wrong)
