"""How much what the emulators do not know may move the posterior."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from graincal.inference.emulator.emulator import Emulator
from graincal.inference.likelihood.likelihood import ReducedLikelihood

# How much a spread counts beside a mean, where it is asked whether the posterior is known: tails make it uncertain by more.
SPREADS = 0.6

# Of the probability, within a standard deviation of a Gaussian's mean.
CENTRAL = 0.683

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
    the same of the logarithm of what the width of its central interval of 68 % would be other by: of a Gaussian that is two standard deviations, and it does not hang on a percent of the probability that
    lies far out. log_evidence: (DRAWS,). Where the emulators do not know whether a region fits, a draw has it fit or not.
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
    weights = np.exp(relative - scipy.special.logsumexp(relative, axis=1)[:, None])
    means, middle, spread = weights @ unit, unit.mean(axis=0), unit.std(axis=0)
    # Where a draw leaves one sample alone, its spread is none that can be told.
    spreads = np.sqrt(np.maximum(weights @ unit**2 - means**2, (LEAST_SPREAD * spread) ** 2))
    # A draw's mean is off by the sampling too, which is no doubt: by the variance of a weighted mean.
    sampling = np.einsum("dm,dmk->dk", weights**2, (unit - means[:, None]) ** 2)
    wider = np.maximum(spread, spreads)
    widths = np.array([_width(column, weights) for column in unit.T]).T
    own = np.array([_width(column, np.full((1, len(unit)), 1 / len(unit)))[0] for column in unit.T])
    other = np.log(np.maximum(widths, LEAST_SPREAD * own) / own)
    return Doubt(
        _usual((means - middle) / wider, sampling / wider**2),
        _usual(other, np.zeros(1)),
        log_evidence + scipy.special.logsumexp(relative, axis=1) - np.log(len(unit)),
    )


def _width(values: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Of the central intervals, CENTRAL of the probability, of values (M,) by each of several sets of weights (D, M): (D,)."""
    order = np.argsort(values, kind="stable")
    cumulated = np.cumsum(weights[:, order], axis=1)
    low, high = (np.argmax(cumulated >= level * cumulated[:, -1:], axis=1) for level in ((1 - CENTRAL) / 2, (1 + CENTRAL) / 2))
    return values[order][high] - values[order][low]


def _usual(off: NDArray[np.float64], sampling: NDArray[np.float64]) -> float:
    """How large values (D, n) are in nine draws of ten, as a standard deviation, less the variance that their sampling has, (D, n) or none: of the column where it is the most."""
    deviation = np.quantile(np.abs(off), MOST_DRAWS, axis=0) / IN_DEVIATIONS
    return float(np.sqrt(np.maximum(deviation**2 - np.median(sampling, axis=0), 0)).max())
