"""What cheaper evaluations of the same tests tell: where to begin, and a first guess of every response."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graincal.data import InputError, ParameterSpace, Reference
from graincal.inference.emulator.emulator import Emulator, Kernels, emulated_log_likelihood
from graincal.inference.likelihood.error_model import ErrorModel
from graincal.inference.likelihood.likelihood import ReducedLikelihood
from graincal.inference.sampling.defensive import DefensiveMixture
from graincal.inference.sampling.explore import explore

# The first batch is drawn where the cheap responses fit at this power of their likelihood: a cheap model is off by more than the errors.
POWER = 0.1


@dataclass(frozen=True, eq=False)
class FirstLook:
    """Evaluations of the same tests by cheaper models (fewer particles), all of them with responses.

    theta (M, n) in the order of the space's names; responses, one (M, K, J) for each reference, at the states that are kept of it (`Thinning`) and in the order of its observables.
    They carry no weight, and the answer is none of them.
    """

    theta: NDArray[np.float64]
    responses: tuple[NDArray[np.float64], ...]

    def check(self, space: ParameterSpace, references: Sequence[Reference]) -> None:
        """Raise InputError where they are not of these parameters and references, or too few."""
        shapes = [(len(self.theta), *reference.values.shape) for reference in references]
        if self.theta.ndim != 2 or self.theta.shape[1] != space.size or [each.shape for each in self.responses] != shapes:
            raise InputError(
                "a first look must be of the same parameters, experiments and observables as the calibration, at the states that are kept of its references."
            )
        if np.sum(space.contains(self.theta)) < 2:
            raise InputError(f"a first look needs at least two evaluations within the parameters' ranges, and it has {np.sum(space.contains(self.theta))}.")

    def emulators(self, space: ParameterSpace, references: Sequence[Reference], known: Sequence[Kernels] | None = None) -> tuple[Emulator, ...]:
        """An emulator of the cheap responses to each reference. known: what the search for each found before."""
        inside = space.contains(self.theta)
        unit = space.to_unit(self.theta[inside])
        return tuple(
            Emulator(unit, responses[inside], reference, seen=space.columns(number), known=known[number] if known else None)
            for number, (reference, responses) in enumerate(zip(references, self.responses))
        )

    def learn(
        self, space: ParameterSpace, references: Sequence[Reference], errors: Sequence[ErrorModel], rng: np.random.Generator
    ) -> tuple[tuple[Emulator, ...], DefensiveMixture]:
        """An emulator of the cheap responses to each reference, and the density to draw the first batch from."""
        emulators = self.emulators(space, references)
        likelihoods = [
            ReducedLikelihood.of(reference, model, emulator.centre, emulator.basis, emulator.added(True))
            for reference, model, emulator in zip(references, errors, emulators)
        ]
        found = explore(space, lambda points: emulated_log_likelihood(likelihoods, emulators, points), rng, power=POWER)
        return emulators, found.proposal
