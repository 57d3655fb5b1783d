"""Batches that are asked for ahead of the one under way: what they are proposed from, and that no order of ends changes what is found."""

from __future__ import annotations

import heapq

import numpy as np
import pytest

from graincal import InputError
from graincal.inference import PosteriorFilter, Stop
from graincal.inference.sampling.defensive import DefensiveMixture
from graincal.inference.sampling.proposal import ProposalOutsideBox

from .linear_curves import CORRELATION_LENGTH, curves, linear_case
from .test_posterior_direct import EVALUATIONS
from .test_posterior_emulated import A_HUNDRED, BOX, finish, measured, test_curves

TRUTH = np.array([0.6, 0.4, 0.7, 0.3])


def test_a_linear_model_has_its_gaussian_posterior_by_the_emulator():
    # The tolerances of a filter that waits.
    case = linear_case(0.05)
    filter = finish(PosteriorFilter(case.space, case.reference, ahead=1, correlation_length=CORRELATION_LENGTH, discrepancy=False, stop=A_HUNDRED), curves)
    assert len(filter.evaluations) <= 100
    assert np.all(np.abs(filter.posterior.mean() - case.mean) <= 0.25 * case.deviation)
    ratio = filter.posterior.std() / case.deviation
    assert 0.8 <= ratio.min() and ratio.max() <= 1.25
    assert filter.log_evidence == pytest.approx(case.log_evidence, abs=0.5)
    assert np.all(np.abs(filter.emulation.answer - case.mean) <= 0.25 * case.deviation)


@pytest.mark.parametrize("noise", [0.005, 0.2])
def test_a_linear_model_has_its_gaussian_posterior_by_its_own_responses(noise):
    case, batch = linear_case(noise), 2000
    stop = Stop(max_iterations=False, max_evaluations=EVALUATIONS)
    filter = PosteriorFilter(
        case.space, case.reference, emulator=False, ahead=1, first_batch=batch, batch=batch, correlation_length=CORRELATION_LENGTH, discrepancy=False, stop=stop
    )
    # Long where the first parameter is large, so that what is told first is not like the rest.
    while not filter.finished:
        asked = filter.ask()
        some = asked.take(np.argsort(asked.theta[:, 0])[:1500])
        filter.tell(some, curves(some.theta))
    assert len(filter.evaluations) == EVALUATIONS
    posterior, weights = filter.posterior, filter.posterior.weights
    # As for a filter that waits: the delta method (Owen 2013, Eq. 9.9).
    centred = posterior.samples - case.mean
    mean_error = np.sqrt(weights**2 @ centred**2)
    assert np.all(np.abs(posterior.mean() - case.mean) <= 4 * mean_error)
    products = centred[:, :, None] * centred[:, None, :]
    found = np.tensordot(weights, products, axes=1)
    assert np.all(np.abs(found - case.covariance) <= 4 * np.sqrt(np.tensordot(weights**2, (products - case.covariance) ** 2, axes=1)))
    assert np.all(mean_error < 0.05 * case.deviation)
    assert filter.log_evidence == pytest.approx(case.log_evidence, abs=0.05)


@pytest.fixture(scope="module")
def fewer_draws():
    """As many draws from the emulated posterior as facts of bits and counts need."""
    with pytest.MonkeyPatch.context() as patch:
        for name, number in {"PARTICLES": 64, "DRAWS": 128, "EFFECTIVE": 50}.items():
            patch.setattr(f"graincal.inference.sampling.explore.{name}", number)
        yield


@pytest.fixture(scope="module")
def expected(fewer_draws):
    return in_turn(new_filter(), test_curves)


def new_filter(**options):
    return PosteriorFilter(
        BOX, measured(TRUTH), **{"ahead": 1, "seed": 5, "stop": Stop(max_iterations=4, posterior_shift=False), "correlation_length": 0.05} | options
    )


def assert_same_bits(one, other):
    np.testing.assert_array_equal(one.evaluations.theta, other.evaluations.theta)
    np.testing.assert_array_equal(one.evaluations.proposal, other.evaluations.proposal)
    np.testing.assert_array_equal(one.posterior.samples, other.posterior.samples)
    np.testing.assert_array_equal(one.posterior.weights, other.posterior.weights)
    assert one.log_evidence == other.log_evidence and one.stopped_because == other.stopped_because


def in_turn(filter, model):
    """As a single worker would: the earliest sample, one after the other."""
    while not filter.finished:
        sample = filter.ask().take([0])
        filter.tell(sample, model(sample.theta))
    return filter


def on_workers(filter, model, seconds, workers):
    """By so many workers that run as long as `seconds` of theta says, on a clock that is only counted: told at each end."""
    running, now, begun = [], 0.0, set()
    while not filter.finished:
        for row, (id, theta) in enumerate(zip(filter.ask().ids, filter.ask().theta)):
            if len(running) < workers and id not in begun:
                begun.add(id)
                heapq.heappush(running, (now + seconds(theta), id))
        now, id = heapq.heappop(running)
        sample = filter.ask().take(filter.ask().ids == id)
        filter.tell(sample, model(sample.theta))
    return filter


def test_any_order_of_telling_gives_the_same_bits(expected):
    assert [len(iteration.samples) for iteration in expected.iterations] == [16, 8, 8, 8, 3]
    for seed in range(2):
        rng, filter = np.random.default_rng(seed), new_filter()
        while not filter.finished:
            asked = filter.ask()
            some = asked.take(rng.permutation(len(asked))[: rng.integers(1, 8)])
            filter.tell(some, test_curves(some.theta))
        assert_same_bits(filter, expected)


