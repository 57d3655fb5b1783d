"""Runs that are stopped early: what their first states bound, what is learnt from them, and that the posterior is what it was."""

from __future__ import annotations

import numpy as np
import pytest

from graincal import Reference
from graincal.inference import PosteriorFilter, Stop
from graincal.inference.emulator.emulator import Emulator
from graincal.inference.likelihood.early_stop import MOST_DROPPED, EarlyStop, FirstStates, segments
from graincal.inference.likelihood.error_model import error_model
from graincal.inference.likelihood.likelihood import log_likelihood, marginal
from graincal.inference.likelihood.reduction import Reduction, columns
from graincal.inference.likelihood.thinning import Thinning

from .linear_curves import CORRELATION_LENGTH, curves, linear_case
from .test_posterior_emulated import BOX, measured, test_curves

pytestmark = pytest.mark.usefixtures("fewer_draws")

TRUTH = np.array([0.6, 0.4, 0.7, 0.3])
FORTY = Stop(posterior_shift=False, max_iterations=False, max_evaluations=43)


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
    errors = error_model(reference, discrepancy=False)
    response = test_curves(TRUTH + 0.02)
    exact = marginal(log_likelihood(response, reference, errors), errors.log_prior)
    assert first_states(reference, errors).bound(response[0]) == pytest.approx(exact[0], rel=1e-9)


