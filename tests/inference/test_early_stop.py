"""Runs that are stopped early: what their first states bound, what is learnt from them, and that the posterior is what it was."""

from __future__ import annotations

import numpy as np
import pytest

from graincal import Reference
from graincal.inference import PosteriorFilter, Stop
from graincal.inference.early_stop import MOST_DROPPED, EarlyStop, FirstStates
from graincal.inference.emulator import Emulator, _of_first_states
from graincal.inference.error_model import error_model
from graincal.inference.likelihood import columns, log_likelihood, marginal

from .linear_curves import CORRELATION_LENGTH, curves, linear_case
from .test_posterior_emulated import BOX, measured, test_curves

pytestmark = pytest.mark.usefixtures("fewer_draws")

TRUTH = np.array([0.6, 0.4, 0.7, 0.3])
SIXTY = Stop(posterior_shift=False, max_iterations=False, max_evaluations=60)


def first_states(reference, errors, simulator=0.0):
    nothing = np.zeros((reference.values.size, reference.values.size))
    return FirstStates(reference, errors, nothing, nothing + simulator)


def run(filter, model):
    """To the end, each response cut off where the filter says so; the part of the states that was run."""
    states = []
    while not filter.finished:
        samples, (early_stop, *_) = filter.ask(), filter.early_stops
        responses = model(samples.theta).copy()
        stopped = np.zeros(len(samples), dtype=bool)
        for row, id in enumerate(samples.ids):
            total = responses.shape[1]
            reached = next((t for t in range(1, total) if early_stop and early_stop.hopeless(0, int(id), responses[row, :t])), total)
            responses[row, reached:] = np.nan
            stopped[row] = reached < total
            states.append(reached / total)
        filter.tell(samples, responses, stopped=stopped)
    return np.mean(states)


def test_all_states_bound_the_likelihood_by_itself():
    reference = measured(TRUTH)
    errors = error_model(reference)
    response = test_curves(TRUTH + 0.02)
    exact = marginal(log_likelihood(response, reference, errors), errors.log_prior)
    assert first_states(reference, errors).bound(response[0]) == pytest.approx(exact[0], rel=1e-9)


@pytest.mark.parametrize("states", [1, 7, 25])
def test_first_states_allow_what_a_perfect_rest_would_have(states):
    # The response that is the most probable, given its first states, goes on as the errors of those lead one to expect.
    reference = measured(TRUTH)
    errors = error_model(reference, correlation_length=0.3)
    response = test_curves(TRUTH + 0.05)[0]
    covariance, residual = errors.covariances[0], columns(reference.values - response)
    known = np.tile(np.arange(len(response)) < states, response.shape[1])
    residual[~known] = covariance[np.ix_(~known, known)] @ np.linalg.solve(covariance[np.ix_(known, known)], residual[known])
    best = reference.values - residual.reshape(response.T.shape).T
    np.testing.assert_allclose(best[:states], response[:states])
    bound = first_states(reference, errors).bound(response[:states])
    assert bound == pytest.approx(log_likelihood(best[None], reference, errors)[0, 0], rel=1e-9)
    other = best + np.where(known.reshape(response.T.shape).T, 0, 0.01)
    assert bound > log_likelihood(other[None], reference, errors)[0, 0]


