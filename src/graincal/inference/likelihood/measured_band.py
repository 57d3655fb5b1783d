"""The band of what a test would measure: responses that are equally probable, each with its errors of measurement."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from graincal.data import InputError, Reference
from graincal.inference.likelihood.error_model import mean_variances

# Halvings of the bracket of a quantile: to rounding.
_HALVINGS = 55

# Where the distribution function is flat, any value between is a quantile: the middle of those of probabilities so far below and above.
_BESIDE = 1e-9


def central_interval(means: NDArray[np.float64], deviations: NDArray[np.float64], probability: float = 0.9) -> NDArray[np.float64]:
    """The central interval, (2, ...), of an equal mixture of K normal distributions, by its distribution function; means and standard deviations (K, ...).

    Without deviations its ends are the quantiles of the means: those that leave equal shares of them beyond, and the middle between two where either would. NaN where a mean is.
    Raises InputError for a probability that is not between 0 and 1.
    """
    if not 0 < probability < 1:
        raise InputError(f"an interval's probability must be between 0 and 1, not {probability!r}.")
    ends = [[_quantile(means, deviations, end + beside) for beside in (-_BESIDE, _BESIDE)] for end in ((1 - probability) / 2, (1 + probability) / 2)]
    return np.mean(ends, axis=1)


def measured_deviations(
    control: NDArray[np.float64], responses: Mapping[str, NDArray[np.float64]], like: Reference, control_name: str, discrepancy: bool | None = None
) -> dict[str, NDArray[np.float64]]:
    """The standard deviations, (K, T) each, of what would be measured of responses, (K, T) each, on a control (T,): of those that `like` is a reference of.

    They are of the measurement as `like` states it, and of what the model cannot reproduce (`discrepancy`, see `error_model`). Parts of a value are of each response's own; the peaks and
    the slopes are those of the mean response, and nothing is of what `like` measured. NaN at the rows at which a mean response is.
    Raises InputError for control values that do not increase.
    """
    return {name: _deviations_of(name, control, responses[name], like, control_name, discrepancy) for name in like.names if name in responses}


def _deviations_of(
    name: str, control: NDArray[np.float64], responses: NDArray[np.float64], like: Reference, control_name: str, discrepancy: bool | None
) -> NDArray[np.float64]:
    """Those of one observable, (K, T)."""
    known, found = np.isfinite(responses).all(axis=0), np.full(responses.shape, np.nan)
    if not known.any():
        return found
    # The others are there for their shares alone, by which errors are taken where none are stated; whatever their values are.
    place, values = like.names.index(name), np.ones((len(responses), int(known.sum()), len(like.names)))
    values[:, :, place] = responses[:, known]
    expected = Reference(
        control[known],
        dict(zip(like.names, values.mean(axis=0).T)),
        like.variance_shares,
        like.measurement_errors,
        control_name=control_name,
        control_step=like.control_step if like.control_name == control_name else 0.0,
        simulated=like.simulated,
    )
    found[:, known] = np.sqrt(mean_variances(expected, discrepancy, values))[:, :, place]
    return found


def _quantile(means: NDArray[np.float64], deviations: NDArray[np.float64], probability: float) -> NDArray[np.float64]:
    # The quantile of a mixture lies between the least and the largest of its parts.
    of_parts = means + ndtri(probability) * deviations
    low, high = of_parts.min(axis=0), of_parts.max(axis=0)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        below = _distribution(middle, means, deviations) < probability
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return high


def _distribution(at: NDArray[np.float64], means: NDArray[np.float64], deviations: NDArray[np.float64]) -> NDArray[np.float64]:
    exact = deviations == 0
    parts = np.where(exact, at >= means, ndtr((at - means) / np.where(exact, 1, deviations)))
    return parts.mean(axis=0)
