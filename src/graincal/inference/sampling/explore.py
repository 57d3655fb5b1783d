"""The posterior of a likelihood that costs next to nothing: samples with weights."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from graincal.data import ParameterSpace
from graincal.inference.sampling.defensive import DefensiveMixture
from graincal.inference.sampling.importance import in_variances, log_evidence, log_importance_weights, normalised, pareto_k
from graincal.inference.sampling.proposal import ProposalOutsideBox
from graincal.inference.sampling.tempering import TemperedSample, temper

# Particles that find the posterior; then so many draws from each of a few densities, at most so many, until so many samples are effective.
PARTICLES, DRAWS, EFFECTIVE, MOST_ROUNDS = 1024, 2048, 1000, 5

# The posterior that is reported has so many draws more, of which so large a share is uniform: a few percent of the probability far out make standard deviations, and fewer draws meet
# little of that. On a measured test standard deviations were 10 % too small without, and scattered by as much.
MORE_DRAWS, MORE_UNIFORM = 8192, 0.4

# Then rounds of so many follow, at most so many, from densities fitted half to the posterior and half to what its variances are made of, until that is so many samples of equal weight for each parameter. Where a few percent
# far out were a dozen draws of large weight, standard deviations of the same posterior were 0.155 to 0.242 from one exploration to another without these rounds.
SPREAD_DRAWS, SPREAD_ROUNDS, SPREAD_EFFECTIVE = 4096, 6, 1000

# A posterior that no mixture of Gaussians fits (a thin bent ridge) leaves fewer than these effective. It is then described by particles,
TOO_FEW = 400

# unless these have lost more than half of the probability that the draws have found for sure (three standard deviations).
MOST_LOST = np.log(2)


@dataclass(frozen=True, eq=False)
class Explored:
    """theta (M, n) with log_weights (M,), and log_likelihood (M,) of each. log_evidence, and its standard deviation over such explorations.

    proposal: a density fitted to the posterior, from which the samples were drawn; or, where no mixture fits it well, tempered samples were taken
    instead (`tempered`), whose evidence is known less well.
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
    def effective_samples(self) -> float:
        """As a number of samples."""
        return float(1 / np.sum(self.weights**2))

    @property
    def pareto_k(self) -> float:
        """Of the weights' tail; see `importance.pareto_k`."""
        return pareto_k(self.log_weights)


def explore(
    space: ParameterSpace,
    log_likelihood: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    rng: np.random.Generator,
    *,
    power: float = 1.0,
    near: DefensiveMixture | None = None,
    thorough: bool = True,
    last: bool = False,
) -> Explored:
    """Samples of prior times likelihood^power; log_likelihood takes points (M, n) of the unit cube, and only such as the prior holds possible.

    Tempering finds where the posterior is; its samples are moved along and not independent. So a density is fitted to them, and what is returned are
    draws from that, weighted: their errors are those of independent draws, and the weights tell whether the fit was good. Where it was not, more
    tempered samples are returned.

    thorough: whether to temper anyway; else only where draws from `near` and from densities fitted to them do not find the posterior.
    last: whether it is the posterior that is reported, to which more draws are given.
    near: a density that is thought to be near the posterior, such as that fitted to the posterior of fewer data. It is drawn from too: where a broad mode holds nearly
    all of the probability at low powers, tempering may lose a narrow one on the way, and weights of draws from both densities tell.
    """
    draws = _Draws(space, log_likelihood, power)
    if near is not None and not thorough:
        draws.add(near, rng)
        while draws.proposals and len(draws.proposals) < MOST_ROUNDS and (len(draws.proposals) < 2 or draws.effective_samples < EFFECTIVE):
            if not draws.add(DefensiveMixture.fitted(space, draws.theta, draws.weights, rng), rng):
                break
        if draws.effective_samples >= TOO_FEW:
            return draws.explored(rng, last)
        draws = _Draws(space, log_likelihood, power)
    found = temper(log_likelihood, space, PARTICLES, rng, power=power)
    wide = space.from_unit(found.wide)
    fitted = DefensiveMixture.fitted(space, space.from_unit(found.unit), np.full(PARTICLES, 1 / PARTICLES), rng, wide)
    for proposal in (fitted,) if near is None else (near, fitted):
        draws.add(proposal, rng)
    least = len(draws.proposals) + 1
    while draws.proposals and (len(draws.proposals) < least or (len(draws.proposals) < MOST_ROUNDS and draws.effective_samples < EFFECTIVE)):
        if not draws.add(DefensiveMixture.fitted(space, draws.theta, draws.weights, rng, wide), rng):
            break
    if draws.effective_samples >= TOO_FEW:
        return draws.explored(rng, last)
    tempered = _tempered(space, [found, temper(log_likelihood, space, PARTICLES, rng, power=power)], draws.proposals[-1] if draws.proposals else fitted)
    lost = draws.log_evidence - 3 * draws.log_evidence_std > tempered.log_evidence + MOST_LOST
    return draws.explored(rng, last) if lost else tempered


