"""The iterative Bayesian filter, driven by ask and tell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graincal.data import InputError, ParameterSpace, Reference, Samples
from graincal.inference.driving.ask_tell import AskTellFilter
from graincal.inference.driving.batch import Batch, Batches
from graincal.inference.driving.iteration import Iteration, weigh
from graincal.inference.driving.stop import Stop
from graincal.inference.likelihood.thinning import Thinning
from graincal.inference.sampling.posterior import Posterior
from graincal.inference.sampling.proposal import COVARIANCES, ProposalOutsideBox, TruncatedMixture, fit_mixture
from graincal.inference.sampling.samples import halton, number_of_samples
from graincal.inference.sampling.weights import error_scale


class IterativeBayesianFilter(AskTellFilter):
    """Calibrates parameters against one or several references (Hartmann, Cheng, Thornton 2022, sections 2.2 and 5).

    Iteration 0 fills the prior with N samples; each later one draws N from a mixture fitted to the weighted samples of the one before. Weights
    follow from the whole history of the observables, under a covariance chosen so that a given part of the samples stays effective.

    >>> filter = IterativeBayesianFilter(space, reference, seed=1)      # doctest: +SKIP
    >>> while not filter.finished:
    ...     samples = filter.ask()
    ...     filter.tell(samples, [curves(theta) for theta in samples.theta])

    The state is a function of the arguments and of what was told: the random numbers of an iteration come from (seed, iteration) alone, and
    responses are used in the order asked. So telling again what was stored, in any order within an iteration, restores a filter bit for bit.

    It never ends in an exception. When no weights exist (too many evaluations failed, or too many fit equally well) or too little of the next
    proposal lies in the box, it finishes, and `stopped_because` says so; the posterior is then that of the last weighted iteration.

    Arguments: `alpha` sets N (Eq. 4); `effective_sample_size` is the part of all N samples, failures included; `scale` is "peak" or "pointwise"
    (see `error_scale`); `covariance` of the mixture "tied" or "full"; `thin` puts the rows of dense references together (see `Thinning`), which s, a
    variance at each state, follows; `stop` holds the criteria; `seed` is a whole number, not negative.
    Raises InputError for arguments that cannot be used.
    """

    def __init__(
        self,
        space: ParameterSpace,
        references: Reference | Sequence[Reference],
        *,
        alpha: float = 10,
        effective_sample_size: float = 0.3,
        scale: str = "peak",
        covariance: str = "tied",
        thin: bool = False,
        stop: Stop = Stop(),
        seed: int = 1,
    ) -> None:
        self.space = space
        self.references = (references,) if isinstance(references, Reference) else tuple(references)
        self.alpha = alpha
        self.effective_sample_size = effective_sample_size
        self.scale = scale
        self.covariance = covariance
        self.thinnings = tuple(Thinning.of(reference, thin) for reference in self.references)
        self.stop = stop
        self.seed = seed
        self.samples_per_iteration = number_of_samples(space.size, alpha)
        self._check()
        self._iterations: list[Iteration] = []
        self._stops: dict[str, str] = {}
        self._proposal: TruncatedMixture | None = None
        self._batches = Batches()
        self._ask(halton(space, self.samples_per_iteration, self._rng()))

    @property
    def posterior(self) -> Posterior | None:
        """The weighted samples of the last iteration that has weights; None before there is one."""
        weighted = [iteration for iteration in self._iterations if not iteration.unweighted]
        return weighted[-1].posterior if weighted else None

    def _complete_batch(self, batch: Batch) -> None:
        iteration = weigh(
            len(self._iterations),
            batch,
            self._proposal,
            self.kept,
            scale=self.scale,
            target=self.effective_sample_size,
        )
        self._iterations.append(iteration)
        if iteration.failed.all():
            self._stops = {"failures": f"all {len(iteration.failed)} evaluations of iteration {iteration.index} failed"}
        elif iteration.unweighted:
            self._stops = {"effective_sample_size": f"{iteration.unweighted} (iteration {iteration.index})"}
        else:
            self._stops = self.stop.reached(self._iterations) | self._ended
        if not self.finished:
            self._propose(iteration)

    def _propose(self, iteration: Iteration) -> None:
        rng = self._rng()
        proposal = fit_mixture(self.space, iteration.samples.theta, iteration.final_weights, rng, covariance=self.covariance)
        try:
            theta = proposal.draw(self.samples_per_iteration, rng)
        except ProposalOutsideBox as reason:
            self._stops = {"proposal": f"{reason} (after iteration {iteration.index})"}
        else:
            self._proposal = proposal
            self._ask(theta)

    def _rng(self) -> np.random.Generator:
        """The random numbers of the iteration that is about to begin."""
        return np.random.default_rng([self.seed, len(self._iterations)])

    def _ask(self, theta: NDArray[np.float64]) -> None:
        ids = np.arange(len(theta), dtype=np.int64) + self._batches.asked
        for array in (ids, theta):
            array.setflags(write=False)
        self._batches.add(Batch(Samples(ids, theta, self.space.names), self.thinnings, self.space))

    def _check(self) -> None:
        if all(getattr(self.stop, field.name) is False for field in fields(Stop) if field.name != "posterior_shift"):
            raise InputError("stop: every criterion is switched off, so that nothing would end the calibration.")
        if not self.references:
            raise InputError("filter: at least one reference is needed.")
        self.space.check_experiments(len(self.references))
        self.space.check_constraints()
        for reference in self.references:
            error_scale(reference, self.scale)
        if self.covariance not in COVARIANCES:
            raise InputError(f'filter.covariance must be "tied" or "full", not "{self.covariance}".')
        count = self.samples_per_iteration
        if not 1 / count < self.effective_sample_size < 1:
            raise InputError(f"filter.effective_sample_size must lie between 1/{count}, one sample of an iteration, and 1, not {self.effective_sample_size}.")
        if not isinstance(self.seed, (int, np.integer)) or self.seed < 0:
            raise InputError(f"seed must be a whole number, not negative, not {self.seed!r}.")
        if self.stop.max_evaluations is not False and self.stop.max_evaluations < count:
            raise InputError(
                f"stop.max_evaluations = {self.stop.max_evaluations} does not hold one iteration of {count} samples: raise it, or lower filter.alpha."
            )


class SequentialMonteCarloFilter(IterativeBayesianFilter):
    """Iteration 0 of the iterative Bayesian filter alone: the baseline of section 3 of the paper."""

    def __init__(self, *arguments: Any, stop: Stop = Stop(), **options: Any) -> None:
        super().__init__(*arguments, stop=replace(stop, max_iterations=1), **options)
