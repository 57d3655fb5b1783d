"""The parameters that fit best as far as the emulators know."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
import scipy
from numpy.typing import NDArray

from graincal.data import ParameterSpace
from graincal.inference.emulator.chance import Chance

# The best is sought from so many of the best samples and evaluations on.
SEARCHES = 4

# Where there are constraints, from so many for each parameter, in so many generations at most.
MEMBERS, FEWEST_MEMBERS, GENERATIONS = 15, 30, 200

LogLikelihood = Callable[[NDArray[np.float64]], NDArray[np.float64]]


def best_fit(expected: LogLikelihood, space: ParameterSpace, known: NDArray[np.float64], impossible: Chance | None) -> NDArray[np.float64]:
    """Where the log likelihood expected at points of the unit cube is the largest, theta (n,), from the best of known points (M, n) on; where parameters are rather feasible than not, as far as there are such points."""
    starts = _feasible(known, impossible)
    starts = starts[np.argsort(-expected(starts), kind="stable")]
    unit = _best_allowed(expected, space, starts, impossible) if space.constraints else _best_in_box(expected, space, starts, impossible)
    return np.clip(space.from_unit(unit), space.low, space.high)


def _best_in_box(expected: LogLikelihood, space: ParameterSpace, starts: NDArray[np.float64], impossible: Chance | None) -> NDArray[np.float64]:
    """From starts (M, n), the best first, along the gradient."""
    step = 1e-4 * np.eye(space.size)

    def downhill(point: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        logs = expected(np.concatenate([point[None], point + step, point - step]))
        return -logs[0], (logs[space.size + 1 :] - logs[1 : space.size + 1]) / 2e-4

    searches = [
        scipy.optimize.minimize(downhill, start, jac=True, method="L-BFGS-B", bounds=[(0, 1)] * space.size, options={"maxiter": 50})
        for start in starts[:SEARCHES]
    ]
    points = _feasible(np.concatenate([starts[:1], [search.x for search in searches]]), impossible)
    return points[np.argmax(expected(points))]


def _best_allowed(expected: LogLikelihood, space: ParameterSpace, starts: NDArray[np.float64], impossible: Chance | None) -> NDArray[np.float64]:
    """The same where constraints hold, which have no gradient: by a population that none leaves."""
    starts = starts[space.allows(starts)]
    avoided = impossible if impossible is None or np.all(impossible.of(starts) < 0.5) else None

    def downhill(points: NDArray[np.float64]) -> NDArray[np.float64]:
        possible = space.allows(points.T)
        if avoided is not None and possible.any():
            possible[possible] = avoided.of(points.T[possible]) < 0.5
        logs = np.full(points.shape[1], np.inf)
        if possible.any():
            logs[possible] = -expected(points.T[possible])
        return logs

    with warnings.catch_warnings():
        # Of places where there is no likelihood, and of a search that is ended by its limit.
        warnings.simplefilter("ignore")
        members = max(FEWEST_MEMBERS, MEMBERS * space.size)
        # Few starts stand there more than once.
        first = np.resize(starts[:members], (members, space.size))
        return scipy.optimize.differential_evolution(
            downhill, [(0, 1)] * space.size, init=first, maxiter=GENERATIONS, seed=0, polish=False, vectorized=True, updating="deferred"
        ).x


def _feasible(unit: NDArray[np.float64], impossible: Chance | None) -> NDArray[np.float64]:
    """Of points (M, n) those that are rather feasible than not; all, where none is."""
    if impossible is None:
        return unit
    feasible = impossible.of(unit) < 0.5
    return unit[feasible] if feasible.any() else unit
