"""One iteration: a batch of samples, and what their responses say."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graincal.data import Reference, Samples
from graincal.inference.driving.batch import Batch
from graincal.inference.likelihood.errors import gl_error
from graincal.inference.sampling.posterior import Posterior
from graincal.inference.sampling.proposal import TruncatedMixture
from graincal.inference.sampling.weights import UnreachableSampleSize, effective_sample_size, log_weights, misfit, solve_s


@dataclass(frozen=True, eq=False)
class Iteration:
    """One iteration, complete. N samples, T states (those of the first experiment, then those of the next), P pairs of experiment and observable.

    An iteration whose effective sample size cannot be met has no weights: they are zero, `s`, `effective_sample_size` and `gl_error` are
    NaN, and `unweighted` says why.
    """

    index: int
    samples: Samples
    proposal: TruncatedMixture | None
    """What the samples were drawn from; None in iteration 0, which fills the box."""
    failed: NDArray[np.bool_]
    """(N,): the evaluations without a usable response."""
    observable_errors: NDArray[np.float64]
    """(N, P), percent, Eq. 5 of Hartmann, Cheng, Thornton (2022); NaN for a failure."""
    errors: NDArray[np.float64]
    """(N,), percent, Eq. 6; NaN for a failure."""
    weights: NDArray[np.float64]
    """(T, N): the weights after each state; each row sums to 1, failures have weight zero."""
    s: float
    """The normalised covariance coefficient, a relative variance at each state."""
    effective_sample_size: float
    """1 / (N sum w^2) after the last state."""
    gl_error: float
    """Percent, Eq. 7."""
    unweighted: str = ""
    stopped: NDArray[np.bool_] | None = None
    """(N,): the evaluations that were stopped, whose errors are those of the states that they came to; None for none of them."""

    @property
    def final_weights(self) -> NDArray[np.float64]:
        """The weights after the last state, (N,)."""
        return self.weights[-1]

    @property
    def s_per_state(self) -> float:
        """s / T. At equal misfit s grows with the number of states T: this is what compares between references."""
        return self.s / len(self.weights)

    @property
    def most_probable(self) -> int | None:
        """The row of the largest weight (of equal ones, that of the smallest error); None without weights."""
        if self.unweighted:
            return None
        return int(np.lexsort((self.errors, -self.final_weights))[0])

    @property
    def error(self) -> float:
        """The error of the most probable sample, percent, Eq. 6; NaN without weights."""
        row = self.most_probable
        return np.nan if row is None else float(self.errors[row])

    @property
    def smallest_error(self) -> float:
        """The smallest error of the samples that were not stopped, percent, Eq. 6; NaN if there is none."""
        errors = self.errors[self.complete]
        return float(errors.min()) if len(errors) else np.nan

    @property
    def complete(self) -> NDArray[np.bool_]:
        """(N,): the evaluations that neither failed nor were stopped."""
        return ~self.failed if self.stopped is None else ~(self.failed | self.stopped)

    @property
    def posterior(self) -> Posterior:
        """The samples with their final weights."""
        return Posterior(self.samples.names, self.samples.theta, self.final_weights)


def weigh(
    index: int,
    batch: Batch,
    proposal: TruncatedMixture | None,
    references: Sequence[Reference],
    *,
    scale: str,
    target: float,
) -> Iteration:
    """Compare the responses of a batch with the references, and weigh the samples so that the effective sample size is `target`.

    references: at the states that the responses are at. Several experiments share one s, and their log-likelihoods add.
    Where no covariance does that, the iteration is returned without weights: that none exist is a result, not an error.
    """
    samples, failed, pairs, errors = batch.samples, batch.failed, batch.observable_errors, batch.errors
    misfits = np.concatenate([misfit(x, y, scale) for x, y in zip(batch.responses, references)], axis=1)
    weights = np.zeros(misfits.T.shape)
    s = sample_size = mean_error = np.nan
    unweighted = ""
    try:
        s = solve_s(misfits, target)
        weights = np.exp(log_weights(misfits, s))
        sample_size = effective_sample_size(weights[-1])
        mean_error = gl_error(weights[-1], errors)
    except UnreachableSampleSize as reason:
        unweighted = str(reason)
    for array in (failed, pairs, errors, weights):
        array.setflags(write=False)
    return Iteration(index, samples, proposal, failed, pairs, errors, weights, s, sample_size, mean_error, unweighted)
