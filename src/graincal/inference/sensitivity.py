"""How much of what a posterior says hangs on what was assumed: on the ranges, on the errors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from graincal.data import ParameterSpace, Reference
from graincal.inference.emulation import Emulation
from graincal.inference.error_model import ErrorModel
from graincal.inference.explore import explore
from graincal.inference.likelihood import ReducedLikelihood
from graincal.inference.posterior import Posterior

def evidence_of_half_ranges(posterior: Posterior, space: ParameterSpace, log_evidence: float) -> float:
    """The log evidence if each range were half as wide, about the posterior's mean as far as the range allows."""
    width = 0.5 * (space.high - space.low)
    low = np.clip(posterior.mean() - 0.5 * width, space.low, space.high - width)
    inside = np.all((posterior.samples >= low) & (posterior.samples <= low + width), axis=1)
    with np.errstate(divide="ignore"):
        return float(log_evidence + space.size * np.log(2) + np.log(posterior.weights[inside].sum()))


def under_other_errors(
    emulation: Emulation, space: ParameterSpace, references: Sequence[Reference], scatters: Sequence[bool], errors: Sequence[ErrorModel], rng: np.random.Generator
) -> Posterior:
    """The posterior under other hypotheses on the errors of the references, by the same emulators: no evaluation is made."""
    likelihoods = [
        ReducedLikelihood.of(reference, model, emulator.centre, emulator.basis, emulator.added(scatter))
        for reference, model, scatter, emulator in zip(references, errors, scatters, emulation.emulators)
    ]
    found = explore(space, lambda unit: emulation.log_likelihood(unit, likelihoods), rng, near=emulation.explored.proposal)
    return Posterior(space.names, found.theta, found.weights)
