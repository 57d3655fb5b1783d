"""How a prediction compares with what was then measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from graincal.data import Reference
from graincal.inference.error_model import error_model
from graincal.inference.errors import observable_errors, sample_errors
from graincal.inference.likelihood import log_likelihood, marginal

# Draws of the measurement errors for each predicted response, to find the ends of a band with.
DRAWS = 50


@dataclass(frozen=True)
class Score:
    """coverage: the share of states within the band, by observable. log_score: log p(y) under the prediction, measurement errors included, for each state;
    the larger the better. error: that of the mean response (Hartmann, Cheng, Thornton 2022, Eq. 6), percent."""

    probability: float
    coverage: Mapping[str, float]
    log_score: float
    error: float


def score(responses: NDArray[np.float64], reference: Reference, probability: float = 0.9) -> Score:
    """Compare equally probable responses (K, T, J) with a reference that they were not fitted to.

    A band holds the central `probability` of responses with measurement errors, state by state. The log score is that of the whole curve: the log of
    the mean over the responses of the probability of the reference, under errors that are alike at neighbouring states (Gneiting and Raftery 2007).
    """
    errors = error_model(reference)
    covariance = np.tensordot(np.exp(errors.log_prior), errors.covariances, axes=1)
    states, observables = reference.values.shape
    deviation = np.sqrt(np.diag(covariance)).reshape(observables, states).T
    noise = deviation * np.random.default_rng(0).standard_normal((DRAWS, 1, states, observables))
    possible = (responses[None] + noise).reshape(-1, states, observables)
    low, high = np.quantile(possible, [(1 - probability) / 2, (1 + probability) / 2], axis=0)
    within = (low <= reference.values) & (reference.values <= high)
    logs = marginal(log_likelihood(responses, reference, errors), errors.log_prior)
    mean = responses.mean(axis=0)[None]
    return Score(
        probability,
        dict(zip(reference.names, within.mean(axis=0).tolist())),
        float((logsumexp(logs) - np.log(len(logs))) / reference.values.size),
        float(sample_errors(observable_errors(mean, reference), reference.shares)[0]),
    )
