"""What is known after an iteration: weighted samples and their moments."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graincal.data import InputError, ParameterSpace

PROBABILITY = 0.9
"""Of the intervals that are told."""


@dataclass(frozen=True, eq=False)
class Posterior:
    """Weighted samples of the parameters: `samples` (N, n) in the order of `names`, `weights` (N,) that sum to 1; a failure's weight is 0.

    `mean`, `std` and `interval` speak of the parameters, or of any quantity of interest given as `of` (N, ...): its value for each
    sample, in the samples' order (a whole curve: (N, T)). Values of samples of weight zero are not looked at.
    """

    names: tuple[str, ...]
    samples: NDArray[np.float64]
    weights: NDArray[np.float64]

    def __repr__(self) -> str:
        told = ", ".join(f"{name} {mean:.4g} ± {std:.2g}" for name, mean, std in zip(self.names, self.mean(), self.std()))
        return f"Posterior({len(self.weights)} weighted samples: {told})"

    def mean(self, of: ArrayLike | None = None) -> NDArray[np.float64]:
        """The weighted mean, (n,) or the shape of one value of `of` (Hartmann, Cheng, Thornton 2022, Eq. 3)."""
        weights, values = self._carried(of)
        return np.tensordot(weights, values, axes=1)

    def std(self, of: ArrayLike | None = None) -> NDArray[np.float64]:
        """The weighted standard deviation, shaped like the mean (Eq. 3)."""
        weights, values = self._carried(of)
        return np.sqrt(np.tensordot(weights, (values - self.mean(of)) ** 2, axes=1))

    def interval(self, probability: float = PROBABILITY, of: ArrayLike | None = None) -> NDArray[np.float64]:
        """The central interval of that probability: lower and upper end, (2, n) or (2, ...).

        Its ends are sample values: the smallest at which the cumulated weight reaches (1 - probability) / 2 and (1 + probability) / 2.
        Raises InputError for a probability that is not between 0 and 1.
        """
        if not 0 < probability < 1:
            raise InputError(f"posterior: the probability of an interval must lie between 0 and 1, not {probability}.")
        weights, values = self._carried(of)
        order = np.argsort(values, axis=0, kind="stable")
        ascending = np.take_along_axis(values, order, axis=0)
        cumulated = np.cumsum(weights[order], axis=0)
        ends = []
        for level in ((1 - probability) / 2, (1 + probability) / 2):
            row = np.argmax(cumulated >= level * cumulated[-1], axis=0)
            ends.append(np.take_along_axis(ascending, row[None], axis=0)[0])
        return np.array(ends)

    def relative_std(self, space: ParameterSpace) -> NDArray[np.float64]:
        """The standard deviation over that of the prior of the space, (n,), in what that is uniform in: near 1 nothing was learnt."""
        return Posterior(self.names, space.to_unit(self.samples), self.weights).std() / space.deviation

    def correlation(self) -> NDArray[np.float64]:
        """Pearson's correlation of the parameters under the weights, (n, n); NaN where a parameter does not vary (paper: Table 5)."""
        weights, values = self._carried(None)
        deviation = values - self.mean()
        spread = self.std()
        covariance = (weights[:, None] * deviation).T @ deviation
        with np.errstate(divide="ignore", invalid="ignore"):
            return covariance / np.outer(spread, spread)

    def _carried(self, of: ArrayLike | None) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Weights and values of the samples that carry weight."""
        values = self.samples if of is None else np.asarray(of, dtype=np.float64)
        if values.shape[:1] != self.weights.shape:
            raise InputError(f"posterior: a quantity of interest needs one value for each of the {len(self.weights)} samples, not {values.shape[:1]}.")
        carry = self.weights > 0
        return self.weights[carry], values[carry]