@pytest.mark.parametrize("states", [1, 7, 25])
def test_first_states_allow_what_a_perfect_rest_would_have(states):
    # The response that is the most probable, given its first states, goes on as the errors of those lead one to expect.
    reference = measured(TRUTH)
    errors = error_model(reference, correlation_length=0.3, discrepancy=False)
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
    errors = error_model(reference, discrepancy=False)
    response = test_curves(TRUTH + 0.1)[0]
    exact, scattering = first_states(reference, errors), first_states(reference, errors, simulator=0.01 * np.ones(2 * response.size // 2))
    bounds = [exact.bound(response[:t]) for t in range(len(response) + 1)]
    assert bounds[0] == exact.largest and np.all(np.diff(bounds) <= 0)
    assert all(scattering.bound(response[:t]) > bound for t, bound in list(enumerate(bounds))[1:])


def test_only_samples_with_a_limit_are_ever_hopeless():
    reference = measured(TRUTH)
    states = first_states(reference, error_model(reference, discrepancy=False))
    far, near = test_curves(1 - TRUTH)[0], reference.values
    # In the second experiment a sample may fit perfectly, whatever it did in the first.
    early_stop = EarlyStop((states, states), {4: 2 * states.largest - 50.0}, (Thinning.of(reference),) * 2)
    assert early_stop.hopeless(0, 4, far) and early_stop.hopeless(1, 4, far)
    # It is seen from the end of the first of four segments on.
    assert [count for count in range(1, 41) if early_stop.hopeless(0, 4, far[:count])] == list(range(10, 41))
    assert not early_stop.hopeless(0, 4, near) and not early_stop.hopeless(0, 5, far)
    assert not early_stop.hopeless(0, 4, np.full_like(far, np.nan))


def test_first_states_are_learnt_from():
    # Whole responses at points of the box, and the first halves of others: what is emulated of first halves is the nearer for them, and the rest about as near.
    rng = np.random.default_rng(2)
    unit, others, points = rng.random((30, 4)), rng.random((40, 4)), rng.random((200, 4))
    begun = test_curves(others)
    begun[:, 20:] = np.nan
    exact, errors = test_curves(points), []
    for more in (None, (others, begun)):
        emulator = Emulator(unit, test_curves(unit), measured(TRUTH), begun=more)
        found = emulator.curves(emulator.predict(points)[0], 2)
        errors.append([np.sqrt(np.mean((found - exact)[:, part] ** 2, axis=(0, 1))) for part in (slice(20), slice(20, 40))])
    (ratio, volume), rest = errors[1][0] / errors[0][0], errors[1][1] / errors[0][1]
    assert ratio < 0.75 and volume < 1 and np.all(rest < 1.2)
    # How well it predicts is judged by those that were run to their end.
    assert emulator.held_out().error.shape == (30,)


def test_one_segment_gives_principal_components():
    curves = np.random.default_rng(1).standard_normal((12, 5)) @ np.random.default_rng(2).standard_normal((5, 40))
    curves -= curves.mean(axis=0)
    reduction = Reduction(curves, np.zeros(40, dtype=np.int64))
    _, sizes, right = np.linalg.svd(curves, full_matrices=False)
    assert reduction.scores.shape == (12, 5)
    np.testing.assert_allclose(np.abs(reduction.basis.T), np.abs(right[:5] * sizes[:5, None]) / np.sqrt(12))
    np.testing.assert_allclose(reduction.scores @ reduction.basis.T, curves, atol=1e-10)


def test_first_segments_have_the_scores_of_the_whole_curve():
    whole = columns(test_curves(np.random.default_rng(1).random((60, 4)))) / 3
    middle = whole[:30].mean(axis=0)
    reduction = Reduction(whole[:30] - middle, np.tile(segments(40), 2))
    np.testing.assert_allclose(reduction.scores.T @ reduction.scores / 30, np.eye(reduction.scores.shape[1]), atol=1e-9)
    np.testing.assert_allclose(reduction.of_first_segments(whole[:30] - middle), reduction.scores, atol=1e-8)
    assert reduction.left_out.mean() < 1e-4 * whole.var()
    # Of others, too; and they say of their first states whatever there is to say.
    exact = reduction.of_first_segments(whole[30:] - middle)
    for states in (10, 15, 20, 30):
        begun = np.where(np.tile(np.arange(40) < states, 2), whole[30:] - middle, np.nan)
        found = reduction.of_first_segments(begun)
        known = np.isfinite(found).all(axis=0)
        # Those on which the whole segments depend, and no other.
        np.testing.assert_array_equal(known, np.abs(reduction.basis[np.tile(np.arange(40) < 10 * (states // 10), 2)]).max(axis=0) > 0)
        np.testing.assert_array_equal(found[:, known], exact[:, known])
        assert np.isnan(found[:, ~known]).all()


def test_a_linear_model_keeps_its_gaussian_posterior():
    case = linear_case(0.05)
    filter = PosteriorFilter(case.space, case.reference, correlation_length=CORRELATION_LENGTH, stop=FORTY, early_stop=True)
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
    filter = PosteriorFilter(
        BOX, reference, correlation_length=0.001, stop=Stop(posterior_shift=False, max_iterations=False, max_evaluations=63), early_stop=True
    )
    run(filter, test_curves)
    stopped = filter.evaluations.stopped
    assert stopped.sum() > 5
    errors = error_model(reference, correlation_length=0.001, discrepancy=False)
    logs = marginal(log_likelihood(test_curves(filter.evaluations.theta), reference, errors), errors.log_prior)
    log_weights = filter.evaluations.log_weights(logs, np.full(len(logs), True))
    drawn = np.sum(filter.evaluations.proposal >= 0)
    held = np.exp(log_weights[stopped] - filter.log_evidence).sum() / drawn
    assert held <= filter.emulation.dropped < MOST_DROPPED


def test_the_first_batch_the_answer_and_its_runs_are_never_stopped():
    filter = PosteriorFilter(BOX, measured(TRUTH), correlation_length=0.001, stop=Stop(posterior_shift=False, max_iterations=4), early_stop=True)
    run(filter, test_curves)
    stopped = [iteration.stopped for iteration in filter.iterations]
    assert not stopped[0].any() and not any(each[-1] for each in stopped) and not stopped[-1].any()
    assert any(each.any() for each in stopped)
    for iteration in filter.iterations:
        assert np.isfinite(iteration.errors).all() and not iteration.failed.any()
        assert np.all(iteration.final_weights[iteration.stopped] == 0)
        assert iteration.smallest_error == iteration.errors[iteration.complete].min()


def test_nothing_is_stopped_unless_that_is_asked_for():
    filter = PosteriorFilter(BOX, measured(TRUTH), correlation_length=0.001, stop=Stop(posterior_shift=False, max_iterations=3))
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
