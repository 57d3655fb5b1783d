"""What a campaign found, as its store holds it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Self, overload

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from graincal.campaign.asked.calibration import POSTERIOR, Calibration, round_of
from graincal.campaign.asked.doubt import Doubt
from graincal.campaign.asked.experiment import Experiment
from graincal.campaign.found.answer import Answer, Candidate
from graincal.campaign.found.packings import TROUBLE
from graincal.campaign.found.replay import knowledge, runs_at_answer
from graincal.campaign.found.scatter import Scatter, scatter_of
from graincal.campaign.stored.code import CHANGED
from graincal.campaign.stored.database import said_of_damage
from graincal.campaign.stored.learnt import Learnt
from graincal.campaign.stored.store import Store
from graincal.data import Failure, InputError, ParameterSpace, Response
from graincal.inference import Grade, Posterior, Stop, grade
from graincal.inference.posterior.emulation import Emulation, Found
from graincal.inference.posterior.knowledge import Knowledge
from graincal.inference.posterior.likely_runs import LikelyRuns
from graincal.interpolation import interpolate, within_reach


class Record:
    """What a campaign found in its complete iterations, as its store holds it. N samples in the order asked, n parameters, E experiments.

    samples (N, n), ids (N,), iteration (N,): every sample and the iteration that asked for it. errors (N,): percent, Eq. 6; NaN for a failure.
    observable_errors (N, P): percent, Eq. 5, by experiment and observable. failed (N,): samples without a usable response in some experiment. stopped (N,):
    samples whose run was stopped early, for it could not matter any more (`PosteriorFilter`); their errors are those of the states that they came to.
    seconds (N, E): run time of each evaluation, NaN where none is known. attempts (N, E): how often each was run.
    iterations: what each iteration found (`graincal.inference.Iteration`; the proposals are not kept).
    learnt: what each brought of the posterior, in figures; empty by methods without one.
    stopped_by, stopped_because: the criterion and a sentence; None while the campaign is not at its end.
    calibration: what was asked. provenance: what it was computed with. started: when, ISO 8601.
    """

    def __init__(self, store: Store, calibration: Calibration) -> None:
        self._store = store
        self.calibration = calibration
        self.provenance = store.provenance
        self.started = store.meta("started")
        self.stopped_by = store.meta("stopped_by")
        self.stopped_because = store.meta("stopped_because")
        self.iterations = store.iterations()
        self.learnt: tuple[Learnt, ...] = store.learnt()
        if store.is_library:
            raise InputError(
                f"{store.folder}: this is a library of runs for no reference, which has no result; calibrations learn from it, by runs under [filter] or by --runs."
            )
        if not self.iterations:
            raise InputError(f"{store.folder or 'the campaign'}: no {round_of(calibration.method)} is complete yet, so there is no result.")
        self.ids = np.concatenate([iteration.samples.ids for iteration in self.iterations])
        self.samples = np.concatenate([iteration.samples.theta for iteration in self.iterations])
        self.iteration = np.concatenate([np.full(len(iteration.samples), iteration.index) for iteration in self.iterations])
        self.errors = np.concatenate([iteration.errors for iteration in self.iterations])
        self.observable_errors = np.concatenate([iteration.observable_errors for iteration in self.iterations])
        self.failed = np.concatenate([iteration.failed for iteration in self.iterations])
        self.stopped = np.concatenate([iteration.stopped for iteration in self.iterations])
        self.seconds, self.attempts = self._runs()

    @classmethod
    def read(cls, folder: str | Path) -> Self:
        """The result in a campaign's folder, also of one that is still running. Raises InputError while no iteration is complete."""
        store = Store.open(Path(folder))
        with said_of_damage(store.database.path):
            return cls(store, store.calibration)

    def __repr__(self) -> str:
        state = f"stopped by {self.stopped_by}" if self.stopped_by else "not at its end"
        best = f", best error {self.best.error:.2f} %" if self.best else ""
        return f"{type(self).__name__}({self.evaluations} evaluations in {len(self.iterations)} {'batches' if self.has_posterior else 'iterations'}, {self.failures} failed{best}, {state})"

    @property
    def folder(self) -> Path | None:
        """The campaign's folder; None where it is kept in memory."""
        return self._store.folder

    @property
    def space(self) -> ParameterSpace:
        """The unknowns and their ranges."""
        return self.calibration.space

    @property
    def experiments(self) -> tuple[Experiment, ...]:
        """The experiments, each with its name, reference and model."""
        return tuple(self.calibration.experiments)

    @property
    def truth(self) -> Mapping[str, float]:
        """Values of parameters that are known, as those of a synthetic reference; none for most."""
        return self.calibration.truth

    @property
    def stop(self) -> Stop:
        """The criteria that were asked for."""
        return self.calibration.stop

    @property
    def evaluations(self) -> int:
        """The number of samples evaluated, N; each in every experiment, unless it failed or was stopped in one."""
        return len(self.samples)

    @property
    def recorded_names(self) -> tuple[tuple[str, str], ...]:
        """What was recorded and not fitted, as (experiment, name): the columns of `recorded_errors`."""
        return tuple((experiment.name, name) for experiment in self.experiments for name in experiment.reference.recorded)

    @cached_property
    def recorded_errors(self) -> NDArray[np.float64]:
        """(N, R): percent, Eq. 5, by experiment and recorded quantity (`recorded_names`), of which nothing that was found depends; NaN for failures, and where a value is not finite. Computed from the
        stored responses when first asked for."""
        return self.recorded_errors_of(self.ids)

    def recorded_errors_of(self, ids: Sequence[int] | NDArray[np.int64]) -> NDArray[np.float64]:
        """Those of some samples, by their ids: (len(ids), R)."""
        rows = np.searchsorted(self.ids, ids)
        columns = []
        for number, experiment in enumerate(self.experiments):
            errors = np.full((len(ids), len(experiment.reference.recorded)), np.nan)
            outcomes = self._store.outcomes(ids, number) if errors.size else []
            given = {row: outcome for row, outcome in enumerate(outcomes) if isinstance(outcome, Response) and not self.failed[rows[row]]}
            if given:
                errors[list(given)] = experiment.recorded_errors(list(given.values()))
            columns.append(errors)
        return np.concatenate(columns, axis=1)

    @property
    def complete(self) -> NDArray[np.bool_]:
        """(N,): the samples that neither failed nor were stopped."""
        return ~(self.failed | self.stopped)

    @property
    def failures(self) -> int:
        """How many of the samples failed."""
        return int(self.failed.sum())

    @property
    def best(self) -> Candidate | None:
        """The sample of the smallest error, the luckiest of the runs that were not stopped; None if there is none."""
        return self._candidate(int(np.argmin(np.where(self.complete, self.errors, np.inf)))) if self.complete.any() else None

    @property
    def best_errors(self) -> NDArray[np.float64]:
        """The error of the best sample so far, after each iteration; NaN as long as there is none."""
        return np.fmin.accumulate([iteration.smallest_error for iteration in self.iterations])

    @property
    def most_probable(self) -> Candidate | None:
        """The sample of the largest weight in the last iteration that has weights: the paper's answer. None without weights."""
        weighted = [iteration for iteration in self.iterations if not iteration.unweighted]
        if not weighted:
            return None
        last = weighted[-1]
        return self._candidate(int(np.searchsorted(self.ids, last.samples.ids[last.most_probable])))

    @cached_property
    def found(self) -> Found | None:
        """What the last look at the evaluations found, by the method "posterior"; None before there was one."""
        return self._store.look()

    @cached_property
    def knowledge(self) -> Knowledge:
        """What is known by the complete iterations, by the method "posterior": errors, evaluations, what packings differ by."""
        return knowledge(self._store, self.calibration)

    @cached_property
    def emulation(self) -> Emulation | None:
        """What the last look found, with the emulators that it was found by, which are made again."""
        if self.found is None:
            return None
        with threadpool_limits(1):
            return self.knowledge.recall(self.found)

    @overload
    def derived(self, name: str, compute: Callable[[], NDArray]) -> NDArray: ...

    @overload
    def derived(self, name: str, compute: Callable[[], NDArray | None]) -> NDArray | None: ...

    def derived(self, name: str, compute: Callable[[], NDArray | None]) -> NDArray | None:
        """Numbers that take long to compute of what the last look found: those that are stored, or else computed by one thread and stored; but for None, which is computed again."""
        assert self.found is not None, "there was a look"
        evaluations = len(self.found.weights)
        known = self._store.derived(name, evaluations)
        if known is None:
            with threadpool_limits(1):
                known = compute()
            if known is not None:
                self._store.keep_derived(name, evaluations, known)
        return known

    @property
    def has_posterior(self) -> bool:
        """Whether the method is "posterior", whose spreads mean what they say."""
        return self.calibration.method == POSTERIOR

    @property
    def settled(self) -> bool:
        """Whether the campaign ended for its posterior was known, and fresh runs had confirmed it."""
        return self.stopped_by == "posterior_shift"

    def knows_packings(self, experiment: int) -> bool:
        """Whether packings like that of an experiment (its number) could be prepared, where they were wanted."""
        return self._store.meta(TROUBLE.format(experiment)) is None

    @property
    def answer(self) -> Answer | None:
        """The parameters that fit best as far as the emulator knows, with the runs there once the campaign is at its end; None by other methods, and while nothing is emulated."""
        last = self.iterations[-1]
        if not self.has_posterior:
            return None
        if runs_at_answer(last.samples, self.space):
            return Answer(last.samples.theta[0], last.samples.ids, last.errors)
        return Answer(self.found.answer, np.empty(0, dtype=np.int64), np.empty(0)) if self.found else None

    @cached_property
    def scatter(self) -> Scatter | None:
        """What the runs at the answer differ by, beside what the emulator misses; None where that is not known."""
        return scatter_of(self)

    @property
    def log_evidence(self) -> float:
        """The log of the probability of the references under the prior, method "posterior"; NaN where it is not known. Its sd is in `learnt`."""
        return self.learnt[-1].log_evidence if self.learnt else np.nan

    @property
    def posterior(self) -> Posterior | None:
        """What is known of the parameters: by the method "posterior" the emulated one, else the samples of the last iteration that has weights; None without."""
        if self.has_posterior:
            return self.found.posterior if self.found else None
        return next((iteration.posterior for iteration in reversed(self.iterations) if not iteration.unweighted), None)

    @property
    def shrinkage(self) -> NDArray[np.float64]:
        """The posterior's standard deviation over the prior's, (n,): near 1 nothing was learnt. Only where there is a posterior."""
        assert self.posterior is not None, "asked where there is a posterior"
        return self.posterior.relative_std(self.space)

    @property
    def fits_about_as_well(self) -> LikelyRuns | None:
        """The runs whose log likelihood is within two standard deviations of that of repeated runs at the answer, or above, and the values that they have: by the method "posterior",
        at any moment, settled or not, and by no emulator. None by other methods, and where no run has a response. `likely_runs` says what it is before the answer is run again."""
        return self.learnt[-1].fits_about_as_well if self.has_posterior else None

    @cached_property
    def accepted(self) -> tuple[Doubt, ...]:
        """The problems in spite of which `graincal calibrate --accept` began it; none mostly."""
        return self._store.accepted

    @cached_property
    def grade(self) -> Grade | None:
        """Of the last iteration, by the paper's method: "optimal", "sub-optimal", "no fit" or "no result", and why. None by the method "posterior", which has no such grade."""
        return None if self.has_posterior else grade(self.iterations[-1], self.stop)

    def response(self, sample: int, experiment: int | str = 0) -> Response | Failure | None:
        """What the evaluation of a sample (its id) gave in an experiment (its number or name), on the states of the model; None where it was left out, for it had
        failed or been stopped in another."""
        return self._store.outcome(sample, self.number(experiment))

    def detail(self, name: str, experiment: int | str = 0) -> NDArray[np.float64]:
        """A detail of the evaluations in an experiment, (N,), such as "steps"; NaN where it is not known, as of many failures."""
        known = self._store.detail(name, self.number(experiment))
        return np.array([np.nan if (value := known.get(int(id))) is None else value for id in self.ids], dtype=np.float64)

    def states(self, experiment: int | str = 0) -> NDArray[np.float64]:
        """The control values (S,) of the states that the model of an experiment comes to, those of its longest response; none where there is no response."""
        number, longest = self.number(experiment), np.empty(0)
        for id in (*self.ids[self.complete], *self.ids[~self.complete]):
            outcome = self.response(int(id), number)
            if isinstance(outcome, Response) and not outcome.stopped:
                return outcome.control
            if isinstance(outcome, Response) and len(outcome.control) > len(longest):
                longest = outcome.control
        return longest

    def responses(self, iteration: int, experiment: int | str = 0) -> dict[str, NDArray[np.float64]]:
        """All responses of an iteration in an experiment, at its `states`: name -> (N, S), in the samples' order, NaN for failures and for what was not run. Feed
        them to the posterior's moments."""
        states = self.states(experiment)
        outcomes = [on_states(self.response(int(id), experiment), states) for id in self.iterations[iteration].samples.ids]
        names = next((tuple(outcome.values) for outcome in outcomes if isinstance(outcome, Response)), ())
        found = {name: np.full((len(outcomes), len(states)), np.nan) for name in names}
        for row, outcome in enumerate(outcomes):
            if isinstance(outcome, Response):
                for name in found.keys() & outcome.values.keys():
                    found[name][row, : len(outcome.values[name])] = outcome.values[name]
        return found

    def mean_response(self, answer: Answer, experiment: int | str = 0) -> Response | None:
        """The mean of what the runs at the answer gave in an experiment; None where none gave a response."""
        states = self.states(experiment)
        outcomes = [on_states(self.response(int(id), experiment), states) for id in answer.samples]
        given = [outcome for outcome in outcomes if isinstance(outcome, Response)]
        names = [name for name in given[0].values if all(name in each.values for each in given)] if given else []
        return replace(given[0], values={name: np.mean([each.values[name] for each in given], axis=0) for name in names}, details={}) if given else None

    @cached_property
    def code_changed(self) -> str | None:
        """The files of its functions' code that were changed between two sittings; None where none was, as far as that is known."""
        return self._store.meta(CHANGED)

    def failure_kinds(self) -> list[tuple[str, str, int]]:
        """Kinds of failure with one of their reasons and how often each occurred, the most frequent first."""
        # As stored by a version before, they may be anything.
        return [(failure.kind, failure.reason, count) for kind, reason, count in self._store.failure_kinds() for failure in [Failure(kind, reason)]]

    def number(self, experiment: int | str) -> int:
        """The number of an experiment, from 0, by its number or name. Raises InputError for one that there is not."""
        if isinstance(experiment, int) and 0 <= experiment < len(self.experiments):
            return experiment
        names = [each.name for each in self.experiments]
        if experiment not in names:
            raise InputError(f'there is no experiment "{experiment}"; there are {", ".join(names)}.')
        return names.index(experiment)

    def _candidate(self, row: int) -> Candidate:
        return Candidate(int(self.ids[row]), int(self.iteration[row]), self.samples[row], float(self.errors[row]))

    def _runs(self) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        seconds = np.full((len(self.ids), len(self.experiments)), np.nan)
        attempts = np.zeros(seconds.shape, dtype=np.int64)
        rows = {int(id): row for row, id in enumerate(self.ids)}
        for sample, experiment, tries, took in self._store.runs():
            if sample in rows:
                attempts[rows[sample], experiment] = tries
                seconds[rows[sample], experiment] = np.nan if took is None else took
        return seconds, attempts


def on_states(outcome: Response | Failure | None, states: NDArray[np.float64]) -> Response | Failure | None:
    """An outcome at the states (S,) of its model, or the first of them that it comes to: a curve that was told by hand may be on others, and is NaN where it does not reach as far."""
    if not isinstance(outcome, Response) or np.array_equal(outcome.control, states[: len(outcome.control)]):
        return outcome
    reached = within_reach(outcome.control, states)
    met = interpolate(outcome, states[:reached])
    if isinstance(met, Failure):
        return met
    return replace(met, control=states, values={name: np.append(values, np.full(len(states) - reached, np.nan)) for name, values in met.values.items()})
