"""The runs that fit about as well: by their own likelihoods, against what is known in closed form."""

from dataclasses import replace

import numpy as np
import pytest

import graincal as gc
from graincal.inference.driving.evaluations import Evaluations
from graincal.inference.likelihood.error_model import error_model
from graincal.inference.likelihood.thinning import Thinning
from graincal.inference.posterior.likely_runs import likely_runs

SPACE = gc.ParameterSpace({"a": (-10, 10), "b": (-10, 10)})
# Two curves of one state each, which are the parameters themselves, known to one unit: the log likelihood is minus half the squared distance from the origin, and a constant.
REFERENCE = gc.Reference(np.array([1.0]), {"x": np.zeros(1), "y": np.zeros(1)}, measurement_errors={"x": 1.0, "y": 1.0})
ERRORS = error_model(Thinning.of(REFERENCE), correlation_length=None, discrepancy=False)


def evaluated(theta, responses=None):
    """Runs at theta (N, 2), all with responses."""
    theta = np.asarray(theta, dtype=float)
    nothing = np.zeros(len(theta), dtype=bool)
    responses = (theta if responses is None else np.asarray(responses, dtype=float))[:, None, :]
    return Evaluations(SPACE, theta, (responses,), np.full(len(theta), -1), nothing, nothing, nothing)


def likely(evaluations, at_answer=0):
    return likely_runs(evaluations, [REFERENCE], [ERRORS], at_answer)


def test_without_scatter_they_are_those_that_a_gaussian_posterior_holds():
    # Of two parameters the log likelihood of posterior samples has a standard deviation of 1, and so runs up to a distance of 2 count: half its square is 2.
    line = np.linspace(0, 5, 101)
    fits = likely(evaluated(np.column_stack([line, 0 * line])))
    assert fits.high == pytest.approx((2.0, 0.0)) and fits.low == (0.0, 0.0) and fits.count == 41 and fits.enough and fits.repeated == 0
    # Over draws from that posterior the standard deviation is what it is said to be.
    draws = np.random.default_rng(1).standard_normal((100_000, 2))
    assert np.std(-0.5 * np.sum(draws**2, axis=1)) == pytest.approx(np.sqrt(2 / 2), rel=0.02)


def test_runs_at_the_answer_say_how_well_others_have_to_fit():
    line = np.linspace(0, 5, 101)
    theta = np.concatenate([np.column_stack([line, 0 * line]), np.zeros((3, 2))])
    # Log likelihoods of 0, -2 and -4 there, but for a constant: a median of -2 and a deviation of 2.
    responses = np.concatenate([theta[:-3], np.sqrt(2 * np.array([[0, 0], [2, 0], [4, 0]]))])
    fits = likely(evaluated(theta, responses), at_answer=3)
    assert fits.repeated == 3 and fits.high[0] == pytest.approx(np.sqrt(12), abs=0.05) and fits.high[0] <= np.sqrt(12)
    assert fits.deviation == pytest.approx(2.0) and not fits.scattered
    # Four times as far apart, one run by itself tells little: the deviation is eight times that of a posterior.
    apart = np.concatenate([theta[:-3], np.sqrt(2 * np.array([[0, 0], [8, 0], [16, 0]]))])
    far = likely(evaluated(theta, apart), at_answer=3)
    assert far.deviation == pytest.approx(8.0) and far.scattered
    # Runs there that are alike tell nothing of it, nor does a single one; and runs there count though they fit worse.
    alike = np.concatenate([theta[:-3], np.full((3, 2), 3.0) + 1e-6 * np.arange(3)[:, None]])
    there = likely(evaluated(alike, alike), at_answer=3)
    assert there.repeated == 0 and there.high == pytest.approx((3.0, 3.0), abs=1e-5) and there.count == 41 + 3
    failed = replace(evaluated(theta, responses), missing=np.arange(len(theta)) >= len(theta) - 2)
    assert likely(failed, at_answer=3).repeated == 0


def test_few_outline_no_range_and_failures_none():
    fits = likely(evaluated([[0, 0], [1, 0], [9, 9]]))
    assert fits.count == 2 and not fits.enough
    lost = evaluated([[0, 0], [1, 0]])
    assert likely(replace(lost, infeasible=np.ones(2, dtype=bool))) is None
    # A run that was stopped has no whole response.
    assert likely(replace(lost, stopped=np.array([False, True]))).count == 1


def test_experiments_add_up():
    line = np.linspace(0, 5, 101)
    once = evaluated(np.column_stack([line, 0 * line]))
    twice = likely_runs(replace(once, responses=once.responses * 2), [REFERENCE] * 2, [ERRORS] * 2)
    # Twice the information: distances shrink by the root of two.
    assert twice.high[0] == pytest.approx(np.sqrt(2), abs=0.05)


def test_one_run_at_the_answer_that_is_far_off_does_not_make_every_run_fit():
    line = np.linspace(0, 5, 101)
    theta = np.concatenate([np.column_stack([line, 0 * line]), np.zeros((3, 2))])
    # Log likelihoods of -0.9, -1 and -200 there, but for a constant: a median of -1, and for two parameters a deviation of at least 1.
    responses = np.concatenate([theta[:-3], np.sqrt(2 * np.array([[0.9, 0], [1, 0], [200, 0]]))])
    fits = likely(evaluated(theta, responses), at_answer=3)
    assert fits.repeated == 3 and fits.high[0] == pytest.approx(np.sqrt(6), abs=0.05) and fits.high[0] <= np.sqrt(6)
