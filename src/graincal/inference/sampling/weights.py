"""Importance weights: the likelihood of a response, the recursion over the states, and the covariance that the effective sample size asks for.

The error y_t - x_t is Gaussian with diagonal covariance s W_jj c_tj^2 (Hartmann, Cheng, Thornton 2022, section 2.2). Everything that does not
involve s is gathered in the misfit; what all samples share cancels when weights are normalised, so a log-likelihood is -misfit / (2 s).
Weights live in logs with the largest taken off: samples that are all far from the reference are compared, not lost to underflow.
"""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from graincal.data import InputError, Reference

SCALES = ("peak", "pointwise")

# Where an observable is below this part of its peak, "pointwise" takes its error as constant: a crossing of zero says nothing about the
# accuracy of a test. At equal misfit a point near zero then counts at most 1 / 0.05^2 = 400 times the peak.
POINTWISE_FLOOR = 0.05


class UnreachableSampleSize(ArithmeticError):
    """No covariance gives the effective sample size asked for. The message says why."""


def error_scale(reference: Reference, scale: str = "peak") -> NDArray[np.float64]:
    """The scale c (T, J) of the error, in the observables' units.

    "peak" is the largest |y| of each observable at all its states; "pointwise" is |y| itself, with a floor of 5 % of the peak.
    Raises InputError for another scale, and for an observable that is zero throughout, which has none.
    """
    magnitude = np.abs(reference.values)
    peak = magnitude.max(axis=0)
    if not np.all(peak > 0):
        name = reference.names[int(np.argmin(peak))]
        raise InputError(f"reference: {name} is zero at every {reference.control_name}, so that no error can be measured relative to it.")
    if scale == "peak":
        return np.broadcast_to(peak, magnitude.shape)
    if scale == "pointwise":
        return np.maximum(magnitude, POINTWISE_FLOOR * peak)
    raise InputError(f'filter.scale must be "peak" or "pointwise", not "{scale}".')


def misfit(response: NDArray[np.float64], reference: Reference, scale: str = "peak") -> NDArray[np.float64]:
    """Squared distances from the reference, sum over j of (y_tj - x_tj)^2 / (W_jj c_tj^2): (N, T), infinite where a response is not finite.

    `response` is x, (N, T, J). W = diag(w~) (det w~)^(-1/J) has the determinant 1: only the ratios of the variance shares w~ matter.
    """
    log_shares = np.log(reference.shares)
    relative_variance = np.exp(log_shares - log_shares.mean())
    with np.errstate(over="ignore", invalid="ignore"):
        distance = (reference.values - response) / error_scale(reference, scale)
        squared = np.sum(distance**2 / relative_variance, axis=2)
    return np.where(np.isfinite(squared), squared, np.inf)


def effective_sample_size(weights: NDArray[np.float64]) -> float:
    """1 / (N sum w^2) of normalised weights (N,): the part of the samples that counts, N counting those of weight zero too."""
    return float(1.0 / (len(weights) * np.sum(weights**2)))


def log_weights(misfits: NDArray[np.float64], s: float) -> NDArray[np.float64]:
    """The logs of the weights after each state, (T, N), from misfits (N, T).

    Recursive Bayes: from 1/N before the first state, w_t is proportional to w_(t-1) p(y_t | x_t) and normalised at each t. Normalising
    along the way only rescales, so the product of the likelihoods so far, a running sum of misfits, gives the same weights.
    At least one sample must have finite misfits; the others have weight zero.
    """
    so_far = np.cumsum(misfits, axis=1).T
    logs = -(so_far - so_far.min(axis=1, keepdims=True)) / (2 * s)
    return logs - scipy.special.logsumexp(logs, axis=1, keepdims=True)


def solve_s(misfits: NDArray[np.float64], target: float) -> float:
    """The normalised covariance coefficient s at which the effective sample size after the last state is `target`.

    `misfits` is (N, T), infinite for a failure. The effective sample size rises with s from (samples tied for the best) / N to
    (valid samples) / N; in between there is one root, found in log s between bounds that enclose it.
    Raises UnreachableSampleSize when the target is not strictly in between.
    """
    total = np.cumsum(misfits, axis=1)[:, -1]
    count = len(total)
    valid = int(np.isfinite(total).sum())
    wanted = target * count
    if not wanted < valid:
        raise UnreachableSampleSize(
            f"only {valid} of {count} samples have a usable response, and an effective sample size of {target:g} needs more than {wanted:g}"
        )
    gap = total[np.isfinite(total)] - total.min()
    tied = int(np.sum(gap == 0))
    if not tied < wanted:
        raise UnreachableSampleSize(
            f"{tied} of {count} samples fit the reference equally well and none fits better, "
            f"so that no covariance brings the effective sample size down to {target:g}"
        )
    with np.errstate(divide="ignore"):
        log_half_gap = np.log(gap) - np.log(2)

    def excess(log_s: float) -> float:
        with np.errstate(over="ignore"):
            likelihood = np.exp(-np.exp(log_half_gap - log_s))
        return likelihood.sum() ** 2 / (count * np.sum(likelihood**2)) - target

    # At the lower bound every sample but the best underflows to zero; at the upper one every likelihood is above exp(-slack),
    # so that the effective sample size is above exp(-2 slack) valid / count, which is still more than the target.
    slack = np.log(valid / wanted) / 4
    lower = log_half_gap[gap > 0].min() - np.log(1000)
    upper = log_half_gap.max() - np.log(slack)
    return float(np.exp(scipy.optimize.brentq(excess, lower, upper, xtol=1e-13, rtol=1e-15, maxiter=1000)))
