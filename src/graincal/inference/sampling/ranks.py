"""Whether posteriors mean what they say: ranks of truths among their samples are uniform (Talts et al. 2018, simulation-based calibration)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

# Sets of uniform ranks that a band is adjusted on: its probability is known to a tenth of itself where one set in a hundred leaves it.
SIMULATED = 20_000


def rank(truth: NDArray[np.float64], values: NDArray[np.float64], weights: NDArray[np.float64], draws: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """How many of `draws` samples of a posterior are below the truth, 0 to draws: (q,), of q quantities whose true values are truth (q,).

    values (M, q) of samples with weights (M,) that sum to 1, from which the draws are taken at random.
    """
    rows = rng.choice(len(weights), size=draws, p=weights)
    return np.sum(values[rows] < truth, axis=0)


@dataclass(frozen=True, eq=False)
class UniformBand:
    """A band that the empirical distribution of `count` uniform ranks from 0 to `draws` stays in everywhere with a given probability.

    depth: twice the least probability, at any rank, of a count as extreme as the band's edge. depths (S,): those of simulated uniform ranks.
    Source: Säilynoja, Bürkner, Vehtari (2022), Statistics and Computing 32, the adjustment by simulation.
    """

    count: int
    draws: int
    depth: float
    depths: NDArray[np.float64]

    @classmethod
    def of(cls, count: int, draws: int, probability: float, rng: np.random.Generator) -> UniformBand:
        """probability: of uniform ranks that stay within."""
        tails = _tails(count, draws)
        depths = np.array([_depth(rng.integers(draws + 1, size=count), draws, tails) for _ in range(SIMULATED)])
        return cls(count, draws, float(np.quantile(depths, 1 - probability)), depths)

    @property
    def below(self) -> NDArray[np.float64]:
        """The probability (draws,) of a uniform rank below 1, 2, ..., draws."""
        return np.arange(1, self.draws + 1) / (self.draws + 1)

    @property
    def edges(self) -> NDArray[np.float64]:
        """The least and the largest part of ranks below 1, 2, ..., draws that is within: (2, draws)."""
        return np.array([scipy.stats.binom.ppf(level, self.count, self.below) for level in (self.depth / 2, 1 - self.depth / 2)]) / self.count

    def distribution(self, ranks: NDArray[np.int64]) -> NDArray[np.float64]:
        """The part (draws,) of ranks (count,) below 1, 2, ..., draws."""
        return _below(ranks, self.draws) / self.count

    def probability(self, ranks: NDArray[np.int64]) -> float:
        """That uniform ranks go as far from the diagonal as these, or further: a p-value."""
        return float(np.mean(self.depths <= _depth(ranks, self.draws, _tails(self.count, self.draws))))

    def holds(self, ranks: NDArray[np.int64]) -> bool:
        """Whether ranks (count,) stay within."""
        return bool(_depth(ranks, self.draws, _tails(self.count, self.draws)) >= self.depth)


def _below(ranks: NDArray[np.int64], draws: int) -> NDArray[np.int64]:
    return np.cumsum(np.bincount(ranks, minlength=draws + 1))[:draws]


def _tails(count: int, draws: int) -> NDArray[np.float64]:
    """Twice the smaller tail probability of 0 to count ranks below 1, 2, ..., draws: (draws, count + 1)."""
    below, counts = np.arange(1, draws + 1)[:, None] / (draws + 1), np.arange(count + 1)
    return 2 * np.minimum(scipy.stats.binom.cdf(counts, count, below), scipy.stats.binom.sf(counts - 1, count, below))


def _depth(ranks: NDArray[np.int64], draws: int, tails: NDArray[np.float64]) -> float:
    return float(tails[np.arange(draws), _below(ranks, draws)].min())
