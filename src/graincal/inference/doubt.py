"""How much what the emulators do not know may move the posterior."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from graincal.inference.emulator import Emulator
from graincal.inference.likelihood import ReducedLikelihood

# How much a spread counts beside a mean, where it is asked whether the posterior is known: tails make it uncertain by more.
SPREADS = 0.6

# Joint draws of the emulators, at so many samples of the posterior.
DRAWS, SAMPLES = 100, 1000


# What nine draws in ten are within, in standard deviations of a Gaussian: a few draws far out would decide a root mean square.
MOST_DRAWS, IN_DEVIATIONS = 0.9, 1.645

# The least standard deviation of a draw's posterior, as a part of the posterior's.
LEAST_SPREAD = 0.01


@dataclass(frozen=True, eq=False)
class Doubt:
    """What the posterior would be if the simulator's mean response were one of DRAWS that the emulators hold possible, each drawn jointly at samples of the posterior.

    means: how far a parameter's mean would be off in nine draws of ten, over 1.645, in its standard deviations, of the parameter where it is the most: that of a Gaussian is its standard deviation; spreads:
    the same of the logarithm of what a standard deviation would be other by. log_evidence: (DRAWS,). Where the emulators do not know whether a region fits, a draw has it fit or not.
    """

    means: float
    spreads: float
    log_evidence: NDArray[np.float64]

    @property
    def most(self) -> float:
        """The larger of both, spreads by their part of what means are."""
        return max(self.means, SPREADS * self.spreads)


def doubt(
    unit: NDArray[np.float64], log_evidence: float, emulators: Sequence[Emulator], likelihoods: Sequence[ReducedLikelihood], rng: np.random.Generator
) -> Doubt:
    """Of a posterior with this log evidence, of which points (M, n) of the unit cube are samples of equal weight."""
    logs, known = np.zeros((DRAWS, len(unit))), np.zeros(len(unit))
    for emulator, likelihood in zip(emulators, likelihoods):
        logs += likelihood.exact(emulator.draw(unit, DRAWS, rng))
        known += likelihood(*emulator.predict(unit))
    # The samples have the density prior times expected likelihood / evidence.
    relative = logs - known
    weights = np.exp(relative - logsumexp(relative, axis=1)[:, None])
    means, middle, spread = weights @ unit, unit.mean(axis=0), unit.std(axis=0)
    # Where a draw leaves one sample alone, its spread is none that can be told.
    spreads = np.sqrt(np.maximum(weights @ unit**2 - means**2, (LEAST_SPREAD * spread) ** 2))
    away = (unit - means[:, None]) / spreads[:, None]
    # A draw's moments are off by the sampling too, which is no doubt: the variances of a weighted mean and of the logarithm of a weighted standard deviation.
    squared = (weights**2)[:, :, None]
    of_means, of_spreads = np.sum(squared * away**2, axis=1), np.sum(squared * (away**2 - 1) ** 2, axis=1) / 4
    wider = np.maximum(spread, spreads)
    off, other = (means - middle) / wider, np.log(spreads / spread)
    return Doubt(_usual(off, of_means * (spreads / wider) ** 2), _usual(other, of_spreads), log_evidence + logsumexp(relative, axis=1) - np.log(len(unit)))


def _usual(off: NDArray[np.float64], sampling: NDArray[np.float64]) -> float:
    """How large values (D, n) are in nine draws of ten, as a standard deviation, less the variance (D, n) that their sampling has: of the column where it is the most."""
    deviation = np.quantile(np.abs(off), MOST_DRAWS, axis=0) / IN_DEVIATIONS
    return float(np.sqrt(np.maximum(deviation**2 - np.median(sampling, axis=0), 0)).max())
