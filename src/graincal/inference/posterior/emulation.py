"""What the evaluations so far say of the posterior, through an emulator of each experiment's response."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from graincal.data import Reference
from graincal.inference.driving.evaluations import Evaluations
from graincal.inference.emulator.chance import OF_FAILURES, OF_IMPOSSIBLE, Chance, chance
from graincal.inference.emulator.emulator import Emulator, Kernels, emulated_log_likelihood
from graincal.inference.emulator.process import Kernel
from graincal.inference.likelihood.early_stop import FirstStates, bounds
from graincal.inference.likelihood.error_model import ErrorModel
from graincal.inference.likelihood.likelihood import ReducedLikelihood, log_likelihood, marginal
from graincal.inference.posterior.best_fit import best_fit
from graincal.inference.posterior.doubt import SAMPLES, Doubt, doubt
from graincal.inference.sampling.defensive import DefensiveMixture
from graincal.inference.sampling.explore import Explored, explore
from graincal.inference.sampling.importance import log_evidence, normalised, pareto_k
from graincal.inference.sampling.posterior import Posterior
from graincal.inference.sampling.proposal import systematic_resampling

# An emulator is asked how it does near the posterior; every evaluation counts there a little, so that there is an answer when none carries weight.
LEAST_COUNT = 0.02

# And its variances are judged by so many evaluations at the least.
JUDGES = 10

# Samples of equal weight that a proposal can be fitted to.
FEWEST = 30


@dataclass(frozen=True, eq=False)
class Found:
    """What the evaluations say of the posterior, in figures: all that is kept of it.

    explored: weighted samples of the posterior. answer (n,): where the log likelihood expected under the errors of measurement alone is the largest, so that neither a response that is known to be
    poor nor one that may be anything is the answer.
    held_out (E,): the emulators' error near the posterior where each evaluation is predicted from the others, as a part of the spread of the responses; of_mean (E,): the
    error there if each were predicted by the mean of all. spread (E,): that of the responses, in parts of the reference's peaks; () in what was stored before it was looked at.
    weights (N,): of the evaluations themselves, zero where they carry none;
    effective_runs and pareto_k tell what they are good for; log_evidence_of_runs is by them alone. coverage: how much of the components of
    the evaluations nearest to the reference lies in their 90 % intervals. dropped: the part of the
    posterior's probability that evaluations which were stopped hold at most. doubt: how much what the emulators do not know may move it. kernels (E,): those of the emulators, and cheaper, of a first look's where there was one. lost: the part of the posterior's
    probability that lies where runs give nothing: where they fail, or where parameters are infeasible. of_impossible: the kernel of the chance of that, or none.
    """

    explored: Explored
    answer: NDArray[np.float64]
    held_out: tuple[float, ...]
    of_mean: tuple[float, ...]
    coverage: float
    weights: NDArray[np.float64]
    pareto_k: float
    log_evidence_of_runs: float
    dropped: float
    doubt: Doubt
    lost: float
    kernels: tuple[Kernels, ...]
    cheaper: tuple[Kernels, ...]
    of_impossible: tuple[Kernel, ...]
    spread: tuple[float, ...]

    @cached_property
    def posterior(self) -> Posterior:
        """The weighted samples."""
        return Posterior(self.explored.proposal.space.names, self.explored.theta, self.explored.weights)

    @property
    def log_evidence(self) -> float:
        """The log of the probability of the references under the prior."""
        return self.explored.log_evidence

    @property
    def effective_runs(self) -> float:
        """How many evaluations of equal weight they amount to."""
        return float(1 / np.sum(self.weights**2)) if self.weights.any() else 0.0

    @property
    def held_out_ratio(self) -> float:
        """The held-out error over that of the mean of all, of the worst experiment."""
        return max(error / of_mean if of_mean else 0.0 for error, of_mean in zip(self.held_out, self.of_mean))

    @property
    def predicts(self) -> bool:
        """Whether the emulators say more than that responses are like those already seen, which is all that a mixture of the parameters knows of them."""
        return self.held_out_ratio < 1


@dataclass(frozen=True, eq=False)
class Emulation(Found):
    """The emulated posterior: what was found, the emulators (E,) that it was found by, the likelihoods of what each predicts and of the first states of a run,
    and the chance that parameters are infeasible; None for the latter where none or all were."""

    emulators: tuple[Emulator, ...]
    likelihoods: tuple[ReducedLikelihood, ...]
    first_states: tuple[FirstStates, ...]
    impossible: Chance | None

    def log_likelihood(self, unit: NDArray[np.float64], likelihoods: Sequence[ReducedLikelihood] | None = None) -> NDArray[np.float64]:
        """The emulated log likelihood (M,) at points (M, n) of the unit cube, the chance that these are infeasible included. likelihoods: others, of the same emulators."""
        return _emulated(likelihoods or self.likelihoods, self.emulators, self.impossible, unit)

    @property
    def found(self) -> Found:
        """Without the emulators."""
        return Found(**_figures(self))


def emulate(
    evaluations: Evaluations,
    references: Sequence[Reference],
    errors: Sequence[ErrorModel],
    scatters: Sequence[bool],
    rng: np.random.Generator,
    before: Emulation | None = None,
    cheaper: Sequence[Emulator] | None = None,
    near: DefensiveMixture | None = None,
    thorough: bool = True,
    last: bool = False,
    of_measurement: Sequence[ErrorModel] | None = None,
) -> Emulation:
    """From evaluations of which at least two have responses. scatters: whether each reference scatters like the simulator, whose covariance is then added.
    before: from fewer of the evaluations. cheaper: emulators of a first look at each reference. near: a density that the posterior is near to, for as long as nothing is before.
    thorough, last: as in `explore`; without anything before it is thorough. of_measurement: the errors of the measurements alone, under which the answer fits best; by default `errors`."""
    learnt = [
        _learn(evaluations, number, reference, model, scatter, before.emulators[number] if before else None, cheaper[number] if cheaper else None)
        for number, (reference, model, scatter) in enumerate(zip(references, errors, scatters))
    ]
    emulators, likelihoods, first_states = zip(*learnt)
    unit, space = evaluations.unit, evaluations.space
    impossible = _impossible(evaluations)

    def emulated(points: NDArray[np.float64]) -> NDArray[np.float64]:
        return _emulated(likelihoods, emulators, impossible, points)

    strict = likelihoods if of_measurement is None else _likelihoods(references, of_measurement, scatters, emulators)

    def expected(points: NDArray[np.float64]) -> NDArray[np.float64]:
        logs = sum(likelihood.expected(*emulator.predict(points)) for likelihood, emulator in zip(strict, emulators))
        return logs if impossible is None else logs + impossible.log_of_none(points)

    explored = explore(space, emulated, rng, near=before.explored.proposal if before else near, thorough=thorough or before is None, last=last)
    explored, lost = _where_runs_succeed(explored, evaluations, impossible, rng)
    log_weights = _log_weights(evaluations, emulated(unit), first_states)
    some, stopped = np.isfinite(log_weights).any(), evaluations.stopped
    weights = normalised(log_weights) if some else np.zeros(len(evaluations))
    held_out = [emulator.held_out() for emulator in emulators]
    nearness = _near_the_posterior(evaluations, weights if some else None, emulators)
    drawn = int(np.sum(evaluations.proposal >= 0))
    of_runs = log_evidence(log_weights, drawn) if some else -np.inf

    drawn_again = systematic_resampling(explored.weights, SAMPLES, rng)
    return Emulation(
        explored=explored,
        answer=best_fit(expected, space, np.concatenate([space.to_unit(explored.theta), unit]), impossible),
        held_out=_averaged([each.error for each in held_out], nearness),
        of_mean=_averaged([each.of_mean for each in held_out], nearness),
        coverage=float(np.mean([emulator.coverage for emulator in emulators])),
        weights=weights,
        pareto_k=pareto_k(log_weights),
        log_evidence_of_runs=of_runs,
        dropped=float(np.exp(log_weights[stopped] - min(explored.log_evidence, of_runs)).sum() / drawn) if some else 0.0,
        doubt=doubt(space.to_unit(explored.theta[drawn_again]), explored.log_evidence, emulators, likelihoods, rng),
        lost=lost,
        kernels=tuple(emulator.kernels for emulator in emulators),
        cheaper=tuple(emulator.kernels for emulator in cheaper or ()),
        of_impossible=() if impossible is None else (impossible.kernel,),
        spread=tuple(each.spread for each in held_out),
        emulators=emulators,
        likelihoods=likelihoods,
        first_states=first_states,
        impossible=impossible,
    )


def changed(
    now: Emulation, before: Emulation, references: Sequence[Reference], errors: Sequence[ErrorModel], scatters: Sequence[bool], unit: NDArray[np.float64]
) -> NDArray[np.float64]:
    """By how much the log likelihood at points (M, n) is another now, by what is known of the responses there alone: (M,).

    What components leave out and runs scatter by is as it was before. Both are counted over all runs, and grow less as more of these lie near the reference: with hundreds of states that alone raises the likelihood by
    many times, wherever a response is known.
    """
    likelihoods = [
        ReducedLikelihood.of(reference, model, emulator.centre, emulator.basis, earlier.added(scatter))
        for reference, model, scatter, emulator, earlier in zip(references, errors, scatters, now.emulators, before.emulators)
    ]
    return now.log_likelihood(unit, likelihoods) - before.log_likelihood(unit)


def _averaged(every: Sequence[NDArray[np.float64]], nearness: Sequence[NDArray[np.float64]]) -> tuple[float, ...]:
    """The root of the mean square of errors (M,), for each experiment, as near to the posterior as they are."""
    return tuple(float(np.sqrt(np.average(errors**2, weights=near))) for errors, near in zip(every, nearness))


def _likelihoods(
    references: Sequence[Reference], errors: Sequence[ErrorModel], scatters: Sequence[bool], emulators: Sequence[Emulator]
) -> list[ReducedLikelihood]:
    """Of what the emulators predict, under errors."""
    return [
        ReducedLikelihood.of(reference, model, emulator.centre, emulator.basis, emulator.added(scatter))
        for reference, model, scatter, emulator in zip(references, errors, scatters, emulators)
    ]


def _log_weights(evaluations: Evaluations, emulated: NDArray[np.float64], first_states: Sequence[FirstStates]) -> NDArray[np.float64]:
    """Of the evaluations (N,), by what is emulated at them (N,)."""
    # A sample that failed for the machine's or the clock's fault counts with what the emulator says of it; an infeasible one with zero.
    logs = np.where(evaluations.infeasible, -np.inf, emulated)
    # And one that was stopped with as much as it can have at most, although the emulator says less.
    stopped = evaluations.stopped
    logs[stopped] = bounds(first_states, [responses[stopped] for responses in evaluations.responses])
    return evaluations.log_weights(logs, np.full(len(evaluations), True))


def _near_the_posterior(evaluations: Evaluations, weights: NDArray[np.float64] | None, emulators: Sequence[Emulator]) -> list[NDArray[np.float64]]:
    """How much the runs that each emulator learnt from say of its errors near the posterior: those with whole responses (M,), by the weights (N,) of all."""
    if weights is None:
        # Runs that were all made before carry no weight: then those whose own responses are nearest count.
        return [emulator.judges for emulator in emulators]
    known = [evaluations.known(number)[0] for number in range(len(emulators))]
    return [np.maximum(weights[whole], LEAST_COUNT / whole.sum()) for whole in known]


def recall(
    found: Found,
    evaluations: Evaluations,
    references: Sequence[Reference],
    errors: Sequence[ErrorModel],
    scatters: Sequence[bool],
    cheaper: Sequence[Emulator] | None = None,
) -> Emulation:
    """What `emulate` found before of the same evaluations, with the emulators made again by the kernels that are kept: nothing is searched for."""
    learnt = [
        _learn(evaluations, number, reference, model, scatter, None, cheaper[number] if cheaper else None, kernels)
        for number, (reference, model, scatter, kernels) in enumerate(zip(references, errors, scatters, found.kernels))
    ]
    emulators, likelihoods, first_states = zip(*learnt)
    return Emulation(
        **_figures(found), emulators=emulators, likelihoods=likelihoods, first_states=first_states, impossible=_impossible(evaluations, *found.of_impossible)
    )


def _emulated(
    likelihoods: Sequence[ReducedLikelihood], emulators: Sequence[Emulator], impossible: Chance | None, unit: NDArray[np.float64]
) -> NDArray[np.float64]:
    logs = emulated_log_likelihood(likelihoods, emulators, unit)
    return logs if impossible is None else logs + impossible.log_of_none(unit)


def _impossible(evaluations: Evaluations, known: Kernel | None = None) -> Chance | None:
    """The chance that parameters are infeasible; an evaluation that failed for another reason tells nothing of it."""
    told = ~evaluations.missing
    return chance(evaluations.unit[told], evaluations.infeasible[told], OF_IMPOSSIBLE, known)


def _where_runs_succeed(explored: Explored, evaluations: Evaluations, impossible: Chance | None, rng: np.random.Generator) -> tuple[Explored, float]:
    """The same with a proposal for the next runs that leaves out where runs fail for another reason than that parameters are infeasible; and how much of the probability lies where runs give nothing, for
    whatever reason."""
    unit, told = evaluations.space.to_unit(explored.theta), ~evaluations.infeasible
    fails = chance(evaluations.unit[told], evaluations.missing[told], OF_FAILURES)
    possible = np.ones(len(unit)) if impossible is None else np.exp(impossible.log_of_none(unit))
    if fails is None:
        return explored, float(explored.weights @ (1 - possible))
    succeed = np.exp(fails.log_of_none(unit))
    succeeding = explored.weights * succeed
    lost = float(explored.weights @ (1 - possible * succeed))
    # Where next to nothing of it lies where runs succeed, a few samples say nothing of where that is.
    if succeeding.sum() ** 2 < FEWEST * np.sum(succeeding**2) or not succeeding.any():
        return explored, lost
    proposal = DefensiveMixture.fitted(evaluations.space, explored.theta, succeeding / succeeding.sum(), rng)
    return replace(explored, proposal=proposal), lost


def _figures(found: Found) -> dict[str, Any]:
    return {each.name: getattr(found, each.name) for each in fields(Found)}


def _learn(
    evaluations: Evaluations,
    number: int,
    reference: Reference,
    errors: ErrorModel,
    scatters: bool,
    before: Emulator | None,
    cheaper: Emulator | None,
    known: Kernels | None = None,
) -> tuple[Emulator, ReducedLikelihood, FirstStates]:
    """Of one experiment: the emulator, and the likelihood of what it predicts and of the first states of a run."""
    whole, begun = evaluations.known(number)
    unit, responses = evaluations.unit, evaluations.responses[number]
    emulator = Emulator(unit[whole], responses[whole], reference, before, evaluations.space.columns(number), cheaper, (unit[begun], responses[begun]), known)
    emulator.trust(_nearness(responses[whole], reference, errors))
    added = emulator.added(scatters)
    likelihood = ReducedLikelihood.of(reference, errors, emulator.centre, emulator.basis, added)
    return emulator, likelihood, FirstStates(reference, errors, added, emulator.simulator)


def _nearness(responses: NDArray[np.float64], reference: Reference, errors: ErrorModel) -> NDArray[np.float64]:
    """Weights of evaluations (N,), as many effective as it takes to judge by, of those whose own responses are nearest to the reference."""
    logs = marginal(log_likelihood(responses, reference, errors), errors.log_prior)
    logs = logs - logs.max()
    enough = min(max(JUDGES, len(logs) / 4), len(logs) / 2)

    def excess(log_power: float) -> float:
        weights = np.exp(np.exp(log_power) * logs)
        return weights.sum() ** 2 / np.sum(weights**2) - enough

    power = 1.0 if excess(0.0) > 0 else np.exp(scipy.optimize.brentq(excess, -60, 0, xtol=1e-3))
    weights = np.exp(power * logs)
    return weights / weights.sum()
