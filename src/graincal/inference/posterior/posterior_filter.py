"""The filter whose posterior means what it says, driven by ask and tell."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from graincal.data import InputError, ParameterSpace, Reference, Samples
from graincal.inference.driving.ask_tell import AskTellFilter
from graincal.inference.driving.batch import Batch, Batches
from graincal.inference.driving.evaluations import Evaluations
from graincal.inference.driving.iteration import Iteration
from graincal.inference.driving.known_runs import KnownRuns, uncovered
from graincal.inference.driving.stop import ITERATIONS, Stop
from graincal.inference.emulator.emulator import Emulator
from graincal.inference.likelihood.early_stop import MOST_DROPPED, EarlyStop
from graincal.inference.likelihood.error_model import ErrorModel
from graincal.inference.likelihood.errors import gl_error
from graincal.inference.likelihood.packings import PackingScatter, Siblings, places
from graincal.inference.posterior.direct import Weighed, weigh_directly
from graincal.inference.posterior.doubt import CENTRAL, Doubt
from graincal.inference.posterior.emulation import Emulation, Found
from graincal.inference.posterior.first_look import FirstLook
from graincal.inference.posterior.knowledge import Knowledge
from graincal.inference.posterior.options import check_options
from graincal.inference.posterior.settling import FRESH, Settling
from graincal.inference.sampling.defensive import DefensiveMixture
from graincal.inference.sampling.importance import normalised
from graincal.inference.sampling.posterior import Posterior
from graincal.inference.sampling.proposal import ProposalOutsideBox, systematic_resampling
from graincal.inference.sampling.samples import replicates

# The runs at the answer that end a calibration: their mean and their spread say more than the luckiest run.
REPLICATES = 3

# Samples of the first batch for each parameter where every run counts. More are there to fill the ranges.
FIRST_PER_PARAMETER = 4

# The limit on evaluations that is not set otherwise: so many a parameter, or so many times a first batch that fills the ranges.
EVALUATIONS_PER_PARAMETER, FIRST_BATCHES = 30, 10

# Runs grow by this part before the posterior is looked at again.
GROWTH = 0.25

# Evaluations up to which each look tempers anew.
FEW = 200


Looks = Callable[[int], Found | None]
"""What was found before by a look at so many evaluations; None where there was none."""


class PosteriorFilter(AskTellFilter):
    """Calibrates parameters against one or several references: the posterior under errors as a laboratory states them.

    A first batch fills the prior. When the runs have grown by a quarter the responses are emulated (`emulate`); the next batch is drawn from a density fitted to the
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

    Arguments: `first_batch` (4 n by default) and `batch` (a quarter of those so far, at least 2 n) count samples, `ahead` batches. `correlation_length` and `discrepancy`: of the errors, see `error_model`.
    `thin`: whether the rows of dense references are put together, to some 50 to 100 states (see `Thinning`).
    `first_look`: evaluations of cheaper models, which say where to begin and what to expect of each response.
    `early_stop`: whether runs may be stopped that cannot matter any more (`early_stops`), by whoever can; their first states are learnt from.
    `emulator`: without one, evaluations are weighted by their own responses, which takes thousands of them and a deterministic model.
    `known`: runs of the same models that were made before; the first batch then fills what they leave open, and is 2 n samples at the least.
    `stop`: ends it by `posterior_shift`, `max_iterations` and `max_evaluations`, which is 30 n if it is not set, and ten first batches where these are of more than 4 n. `seed` is a whole number, not negative.
    `siblings`: for each reference, how its model can be run on packings like its own (`Siblings`), or None where it cannot: once the first batch is told, `places` says where they
    are to be run, and nothing is learnt before `tell_packings` says what they gave.
    `looks`: what was found before by a look at so many evaluations, so that it is not taken again, or None; of the same arguments and evaluations. Raises InputError for arguments that cannot be used.
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
        discrepancy: bool | None = None,
        emulator: bool = True,
        early_stop: bool = False,
        thin: bool = True,
        siblings: Sequence[Siblings | None] | None = None,
        first_look: FirstLook | None = None,
        known: KnownRuns | None = None,
        stop: Stop = Stop(),
        seed: int = 1,
        looks: Looks | None = None,
    ) -> None:
        self.space = space
        references = (references,) if isinstance(references, Reference) else tuple(references)
        self.first_batch = FIRST_PER_PARAMETER * space.size if first_batch is None else first_batch
        self.batch = batch
        self.ahead = ahead
        self.emulator = emulator
        self.early_stop = early_stop
        self.stop = stop
        self.seed = seed
        if not references:
            raise InputError("filter: at least one reference is needed.")
        space.check_experiments(len(references))
        space.check_constraints()
        check_options({"first_batch": self.first_batch, "batch": batch}, ahead, seed, stop, self._at_answer)
        self.knowledge = Knowledge(
            space, references, correlation_length=correlation_length, discrepancy=discrepancy, thin=thin, siblings=siblings, first_look=first_look, known=known
        )
        self.thinnings = self.knowledge.thinnings
        self._told_packings = not any(self.siblings)
        self._places: NDArray[np.float64] | None = None
        self._held: Batch | None = None
        self._iterations: list[Iteration] = []
        self._latest: Emulation | None = None
        self._found: list[Found | None] = []
        self._weighed: list[Weighed | None] = []
        self._stops: dict[str, str] = {}
        self._finished = False
        self._batches = Batches()
        # Of each batch under way: the density, and how many samples were drawn from it.
        self._origins: deque[tuple[DefensiveMixture, int]] = deque()
        self._replicated = False
        self._looked_at = 0
        self._settling = Settling(stop.posterior_shift)
        self._recall: Looks = looks or (lambda count: None)
        self._taken: list[Found] = []
        self._cheaper, self._start = self._first_look(first_look)
        self._begin()
        self._propose()

    @property
    def errors(self) -> tuple[ErrorModel, ...]:
        """The hypotheses on the errors of each reference."""
        return self.knowledge.errors

    @property
    def siblings(self) -> tuple[Siblings | None, ...]:
        """For each reference, how its model can be run on packings like its own."""
        return self.knowledge.siblings

    @property
    def packings(self) -> tuple[PackingScatter | None, ...]:
        """What packings differ by, for each reference; None where it is not known."""
        return self.knowledge.packings

    @property
    def places(self) -> NDArray[np.float64] | None:
        """Where the siblings of each experiment's packing are to be run, theta (P, n), before anything is learnt; None where they are not wanted (any more)."""
        return self._places

    def tell_packings(self, theta: NDArray[np.float64], responses: Sequence[NDArray[np.float64] | None]) -> None:
        """Say what siblings gave at the places theta (P, n), which evaluations were made at too: for each reference (S, P, R, T, J), R runs of each, at all of its rows, NaN where there is no response; None
        where none could be run. Then the first batch is learnt from."""
        if self._places is None:
            raise InputError("tell_packings: no runs on other packings are wanted now.")
        self._told_packings, self._places = True, None
        self.knowledge.tell_packings(theta, responses)
        if self._held is not None:
            held, self._held = self._held, None
            self._after(held)
            self._complete_batches()

    @property
    def most_evaluations(self) -> int | None:
        """The limit on evaluations; None for no limit."""
        if self.stop.max_evaluations is False:
            few = EVALUATIONS_PER_PARAMETER * self.space.size
            return max(few, FIRST_BATCHES * self.first_batch if self._fills else few) if self.emulator else None
        return self.stop.max_evaluations

    @property
    def _fills(self) -> bool:
        """Whether runs are so cheap that the first batch is there to fill the ranges."""
        return self.first_batch > FIRST_PER_PARAMETER * self.space.size

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
        return self.knowledge.evaluations

    @property
    def emulation(self) -> Emulation | None:
        """What the last batch brought; None without an emulator, and before there are two responses."""
        return self._latest

    @property
    def found(self) -> tuple[Found | None, ...]:
        """What was found of the posterior after each batch; None without an emulator, and where there were less than two responses."""
        return tuple(self._found)

    def take_looks(self) -> list[Found]:
        """What was found by looks at the evaluations since this was last asked; a look for the answer is among them, which `found` leaves out."""
        taken, self._taken = self._taken, []
        return taken

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
        return Posterior(self.space.names, self.evaluations.theta, normalised(weighed.log_weights)) if weighed else None

    @property
    def log_evidence(self) -> float:
        """The log of the probability of the references under the prior; NaN before there is a posterior."""
        source = self.emulation or self.weighed
        return source.log_evidence if source else np.nan

    @property
    def doubt(self) -> Doubt | None:
        """How much what the emulators do not know may move the posterior, as it is now."""
        return self._latest.doubt if self._latest else None

    @property
    def confirmed(self) -> float:
        """By what factor the latest fresh runs at draws from the posterior changed their places' probability, on the mean: 1 where they fitted as it had said; NaN before there are any."""
        return self._settling.confirmed

    def shift(self, last: int = 0) -> float:
        """How far a batch moved the posterior at most, the last one or one so many before: a mean in standard deviations, or the log of the width of an interval of 68 %. Infinite where
        there is none to compare with or it was not looked at, and where the emulator predicts nothing (`Emulation.predicts`)."""
        if len(self._found) < 2 + last:
            return np.inf
        after, earlier = self._found[-1 - last], self._found[-2 - last]
        if after is earlier or not (after and earlier and after.predicts and earlier.predicts):
            return np.inf
        now, before = after.posterior, earlier.posterior
        with np.errstate(divide="ignore", invalid="ignore"):
            moved = np.abs(now.mean() - before.mean()) / now.std()
            stretched = np.abs(np.log(np.ptp(now.interval(CENTRAL), axis=0) / np.ptp(before.interval(CENTRAL), axis=0)))
        return float(np.nanmax([*moved, *stretched]))

    def batch_after(self, count: int) -> int:
        """How many samples a batch has that is asked for after so many, fresh runs apart."""
        return max(2 * self.space.size, int(np.ceil(GROWTH * count))) if self.batch is None else self.batch

    # The loop

    def _complete_batches(self) -> None:
        while self._held is None and (batch := self._batches.take_complete()):
            self._complete_batch(batch)

    def _begin(self) -> None:
        """Ask for the first batch: of runs that fill the ranges, those that no known run is near."""
        if not self.knowledge.before:
            return self._ask(self._start, self.first_batch)
        filling = self._start.draw(self.first_batch, self._rng("draw", 0))
        least = min(2 * self.space.size, self.first_batch)
        # A run that failed by a limit says nothing of its place.
        told = self.evaluations.unit[~self.evaluations.missing]
        open_yet = uncovered(self.space.to_unit(filling), told, least)
        self._ask(self._start, 0, filling[open_yet])

    def _complete_batch(self, batch: Batch) -> None:
        self.knowledge.add(batch, *self._origins.popleft())
        fits = self.knowledge.fits() if not self._told_packings else np.empty(0)
        if np.isfinite(fits).any():
            self._places, self._held = places(self.space, self.evaluations.theta, fits), batch
            return
        self._after(batch)

    def _after(self, batch: Batch) -> None:
        # By one thread: with several, sums are taken in another order, and the last digits would depend on the machine.
        with threadpool_limits(1):
            self._learn(batch)
            self._go_on()

    def _learn(self, batch: Batch) -> None:
        if self.evaluations.usable.sum() < 2:
            self._found.append(None)
            self._weighed.append(None)
        elif not self.emulator:
            self._found.append(None)
            self._weighed.append(weigh_directly(self.evaluations, self.kept, self.errors))
        else:
            fresh = self._settling.is_fresh(len(self._iterations))
            if fresh or self._due:
                self._latest = self._look(thorough=fresh)
                self._found.append(self._latest.found)
            else:
                self._found.append(self._found[-1])
            self._weighed.append(None)
            if fresh and self._latest:
                changed = self.knowledge.changed(self._latest, self._settling.before_fresh, self.space.to_unit(batch.samples.theta))
                self._settling.confirm(np.where(batch.infeasible, -np.inf, changed), self._latest, self.shift())
            else:
                self._settling.learn()
        self._iterations.append(self._iteration(batch))

    @property
    def _due(self) -> bool:
        """Whether the runs have grown enough since the last look, or are the last; beside those that were known before."""
        before = self.knowledge.before
        return len(self.evaluations) - before >= (1 + GROWTH) * max(self._looked_at - before, 0) or self._replicated

    def _look(self, thorough: bool) -> Emulation:
        count = len(self.evaluations)
        if found := self._recall(count):
            emulation = self.knowledge.recall(found, self._cheaper)
        else:
            rng, near = self._rng("emulate", count), self._start if self._cheaper else None
            emulation = self.knowledge.look(rng, self._latest, self._cheaper, near, thorough or count <= FEW, self._replicated)
            self._taken.append(emulation.found)
        self._looked_at = count
        return emulation

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
            # What was not looked at yet tells where the answer is; the batch before stays what it was, for whoever goes on by another limit.
            emulation = self.emulation if self._looked_at == len(self.evaluations) else self._look(thorough=False)
            self._replicated = True
            self._ask(DefensiveMixture(self.space), 0, replicates(emulation.answer, REPLICATES, self.space))
        else:
            self._finished = True

    def _propose(self) -> None:
        """Ask for as many batches as may be under way, as far as the limits go."""
        while not self._stops and len(self._batches) <= self.ahead and not self._reached():
            self._propose_one()

    def _propose_one(self) -> None:
        rng, size = self._rng("propose", self._batches_asked), self._next_size
        emulation = self.emulation
        if emulation and self._settling.wants_fresh_runs(emulation):
            drawn = systematic_resampling(emulation.posterior.weights, FRESH, rng)
            self._settling.ask_fresh_runs(self._batches_asked, emulation)
            self._ask(DefensiveMixture(self.space), 0, emulation.posterior.samples[drawn])
            return
        if emulation and emulation.predicts:
            self._ask(emulation.explored.proposal, size - 1, emulation.answer[None], emulation if self.early_stop else None)
            return
        weighed = self.weighed or (weigh_directly(self.evaluations, self.kept, self.errors) if self._iterations else None)
        if weighed is None:
            self._ask(self._start, size)
            return
        self._ask(DefensiveMixture.fitted(self.space, self.evaluations.theta, weighed.weights, rng), size)

    @property
    def _next_size(self) -> int:
        """How many samples the next batch has: as many as the runs are to grow by before the posterior is looked at again, where it is not said. A limit changes nothing of it, so that whoever
        raises one goes on with the same batches."""
        if self._settling.wants_fresh_runs(self.emulation):
            return FRESH
        return self.batch_after(self._batches.asked)

    @property
    def _at_answer(self) -> int:
        return REPLICATES if self.emulator else 0

    def _fits(self, size: int) -> bool:
        """Whether a batch of so many, and the runs at the answer, are within the limit."""
        most = self.most_evaluations
        return most is None or self._batches.asked + size + self._at_answer <= most

    def _ask(self, proposal: DefensiveMixture, count: int, chosen: NDArray[np.float64] | None = None, emulation: Emulation | None = None) -> None:
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
        densities = self.evaluations.log_densities(theta)
        densities = np.logaddexp(densities, np.log(len(theta)) + proposal.log_density(theta))
        # Ten times as many as there are, whatever the limit: the part that all batches may drop then adds up to a fraction of it, for it grows by the logarithm.
        runs = 10 * (self._batches.asked + len(theta))
        evidence = min(emulation.log_evidence, emulation.log_evidence_of_runs)
        return np.log(MOST_DROPPED / runs) + evidence + self.space.log_volume + densities

    def _first_look(self, first_look: FirstLook | None) -> tuple[tuple[Emulator, ...] | None, DefensiveMixture]:
        """Emulators of a first look, and the density of the first batch: all of the box where there was none."""
        if first_look is None:
            return None, DefensiveMixture(self.space)
        with threadpool_limits(1):
            return first_look.learn(self.space, self.kept, self.errors, self._rng("look", 0))

    def _reached(self) -> dict[str, str]:
        """The criteria that are met, with a clause each; as `Stop.reached`."""
        met = {}
        if self._settling.settled and self.doubt is not None:
            met["posterior_shift"] = (
                f"what the emulator does not know moves means and spreads by {self.doubt.most:.2f} standard deviations, {self.stop.posterior_shift:g} is enough, and {FRESH} fresh runs fit as "
                "the posterior says"
            )
        met |= self._limits() | self._ended
        if self._iterations and not self.evaluations.usable.any():
            return {"failures": f"all {self._batches.asked} evaluations failed"}
        return met

    def _limits(self) -> dict[str, str]:
        """The limits that are reached."""
        met, stop, count = {}, self.stop, self._batches.asked
        # Without an emulator nothing else ends it.
        most = ITERATIONS if stop.max_iterations is None and not self.emulator else stop.max_iterations
        if most and self._batches_asked >= most:
            met["max_iterations"] = f"the limit of {most} batches is reached"
        if not self._fits(self._next_size):
            met["max_evaluations"] = (
                f"{count} evaluations are done, and another batch{f' beside the {REPLICATES} runs at the answer' if self.emulator else ''} would exceed the limit of {self.most_evaluations}"
            )
        return met

    def _iteration(self, batch: Batch) -> Iteration:
        pairs, errors, stopped = batch.observable_errors, batch.errors, batch.stopped
        weights, sample_size, mean_error, unweighted = np.zeros(len(errors)), np.nan, np.nan, "no response to learn from"
        logs = None
        if self.emulation:
            logs = self.emulation.log_likelihood(self.space.to_unit(batch.samples.theta))
        elif self.weighed:
            logs = self.weighed.log_weights[-len(errors) :]
        if logs is not None and not batch.failed.all():
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
