"""The posterior of a likelihood that costs next to nothing: samples with weights."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graincal.data import ParameterSpace
from graincal.inference.defensive import DefensiveMixture
from graincal.inference.importance import log_evidence, log_importance_weights, normalised, pareto_k
from graincal.inference.proposal import ProposalOutsideBox
from graincal.inference.tempering import temper

# Particles that find the posterior; then so many draws from a density fitted to them, in two rounds or more, until so many samples are effective.
PARTICLES, DRAWS, EFFECTIVE, MOST_ROUNDS = 1024, 2048, 1000, 5

# A posterior that no mixture of Gaussians fits (a thin bent ridge) leaves fewer than these effective. It is then described by so many particles.
TOO_FEW, MORE_PARTICLES = 400, 2048


@dataclass(frozen=True, eq=False)
class Explored:
    """theta (M, n) with log_weights (M,), and log_likelihood (M,) of each. log_evidence, and its standard deviation over such explorations.

    proposal: a density fitted to the posterior, from which the samples were drawn; or, where no mixture fits it well, tempered samples were taken
    instead (`tempered`), whose weights are equal and whose evidence is known less well.
    """

    theta: NDArray[np.float64]
    log_weights: NDArray[np.float64]
    log_likelihood: NDArray[np.float64]
    log_evidence: float
    log_evidence_std: float
    proposal: DefensiveMixture
    tempered: bool = False

    @property
    def weights(self) -> NDArray[np.float64]:
        """Weights that sum to 1."""
        return normalised(self.log_weights)

    @property
    def effective_sample_size(self) -> float:
        """As a number of samples."""
        return float(1 / np.sum(self.weights**2))

    @property
    def pareto_k(self) -> float:
        """Of the weights' tail; see `importance.pareto_k`."""
        return pareto_k(self.log_weights)


def explore(
    space: ParameterSpace, log_likelihood: Callable[[NDArray[np.float64]], NDArray[np.float64]], rng: np.random.Generator, *, power: float = 1.0
) -> Explored:
    """Samples of prior times likelihood^power; log_likelihood takes points (M, n) of the unit cube. The prior is uniform on the box.

    Tempering finds where the posterior is; its samples are moved along and not independent. So a density is fitted to them, and what is returned are
    draws from that, weighted: their errors are those of independent draws, and the weights tell whether the fit was good. Where it was not, more
    tempered samples are returned.
    """
    found = temper(log_likelihood, space.size, PARTICLES, rng, power=power)
    theta, weights = space.from_unit(found.unit), np.full(PARTICLES, 1 / PARTICLES)
    proposals, drawn, logs = [], np.empty((0, space.size)), np.empty(0)
    while len(proposals) < 2 or (len(proposals) < MOST_ROUNDS and 1 / np.sum(weights**2) < EFFECTIVE):
        proposals.append(DefensiveMixture.fitted(space, theta, weights, rng, space.from_unit(found.wide)))
        try:
            new = proposals[-1].draw(DRAWS, rng)
        except ProposalOutsideBox:
            # No mixture fits: the tempered samples below stand for it.
            drawn = np.empty((0, space.size))
            break
        drawn = np.concatenate([drawn, new])
        logs = np.concatenate([logs, log_likelihood(space.to_unit(new))])
        densities = np.array([proposal.log_density(drawn) for proposal in proposals])
        log_weights = log_importance_weights(power * logs - space.log_volume, densities, np.full(len(proposals), DRAWS))
        theta, weights = drawn, normalised(log_weights)
    if not len(drawn) or 1 / np.sum(weights**2) < TOO_FEW:
        two = [temper(log_likelihood, space.size, MORE_PARTICLES // 2, rng, power=power) for _ in range(2)]
        theta, logs = space.from_unit(np.concatenate([each.unit for each in two])), np.concatenate([each.log_likelihood for each in two])
        evidences = [each.log_evidence for each in two]
        return Explored(
            theta, np.zeros(len(theta)), logs, float(np.mean(evidences)), float(abs(evidences[0] - evidences[1]) / 2), proposals[-1], tempered=True
        )
    size = len(log_weights)
    std = float(np.sqrt(max(size * np.sum(weights**2) - 1, 0) / size))
    return Explored(drawn, log_weights, logs, log_evidence(log_weights, size), std, proposals[-1])
