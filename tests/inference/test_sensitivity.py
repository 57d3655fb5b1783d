"""What is said of a posterior under other assumptions, where it is known what that ought to be."""

from __future__ import annotations

import numpy as np
import pytest

from graincal import ParameterSpace, Posterior
from graincal.inference import PosteriorFilter, Stop
from graincal.inference.posterior.sensitivity import evidence_of_half_ranges, under_other_errors

from .linear_curves import CORRELATION_LENGTH, curves, linear_case


def calibrated(reference, space, evaluations, **options):
    filter = PosteriorFilter(space, reference, stop=Stop(posterior_shift=False, max_iterations=False, max_evaluations=evaluations), **options)
    while not filter.finished:
        samples = filter.ask()
        filter.tell(samples, curves(samples.theta))
    return filter


def test_an_evidence_is_sure_where_the_emulator_is_and_not_where_it_is_not():
    case = linear_case(0.05)
    deviations = []
    for evaluations, batch in ((23, 6), (100, 20)):
        filter = calibrated(case.reference, case.space, evaluations, correlation_length=CORRELATION_LENGTH, discrepancy=False, first_batch=6, batch=batch)
        drawn = filter.emulation.doubt.log_evidence
        # Their expectation is the evidence itself: within four standard errors of the mean of the draws, and those of the samples.
        expected = np.log(np.mean(np.exp(drawn - filter.log_evidence)))
        assert abs(expected) <= 4 * drawn.std() / np.sqrt(len(drawn)) + 4 / np.sqrt(400)
        deviations.append(drawn.std())
    assert deviations[1] < 0.5
    assert deviations[1] < deviations[0]


def test_half_the_range_of_n_parameters_is_worth_n_log_two_to_a_narrow_posterior_and_nothing_to_none():
    space = ParameterSpace({"a": (0, 1), "b": (10, 30), "c": (-1, 1)})
    rng = np.random.default_rng(0)
    narrow = Posterior(space.names, space.from_unit(np.clip(0.9 + 0.01 * rng.standard_normal((500, 3)), 0, 1)), np.full(500, 1 / 500))
    assert evidence_of_half_ranges(narrow, space, -3.0) == pytest.approx(-3.0 + 3 * np.log(2))
    prior = Posterior(space.names, space.from_unit(rng.random((20000, 3))), np.full(20000, 1 / 20000))
    # An eighth of the samples lie inside: its log is known within 1 / sqrt(2500).
    assert evidence_of_half_ranges(prior, space, -3.0) == pytest.approx(-3.0, abs=4 / np.sqrt(2500))


def test_without_a_discrepancy_the_posterior_is_that_of_the_errors_alone():
    case = linear_case(0.05)
    options = {"correlation_length": CORRELATION_LENGTH}
    allowed = calibrated(case.reference, case.space, 100, discrepancy=True, batch=20, **options)
    exact = under_other_errors(
        allowed.emulation, case.space, allowed.kept, allowed.knowledge.scatters, allowed.knowledge.errors_if(discrepancy=False), np.random.default_rng(0)
    )
    assert np.all(np.abs(exact.mean() - case.mean) <= 0.25 * case.deviation)
    ratio = exact.std() / case.deviation
    assert 0.8 <= ratio.min() and ratio.max() <= 1.25
    assert np.all(allowed.posterior.std() > exact.std())