def test_a_fast_run_is_no_better_a_sample(expected):
    # Fifty times as long at one end of the range as at the other, either way round, on few workers and on more than there are samples.
    for workers, sign in ((3, 1), (40, -1)):
        assert_same_bits(on_workers(new_filter(), test_curves, lambda theta: 50 ** (sign * theta[0]), workers), expected)


def test_a_batch_is_proposed_from_those_before_the_one_under_way(fewer_draws):
    filter = new_filter()
    first, second = filter.under_way
    assert [len(first), len(second), len(filter.ask())] == [16, 8, 24] and list(filter.ask().ids) == list(range(24))
    # The later one by itself brings nothing: it waits for the earlier.
    filter.tell(second, test_curves(second.theta))
    assert filter.iterations == () and filter.posterior is None
    np.testing.assert_array_equal(filter.ask().ids, first.ids)
    filter.tell(first, test_curves(first.theta))
    assert len(filter.iterations) == 2 and [batch.ids[0] for batch in filter.under_way] == [24, 32]

    # What becomes of the second does not reach the third, which was asked for before.
    one, other = new_filter(), new_filter()
    for filter, failed in ((one, False), (other, True)):
        filter.tell(first, test_curves(first.theta))
        third = filter.under_way[1]
        filter.tell(second, test_curves(second.theta), failed=np.full(8, failed))
        np.testing.assert_array_equal(third.theta, filter.under_way[0].theta)
    np.testing.assert_array_equal(one.under_way[0].theta, other.under_way[0].theta)
    assert not np.array_equal(one.under_way[1].theta, other.under_way[1].theta)


def test_a_sample_has_the_density_of_the_batch_that_it_was_drawn_from(expected):
    found = expected.evaluations
    # Of the first two nothing was known: both are of the prior, whose density on the unit box is 1. One of each later batch was chosen.
    assert list(found.proposal) == [0] * 16 + [1] * 8 + ([2] * 7 + [-1]) + ([3] * 7 + [-1]) + [-1] * 3
    assert all(np.all(found.proposals[k].log_density(found.theta) == 0) for k in (0, 1))
    assert all(np.ptp(found.proposals[k].log_density(found.theta)) > 1 for k in (2, 3))


@pytest.mark.parametrize("stop, sizes", [(Stop(max_iterations=1), [16, 3]), (Stop(max_iterations=3, posterior_shift=False), [16, 8, 8, 3]),
                                         (Stop(max_evaluations=35, posterior_shift=False), [16, 8, 8, 3]), (Stop(max_evaluations=34, posterior_shift=False), [16, 8, 3])])  # fmt: skip
def test_limits_count_what_is_asked_for(stop, sizes, fewer_draws):
    filter = new_filter(stop=stop)
    finish(filter, test_curves)
    assert [len(iteration.samples) for iteration in filter.iterations] == sizes
    assert filter.stopped_by == ("max_iterations" if stop.max_evaluations is False else "max_evaluations")


def test_once_settled_it_waits_for_what_was_asked_and_runs_the_answer(fewer_draws):
    filter = in_turn(new_filter(stop=Stop(max_iterations=False, max_evaluations=160)), test_curves)
    assert filter.stopped_by == "posterior_shift"
    # It settled with the batch before the last; the last had been asked for, and is used.
    assert len(filter.iterations[-3].samples) == 20 and 0.5 <= filter.confirmed <= 3
    answer = filter.found[-2].answer
    np.testing.assert_allclose(filter.iterations[-1].samples.theta, np.tile(answer, (3, 1)), atol=1e-5)
    assert filter.evaluations.proposal[-11:-3].max() > 0


def test_a_first_batch_without_responses_leaves_it_to_the_second(fewer_draws):
    filter = new_filter()
    first, second = filter.under_way
    filter.tell(first, test_curves(first.theta), failed=np.ones(16, dtype=bool))
    assert not filter.finished and len(filter.under_way) == 1
    filter.tell(second, test_curves(second.theta))
    # As many as may be under way again.
    assert len(filter.under_way) == 2 and not np.array_equal(*(batch.theta for batch in filter.under_way))
    finish(filter, test_curves)
    assert filter.stopped_by == "max_iterations"

    filter = finish(new_filter(), test_curves, failed=lambda theta: np.ones(len(theta), dtype=bool))
    assert filter.stopped_by == "failures" and filter.posterior is None and len(filter.evaluations) == 24


def test_where_no_proposal_lies_in_the_box_it_waits_and_ends_in_words(monkeypatch, fewer_draws):
    filter = new_filter()
    first, second = filter.under_way

    def outside(*_):
        raise ProposalOutsideBox("only 1e-9 of the proposal's mass lies within the parameters' ranges")

    monkeypatch.setattr(DefensiveMixture, "draw", outside)
    filter.tell(first, test_curves(first.theta))
    assert not filter.finished and filter.stopped_by is None and len(filter.ask()) == 8
    filter.tell(second, test_curves(second.theta))
    assert filter.finished and filter.stopped_by == "proposal" and len(filter.evaluations) == 24


def test_what_is_told_wrongly_changes_nothing(fewer_draws):
    filter = new_filter()
    asked = filter.ask()
    both = asked.take([15, 16])
    for samples, failed, words in ((both, [True], "failed must have one entry"), (asked.take([16, 16]), None, "sample 16 is given twice")):
        with pytest.raises(InputError, match=words):
            filter.tell(samples, test_curves(samples.theta), failed)
    assert len(filter.ask()) == 24
    filter.tell(both, test_curves(both.theta))
    with pytest.raises(InputError, match="sample 15 has already been told"):
        filter.tell(both, test_curves(both.theta))


@pytest.mark.parametrize("ahead", [-1, True, 1.0, "1"])
def test_ahead_is_a_number_of_batches(ahead):
    with pytest.raises(InputError, match="filter.ahead must be a whole number, not negative, not "):
        new_filter(ahead=ahead)
