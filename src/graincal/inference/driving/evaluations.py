"""Everything that has been told to a posterior filter, and the densities that it was drawn from."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from graincal.data import ParameterSpace
from graincal.inference.driving.batch import Batch
from graincal.inference.driving.known_runs import KnownRuns
from graincal.inference.likelihood.early_stop import leading_states
from graincal.inference.sampling.defensive import DefensiveMixture
from graincal.inference.sampling.importance import log_importance_weights


@dataclass(frozen=True, eq=False)
class Evaluations:
    """N evaluations in the order asked.

    theta (N, n); responses, one (N, T, J) for each reference, NaN where there is none. proposal (N,): the number of the density that each was drawn
    from, -1 for one that was chosen, which carries no weight. infeasible (N,): no response, for the parameters are impossible: the likelihood
    is zero. missing (N,): no response for another reason, which says nothing of the parameters. stopped (N,): the first states of a response, which say
    that the likelihood is next to nothing.
    """

    space: ParameterSpace
    theta: NDArray[np.float64]
    responses: tuple[NDArray[np.float64], ...]
    proposal: NDArray[np.int64]
    missing: NDArray[np.bool_]
    infeasible: NDArray[np.bool_]
    stopped: NDArray[np.bool_]
    proposals: tuple[DefensiveMixture, ...] = ()

    @classmethod
    def none(cls, space: ParameterSpace, shapes: list[tuple[int, int]]) -> Evaluations:
        """Before the first; shapes: (T, J) of each reference."""
        nothing = np.empty(0, dtype=bool)
        return cls(space, np.empty((0, space.size)), tuple(np.empty((0, *shape)) for shape in shapes), np.empty(0, dtype=np.int64), nothing, nothing, nothing)

    @classmethod
    def of(cls, space: ParameterSpace, runs: KnownRuns) -> Evaluations:
        """Runs that were made before, which carry no weight."""
        return cls(space, runs.theta, runs.responses, np.full(len(runs), -1), runs.missing, runs.infeasible, np.zeros(len(runs), dtype=bool))

    def __len__(self) -> int:
        return len(self.theta)

    def with_batch(self, batch: Batch, proposal: DefensiveMixture, drawn: int) -> Evaluations:
        """And those of a batch, whose first `drawn` samples came from the proposal and whose others were chosen."""
        number = np.where(np.arange(len(batch.samples)) < drawn, len(self.proposals), -1)
        return replace(
            self,
            theta=np.concatenate([self.theta, batch.samples.theta]),
            responses=tuple(np.concatenate([known, new]) for known, new in zip(self.responses, batch.responses)),
            proposal=np.concatenate([self.proposal, number]),
            missing=np.concatenate([self.missing, batch.failed & ~batch.infeasible]),
            infeasible=np.concatenate([self.infeasible, batch.infeasible]),
            stopped=np.concatenate([self.stopped, batch.stopped]),
            proposals=(*self.proposals, proposal),
        )

    def first(self, count: int) -> Evaluations:
        """The first so many."""
        return replace(
            self,
            theta=self.theta[:count],
            responses=tuple(responses[:count] for responses in self.responses),
            proposal=self.proposal[:count],
            missing=self.missing[:count],
            infeasible=self.infeasible[:count],
            stopped=self.stopped[:count],
        )

    @property
    def usable(self) -> NDArray[np.bool_]:
        """Which have whole responses, (N,)."""
        return ~(self.missing | self.infeasible | self.stopped)

    @property
    def unit(self) -> NDArray[np.float64]:
        """theta on the unit cube."""
        return self.space.to_unit(self.theta)

    def known(self, experiment: int) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Which have the whole of their response in an experiment, (N,), and which the first of its states only, (N,)."""
        states = leading_states(self.responses[experiment])
        whole = states == self.responses[experiment].shape[1]
        return self.usable | (self.stopped & whole), self.stopped & ~whole & (states > 0)

    def log_densities(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        """The log of how many samples were drawn by volume at points (M, n), of all proposals: (M,)."""
        counts = np.bincount(self.proposal[self.proposal >= 0], minlength=len(self.proposals))
        asked = np.flatnonzero(counts)
        if not len(asked):
            return np.full(len(theta), -np.inf)
        return scipy.special.logsumexp([self.proposals[k].log_density(theta) for k in asked], axis=0, b=counts[asked, None])

    def log_weights(self, log_likelihood: NDArray[np.float64], counted: NDArray[np.bool_]) -> NDArray[np.float64]:
        """log w (N,) for log likelihoods (N,): against all densities that the `counted` samples were drawn from, as many as each of them is of.

        Samples that are not counted, and those that were chosen, have none (-inf).
        """
        drawn = counted & (self.proposal >= 0)
        counts = np.bincount(self.proposal[drawn], minlength=len(self.proposals))
        asked = np.flatnonzero(counts)
        logs = np.full(len(self), -np.inf)
        if drawn.any():
            densities = np.array([self.proposals[k].log_density(self.theta[drawn]) for k in asked])
            logs[drawn] = log_importance_weights(log_likelihood[drawn] - self.space.log_volume, densities, counts[asked])
        return logs
