"""Weights of samples that were drawn from several densities, and what they say of themselves."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

LEAST = 1e-250
"""Of the largest weight: less is as none, and its reciprocal may be no number."""

ROUNDING = 1e-9
"""A coordinate that varies by no more than this part of itself does not vary."""


def log_importance_weights(log_target: NDArray[np.float64], log_proposals: NDArray[np.float64], counts: NDArray[np.int64]) -> NDArray[np.float64]:
    """log w (N,) of samples against everything that was asked: log target - log sum_k (N_k / N) q_k.

    log_target (N,): prior times likelihood. log_proposals (K, N): the density of each proposal at every sample. counts (K,): how many each was asked
    for. Together the proposals are one mixture, from which the samples are a stratified draw: "deterministic mixture" or "balance heuristic", Veach
    and Guibas (1995), Owen and Zhou (2000).
    """
    shares = counts / counts.sum()
    return log_target - scipy.special.logsumexp(log_proposals, axis=0, b=shares[:, None])


def normalised(log_weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """The weights (N,) that sum to 1."""
    return np.exp(log_weights - scipy.special.logsumexp(log_weights))


def in_variances(points: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """What each sample (M, n), of weights (M,) that sum to 1, counts in the variance of each coordinate, w ((x - mean) / std)^2: (M, k), each column sums to 1, for the k coordinates that vary.

    A percent of the probability six standard deviations off makes a third of a variance.
    """
    squares = (points - weights @ points) ** 2
    variances = weights @ squares
    varies = variances > ROUNDING**2 * np.max(points**2, axis=0, initial=0)
    return weights[:, None] * squares[:, varies] / variances[varies]


def log_evidence(log_weights: NDArray[np.float64], asked: int) -> float:
    """The log of the mean weight: of the integral of prior times likelihood."""
    return float(scipy.special.logsumexp(log_weights) - np.log(asked))


def pareto_k(log_weights: NDArray[np.float64]) -> float:
    """The shape k of the tail of the weights; above 0.7 a few samples decide what all say (Vehtari et al. 2024, Pareto smoothed importance sampling).

    A generalised Pareto distribution fitted to the largest min(N / 5, 3 sqrt N) weights, less the largest of the others. NaN for fewer than 25 samples of weight.
    """
    weights = np.sort(normalised(log_weights[np.isfinite(log_weights)]))
    size = int(min(len(weights) / 5, 3 * np.sqrt(len(weights))))
    if size < 5:
        return np.nan
    tail = weights[-size:] - weights[-size - 1]
    tail = tail[tail > LEAST * tail[-1]]
    if len(tail) < 5:
        return -np.inf
    # The weakly informative prior of the paper, ten samples of k = 0.5.
    return float((len(tail) * _pareto_shape(tail) + 10 * 0.5) / (len(tail) + 10))


def _pareto_shape(excesses: NDArray[np.float64]) -> float:
    """The shape of a generalised Pareto distribution of excesses (N,), ascending and above 0: positive for a heavy tail.

    The distribution is of 1 + b x to the power -1 / k. Given b, the most likely k is the mean of log(1 + b x), so b alone is left: its mean under the likelihood at that k, over points
    spread by a prior that the quartile of the data scales. Source: Zhang and Stephens (2009), Technometrics 51.
    """
    count, largest, quartile = len(excesses), excesses[-1], excesses[int(len(excesses) / 4 + 0.5) - 1]
    points = 30 + int(np.sqrt(count))
    spread = (np.sqrt(points / (np.arange(1, points + 1) - 0.5)) - 1) / (3 * quartile)
    b = spread - 1 / largest
    k = np.mean(np.log1p(b[:, None] * excesses), axis=1)
    log_likelihood = count * (np.log(b / k) - k - 1)
    return float(np.mean(np.log1p((normalised(log_likelihood) @ b) * excesses)))
