"""How much what the emulators do not know may move the posterior."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from graincal.inference.emulator import Emulator
from graincal.inference.likelihood import ReducedLikelihood

# How much a spread counts beside a mean, where it is asked whether the posterior is known.
SPREADS = 0.6

# Joint draws of the emulators, at so many samples of the posterior.
DRAWS, SAMPLES = 100, 1000


@dataclass(frozen=True, eq=False)
class Doubt:
    """What the posterior would be if the simulator's mean response were one of DRAWS that the emulators hold possible, each drawn jointly at samples of the posterior.

    means: root mean square over these of what a parameter's mean would be off, in its standard deviations, of the parameter where it is the most; spreads: of the logarithm of what
    a standard deviation would be other by. log_evidence: (DRAWS,). Where the emulators do not know whether a region fits, a draw has it fit or not.
    """

    means: float
    spreads: float
    log_evidence: NDArray[np.float64]

    @property
    def most(self) -> float:
        """The larger of both, spreads by their part of what means are: their own tails make them uncertain by more."""
        return max(self.means, SPREADS * self.spreads)


def doubt(
    unit: NDArray[np.float64], log_evidence: float, emulators: Sequence[Emulator], likelihoods: Sequence[ReducedLikelihood], rng: np.random.Generator
) -> Doubt:
    """Of a posterior with this log evidence, of which points (M, n) of the unit cube are samples of equal weight in no order, M even.

    Each draw's posterior is found by both halves of the samples. What they agree on is the draw's, and what they do not is the sampling's: so products of both halves have the variance over the draws
    for their mean, and nothing of the sampling's.
    """
    logs, known = np.zeros((DRAWS, len(unit))), np.zeros(len(unit))
    for emulator, likelihood in zip(emulators, likelihoods):
        logs += likelihood.exact(emulator.draw(unit, DRAWS, rng))
        known += likelihood(*emulator.predict(unit))
    # The samples have the density prior times expected likelihood / evidence.
    relative = logs - known
    half = len(unit) // 2
    halves = [_moments(unit[part], relative[:, part]) for part in (slice(half), slice(half, None))]
    spread = unit.std(axis=0)
    # Both halves of a draw about what they are over all draws, which is the same but for the sampling.
    off, other = (
        np.maximum(np.mean(np.prod([each - each.mean(axis=0) for each in pair], axis=0), axis=0), 0)
        for pair in zip(*((mean / np.maximum(spread, deviation), np.log(deviation / spread)) for mean, deviation in halves))
    )
    return Doubt(float(np.sqrt(off.max())), float(np.sqrt(other.max())), log_evidence + logsumexp(relative, axis=1) - np.log(len(unit)))


def _moments(unit: NDArray[np.float64], relative: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Means and standard deviations (D, n) of points (M, n) by each draw's log weights (D, M)."""
    weights = np.exp(relative - logsumexp(relative, axis=1)[:, None])
    means = weights @ unit
    return means, np.sqrt(np.maximum(weights @ unit**2 - means**2, 1e-300))
