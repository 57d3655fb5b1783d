"""How much of what a posterior says hangs on what was assumed: on the ranges, on the errors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from graincal.data import InputError, ParameterSpace, Reference
from graincal.inference.likelihood.error_model import ErrorModel
from graincal.inference.likelihood.likelihood import ReducedLikelihood
from graincal.inference.posterior.emulation import Emulation
from graincal.inference.sampling.explore import explore
from graincal.inference.sampling.importance import normalised
from graincal.inference.sampling.posterior import Posterior
from graincal.inference.sampling.proposal import systematic_resampling

# Samples of the posterior that are weighted anew for other errors, and how many effective ones are enough.
SAMPLES, ENOUGH = 2000, 200


def evidence_of_half_ranges(posterior: Posterior, space: ParameterSpace, log_evidence: float) -> float:
    """The log evidence if each range were half as wide, about the posterior's mean as far as the range allows. NaN where the constraints leave so little of that, that its volume cannot be known."""
    low = np.clip(space.to_unit(posterior.mean()) - 0.25, 0, 0.5)
    half = space.within(space.from_unit(low), space.from_unit(low + 0.5))
    inside = half.in_ranges(posterior.samples)
    try:
        smaller = space.log_volume - half.log_volume
    except InputError:
        return np.nan
    with np.errstate(divide="ignore"):
        return float(log_evidence + smaller + np.log(posterior.weights[inside].sum()))


def under_other_errors(
    emulation: Emulation,
    space: ParameterSpace,
    references: Sequence[Reference],
    scatters: Sequence[bool],
    errors: Sequence[ErrorModel],
    rng: np.random.Generator,
) -> Posterior:
    """The posterior under other hypotheses on the errors of the references, by the same emulators: no evaluation is made.

    By the samples of the posterior, weighted anew; or by others, where too few of these would carry the weight.
    """
    likelihoods = [
        ReducedLikelihood.of(reference, model, emulator.centre, emulator.basis, emulator.added(scatter))
        for reference, model, scatter, emulator in zip(references, errors, scatters, emulation.emulators)
    ]
    theta = emulation.posterior.samples[systematic_resampling(emulation.posterior.weights, SAMPLES, rng)]
    unit = space.to_unit(theta)
    predicted = [emulator.predict(unit) for emulator in emulation.emulators]
    others, own = (np.sum([likelihood(*each) for likelihood, each in zip(every, predicted)], axis=0) for every in (likelihoods, emulation.likelihoods))
    weights = normalised(others - own)
    if 1 / np.sum(weights**2) >= ENOUGH:
        return Posterior(space.names, theta, weights)
    return _explored(space, lambda unit: emulation.log_likelihood(unit, likelihoods), emulation, rng)


def under_one_likelihood(emulation: Emulation, space: ParameterSpace, experiment: int, likelihood: ReducedLikelihood, rng: np.random.Generator) -> Posterior:
    """The posterior by the emulator of one experiment (its number) alone, under another likelihood of what it predicts."""
    emulator, impossible = emulation.emulators[experiment], emulation.impossible

    def log_likelihood(unit: NDArray[np.float64]) -> NDArray[np.float64]:
        logs = likelihood(*emulator.predict(unit))
        return logs if impossible is None else logs + impossible.log_of_none(unit)

    return _explored(space, log_likelihood, emulation, rng)


def _explored(
    space: ParameterSpace, log_likelihood: Callable[[NDArray[np.float64]], NDArray[np.float64]], emulation: Emulation, rng: np.random.Generator
) -> Posterior:
    # Wider posteriors reach into the ranges.
    near = replace(emulation.explored.proposal, prior_share=0.5)
    found = explore(space, log_likelihood, rng, near=near, thorough=False, last=True)
    return Posterior(space.names, found.theta, found.weights)
