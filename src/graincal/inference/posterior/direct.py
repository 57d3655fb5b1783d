"""Weights of evaluations by their own responses: for models that are deterministic, and where no emulator predicts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from graincal.data import Reference
from graincal.inference.driving.evaluations import Evaluations
from graincal.inference.likelihood.error_model import ErrorModel
from graincal.inference.likelihood.likelihood import log_likelihood, marginal
from graincal.inference.sampling.importance import log_evidence, normalised, pareto_k

# The power of the likelihood is as high as leaves this number of evaluations effective for each parameter.
EFFECTIVE_PER_PARAMETER = 20


@dataclass(frozen=True, eq=False)
class Weighed:
    """weights (N,) of the evaluations under likelihood^power; log_weights (N,) under the likelihood itself, to which log_evidence belongs too."""

    weights: NDArray[np.float64]
    power: float
    log_weights: NDArray[np.float64]
    log_evidence: float

    @property
    def effective_samples(self) -> float:
        """Under the likelihood itself, as a number of evaluations."""
        return float(np.exp(-scipy.special.logsumexp(2 * (self.log_weights - scipy.special.logsumexp(self.log_weights)))))

    @property
    def pareto_k(self) -> float:
        """Of the weights under the likelihood itself."""
        return pareto_k(self.log_weights)


def weigh_directly(evaluations: Evaluations, references: Sequence[Reference], errors: Sequence[ErrorModel], effective: float | None = None) -> Weighed | None:
    """The weights of evaluations; None while no sample that was drawn has a response.

    effective: the number of evaluations to leave effective, by a power of the likelihood below 1 if need be; 20 a parameter, and not more than half
    of all, if not said.
    """
    # An infeasible sample is one of those asked, of likelihood zero; one that is missing has not been asked.
    counted = ~evaluations.missing
    logs = np.full(len(evaluations), -np.inf)
    usable = evaluations.usable
    logs[usable] = sum(
        marginal(log_likelihood(responses[usable], reference, model), model.log_prior)
        for responses, reference, model in zip(evaluations.responses, references, errors)
    )
    base = evaluations.log_weights(np.where(np.isfinite(logs), 0.0, -np.inf), counted)
    carrying = np.isfinite(base)
    if not carrying.any():
        return None
    asked = int((counted & (evaluations.proposal >= 0)).sum())
    if effective is None:
        effective = min(EFFECTIVE_PER_PARAMETER * evaluations.space.size, carrying.sum() / 2)

    def tempered(power: float) -> NDArray[np.float64]:
        return np.where(carrying, base + power * np.where(carrying, logs, 0), -np.inf)

    def excess(log_power: float) -> float:
        at = tempered(np.exp(log_power))[carrying]
        return np.exp(2 * scipy.special.logsumexp(at) - scipy.special.logsumexp(2 * at)) - effective

    power = 1.0
    if excess(0.0) < 0:
        power = float(np.exp(scipy.optimize.brentq(excess, -40, 0, xtol=1e-3))) if excess(-40.0) > 0 else 0.0
    whole = tempered(1.0)
    return Weighed(normalised(tempered(power)), power, whole, log_evidence(whole[carrying], asked))
