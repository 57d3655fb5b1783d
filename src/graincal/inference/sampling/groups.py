"""Separate groups of parameter values among which the weight is divided."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components, minimum_spanning_tree
from scipy.spatial.distance import cdist
from sklearn.exceptions import ConvergenceWarning
from sklearn.mixture import GaussianMixture
from threadpoolctl import threadpool_limits

from graincal.data import ParameterSpace
from graincal.inference import Posterior
from graincal.inference.sampling.proposal import LEAST_WIDTH, systematic_resampling

APART = 6.0
"""Standard deviations within groups that lie between the centres of two: those of one even cloud, cut into halves, are 3.5 apart."""
LEAST_SHARE = 0.1
LEAST_SAMPLES = 3.0
"""Of equal weight, that a group must be worth."""
LEAST_IN_ALL = 15.0
"""Of equal weight, below which no groups are told: of ten, single clouds look divided in up to 20 % of trials, of 24 in 5 % (a thin bent one in 12 %)."""
_NEGLIGIBLE = 0.01
"""Of the largest weight: what carries less is left out."""
_MOST = 5
_MOST_SAMPLES = 3_000
_COPIES = 10


@dataclass(frozen=True, eq=False)
class Group:
    """A group: its share of the weight, and its weighted mean (n,)."""

    share: float
    centre: NDArray[np.float64]


def find_groups(space: ParameterSpace, posterior: Posterior) -> tuple[Group, ...]:
    """The groups of a posterior's samples, the heaviest first; empty where there are not two that can be told apart.

    Gaussian mixtures of one to five components with one covariance are fitted to the samples, scaled by the box and resampled by weight. The Bayesian
    information criterion of as many samples as carry the weight chooses among them. Components that are not APART, or that are no further from each other
    than samples of either are among themselves (a bent ridge, in pieces), are one group. Groups of less than a tenth of the weight, or worth fewer than
    three samples, are not named; and none where all are worth fewer than fifteen.
    """
    carry = posterior.weights > _NEGLIGIBLE * posterior.weights.max()
    weights, samples = posterior.weights[carry], posterior.samples[carry]
    unit = space.to_unit(samples)
    if _effective(weights) < LEAST_IN_ALL:
        return ()
    copies = unit[systematic_resampling(weights, _COPIES * len(weights), np.random.default_rng(0))]
    mixture = _best_mixture(copies, _effective(weights))
    group_of = _joined(mixture, unit)
    groups = []
    for number in range(group_of.max() + 1):
        inside = np.where(group_of == number, weights, 0.0)
        if (share := float(inside.sum())) > LEAST_SHARE and _effective(inside) >= LEAST_SAMPLES:
            groups.append(Group(share, inside @ samples / share))
    return tuple(sorted(groups, key=lambda group: -group.share)) if len(groups) > 1 else ()


def _best_mixture(copies: NDArray[np.float64], effective: float) -> GaussianMixture:
    best, lowest = None, np.inf
    with threadpool_limits(1), warnings.catch_warnings():
        # One that has not converged, or has fewer points than components, is no better by the criterion than it is.
        warnings.simplefilter("ignore", ConvergenceWarning)
        for components in range(1, _MOST + 1):
            mixture = GaussianMixture(components, covariance_type="tied", reg_covar=LEAST_WIDTH**2, n_init=3, random_state=0).fit(copies)
            free = components * (copies.shape[1] + 1)
            criterion = free * np.log(effective) - 2 * effective * mixture.score(copies)
            if criterion < lowest:
                best, lowest = mixture, criterion
    return best


def _joined(mixture: GaussianMixture, unit: NDArray[np.float64]) -> NDArray[np.int32]:
    """For each of the samples (N, n) the number of its group."""
    component = mixture.predict(unit)
    precision = mixture.precisions_
    centres = cdist(mixture.means_, mixture.means_, "mahalanobis", VI=precision)
    # Every k-th of very many: distances between all of them would fill the memory, and gaps between some thousands are known by those.
    every = slice(None, None, -(-len(unit) // _MOST_SAMPLES))
    distances, kept = cdist(unit[every], unit[every], "mahalanobis", VI=precision), component[every]
    widest = np.array([_widest_gap(distances[np.ix_(kept == c, kept == c)]) for c in range(len(centres))])
    joined = centres < APART
    for a, b in np.argwhere(~joined):
        between = distances[np.ix_(kept == a, kept == b)]
        joined[a, b] = between.size and between.min() <= max(widest[a], widest[b])
    return connected_components(joined)[1][component]


def _widest_gap(distances: NDArray[np.float64]) -> float:
    """The longest edge of the shortest tree that connects points of these distances (N, N)."""
    return float(minimum_spanning_tree(distances).max()) if len(distances) > 1 else 0.0


def _effective(weights: NDArray[np.float64]) -> float:
    """The number of samples of equal weight that would carry as much."""
    return float(weights.sum() ** 2 / np.sum(weights**2)) if weights.any() else 0.0
