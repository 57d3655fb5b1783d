"""What limits come to is what a campaign then uses."""

import pytest

from graincal import Experiment, Stop
from graincal.campaign import Calibration
from graincal.campaign.asked.limits import Limits

from .hyperbola import SPACE, model, reference


@pytest.mark.parametrize(
    ("method", "options", "stop", "evaluations", "rounds", "ended_by"),
    [
        ("posterior", {"first_batch": 20, "batch": 10}, Stop(max_evaluations=30), 23, 1, "max_evaluations"),
        ("posterior", {"first_batch": 20, "batch": 10}, Stop(max_evaluations=33), 33, 2, "max_evaluations"),
        # Batches grow by a quarter: 10, 4, 4, 5.
        ("posterior", {"first_batch": 10}, Stop(max_evaluations=600, max_iterations=4, posterior_shift=False), 26, 4, "max_iterations"),
        # Fresh runs may take the place of batches.
        ("posterior", {"first_batch": 10}, Stop(max_evaluations=600, max_iterations=4), 73, 4, "max_iterations"),
        ("posterior", {"first_batch": 10}, Stop(max_evaluations=100_000), 100_000, 40, "max_evaluations"),
        ("iterative-bayesian", {}, Stop(), 400, 20, "max_iterations"),
        ("iterative-bayesian", {}, Stop(max_evaluations=70), 60, 3, "max_evaluations"),
        ("iterative-bayesian", {}, Stop(max_evaluations=700, max_iterations=False), 700, 35, "max_evaluations"),
        ("iterative-bayesian", {}, Stop(max_iterations=False), None, None, ""),
        ("sequential-monte-carlo", {}, Stop(), 20, 1, "max_iterations"),
    ],
)
def test_limits(method, options, stop, evaluations, rounds, ended_by):
    calibration = Calibration(SPACE, [Experiment("x", model(), reference())], method, options, stop, workers=1)
    limits = Limits.of(calibration, calibration.blank_filter())
    if evaluations == 100_000:
        assert 0.75 * evaluations < limits.evaluations <= evaluations and limits.ended_by == ended_by
        return
    assert (limits.evaluations, limits.rounds, limits.ended_by) == (evaluations, rounds, ended_by)
