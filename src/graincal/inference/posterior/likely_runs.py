"""The runs that fit about as well as the answer does, each by its own response: known at any moment, and without an emulator."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from graincal.data import Reference
from graincal.inference.driving.evaluations import Evaluations
from graincal.inference.likelihood.error_model import ErrorModel
from graincal.inference.likelihood.likelihood import log_likelihood, marginal

WITHIN = 2.0
"""Standard deviations of the log likelihood below what the answer has, within which a run fits about as well."""

UNBIASED = (np.nan, np.nan, 1.196, 1.495, 1.363, 1.206, 1.200, 1.140, 1.129, 1.107)
"""By the number of values up to nine, what makes a standard deviation by the median absolute deviation that of a Gaussian's on the mean (Croux and Rousseeuw 1992)."""

HARDLY = 0.1
"""Of the standard deviation that a posterior has by itself: runs at one place whose log likelihoods differ by less do not tell how well others have to fit."""

SCATTERED = 3.0
"""Times the standard deviation that a posterior has by itself: where runs at one place differ by more, nearly any run may fit as well as some run at the answer."""


@dataclass(frozen=True)
class LikelyRuns:
    """count: how many there are. low, high (n,): the ends of the values that they have, of each parameter.

    least: the log likelihood from which a run is one of them. repeated: how many runs at the answer that was found by; 0 where it is by the most likely run, for the answer has
    not been run again yet, or the runs there hardly differ. deviation: the standard deviation of the log likelihood, of which `least` is WITHIN below; NaN in what earlier versions stored.
    """

    count: int
    low: tuple[float, ...]
    high: tuple[float, ...]
    least: float
    repeated: int
    deviation: float = math.nan

    @property
    def scattered(self) -> bool:
        """Whether the runs at the answer scatter so much that one run by itself tells little of the parameters."""
        return self.repeated > 0 and self.deviation > SCATTERED * math.sqrt(len(self.low) / 2)

    @property
    def enough(self) -> bool:
        """Whether there are so many that they can outline a range: more than there are parameters."""
        return self.count > len(self.low)


def likely_runs(evaluations: Evaluations, references: Sequence[Reference], errors: Sequence[ErrorModel], at_answer: int = 0) -> LikelyRuns | None:
    """Of evaluations that have whole responses, under the errors that the posterior counts (an `ErrorModel` for each reference); None where none has. at_answer: how many of
    the last were made at the answer. Those with a response are always among them.

    A run fits about as well if its log likelihood is at most two standard deviations below the median of those of the runs at the answer. Their deviation is the smaller of the standard deviation and that by the
    median absolute deviation, so that one run that is far off does not make every run fit; and at least √(n / 2), the standard deviation of the log likelihood over a Gaussian posterior of n parameters, for twice its distance from the largest has
    the chi-squared distribution of n degrees of freedom. Where the runs at the answer do not tell, it is at most two times √(n / 2) below the largest.
    """
    usable = evaluations.usable
    if not usable.any():
        return None
    logs = log_likelihoods(evaluations, references, errors)
    there = usable & (np.arange(len(evaluations)) >= len(evaluations) - at_answer)
    own = np.sqrt(evaluations.space.size / 2)
    deviation = _deviation(logs[there]) if there.sum() > 1 else 0.0
    tells = deviation > HARDLY * own
    middle, deviation = (np.median(logs[there]), max(deviation, own)) if tells else (logs.max(), own)
    least = middle - WITHIN * deviation
    theta = evaluations.theta[(logs >= least) | there]
    return LikelyRuns(
        len(theta), tuple(theta.min(axis=0).tolist()), tuple(theta.max(axis=0).tolist()), float(least), int(there.sum()) if tells else 0, float(deviation)
    )


def _deviation(values: NDArray[np.float64]) -> float:
    """Of values (K,), two or more: the smaller of their standard deviation and of that by the median absolute deviation, which one that is far off hardly moves."""
    count = len(values)
    factor = UNBIASED[count] if count < len(UNBIASED) else count / (count - 0.8)
    return min(float(np.std(values, ddof=1)), float(factor * scipy.stats.median_abs_deviation(values, scale="normal")))


def log_likelihoods(evaluations: Evaluations, references: Sequence[Reference], errors: Sequence[ErrorModel]) -> NDArray[np.float64]:
    """The log likelihood of each evaluation by its own response, (N,), which a run that fits about as well has at least `LikelyRuns.least` of; -inf without a whole response."""
    usable = evaluations.usable
    logs = np.full(len(evaluations), -np.inf)
    # Small matrices, which several threads only slow down: tenfold and more on a machine whose cores are all at work.
    with threadpool_limits(1):
        logs[usable] = sum(
            marginal(log_likelihood(responses[usable], reference, model), model.log_prior)
            for responses, reference, model in zip(evaluations.responses, references, errors)
        )
    return logs
