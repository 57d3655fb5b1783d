"""How much of what a posterior says hangs on what was assumed: on the emulator as it happens to be, on the ranges, on a discrepancy of the model."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from graincal.data import ParameterSpace
from graincal.inference.emulation import Emulation
from graincal.inference.emulator import emulated_log_likelihood
from graincal.inference.error_model import error_model
from graincal.inference.explore import explore
from graincal.inference.likelihood import ReducedLikelihood
from graincal.inference.posterior import Posterior
from graincal.inference.proposal import systematic_resampling
from graincal.inference.thinning import Thinning

# Joint draws of the emulators, at so many samples of the posterior.
DRAWS, SAMPLES = 50, 400


def evidence_over_emulators(emulation: Emulation, space: ParameterSpace, rng: np.random.Generator) -> NDArray[np.float64]:
    """The log evidence, (DRAWS,), if the simulator's mean response were one of so many that the emulators hold possible, each drawn jointly at samples of the posterior.

    Where the emulator does not know whether a region fits, a draw has it fit or not, and the evidence is much the larger or not.
    """
    posterior = emulation.posterior
    unit = space.to_unit(posterior.samples[systematic_resampling(posterior.weights, SAMPLES, rng)])
    logs = np.zeros((DRAWS, SAMPLES))
    for emulator, likelihood in zip(emulation.emulators, emulation.likelihoods):
        drawn = emulator.draw(unit, DRAWS, rng)
        logs += likelihood(drawn.reshape(DRAWS * SAMPLES, -1), np.zeros((DRAWS * SAMPLES, drawn.shape[2]))).reshape(DRAWS, SAMPLES)
    # The samples have the density prior times expected likelihood / evidence.
    return emulation.log_evidence + logsumexp(logs - emulation.log_likelihood(unit), axis=1) - np.log(SAMPLES)


def log_evidence_std(emulation: Emulation, space: ParameterSpace) -> float:
    """The standard deviation of the log evidence: over responses that the emulators hold possible, and over explorations."""
    return float(np.hypot(evidence_over_emulators(emulation, space, np.random.default_rng(0)).std(), emulation.explored.log_evidence_std))


def evidence_of_half_ranges(posterior: Posterior, space: ParameterSpace, log_evidence: float) -> float:
    """The log evidence if each range were half as wide, about the posterior's mean as far as the range allows."""
    width = 0.5 * (space.high - space.low)
    low = np.clip(posterior.mean() - 0.5 * width, space.low, space.high - width)
    inside = np.all((posterior.samples >= low) & (posterior.samples <= low + width), axis=1)
    with np.errstate(divide="ignore"):
        return float(log_evidence + space.size * np.log(2) + np.log(posterior.weights[inside].sum()))


def without_discrepancy(
    emulation: Emulation,
    space: ParameterSpace,
    thinnings: Sequence[Thinning],
    scatters: Sequence[bool],
    correlation_length: float | None,
    rng: np.random.Generator,
) -> Posterior:
    """The posterior if the model were able to reproduce the references, by the same emulators: no evaluation is made."""
    likelihoods = [
        ReducedLikelihood.of(
            thinning.kept, error_model(thinning, correlation_length=correlation_length), emulator.centre, emulator.basis, emulator.added(scatter)
        )
        for thinning, scatter, emulator in zip(thinnings, scatters, emulation.emulators)
    ]
    found = explore(space, lambda unit: emulated_log_likelihood(likelihoods, emulation.emulators, unit), rng, near=emulation.explored.proposal)
    return Posterior(space.names, found.theta, found.weights)
