"""How much of what a posterior says hangs on what was assumed: on the emulator as it happens to be, on the ranges, on the errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from graincal.data import ParameterSpace, Reference
from graincal.inference.emulation import Emulation
from graincal.inference.emulator import emulated_log_likelihood
from graincal.inference.error_model import ErrorModel
from graincal.inference.explore import explore
from graincal.inference.likelihood import ReducedLikelihood
from graincal.inference.posterior import Posterior
from graincal.inference.proposal import systematic_resampling

# How much a spread counts beside a mean, where it is asked whether the posterior is known.
SPREADS = 0.6

# Joint draws of the emulators, at so many samples of the posterior.
DRAWS, SAMPLES = 40, 300


@dataclass(frozen=True)
class Doubt:
    """What the posterior would be if the simulator's mean response were one of DRAWS that the emulators hold possible, each drawn jointly at samples of the posterior.

    means: root mean square over these of what a parameter's mean would be off, in its standard deviations, of the parameter where it is the most; spreads: of the logarithm of what
    a standard deviation would be other by. log_evidence: (DRAWS,). Where the emulators do not know whether a region fits, a draw has it fit or not.
    """

    means: float
    spreads: float
    log_evidence: NDArray[np.float64]

    @property
    def most(self) -> float:
        """The larger of both, spreads by their part of what means are: their own tails make them uncertain by more."""
        return max(self.means, SPREADS * self.spreads)


def doubt(emulation: Emulation, space: ParameterSpace, rng: np.random.Generator) -> Doubt:
    """How much the emulators' doubt may move the posterior."""
    posterior = emulation.posterior
    unit = space.to_unit(posterior.samples[systematic_resampling(posterior.weights, SAMPLES, rng)])
    logs = np.zeros((DRAWS, SAMPLES))
    for emulator, likelihood in zip(emulation.emulators, emulation.likelihoods):
        drawn = emulator.draw(unit, DRAWS, rng)
        logs += likelihood(drawn.reshape(DRAWS * SAMPLES, -1), np.zeros((DRAWS * SAMPLES, drawn.shape[2]))).reshape(DRAWS, SAMPLES)
    # The samples have the density prior times expected likelihood / evidence.
    relative = logs - emulation.log_likelihood(unit)
    weights = np.exp(relative - logsumexp(relative, axis=1)[:, None])
    means = weights @ unit
    spreads = np.sqrt(np.maximum(weights @ unit**2 - means**2, 1e-300))
    middle, spread = unit.mean(axis=0), unit.std(axis=0)
    off = np.sqrt(np.mean(((means - middle) / np.maximum(spread, spreads)) ** 2, axis=0))
    other = np.sqrt(np.mean(np.log(spreads / spread) ** 2, axis=0))
    return Doubt(float(off.max()), float(other.max()), emulation.log_evidence + logsumexp(relative, axis=1) - np.log(SAMPLES))


def evidence_over_emulators(emulation: Emulation, space: ParameterSpace, rng: np.random.Generator) -> NDArray[np.float64]:
    """The log evidence, (DRAWS,), under responses that the emulators hold possible."""
    return doubt(emulation, space, rng).log_evidence


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
    found = explore(space, lambda unit: emulated_log_likelihood(likelihoods, emulation.emulators, unit), rng, near=emulation.explored.proposal)
    return Posterior(space.names, found.theta, found.weights)
