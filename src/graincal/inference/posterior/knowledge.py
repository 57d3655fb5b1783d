"""What is known of the parameters: references with what is assumed of their errors, and everything that has been evaluated."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from graincal.data import InputError, ParameterSpace, Reference
from graincal.inference.driving.batch import Batch
from graincal.inference.driving.evaluations import Evaluations
from graincal.inference.driving.known_runs import KnownRuns
from graincal.inference.emulator.emulator import Emulator
from graincal.inference.likelihood.error_model import ErrorModel, ErrorOptions, error_model, hypotheses
from graincal.inference.likelihood.errors import observable_errors, sample_errors
from graincal.inference.likelihood.packings import PackingScatter, Siblings, packing_scatter
from graincal.inference.likelihood.thinning import Thinning
from graincal.inference.posterior.emulation import Emulation, Found, changed, emulate, recall
from graincal.inference.posterior.first_look import FirstLook
from graincal.inference.sampling.defensive import DefensiveMixture

# Of the covariances of the errors: each is held so many times while a likelihood is made of it, and more memory than this is refused.
COPIES = 3
MOST_MEMORY = 4e9


class Knowledge:
    """References, what is assumed of their errors, and the evaluations so far; what these say of the posterior is found by a look at them.

    thinnings, kept: the references as they are weighed, at the states that are kept of each. errors: the hypotheses on the errors of each. scatters: whether each scatters like a run. packings: what
    packings differ by, for each; None where that is not known. evaluations: everything told, after the `before` runs that were known before. Arguments as of `PosteriorFilter`.
    """

    def __init__(
        self,
        space: ParameterSpace,
        references: Sequence[Reference],
        *,
        correlation_length: float | None = None,
        discrepancy: bool | None = None,
        thin: bool = True,
        siblings: Sequence[Siblings | None] | None = None,
        first_look: FirstLook | None = None,
        known: KnownRuns | None = None,
    ) -> None:
        self.space, self.references = space, tuple(references)
        self.thinnings = tuple(Thinning.of(reference, thin) for reference in self.references)
        self.kept = tuple(thinning.kept for thinning in self.thinnings)
        self.siblings = tuple(siblings or [None] * len(self.references))
        if len(self.siblings) != len(self.references):
            raise InputError(f"filter.siblings must have one entry for each of the {len(self.references)} references.")
        self.error_options: ErrorOptions = {"correlation_length": correlation_length, "discrepancy": discrepancy}
        self._check_size(discrepancy)
        self.scatters = tuple(reference.simulated for reference in self.references)
        self.packings: tuple[PackingScatter | None, ...] = (None,) * len(self.references)
        self.errors = self.errors_if()
        self.evaluations = Evaluations.none(space, [reference.values.shape for reference in self.kept])
        if known is not None:
            known.check(space, self.kept)
            self.evaluations = Evaluations.of(space, known)
        self.before = len(self.evaluations)
        if first_look is not None:
            first_look.check(space, self.kept)
        self.first_look = first_look

    def add(self, batch: Batch, proposal: DefensiveMixture, drawn: int) -> None:
        """The evaluations of a batch too, whose first `drawn` samples came from the proposal and whose others were chosen."""
        self.evaluations = self.evaluations.with_batch(batch, proposal, drawn)

    def tell_packings(self, theta: NDArray[np.float64], responses: Sequence[NDArray[np.float64] | None]) -> None:
        """Say what siblings gave at the places theta (P, n), as `PosteriorFilter.tell_packings`."""
        theirs = [np.flatnonzero(np.all(self.evaluations.theta == place, axis=1)) for place in theta]
        own = np.array([rows[0] if len(rows) else -1 for rows in theirs])
        self.packings = tuple(
            None
            if sibling is None or told is None
            else packing_scatter(
                np.array([[thinning.reduce(runs) for runs in each] for each in told]),
                np.where(own[:, None, None] >= 0, known[own], np.nan),
                thinning.kept.control,
                sibling,
            )
            for sibling, told, thinning, known in zip(self.siblings, responses, self.thinnings, self.evaluations.responses)
        )
        self.errors = self.errors_if()

    def fits(self) -> NDArray[np.float64]:
        """The error (Eq. 6) of each evaluation at the states that are kept, (N,); NaN for one without a whole response."""
        errors = np.full(len(self.evaluations), np.nan)
        whole = self.evaluations.usable
        pairs = [observable_errors(responses[whole], reference) for responses, reference in zip(self.evaluations.responses, self.kept)]
        errors[whole] = sample_errors(np.concatenate(pairs, axis=1), np.concatenate([reference.shares for reference in self.kept]))
        return errors

    def errors_if(self, *, discrepancy: bool = True, packings: bool = True) -> tuple[ErrorModel, ...]:
        """The hypotheses on the errors of each reference as they would be without what the model cannot reproduce, or without what packings differ by."""
        options: ErrorOptions = self.error_options if discrepancy else {**self.error_options, "discrepancy": False}
        return tuple(
            error_model(thinning, **options, packings=scatter if packings else None, counted=self.counted(number))
            for number, (thinning, scatter) in enumerate(zip(self.thinnings, self.packings))
        )

    def counted(self, experiment: int) -> float:
        """How often the variance between packings is counted in an experiment: for the mean of those that are run, and once more for the packing that a reference was simulated on, unless what runs
        scatter by, which is added there, holds it already. A sand has none of its own. So many experiments on one packing have its deviation in common: each counts so many times as much of it, that
        together they tell as much of a parameter that they share as one does."""
        siblings = self.siblings[experiment]
        if siblings is None:
            return 0.0
        of_reference = 1.0 if self.references[experiment].simulated and siblings.own == 1 else 0.0
        return siblings.shared / siblings.own + of_reference

    def look(
        self, rng: np.random.Generator, before: Emulation | None, cheaper: Sequence[Emulator] | None, near: DefensiveMixture | None, thorough: bool, last: bool
    ) -> Emulation:
        """Emulate the responses, and find the posterior; as `emulate`."""
        measured = self.errors_if(discrepancy=False, packings=False)
        return emulate(self.evaluations, self.kept, self.errors, self.scatters, rng, before, cheaper, near, thorough, last, measured)

    def changed(self, now: Emulation, before: Emulation, unit: NDArray[np.float64]) -> NDArray[np.float64]:
        """By how much the log likelihood at points (M, n) is another now, by what is known of the responses there; as `emulation.changed`."""
        return changed(now, before, self.kept, self.errors, self.scatters, unit)

    def recall(self, found: Found, cheaper: Sequence[Emulator] | None = None) -> Emulation:
        """What a look at the first of the evaluations found, with its emulators; cheaper: those of the first look, made again if they are not given."""
        if found.cheaper and cheaper is None:
            assert self.first_look is not None, "kernels of a first look are found where there was one"
            cheaper = self.first_look.emulators(self.space, self.kept, found.cheaper)
        return recall(found, self.evaluations.first(len(found.weights)), self.kept, self.errors, self.scatters, cheaper)

    def _check_size(self, discrepancy: bool | None) -> None:
        """Raise InputError where the covariances of a reference that is not thinned would need more memory than is reasonable."""
        for reference, siblings in zip(self.kept, self.siblings):
            states, observables = reference.values.shape
            needed = hypotheses(reference, discrepancy, siblings is not None) * (states * observables) ** 2 * 8 * COPIES
            if needed > MOST_MEMORY:
                raise InputError(
                    f"filter.thin = false keeps all {states} rows of a reference with {observables} observable{'s' * (observables > 1)}, and the covariances of their errors would "
                    f"need about {needed / 1e9:.0f} GB of memory, more than the {MOST_MEMORY / 1e9:g} GB allowed: leave filter.thin out, or give fewer rows."
                )
