"""How far responses are from a reference, in percent (Hartmann, Cheng, Thornton 2022, Eq. 5-7)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from graincal.data import Reference


def observable_errors(response: NDArray[np.float64], reference: Reference) -> NDArray[np.float64]:
    """Eq. 5: 100 sum_t |y_tj - x_tj| / sum_t |y_tj| for each sample and observable, (N, J), of a response x (N, T, J).

    The sums run over all states, the first included. Where a response is NaN, so is its error; where the sum overflows, it is infinite.
    """
    values = reference.values
    with np.errstate(over="ignore"):
        return 100 * np.abs(values - response).sum(axis=1) / np.abs(values).sum(axis=0)


def sample_errors(errors: NDArray[np.float64], shares: NDArray[np.float64]) -> NDArray[np.float64]:
    """Eq. 6: the mean of a sample's errors (N, P) over all P pairs of experiment and observable, weighted by 1 / w~: (N,).

    `shares` is w~ (P,): the smaller an observable's variance share, the more its error counts.
    """
    return errors @ (1 / shares) / np.sum(1 / shares)


def gl_error(weights: NDArray[np.float64], errors: NDArray[np.float64]) -> float:
    """Eq. 7: the mean of the samples' errors (N,) under their weights (N,). Samples of weight zero need no error."""
    carry = weights > 0
    return float(weights[carry] @ errors[carry])