def test_more_states_and_less_scatter_bound_more_tightly():
    reference = measured(TRUTH)
    errors = error_model(reference)
    response = test_curves(TRUTH + 0.1)[0]
    exact, scattering = first_states(reference, errors), first_states(reference, errors, simulator=0.01 * np.ones(2 * response.size // 2))
    bounds = [exact.bound(response[:t]) for t in range(len(response) + 1)]
    assert bounds[0] == exact.largest and np.all(np.diff(bounds) <= 0)
    assert all(scattering.bound(response[:t]) > bound for t, bound in list(enumerate(bounds))[1:])


def test_only_samples_with_a_limit_are_ever_hopeless():
    reference = measured(TRUTH)
    states = first_states(reference, error_model(reference))
    far, near = test_curves(1 - TRUTH)[0], reference.values
    # In the second experiment a sample may fit perfectly, whatever it did in the first.
    early_stop = EarlyStop((states, states), {4: 2 * states.largest - 50.0})
    assert early_stop.hopeless(0, 4, far) and early_stop.hopeless(1, 4, far)
    assert not early_stop.hopeless(0, 4, near) and not early_stop.hopeless(0, 5, far)
    assert not early_stop.hopeless(0, 4, np.full_like(far, np.nan))


def test_first_states_tell_of_the_whole_curve_as_much_as_they_can():
    # Whole responses at points of the box, and the first halves of others: the emulator is nearer to the others' whole than without them, within its deviations.
    rng = np.random.default_rng(2)
    unit, others, points = rng.random((30, 4)), rng.random((40, 4)), rng.random((200, 4))
    begun = test_curves(others)
    begun[:, 20:] = np.nan
    reference = measured(TRUTH)
    exact = test_curves(points)
    errors = []
    for more in (None, (others, begun)):
        emulator = Emulator(unit, test_curves(unit), reference, begun=more)
        found = emulator.curves(emulator.predict(points)[0], 2)
        errors.append(np.sqrt(np.mean((found - exact) ** 2, axis=(0, 1))))
    assert np.all(errors[1] < 0.75 * errors[0])
    # Of those that were run to their end nothing is lost.
    assert emulator.held_out().error.shape == (30,)


@pytest.mark.parametrize("width", [1.0, 0.15])
@pytest.mark.parametrize("states", [3, 10, 20, 30])
def test_what_first_states_tell_is_off_by_as_much_as_it_says(width, states):
    # Complete curves from all of the box, or from a part of it about the truth, as after a first look; those that were stopped are from all of it.
    rng = np.random.default_rng(1)
    unit, others = np.clip(TRUTH + width * (2 * rng.random((30, 4)) - 1), 0, 1), rng.random((60, 4))
    peaks = np.repeat(np.abs(test_curves(TRUTH)[0]).max(axis=0), 40)
    whole, stopped = (columns(test_curves(each)) / peaks for each in (unit, others))
    middle = whole.mean(axis=0)
    left, sizes, right = np.linalg.svd(whole - middle, full_matrices=False)
    deviation = sizes[:6] / np.sqrt(30)
    scores, basis = left[:, :6] * sizes[:6] / deviation, right[:6].T * deviation
    left_out = np.mean((whole - middle - scores @ basis.T) ** 2, axis=0)
    begun = np.where(np.tile(np.arange(40) < states, 2), stopped - middle, np.nan)
    found, variances = _of_first_states(begun, whole - middle, scores, basis, left_out)
    off = (found - (stopped - middle) @ right[:6].T / deviation) / np.sqrt(variances)
    assert np.all(np.sqrt(np.mean(off**2, axis=0)) < 1.25) and np.mean(np.abs(off) < 3) > 0.98


def test_a_curve_that_no_other_is_like_counts_for_little():
    rng = np.random.default_rng(2)
    unit, strange = rng.random((30, 4)), np.full((1, 4), 0.5)
    begun = test_curves(strange) + 0.3 * np.sin(40 * np.linspace(0, 1, 40))[None, :, None]
    begun[:, 30:] = np.nan
    reference = measured(TRUTH)
    without, with_it = (Emulator(unit, test_curves(unit), reference, begun=each) for each in (None, (strange, begun)))
    moved = with_it.curves(with_it.predict(strange)[0], 2) - without.curves(without.predict(strange)[0], 2)
    assert np.abs(moved[0, :, 0]).max() < 0.1


def test_a_linear_model_keeps_its_gaussian_posterior():
    case = linear_case(0.05)
    filter = PosteriorFilter(case.space, case.reference, correlation_length=CORRELATION_LENGTH, stop=SIXTY)
    share = run(filter, curves)
    assert share < 1 and filter.evaluations.stopped.any()
    assert np.all(np.abs(filter.posterior.mean() - case.mean) <= 0.25 * case.deviation)
    ratio = filter.posterior.std() / case.deviation
    assert 0.8 <= ratio.min() and ratio.max() <= 1.25
    assert filter.log_evidence == pytest.approx(case.log_evidence, abs=0.5)
    assert 0 < filter.emulation.dropped < MOST_DROPPED


def test_what_is_dropped_is_what_it_would_have_weighed_at_most():
    # Run to their ends, the stopped samples have less of the posterior than was allowed them.
    reference = measured(TRUTH)
    filter = PosteriorFilter(BOX, reference, correlation_length=0.001, stop=SIXTY)
    run(filter, test_curves)
    stopped = filter.evaluations.stopped
    assert stopped.sum() > 5
    errors = error_model(reference, correlation_length=0.001)
    logs = marginal(log_likelihood(test_curves(filter.evaluations.theta), reference, errors), errors.log_prior)
    log_weights = filter.evaluations.log_weights(logs, np.full(len(logs), True))
    drawn = np.sum(filter.evaluations.proposal >= 0)
    held = np.exp(log_weights[stopped] - filter.log_evidence).sum() / drawn
    assert held <= filter.emulation.dropped < MOST_DROPPED


def test_the_first_batch_the_answer_and_its_runs_are_never_stopped():
    filter = PosteriorFilter(BOX, measured(TRUTH), correlation_length=0.001, stop=Stop(posterior_shift=False, max_iterations=4))
    run(filter, test_curves)
    stopped = [iteration.stopped for iteration in filter.iterations]
    assert not stopped[0].any() and not any(each[-1] for each in stopped) and not stopped[-1].any()
    assert any(each.any() for each in stopped)
    for iteration in filter.iterations:
        assert np.isfinite(iteration.errors).all() and not iteration.failed.any()
        assert np.all(iteration.final_weights[iteration.stopped] == 0)
        assert iteration.smallest_error == iteration.errors[iteration.complete].min()


def test_nothing_is_stopped_where_that_is_switched_off():
    filter = PosteriorFilter(BOX, measured(TRUTH), correlation_length=0.001, stop=Stop(posterior_shift=False, max_iterations=3), early_stop=False)
    assert run(filter, test_curves) == 1 and filter.emulation.dropped == 0


def test_a_response_that_ends_without_being_stopped_is_a_failure():
    filter = PosteriorFilter(BOX, measured(TRUTH), stop=Stop(max_iterations=2))
    samples = filter.ask()
    responses = test_curves(samples.theta).copy()
    responses[3, 10:] = np.nan
    filter.tell(samples, responses)
    assert list(np.flatnonzero(filter.iterations[0].failed)) == [3] and not filter.iterations[0].stopped.any()


def test_stopped_runs_of_two_experiments_are_learnt_from():
    # A sample that was stopped in the first is not run in the second; one that was stopped in the second has the whole of the first.
    first = measured(TRUTH)
    reference = Reference(first.control, dict(first.observables), measurement_errors=dict(first.measurement_errors))
    filter = PosteriorFilter(BOX, [reference, reference], correlation_length=0.001, stop=Stop(posterior_shift=False, max_iterations=2))
    samples = filter.ask()
    filter.tell(samples, [test_curves(samples.theta)] * 2)
    samples = filter.ask()
    responses = [test_curves(samples.theta), test_curves(samples.theta)]
    responses[0][0, 10:], responses[1][0] = np.nan, np.nan
    responses[1][1, 20:] = np.nan
    filter.tell(samples, responses, stopped=np.arange(len(samples)) < 2)
    assert not filter.iterations[1].failed.any() and np.isfinite(filter.iterations[1].errors).all()
    whole, begun = filter.evaluations.known(0)
    assert whole[-len(samples) :].sum() == len(samples) - 1 and begun.sum() == 1
    whole, begun = filter.evaluations.known(1)
    assert whole[-len(samples) :].sum() == len(samples) - 2 and begun.sum() == 1
