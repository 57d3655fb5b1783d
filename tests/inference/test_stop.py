import numpy as np
import pytest

from graincal.data import InputError, Samples
from graincal.inference import Iteration, Stop

OFF = dict(s=False, gl_error_increment=False, error=False, error_increment=False, max_iterations=False, max_evaluations=False)


def iteration(index, s=1.0, gl_error=30.0, error=20.0):
    """An iteration of ten samples, the first of which is the most probable and has this error."""
    weights = np.full((1, 10), 0.05)
    weights[0, 0] = 0.55
    return Iteration(
        index=index,
        samples=Samples(np.arange(10) + 10 * index, np.zeros((10, 1)), ("a",)),
        proposal=None,
        failed=np.zeros(10, dtype=bool),
        observable_errors=np.full((10, 1), error),
        errors=np.full(10, error),
        weights=weights,
        s=s,
        effective_sample_size=0.3,
        gl_error=gl_error,
    )


@pytest.mark.parametrize(
    ("criterion", "limit", "before", "met", "not_met"),
    [
        ("s", 0.01, {}, {"s": 0.01}, {"s": 0.0101}),
        ("gl_error_increment", 0.25, {"gl_error": 9.0}, {"gl_error": 9.25}, {"gl_error": 9.3}),
        ("gl_error_increment", 0.25, {"gl_error": 9.0}, {"gl_error": 8.75}, {"gl_error": 8.7}),
        ("error", 2.0, {}, {"error": 2.0}, {"error": 2.01}),
        ("error_increment", 0.25, {"error": 9.0}, {"error": 9.25}, {"error": 9.3}),
        ("error_increment", 0.25, {"error": 9.0}, {"error": 8.75}, {"error": 8.7}),
    ],
)
def test_each_criterion_of_eq_12_stops_alone_and_at_its_limit(criterion, limit, before, met, not_met):
    stop = Stop(**{**OFF, "max_iterations": 20, criterion: limit})
    history = [iteration(0, **before)]
    assert stop.reached([*history, iteration(1, **not_met)]) == {}
    assert list(stop.reached([*history, iteration(1, **met)])) == [criterion]


def test_increments_need_a_previous_iteration():
    assert Stop().reached([iteration(0)]) == {}


def test_limits_count_iteration_0_and_never_let_an_iteration_exceed_the_evaluations():
    history = [iteration(0), iteration(1), iteration(2)]
    assert Stop(**{**OFF, "max_iterations": 3}).reached(history[:2]) == {}
    assert list(Stop(**{**OFF, "max_iterations": 3}).reached(history)) == ["max_iterations"]
    assert Stop(**{**OFF, "max_evaluations": 30}).reached(history[:2]) == {}
    assert list(Stop(**{**OFF, "max_evaluations": 29}).reached(history[:2])) == ["max_evaluations"]


def test_all_criteria_that_are_met_are_named_with_their_figures():
    reasons = Stop().reached([iteration(0), iteration(1, s=0.005, error=1.5)])
    assert list(reasons) == ["s", "gl_error_increment", "error"]
    assert reasons["s"] == "the covariance coefficient s = 0.005 is at most 0.01"
    assert reasons["error"] == "the most probable sample's error of 1.50 % is at most 2 %"


def test_a_criterion_that_is_switched_off_does_not_stop():
    history = [iteration(0), iteration(1, s=1e-9, error=0.0, gl_error=30.0)]
    assert Stop(**{**OFF, "max_iterations": 3}).reached(history) == {}


@pytest.mark.parametrize(
    "wrong", [{"s": True}, {"s": None}, {"error": -1}, {"error": np.nan}, {"max_iterations": 0}, {"max_evaluations": 2.5}, {"max_iterations": "20"}]
)
def test_values_that_are_no_limits_are_refused(wrong):
    with pytest.raises(InputError, match=f"stop.{next(iter(wrong))} must be"):
        Stop(**wrong)


def test_a_calibration_that_nothing_would_end_is_refused():
    with pytest.raises(InputError, match="every criterion is switched off"):
        Stop(**OFF, posterior_shift=False)
