"""The filter whose posterior means what it says, driven by ask and tell."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from graincal.data import InputError, ParameterSpace, Reference, Samples
from graincal.inference.ask_tell import AskTellFilter
from graincal.inference.batch import Batch, Batches
from graincal.inference.defensive import DefensiveMixture
from graincal.inference.direct import Weighed, weigh_directly
from graincal.inference.early_stop import MOST_DROPPED, EarlyStop
from graincal.inference.emulation import Emulation, emulate
from graincal.inference.emulator import Emulator
from graincal.inference.error_model import error_model, hypotheses
from graincal.inference.errors import gl_error
from graincal.inference.evaluations import Evaluations
from graincal.inference.first_look import FirstLook
from graincal.inference.importance import normalised
from graincal.inference.iteration import Iteration
from graincal.inference.posterior import Posterior
from graincal.inference.proposal import ProposalOutsideBox
from graincal.inference.stop import Stop
from graincal.inference.thinning import Thinning

# The runs at the answer that end a calibration: their mean and their spread say more than the luckiest run.
REPLICATES = 3

# How far apart they are, in parts of the ranges: enough to be another run in float32 too.
APART = 1e-6

# Of the covariances of the errors: each is held so many times while a likelihood is made of it, and more memory than this is refused.
COPIES = 3
MOST_MEMORY = 4e9

# The limit on evaluations that is not set otherwise.
EVALUATIONS_PER_PARAMETER = 20


class PosteriorFilter(AskTellFilter):
    """Calibrates parameters against one or several references: the posterior under errors as a laboratory states them.

    A first batch fills the box. After each batch the responses are emulated (`emulate`) and the next one is drawn from a density fitted to the
    emulated posterior; one sample of each is the answer so far (`Emulation.answer`). Every evaluation is used. At the end the answer is run three times.

    >>> filter = PosteriorFilter(space, reference, seed=1)      # doctest: +SKIP
    >>> while not filter.finished:
    ...     samples = filter.ask()
    ...     filter.tell(samples, [curves(theta) for theta in samples.theta])

    So that nobody waits for the longest run of a batch, `ahead` batches more are asked for while one is under way: batch k is proposed from all up to
    k - 1 - `ahead`, whatever has been told of those between, since a short run is not a better sample. Batches are learnt from in order, once
    they are complete. When a criterion is met, what has been asked for by then is still awaited and used, and then the answer run. Limits count what is asked for.

    The state is a function of the arguments and of what was told, as that of `IterativeBayesianFilter`: telling again what was stored, in any order,
    restores a filter bit for bit. It never ends in an exception. The weights of `iterations` are those of each batch's own samples, and their `s` is NaN.

    Arguments: `first_batch` (4 n by default) and `batch` (2 n) count samples, `ahead` batches. `correlation_length` and `discrepancy`: of the errors, see `error_model`.
    `thin`: whether the rows of dense references are put together, to some 50 to 100 states (see `Thinning`).
    `first_look`: evaluations of cheaper models, which say where to begin and what to expect of each response.
    `early_stop`: whether runs may be stopped that cannot matter any more (`early_stops`), by whoever can; their first states are learnt from.
    `emulator`: without one, evaluations are weighted by their own responses, which takes thousands of them and a deterministic model.
    `stop`: ends it by `posterior_shift`, `max_iterations` and `max_evaluations`, which is 20 n if it is not set. `scatters`: for each reference,
    whether the lab's sample is one of many like the model's runs, because these are spread over several packings; what runs at one Theta scatter by
    is then added to the errors, as it is where a reference was simulated itself. `seed` is a whole number, not negative.
    Raises InputError for arguments that cannot be used.
    """

    def __init__(
        self,
        space: ParameterSpace,
        references: Reference | Sequence[Reference],
        *,
        first_batch: int | None = None,
        batch: int | None = None,
        ahead: int = 0,
        correlation_length: float | None = None,
        discrepancy: bool = False,
        emulator: bool = True,
        early_stop: bool = False,
        thin: bool = True,
        scatters: Sequence[bool] | None = None,
        first_look: FirstLook | None = None,
        stop: Stop = Stop(),
        seed: int = 1,
    ) -> None:
        self.space = space
        self.references = (references,) if isinstance(references, Reference) else tuple(references)
        self.first_batch = 4 * space.size if first_batch is None else first_batch
        self.batch = 2 * space.size if batch is None else batch
        self.ahead = ahead
        self.emulator = emulator
        self.early_stop = early_stop
        self.thinnings = tuple(Thinning.of(reference, thin) for reference in self.references)
        self.stop = stop
        self.seed = seed
        self._check(scatters)
        self._check_size(discrepancy)
        self.errors = tuple(error_model(reference, correlation_length=correlation_length, discrepancy=discrepancy) for reference in self.thinnings)
        self.scatters = tuple(
            reference.simulated or scatter for reference, scatter in zip(self.references, scatters or [False] * len(self.references))
        )
        self._evaluations = Evaluations.none(space, [reference.values.shape for reference in self.kept])
        self._iterations: list[Iteration] = []
        self._emulations: list[Emulation | None] = []
        self._weighed: list[Weighed | None] = []
        self._stops: dict[str, str] = {}
        self._finished = False
        self._batches = Batches()
        # Of each batch under way: the density, and how many samples were drawn from it.
        self._origins: deque[tuple[DefensiveMixture, int]] = deque()
        self._replicated = False
        self._cheaper, self._start = self._look(first_look)
        self._ask(self._start, self.first_batch)
        self._propose()

    @property
    def most_evaluations(self) -> int | None:
        """The limit on evaluations; None for no limit."""
        if self.stop.max_evaluations is False:
            return EVALUATIONS_PER_PARAMETER * self.space.size if self.emulator else None
        return self.stop.max_evaluations

    @property
    def finished(self) -> bool:
        """Whether there is nothing more to ask: the runs at the answer follow after the criteria are met."""
        return self._finished

    @property
    def answered(self) -> bool:
        """Whether the last batch was the runs at the answer, which are not there to move the posterior."""
        return self._replicated and self._finished

    @property
    def evaluations(self) -> Evaluations:
        """Everything told, of complete batches."""
        return self._evaluations

    @property
    def emulation(self) -> Emulation | None:
        """What the last batch brought; None without an emulator, and before there are two responses."""
        return self._emulations[-1] if self._emulations else None

    @property
    def emulations(self) -> tuple[Emulation | None, ...]:
        """After each batch."""
        return tuple(self._emulations)

    @property
    def weighed(self) -> Weighed | None:
        """The evaluations by their own responses, without an emulator."""
        return self._weighed[-1] if self._weighed else None

    @property
    def posterior(self) -> Posterior | None:
        """The posterior under the likelihood itself; None before there is one."""
        if self.emulation:
            return self.emulation.posterior
        weighed = self.weighed
        return Posterior(self.space.names, self._evaluations.theta, normalised(weighed.log_weights)) if weighed else None

    @property
    def log_evidence(self) -> float:
        """The log of the probability of the references under the prior; NaN before there is a posterior."""
        source = self.emulation or self.weighed
        return source.log_evidence if source else np.nan

    def shift(self, last: int = 0) -> float:
        """How far a batch moved the posterior at most, the last one or one so many before: a mean in standard deviations, or the log of a deviation. Infinite where
        there is none to compare with, and where the emulator predicts nothing (`Emulation.predicts`)."""
        if len(self._emulations) < 2 + last:
            return np.inf
        after, earlier = self._emulations[-1 - last], self._emulations[-2 - last]
        if not (after and earlier and after.predicts and earlier.predicts):
            return np.inf
        now, before = after.posterior, earlier.posterior
        with np.errstate(divide="ignore", invalid="ignore"):
            moved = np.abs(now.mean() - before.mean()) / now.std()
            stretched = np.abs(np.log(now.std() / before.std()))
        return float(np.nanmax([*moved, *stretched]))

    def ask_instead(self, samples: Samples) -> None:
        """Have these told next, with ids that go on from the last told, instead of what is asked for: they are learnt from, and carry no weight."""
        self._origins.clear()
        self._origins.append((self._start, 0))
        self._batches.replace(Batch(samples, self.thinnings, self.space))

    # The loop

    def _complete_batch(self, batch: Batch) -> None:
        # By one thread: with several, sums are taken in another order, and the last digits would depend on the machine.
        with threadpool_limits(1):
            self._learn(batch)
            self._go_on()

    def _learn(self, batch: Batch) -> None:
        self._evaluations = self._evaluations.with_batch(batch, *self._origins.popleft())
        if self._evaluations.usable.sum() < 2:
            self._emulations.append(None), self._weighed.append(None)
        elif self.emulator:
            before = next((emulation for emulation in reversed(self._emulations) if emulation), None)
            # Of batches under way those who may stop their runs hold what they need.
            self._emulations = [each and replace(each, first_states=()) for each in self._emulations]
            self._emulations.append(
                emulate(
                    self._evaluations,
                    self.kept,
                    self.errors,
                    self.scatters,
                    self._rng("emulate", len(self._iterations)),
                    before,
                    self._cheaper,
                    self._start if self._cheaper else None,
                )
            )
            self._weighed.append(None)
        else:
            self._emulations.append(None)
            self._weighed.append(weigh_directly(self._evaluations, self.kept, self.errors))
        self._iterations.append(self._iteration(batch))

    def _go_on(self) -> None:
        if not self._stops:
            met = self._reached()
            # Limits keep from asking for more; whether they end it is seen when all that was asked for is there.
            self._stops = {name: clause for name, clause in met.items() if name == "posterior_shift"} if len(self._batches) else met
        if not self._stops:
            self._propose()
        elif len(self._batches):
            return
        elif self.emulation and not self._replicated and "proposal" not in self._stops:
            self._replicated = True
            self._ask(DefensiveMixture(self.space), 0, self._replicates(self.emulation.answer))
        else:
            self._finished = True

    def _propose(self) -> None:
        """Ask for as many batches as may be under way, as far as the limits go."""
        while not self._stops and len(self._batches) <= self.ahead and not self._reached():
            self._propose_one()

    def _propose_one(self) -> None:
        rng = self._rng("propose", self._batches_asked)
        emulation = self.emulation
        if emulation and emulation.predicts:
            self._ask(emulation.explored.proposal, self.batch - 1, emulation.answer[None], emulation if self.early_stop else None)
            return
        weighed = self.weighed or (weigh_directly(self._evaluations, self.kept, self.errors) if self._iterations else None)
        if weighed is None:
            self._ask(self._start, self.batch)
            return
        self._ask(DefensiveMixture.fitted(self.space, self._evaluations.theta, weighed.weights, rng), self.batch)

    def _ask(
        self, proposal: DefensiveMixture, count: int, chosen: NDArray[np.float64] | None = None, emulation: Emulation | None = None
    ) -> None:
        """Ask for so many samples of a density and those chosen. emulation: by which runs of the former may be stopped."""
        try:
            drawn = proposal.draw(count, self._rng("draw", self._batches_asked)) if count else np.empty((0, self.space.size))
        except ProposalOutsideBox as reason:
            self._stops = {"proposal": f"{reason} (after batch {len(self._iterations) - 1})"}
            self._finished = not len(self._batches)
            return
        theta = drawn if chosen is None else np.concatenate([drawn, chosen])
        ids = np.arange(len(theta), dtype=np.int64) + self._batches.asked
        for array in (ids, theta):
            array.setflags(write=False)
        least = dict(zip(ids.tolist(), self._least(emulation, proposal, drawn))) if emulation else {}
        early_stop = EarlyStop(emulation.first_states, least, self.thinnings) if emulation else None
        self._origins.append((proposal, count))
        self._batches.add(Batch(Samples(ids, theta, self.space.names), self.thinnings, self.space, early_stop))

    def _least(self, emulation: Emulation, proposal: DefensiveMixture, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        """The log likelihood (M,) below which samples (M, n) of a proposal are of no account: so many runs of that together have not the part
        MOST_DROPPED of the evidence, which is taken to be the smaller of what the emulator and the runs alone say."""
        densities = self._evaluations.log_densities(theta)
        densities = np.logaddexp(densities, np.log(len(theta)) + proposal.log_density(theta))
        # Ten times as many as there are, whatever the limit: the part that all batches may drop then adds up to a fraction of it, for it grows by the logarithm.
        runs = 10 * (self._batches.asked + len(theta))
        evidence = min(emulation.log_evidence, emulation.log_evidence_of_runs)
        return np.log(MOST_DROPPED / runs) + evidence + self.space.log_volume + densities

    def _look(self, first_look: FirstLook | None) -> tuple[tuple[Emulator, ...] | None, DefensiveMixture]:
        """Emulators of a first look, and the density of the first batch: all of the box where there was none."""
        if first_look is None:
            return None, DefensiveMixture(self.space)
        first_look.check(self.space, self.kept)
        with threadpool_limits(1):
            return first_look.learn(self.space, self.kept, self.errors, self._rng("look", 0))

    def _replicates(self, answer: NDArray[np.float64]) -> NDArray[np.float64]:
        """The answer, so many times: a millionth of the ranges apart, or a deterministic simulator would give the same run each time."""
        middle = 0.5 * (self.space.low + self.space.high)
        inwards = np.where(answer < middle, 1.0, -1.0)
        return answer + APART * np.arange(REPLICATES)[:, None] * inwards * (self.space.high - self.space.low)

    def _reached(self) -> dict[str, str]:
        """The criteria that are met, with a clause each; as `Stop.reached`."""
        stop, count = self.stop, self._batches.asked
        met = {}
        shift = max(self.shift(), self.shift(1))
        if self.emulator and stop.posterior_shift is not False and shift <= stop.posterior_shift:
            met["posterior_shift"] = f"the last two batches moved the posterior by at most {shift:.2f} standard deviations, and {stop.posterior_shift:g} is enough"
        if stop.max_iterations is not False and self._batches_asked >= stop.max_iterations:
            met["max_iterations"] = f"the limit of {stop.max_iterations} batches is reached"
        most = self.most_evaluations
        if most is not None and count + self.batch + (REPLICATES if self.emulator else 0) > most:
            met["max_evaluations"] = f"{count} evaluations are done, and another batch{' and the runs at the answer' if self.emulator else ''} would exceed the limit of {most}"
        if self._iterations and not self._evaluations.usable.any():
            return {"failures": f"all {count} evaluations failed"}
        return met

    def _iteration(self, batch: Batch) -> Iteration:
        pairs, errors, stopped = batch.observable_errors, batch.errors, batch.stopped
        weights, sample_size, mean_error, unweighted = np.zeros(len(errors)), np.nan, np.nan, "no response to learn from"
        if not batch.failed.all() and (self.emulation or self.weighed):
            if self.emulation:
                logs = self.emulation.log_likelihood(self.space.to_unit(batch.samples.theta))
            else:
                logs = self.weighed.log_weights[-len(errors) :]
            logs = np.where(batch.failed | stopped, -np.inf, logs)
            if np.isfinite(logs).any():
                weights, unweighted = normalised(logs), ""
                mean_error = gl_error(weights, errors)
                sample_size = 1 / (len(weights) * np.sum(weights**2))
        for array in (batch.failed, stopped, pairs, errors, weights):
            array.setflags(write=False)
        return Iteration(
            len(self._iterations), batch.samples, None, batch.failed, pairs, errors, weights[None], np.nan, sample_size, mean_error, unweighted, stopped
        )

    @property
    def _batches_asked(self) -> int:
        return len(self._iterations) + len(self._batches)

    def _rng(self, purpose: str, batch: int) -> np.random.Generator:
        """The random numbers of one purpose and of the batch of this number."""
        return np.random.default_rng([self.seed, batch, sum(purpose.encode())])

    def _check_size(self, discrepancy: bool) -> None:
        """Raise InputError where the covariances of a reference that is not thinned would need more memory than is reasonable."""
        for reference in self.kept:
            states, observables = reference.values.shape
            needed = hypotheses(discrepancy) * (states * observables) ** 2 * 8 * COPIES
            if needed > MOST_MEMORY:
                raise InputError(
                    f"filter.thin = false keeps all {states} rows of a reference with {observables} observable{'s' * (observables > 1)}, and the covariances of their errors would "
                    f"need about {needed / 1e9:.0f} GB of memory, more than the {MOST_MEMORY / 1e9:g} GB allowed: leave filter.thin out, or give fewer rows."
                )

    def _check(self, scatters: Sequence[bool] | None) -> None:
        if not self.references:
            raise InputError("filter: at least one reference is needed.")
        self.space.check_experiments(len(self.references))
        for name in ("first_batch", "batch"):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < 2:
                raise InputError(f"filter.{name} must be a whole number above 1, not {value!r}.")
        if isinstance(self.ahead, bool) or not isinstance(self.ahead, (int, np.integer)) or self.ahead < 0:
            raise InputError(f"filter.ahead must be a whole number, not negative, not {self.ahead!r}.")
        if scatters is not None and len(scatters) != len(self.references):
            raise InputError(f"filter.scatters must have one entry for each of the {len(self.references)} references.")
        if not isinstance(self.seed, (int, np.integer)) or self.seed < 0:
            raise InputError(f"seed must be a whole number, not negative, not {self.seed!r}.")
        answer = REPLICATES if self.emulator else 0
        if self.stop.max_evaluations is not False and self.stop.max_evaluations < self.first_batch + answer:
            runs = f" and the {answer} runs at the answer" if answer else ""
            raise InputError(
                f"stop.max_evaluations = {self.stop.max_evaluations} does not hold the first batch of {self.first_batch} samples{runs}: "
                f"at least {self.first_batch + answer}, or a smaller filter.first_batch, was expected."
            )
