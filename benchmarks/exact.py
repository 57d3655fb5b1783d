"""The posterior of a model that costs nothing, by a run so long that methods can be judged by it."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray
from problems import PROBLEMS, SPACE, Problem

import graincal as gc
from graincal.inference.sampling.proposal import systematic_resampling

WALKERS, POWERS, MOVES_EACH, LAST_MOVES, RUNS = 2048, 60, 12, 800, 2

# Of a standard deviation: runs that differ by more are said.
APART = 0.1


@cache
def exact_moments(name: str, seed: int, noise: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Means and standard deviations (n,) of the parameters, given that problem's reference of that seed and noise."""
    problem = PROBLEMS[name]
    reference = problem.reference(seed, noise)
    runs = [walk(problem, reference, np.random.default_rng([seed, run])) for run in range(RUNS)]
    both = np.concatenate(runs)
    mean, std = both.mean(axis=0), both.std(axis=0)
    apart = max(max(np.abs((run.mean(axis=0) - mean) / std).max(), np.abs(run.std(axis=0) / std - 1).max()) for run in runs)
    if apart > APART:
        print(f"  the exact posterior of {name}, seed {seed}, is known to {apart:.2f} of its standard deviations only", flush=True)
    return mean, std


def walk(problem: Problem, reference: gc.Reference, rng: np.random.Generator) -> NDArray[np.float64]:
    """Samples (M, n): differential evolution of two halves of walkers (ter Braak 2006) while the likelihood's power rises to 1, and for long after."""
    deviations = np.array([reference.measurement_errors[name].absolute for name in reference.names])

    def log_likelihood(unit: NDArray) -> NDArray:
        outside = np.any((unit < 0) | (unit > 1), axis=1)
        misfit = (problem.curves(SPACE.from_unit(np.clip(unit, 0, 1))) - reference.values) / deviations
        return np.where(outside, -np.inf, -0.5 * np.sum(misfit**2, axis=(1, 2)))

    unit = rng.random((WALKERS, SPACE.size))
    logs = log_likelihood(unit)
    half = WALKERS // 2
    # The power rises slowly, so that no part of the posterior is lost on the way.
    powers = np.concatenate([np.repeat(np.geomspace(1e-4, 1, POWERS), MOVES_EACH), np.ones(LAST_MOVES)])
    kept = []
    for move, (last, power) in enumerate(zip(np.concatenate([[0], powers]), powers)):
        if power > last:
            weights = np.exp((power - last) * (logs - logs.max()))
            rows = rng.permutation(systematic_resampling(weights / weights.sum(), WALKERS, rng))
            unit, logs = unit[rows], logs[rows]
        for mine, others in ((slice(0, half), slice(half, None)), (slice(half, None), slice(0, half))):
            pool = unit[others]
            first, second = rng.integers(half, size=(2, half))
            length = np.where(rng.random(half) < 0.1, 1.0, rng.uniform(0.1, 1.2, half) * 2.38 / np.sqrt(2 * SPACE.size))
            proposed = unit[mine] + length[:, None] * (pool[first] - pool[second]) + 1e-4 * rng.standard_normal((half, SPACE.size))
            new = log_likelihood(proposed)
            accepted = np.log(rng.random(half)) < power * (new - logs[mine])
            unit[mine] = np.where(accepted[:, None], proposed, unit[mine])
            logs[mine] = np.where(accepted, new, logs[mine])
        if move >= len(powers) - LAST_MOVES // 2 and move % 25 == 0:
            kept.append(unit.copy())
    return SPACE.from_unit(np.concatenate(kept))
