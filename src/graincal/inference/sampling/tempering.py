"""Samples of a posterior whose likelihood costs next to nothing, by tempering from the prior."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from graincal.data import ParameterSpace
from graincal.inference.sampling.proposal import systematic_resampling
from graincal.inference.sampling.samples import allowed

# Each power of the likelihood is as much above the last as leaves this part of the samples effective.
EFFECTIVE = 0.5

# Moves at each power, and at the last one: enough for every sample to forget where it was copied from.
MOVES = 12
LAST_MOVES = 60

# Samples at about this part of the last power are kept too: they reach into the tails, wherever these bend.
WIDE_POWER = 0.3


@dataclass(frozen=True, eq=False)
class TemperedSample:
    """Equally weighted samples (M, n) of prior times likelihood^power on the unit cube; the log likelihood (M,) of each; the log evidence at that power.

    wide (M, n): such samples at about 0.3 of the power.
    """

    unit: NDArray[np.float64]
    log_likelihood: NDArray[np.float64]
    log_evidence: float
    wide: NDArray[np.float64]


def temper(
    log_likelihood: Callable[[NDArray[np.float64]], NDArray[np.float64]], space: ParameterSpace, count: int, rng: np.random.Generator, *, power: float = 1.0
) -> TemperedSample:
    """`count` samples, an even number, on the unit cube, under a prior that is uniform where the space holds parameters possible.

    Sequential Monte Carlo: the power of the likelihood rises from 0, samples are resampled at each, and moved by differential evolution
    (ter Braak 2006): each half of them along differences of two of the other half, which fits scale and shape of whatever is there, several modes
    and ridges too. Sources: Del Moral, Doucet, Jasra (2006), Journal of the Royal Statistical Society B 68.
    """
    from scipy.stats import qmc

    sequence = qmc.Sobol(d=space.size, scramble=True, seed=rng)
    # Of a power of two, which the sequence fills evenly.
    unit = allowed(lambda more: sequence.random(1 << (more - 1).bit_length()), count, space)[:count]
    logs = log_likelihood(unit)
    reached, evidence, wide = 0.0, 0.0, unit
    while reached < power:
        step = _next_step(logs, power - reached)
        if reached < WIDE_POWER * power < reached + step:
            step = WIDE_POWER * power - reached
        increments = step * logs
        evidence += scipy.special.logsumexp(increments) - np.log(count)
        rows = systematic_resampling(np.exp(increments - scipy.special.logsumexp(increments)), count, rng)
        # The halves are drawn anew each time, so that copies of one sample do not all stand in one.
        rows = rng.permutation(rows)
        unit, logs = unit[rows], logs[rows]
        reached = power if step == power - reached else reached + step
        for _ in range(LAST_MOVES if reached == power else MOVES):
            unit, logs = _move(log_likelihood, space, unit, logs, reached, rng)
        if reached <= WIDE_POWER * power * (1 + 1e-12):
            wide = unit
    return TemperedSample(unit, logs, float(evidence), wide)


def _next_step(logs: NDArray[np.float64], most: float) -> float:
    """How much the power may rise: until EFFECTIVE of the samples remain effective."""

    def excess(log_step: float) -> float:
        increments = np.exp(log_step) * logs
        size = np.exp(2 * scipy.special.logsumexp(increments) - scipy.special.logsumexp(2 * increments)) / len(logs)
        return size - EFFECTIVE

    if excess(np.log(most)) >= 0:
        return most
    return float(np.exp(scipy.optimize.brentq(excess, np.log(most) - 60, np.log(most), xtol=1e-3)))


def _move(
    log_likelihood: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    space: ParameterSpace,
    unit: NDArray[np.float64],
    logs: NDArray[np.float64],
    power: float,
    rng: np.random.Generator,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    count, size = unit.shape
    unit, logs = unit.copy(), logs.copy()
    half = count // 2
    for mine, others in ((slice(0, half), slice(half, count)), (slice(half, count), slice(0, half))):
        moving, pool = unit[mine], unit[others]
        first = rng.integers(len(pool), size=len(moving))
        second = (first + rng.integers(1, len(pool), size=len(moving))) % len(pool)
        # Once in ten a whole difference, which leads from one mode to another; or else the best length for a Gaussian, more or less.
        length = np.where(rng.random(len(moving)) < 0.1, 1.0, 2.38 / np.sqrt(2 * size) * rng.uniform(0.3, 1.2, len(moving)))
        proposed = moving + length[:, None] * (pool[first] - pool[second]) + 1e-4 * rng.standard_normal(moving.shape)
        inside = space.allows(proposed)
        new = np.full(len(moving), -np.inf)
        if inside.any():
            new[inside] = log_likelihood(proposed[inside])
        accepted = np.log(rng.random(len(moving))) < power * (new - logs[mine])
        accepted &= inside
        unit[mine] = np.where(accepted[:, None], proposed, moving)
        logs[mine] = np.where(accepted, new, logs[mine])
    return unit, logs
