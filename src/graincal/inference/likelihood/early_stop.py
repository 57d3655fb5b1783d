"""Whether a run that is under way can still matter to the posterior: its first states bound what all of them can say."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from graincal.data import Reference
from graincal.inference.likelihood.error_model import ErrorModel
from graincal.inference.likelihood.thinning import Thinning

MOST_DROPPED = 1e-3
"""All runs that are stopped together hold at most so much of the posterior's probability."""

SEGMENTS = 4
"""Of a curve: at the end of each it is seen whether a run goes on, and what it came to is learnt from."""


def segments(states: int) -> NDArray[np.int64]:
    """The number of the segment that each of so many states is of, (T,)."""
    return np.arange(states) * min(SEGMENTS, states) // states


class FirstStates:
    """What the first states of a response allow its log likelihood to be at most: that of a response which fits perfectly from there on.

    The likelihood is a product over the states of the probability of each given those before it. What is known of a run's first states makes the first
    of these factors; the others are at most what they are for a state exactly where those before it lead one to expect it. It is a bound as far as the
    simulator's scatter is known, of which few runs tell little.
    """

    def __init__(self, reference: Reference, errors: ErrorModel, added: NDArray[np.float64], simulator: NDArray[np.float64]) -> None:
        """added (J T, J T): beside the errors, as in `ReducedLikelihood`. simulator (J T, J T): what one run may be off from the mean response, by which
        the likelihood goes: a run counts as far from the reference only by what this cannot explain."""
        values = reference.values
        # State by state, unlike elsewhere: so the covariance of the first states is a leading block, and its factor one of the whole's.
        self._order = np.arange(values.size).reshape(values.shape[::-1]).T.ravel()
        self._values = values.ravel()
        self._ends = 1 + np.flatnonzero(np.diff(segments(len(values)), append=SEGMENTS))
        self._log_prior = errors.log_prior
        own = [self._by_states(covariance + added) for covariance in errors.covariances]
        factors = [np.linalg.cholesky(covariance + self._by_states(simulator)) for covariance in own]
        self._whitening = np.array([scipy.linalg.solve_triangular(factor, np.eye(len(factor)), lower=True) for factor in factors])
        # The larger density of the two, so that it remains a bound.
        self._largest = np.array([-np.log(np.diag(np.linalg.cholesky(covariance))).sum() for covariance in own])
        self._largest -= 0.5 * values.size * np.log(2 * np.pi)

    @property
    def largest(self) -> float:
        """Of a response of which nothing is known."""
        return float(scipy.special.logsumexp(self._largest + self._log_prior))

    def whole_segments(self, states: NDArray[np.float64]) -> NDArray[np.float64]:
        """Those of the first states (t, J) that are of segments which are whole."""
        return states[: self._ends[self._ends <= len(states)].max(initial=0)]

    def bound(self, states: NDArray[np.float64]) -> float:
        """Of a response whose first states are known, (t, J)."""
        if not states.size:
            return self.largest
        residual = self._values[: states.size] - states.ravel()
        # Not by linear algebra of several threads, whose last digits depend on their number: what is stopped must not.
        white = np.einsum("hij,j->hi", self._whitening[:, : states.size, : states.size], residual)
        return float(scipy.special.logsumexp(self._largest - 0.5 * np.sum(white**2, axis=1) + self._log_prior))

    def _by_states(self, covariance: NDArray[np.float64]) -> NDArray[np.float64]:
        return covariance[np.ix_(self._order, self._order)]


@dataclass(frozen=True, eq=False)
class EarlyStop:
    """When runs of one batch may be stopped: where the bound on their log likelihood is below `least`, by id; those without one are never. `thinnings`: of the
    reference of each experiment.

    It changes with nothing, so that any thread may ask it, and the result does not depend on when.
    """

    experiments: tuple[FirstStates, ...]
    least: Mapping[int, float]
    thinnings: tuple[Thinning, ...]

    def hopeless(self, experiment: int, id: int, rows: NDArray[np.float64]) -> bool:
        """Whether a sample cannot matter any more, by its first rows (t, J) in one experiment, whatever it gives from there on and in the others."""
        first = self.experiments[experiment]
        states = first.whole_segments(self.thinnings[experiment].states_of(rows))
        if id not in self.least or not len(states) or not np.isfinite(states).all():
            return False
        others = sum(each.largest for number, each in enumerate(self.experiments) if number != experiment)
        return first.bound(states) + others < self.least[id]


def bounds(experiments: Sequence[FirstStates], responses: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """At most what the log likelihood of each sample is, (N,), by its responses, one (N, T, J) for each experiment, NaN from the state on at which it was stopped."""
    total = np.zeros(len(responses[0]))
    for each, response in zip(experiments, responses):
        reached = leading_states(response)
        total += [each.bound(x[:t]) for x, t in zip(response, reached)]
    return total


def leading_states(responses: NDArray[np.float64]) -> NDArray[np.int64]:
    """How many states of each response (N, T, J) are known before the first that is not, (N,)."""
    known: NDArray[np.bool_] = np.all(np.isfinite(responses), axis=2)
    return np.where(known.all(axis=1), known.shape[1], np.argmin(known, axis=1))
