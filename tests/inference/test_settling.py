"""When a posterior counts as known."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from graincal import ParameterSpace, Reference
from graincal.inference import PosteriorFilter, Stop
from graincal.inference.posterior.settling import Settling

STATES = np.linspace(0, 1, 80)


def curves(theta):
    """Two parameters at the truth, and away from it a ripple too, which takes more components than there are."""
    a, b = np.asarray(theta).T
    ripple = 0.5 * ((a - 0.5) ** 2 + (b - 0.5) ** 2)[:, None] * np.sin(40 * STATES**1.5 * (1 + b[:, None]) + 20 * a[:, None])
    return (a[:, None] * STATES + b[:, None] * STATES**2 + ripple)[..., None]


def test_what_components_leave_out_is_no_surprise():
    # Runs near the truth have no ripple, and the more there are of them, the less is left out on the mean: that raises the likelihood of all that is known.
    space = ParameterSpace({"a": (0, 1), "b": (0, 1)})
    reference = Reference(STATES, {"q": curves([[0.5, 0.5]])[0, :, 0]}, measurement_errors={"q": 0.03})
    stop = Stop(posterior_shift=False, max_iterations=5, max_evaluations=False)
    filter = PosteriorFilter(space, reference, first_batch=40, correlation_length=0.001, discrepancy=False, stop=stop)
    looks = []
    while len(looks) < 5:
        samples = filter.ask()
        filter.tell(samples, list(curves(samples.theta)))
        looks.append(filter.emulation)
    before, now = looks[-2:]
    known = space.to_unit(now.posterior.samples[np.random.default_rng(0).choice(len(now.posterior.samples), 300, p=now.posterior.weights)])
    risen = np.median(now.log_likelihood(known) - before.log_likelihood(known))
    changed = filter.knowledge.changed(now, before, known)
    assert risen > 2 and np.abs(changed).max() < 0.3


@pytest.mark.parametrize(
    ("change", "infeasible", "shift", "settles"),
    [
        (0.0, 0, 0.4, True),
        (0.0, 0, 0.6, False),
        (1.0, 0, 0.1, True),
        (1.2, 0, 0.1, False),
        (-0.6, 0, 0.1, True),
        (-0.8, 0, 0.1, False),
        (0.0, 9, 0.1, True),
        (0.0, 11, 0.1, False),
    ],
)
def test_fresh_runs_settle_it_where_they_fit_as_it_says_and_move_it_by_little(change, infeasible, shift, settles):
    now = SimpleNamespace(predicts=True, doubt=SimpleNamespace(most=0.1), lost=0.0)
    settling = Settling(0.25)
    settling.ask_fresh_runs(3, now)
    settling.confirm(np.where(np.arange(20) < infeasible, -np.inf, change), now, shift)
    assert settling.settled is settles and settling.confirmed == pytest.approx((20 - infeasible) / 20 * np.exp(change))
