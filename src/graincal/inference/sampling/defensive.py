"""A proposal that leaves nothing out: a mixture fitted to a posterior, its wide shadow, and a share of the prior."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from graincal.data import ParameterSpace
from graincal.inference.sampling.proposal import LEAST_MASS, ProposalOutsideBox, TruncatedMixture, fit_mixture, places
from graincal.inference.sampling.samples import allowed

# Of every component a part is as many times as wide, so that the tails of the proposal are heavier than those of what it was fitted to.
WIDE_PART, WIDER = 0.2, 2.5

# Where it is known how the posterior widens as the data are trusted less, a part is fitted to that: tails of a bent ridge are bent.
BENT_PART = 0.3

# The prior's share, which finds a mode that no evaluation has shown yet, and bounds the weights.
PRIOR_SHARE = 0.1

# Points that are drawn at once, of which few may be within the ranges: more take memory.
MOST_AT_ONCE = 2**18

# A fit to a posterior's samples: so many components at most, copies of samples that it is trained on, and steps. What the fit lacks the weights mend.
COMPONENTS, COPIES, STEPS = 10, 2000, 40


@dataclass(frozen=True, eq=False)
class DefensiveMixture:
    """A density where the prior holds parameters possible: `prior_share` of it uniform, the rest a truncated mixture. None for the mixture: all of it uniform."""

    space: ParameterSpace
    mixture: TruncatedMixture | None = None
    prior_share: float = PRIOR_SHARE

    @classmethod
    def fitted(
        cls,
        space: ParameterSpace,
        theta: NDArray[np.float64],
        weights: NDArray[np.float64],
        rng: np.random.Generator,
        wide: NDArray[np.float64] | None = None,
    ) -> DefensiveMixture:
        """To samples theta (N, n) with weights (N,) that sum to 1; wide (M, n): equally weighted samples of the same at a lower power of the likelihood."""
        core = _fit(space, theta, weights, rng)
        wider = TruncatedMixture(space, core.weights, core.means, WIDER**2 * core.covariances)
        parts = [(1 - WIDE_PART, core), (WIDE_PART, wider)]
        if wide is not None:
            parts = [(1 - WIDE_PART - BENT_PART, core), (WIDE_PART, wider), (BENT_PART, _fit(space, wide, np.full(len(wide), 1 / len(wide)), rng))]
        return cls(
            space,
            TruncatedMixture(
                space,
                np.concatenate([part * mixture.weights for part, mixture in parts]),
                np.concatenate([mixture.means for _, mixture in parts]),
                np.concatenate([mixture.covariances for _, mixture in parts]),
            ),
        )

    def log_density(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        """The log of the density (N,) at theta (N, n), in the parameters' own units; -inf where the prior is zero."""
        uniform = np.where(self.space.contains(theta), -self.space.log_volume, -np.inf)
        if self.mixture is None:
            return uniform
        return np.logaddexp(np.log(self.prior_share) + uniform, np.log1p(-self.prior_share) + self.mixture.log_density(theta))

    def draw(self, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """`count` points (count, n), each distributed as the density says, spread out: a scrambled Halton sequence carried over into it.

        Raises ProposalOutsideBox where next to nothing of the mixture lies where the prior holds parameters possible.
        """
        from scipy.stats import qmc

        size = self.space.size
        sequence = qmc.Halton(d=size + 1, scramble=True, seed=rng)
        kept = np.empty((0, size))
        if self.mixture is None:
            kept = allowed(lambda more: sequence.random(more)[:, 1:], count, self.space)
        else:
            mass = self.mixture.mass
            if mass < LEAST_MASS:
                raise ProposalOutsideBox(f"only {mass:.1e} of the proposal's mass lies within {places(self.space)}")
            # What is drawn from the whole mixture and falls outside is left out, which is to draw from the truncated one: its share of the draws
            # has to be the larger for it. So has that of the prior, of which constraints leave a part of the box.
            uniform, truncated = self.prior_share / self.space.part, (1 - self.prior_share) / mass
            share = uniform / (uniform + truncated)
            bounds = np.concatenate([[share], share + (1 - share) * np.cumsum(self.mixture.weights)])
            factors = np.linalg.cholesky(self.mixture.covariances)
            wanted = max(64, int(np.ceil(count / mass)))
            for _ in range(100 * int(np.ceil(wanted / MOST_AT_ONCE))):
                drawn = sequence.random(min(wanted, MOST_AT_ONCE))
                component = np.minimum(np.searchsorted(bounds, drawn[:, 0], side="right") - 1, len(factors) - 1)
                normal = scipy.special.ndtri(np.clip(drawn[:, 1:], 1e-12, 1 - 1e-12))
                unit = np.where((component < 0)[:, None], drawn[:, 1:], self.mixture.means[component] + np.einsum("mij,mj->mi", factors[component], normal))
                kept = np.concatenate([kept, unit[self.space.allows(unit)]])
                if len(kept) >= count:
                    break
            else:
                raise ProposalOutsideBox(f"{len(kept)} of {count} draws from the proposal fell within {places(self.space)} in 100 rounds")
        # low + 1 * (high - low) may round to the number after high.
        return np.clip(self.space.from_unit(kept[:count]), self.space.low, self.space.high)


def _fit(space: ParameterSpace, theta: NDArray[np.float64], weights: NDArray[np.float64], rng: np.random.Generator) -> TruncatedMixture:
    components = min(COMPONENTS, max(1, len(theta) // 10))
    mixture = fit_mixture(space, theta, weights, rng, covariance="full", components=components, copies=COPIES, steps=STEPS)
    used = mixture.weights > 1e-3
    weights = mixture.weights[used]
    return TruncatedMixture(space, weights / weights.sum(), mixture.means[used], mixture.covariances[used])
