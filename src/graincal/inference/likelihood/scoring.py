"""How a prediction compares with what was then measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graincal.data import InputError, Reference
from graincal.inference.likelihood.error_model import ErrorModel, error_model
from graincal.inference.likelihood.errors import observable_errors, sample_errors
from graincal.inference.likelihood.likelihood import ReducedLikelihood
from graincal.inference.likelihood.measured_band import central_interval, measured_deviations
from graincal.inference.likelihood.reduction import columns
from graincal.inference.likelihood.thinning import Thinning


@dataclass(frozen=True)
class Score:
    """coverage: the share of rows within the band, by observable. log_score: log p(y) under the prediction, measurement errors included, for each value that is
    kept of a dense curve (`Thinning`); the larger the better. error: that of the mean response (Hartmann, Cheng, Thornton 2022, Eq. 6), percent."""

    probability: float
    coverage: Mapping[str, float]
    log_score: float
    error: float


def score(
    responses: NDArray[np.float64], reference: Reference, probability: float = 0.9, *, correlation_length: float | None = None, discrepancy: bool | None = None
) -> Score:
    """Compare equally probable responses (K, T, J), at least two, with a reference that they were not fitted to.

    A band holds the central `probability` of responses with measurement errors, state by state. The log score is that of the whole curve under a Gaussian
    of the responses' mean and covariance, to which measurement errors that are correlated at neighbouring states are added (Gneiting and Raftery 2007). The mean of
    their own probabilities would be that of the luckiest response. The covariance of K responses has K - 1 directions; along others there are the errors alone, and two modes are one broad Gaussian.
    correlation_length, discrepancy: of the errors, see `error_model`. Raises InputError for fewer than two responses.
    """
    if len(responses) < 2:
        raise InputError(f"a score needs two responses, not {len(responses)}.")
    thinning = Thinning.of(reference)
    errors = error_model(thinning, correlation_length=correlation_length, discrepancy=discrepancy)
    mean = responses.mean(axis=0)[None]
    return Score(
        probability,
        _coverage(responses, reference, probability, discrepancy),
        _log_density(thinning.reduce(responses), thinning.kept, errors) / thinning.kept.values.size,
        float(sample_errors(observable_errors(mean, reference), reference.shares)[0]),
    )


def _coverage(responses: NDArray[np.float64], reference: Reference, probability: float, discrepancy: bool | None) -> dict[str, float]:
    """The share of rows within the band, by observable."""
    curves = dict(zip(reference.names, np.moveaxis(responses, 2, 0)))
    within = {}
    for name, deviations in measured_deviations(reference.control, curves, reference, reference.control_name, discrepancy).items():
        low, high = central_interval(curves[name], deviations, probability)
        within[name] = float(np.mean((low <= reference.observables[name]) & (reference.observables[name] <= high)))
    return within


def _log_density(responses: NDArray[np.float64], reference: Reference, errors: ErrorModel) -> float:
    """Of the reference, where the responses are a sample of a Gaussian: one more of them differs from their mean by their covariance and by the error of that mean."""
    curves = columns(responses)
    mean, count = curves.mean(axis=0), len(curves)
    basis = (curves - mean).T * np.sqrt((1 + 1 / count) / (count - 1))
    likelihood = ReducedLikelihood.of(reference, errors, mean, basis, np.zeros((len(mean), len(mean))))
    (log_density,) = likelihood(np.zeros((1, count)), np.ones((1, count)))
    return float(log_density)
