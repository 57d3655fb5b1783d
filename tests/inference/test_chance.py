"""How probable a failure is, and what a posterior makes of it: it is cut where parameters are infeasible, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest

from graincal.inference import PosteriorFilter, Stop
from graincal.inference.emulator.chance import OF_FAILURES, OF_IMPOSSIBLE, Chance, chance

from .linear_curves import CORRELATION_LENGTH, curves, linear_case

pytestmark = pytest.mark.usefixtures("fewer_draws")


def test_it_is_known_on_both_sides_of_a_boundary_and_nothing_is_certain():
    rng = np.random.default_rng(0)
    unit, others = rng.random((200, 4)), rng.random((2000, 4))
    fails = unit[:, 0] + 0.5 * unit[:, 1] > 1
    found = Chance(unit, fails, OF_IMPOSSIBLE)
    truth = others[:, 0] + 0.5 * others[:, 1] > 1
    chances = found.of(others)
    assert np.mean((chances - truth) ** 2) < 0.02
    # Evidence counts: deep on one side as good as nothing is left.
    assert found.log_of_none(np.array([[0.95, 0.9, 0.5, 0.5]]))[0] < -5
    np.testing.assert_allclose(np.log1p(-chances), found.log_of_none(others), atol=1e-9)
    assert np.mean(np.where(truth, np.log(chances), np.log1p(-chances))) > -0.1


def test_failures_without_a_place_have_about_the_same_chance_everywhere():
    rng = np.random.default_rng(1)
    unit = rng.random((300, 3))
    chances = Chance(unit, rng.random(300) < 0.2, OF_FAILURES).of(rng.random((2000, 3)))
    assert chances.mean() == pytest.approx(0.2, abs=0.08) and chances.max() < 0.6


def test_of_none_or_all_nothing_is_learnt():
    unit = np.random.default_rng(0).random((10, 2))
    assert chance(unit, np.zeros(10, dtype=bool), OF_FAILURES) is None and chance(unit, np.ones(10, dtype=bool), OF_FAILURES) is None


def calibrate(**reason):
    """The linear curves, of which all fail beyond the exact posterior's mean in the first parameter."""
    case = linear_case(0.05)
    options = {"correlation_length": CORRELATION_LENGTH, "discrepancy": False, "batch": 20}
    filter = PosteriorFilter(case.space, case.reference, stop=Stop(posterior_shift=False, max_evaluations=75), **options)
    while not filter.finished:
        samples = filter.ask()
        beyond = samples.theta[:, 0] > case.mean[0]
        filter.tell(samples, curves(samples.theta), **{name: beyond for name in reason})
    return case, filter


def test_a_posterior_is_cut_where_parameters_are_infeasible():
    case, filter = calibrate(infeasible=True)
    posterior = filter.posterior
    assert posterior.weights[posterior.samples[:, 0] > case.mean[0] + 0.2 * case.deviation[0]].sum() < 0.05
    # That of half a Gaussian.
    assert posterior.mean()[0] == pytest.approx(case.mean[0] - np.sqrt(2 / np.pi) * case.deviation[0], abs=0.25 * case.deviation[0])
    assert filter.emulation.answer[0] < case.mean[0] + 0.1 * case.deviation[0] and filter.emulation.lost < 0.2


def test_and_not_where_runs_fail_for_another_reason():
    case, filter = calibrate(failed=True)
    posterior = filter.posterior
    assert posterior.weights[posterior.samples[:, 0] > case.mean[0]].sum() == pytest.approx(0.5, abs=0.25)
    assert filter.emulation.lost == pytest.approx(posterior.weights[posterior.samples[:, 0] > case.mean[0]].sum(), abs=0.15)
    # Few of the later runs go where they fail.
    last = filter.evaluations.theta[32:-3, 0]
    assert np.mean(last > case.mean[0]) < 0.3


def test_a_posterior_that_lies_where_runs_fail_has_not_settled():
    case = linear_case(0.05)
    filter = PosteriorFilter(case.space, case.reference, correlation_length=CORRELATION_LENGTH, discrepancy=False, stop=Stop(max_evaluations=83))
    while not filter.finished:
        samples = filter.ask()
        filter.tell(samples, curves(samples.theta), failed=samples.theta[:, 0] > case.mean[0] - 1.5 * case.deviation[0])
    assert filter.emulation.lost > 0.5 and filter.stopped_by == "max_evaluations"


def test_an_infeasible_optimum_is_left_and_never_the_answer():
    # All that fits by six standard deviations better is infeasible.
    case = linear_case(0.05)
    edge = case.mean[0] - 6 * case.deviation[0]
    filter = PosteriorFilter(
        case.space, case.reference, correlation_length=CORRELATION_LENGTH, discrepancy=False, stop=Stop(posterior_shift=False, max_evaluations=112), batch=20
    )
    while not filter.finished:
        samples = filter.ask()
        filter.tell(samples, curves(samples.theta), infeasible=samples.theta[:, 0] > edge)
    assert filter.emulation.answer[0] < edge + 0.5 * case.deviation[0]
    # What the posterior holds there all the same is told as lost, and keeps it from settling.
    assert filter.emulation.lost > 0.5