class _Draws:
    """Draws from several densities, weighted against all of them together."""

    def __init__(self, space: ParameterSpace, log_likelihood: Callable[[NDArray[np.float64]], NDArray[np.float64]], power: float) -> None:
        self.space, self._evaluate, self.power = space, log_likelihood, power
        self.proposals: list[DefensiveMixture] = []
        self.counts: list[int] = []
        self.theta, self.log_likelihood, self.log_weights = np.empty((0, space.size)), np.empty(0), np.empty(0)

    @property
    def weights(self) -> NDArray[np.float64]:
        return normalised(self.log_weights)

    @property
    def effective_samples(self) -> float:
        return float(1 / np.sum(self.weights**2)) if self.proposals else 0.0

    @property
    def log_evidence(self) -> float:
        return log_evidence(self.log_weights, len(self.log_weights)) if self.proposals else -np.inf

    @property
    def log_evidence_std(self) -> float:
        size = len(self.log_weights)
        return float(np.sqrt(max(size * np.sum(self.weights**2) - 1, 0) / size)) if self.proposals else np.inf

    def add(self, proposal: DefensiveMixture, rng: np.random.Generator, count: int | None = None) -> bool:
        """Draw from one more density, if it can be drawn from; count: so often, DRAWS by default."""
        count = DRAWS if count is None else count
        try:
            new = proposal.draw(count, rng)
        except ProposalOutsideBox:
            return False
        self.proposals.append(proposal)
        self.counts.append(count)
        self.theta = np.concatenate([self.theta, new])
        self.log_likelihood = np.concatenate([self.log_likelihood, self._evaluate(self.space.to_unit(new))])
        densities = np.array([each.log_density(self.theta) for each in self.proposals])
        self.log_weights = log_importance_weights(self.power * self.log_likelihood - self.space.log_volume, densities, np.array(self.counts))
        return True

    def explored(self, rng: np.random.Generator, last: bool) -> Explored:
        """What the draws say; with more of them if it is the last."""
        proposal = self.proposals[-1]
        if last:
            self.add(replace(DefensiveMixture.fitted(self.space, self.theta, self.weights, rng), prior_share=MORE_UNIFORM), rng, MORE_DRAWS)
            self._add_where_spread_comes_from(rng)
        return Explored(self.theta, self.log_weights, self.log_likelihood, self.log_evidence, self.log_evidence_std, proposal)

    def _add_where_spread_comes_from(self, rng: np.random.Generator) -> None:
        for _ in range(SPREAD_ROUNDS):
            weights = self.weights
            parts = in_variances(self.space.to_unit(self.theta), weights)
            if np.all(1 / np.sum(parts**2, axis=0) >= SPREAD_EFFECTIVE):
                return
            fitted = DefensiveMixture.fitted(self.space, self.theta, (weights + parts.mean(axis=1)) / 2, rng)
            if not self.add(fitted, rng, SPREAD_DRAWS):
                return


def _tempered(space: ParameterSpace, samples: list[TemperedSample], proposal: DefensiveMixture) -> Explored:
    """Two tempered samples as one: each has the part of the whole that its evidence says."""
    evidences = np.array([sample.log_evidence for sample in samples])
    return Explored(
        space.from_unit(np.concatenate([sample.unit for sample in samples])),
        np.repeat(evidences, [len(sample.unit) for sample in samples]),
        np.concatenate([sample.log_likelihood for sample in samples]),
        float(scipy.special.logsumexp(evidences) - np.log(len(evidences))),
        float(abs(evidences[0] - evidences[1]) / 2),
        proposal,
        tempered=True,
    )
