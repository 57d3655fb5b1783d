"""How far responses are from a reference, in percent (Hartmann, Cheng, Thornton 2022, Eq. 5-7)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from graincal.data import Reference


def curve_error(response: NDArray[np.float64], reference: NDArray[np.float64], axis: int = -1) -> NDArray[np.float64]:
    """Eq. 5 of one curve x (T,) against another y (T,), percent: 100 sum_t |y_t - x_t| / sum_t |y_t|, of any quantity at the same states.

    Both may hold several curves, whose shapes go together as NumPy's do; states are along `axis`, which is summed over: responses (N, T) against a reference (T,) give (N,).
    The sums run over all states, the first included. Where a response is NaN, so is its error; where the sum overflows, or the reference is 0 throughout, it is infinite, or NaN for 0 / 0.
    """
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        return 100 * np.abs(reference - response).sum(axis=axis) / np.abs(reference).sum(axis=axis)


def observable_errors(response: NDArray[np.float64], reference: Reference) -> NDArray[np.float64]:
    """Eq. 5 (`curve_error`) for each sample and observable, (N, J), of a response x (N, T, J)."""
    return curve_error(response, reference.values, axis=-2)


def sample_errors(errors: NDArray[np.float64], shares: NDArray[np.float64]) -> NDArray[np.float64]:
    """Eq. 6: the mean of a sample's errors (N, P) over all P pairs of experiment and observable, weighted by 1 / w~: (N,).

    `shares` is w~ (P,): the smaller an observable's variance share, the more its error counts.
    """
    return errors @ (1 / shares) / np.sum(1 / shares)


def errors_so_far(responses: Sequence[NDArray[np.float64]], references: Sequence[Reference]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """`observable_errors` (N, P) and `sample_errors` (N,) of responses that were stopped, one (N, T, J) for each reference: over the states that they came
    to, and the experiments that they were run in."""
    pairs = []
    for response, reference in zip(responses, references):
        known = np.isfinite(response)
        apart = np.where(known, np.abs(reference.values - response), 0).sum(axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            errors = 100 * apart / np.where(known, np.abs(reference.values), 0).sum(axis=1)
        pairs.append(np.where(known.any(axis=1), errors, np.nan))
    errors, trust = np.concatenate(pairs, axis=1), 1 / np.concatenate([reference.shares for reference in references])
    with np.errstate(invalid="ignore"):
        means = np.nansum(errors * trust, axis=1) / np.sum(~np.isnan(errors) * trust, axis=1)
    return errors, np.where(np.isnan(means), np.inf, means)


def gl_error(weights: NDArray[np.float64], errors: NDArray[np.float64]) -> float:
    """Eq. 7: the mean of the samples' errors (N,) under their weights (N,). Samples of weight zero need no error."""
    carry = weights > 0
    return float(weights[carry] @ errors[carry])
