"""How far a campaign is, for people and programs, also while another process runs it."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from graincal.campaign.found.answer import Answer, Candidate
from graincal.campaign.found.by_hand import by_hand, waiting
from graincal.campaign.found.next_command import next_command
from graincal.campaign.found.record import Record
from graincal.campaign.found.recorded import recorded_of_answer
from graincal.campaign.found.remarks import remarks
from graincal.campaign.found.replay import runs_at_answer
from graincal.campaign.found.to_end import to_end_of
from graincal.campaign.found.trust import accepted_problems, changed_code
from graincal.campaign.stored.code import CHANGED
from graincal.campaign.stored.database import said_of_damage
from graincal.campaign.stored.log import is_running
from graincal.campaign.stored.store import LOOK, Store, holds_campaign
from graincal.data import Failure, ParameterSpace
from graincal.inference import Iteration


def status(folder: str | Path) -> dict[str, Any]:
    """What `graincal status --json` prints: a contract for programs. What is not known is None; errors are in percent, times in seconds.

    folder; state: "running" (a process holds it), "interrupted" (none does, and it is not at its end), "waiting" (so, for runs that somebody makes by hand) or "finished".
    graincal: the version that began it; started, updated: ISO 8601, when it began and when the last evaluation ended.
    method, seed, parameters (names), units: {parameter: unit, "" for none}, experiments (names).
    evaluations, failures, stopped: samples evaluated in every experiment, or failed or stopped early in one; those that failed; those that were stopped.
    failure_kinds: {kind: how many evaluations failed so}, the most frequent first.
    first_look: the status of the first look, where one is taken first, as that of a campaign; None where none is, or it has not begun.
    by_hand: how many runs wait to be made by hand, only where an experiment is run so.
    iteration: {index, samples, evaluated, failed, stopped} of the one under way, or the last.
    iterations: of each complete one {index, samples, failed, stopped, s, s_per_state, effective_sample_size, gl_error, error, smallest_error, best_error}, where
    `error` is that of the most probable sample (Eq. 6), `smallest_error` the smallest of this iteration and `best_error` that of all iterations so far.
    With the method "posterior" also {posterior_shift, held_out_error, coverage, log_evidence, log_evidence_std, pareto_k, dropped, held_out_ratio, doubt, confirmed,
    effective_runs} (`Learnt`).
    best, most_probable: {sample, iteration, error, theta: {parameter: value}} over all complete iterations, and of the last that has weights.
    answer: {theta: {parameter: value}, errors: [of its runs], mean, spread} of the method "posterior", once it is known; errors is empty, mean and spread are None, until the campaign has run it again.
    settled: whether the campaign ended because its posterior was known. posterior: {mean, std: {parameter: value}, interval_90: {parameter: [low, high]}} of the method "posterior", by what is known so far.
    fits_about_as_well: {runs, enough, range: {parameter: [low, high]}} of the method "posterior" (`Result.fits_about_as_well`): how many runs fit about as well as the answer,
    and the values that they have; `enough` is false where they are too few to outline a range.
    recorded: [{experiment, observable, of, errors, mean, spread}], only where something was recorded that is not fitted: its errors (Eq. 5) by the runs at the "answer", or by the "most probable sample" of
    the paper's method, or by the "best sample" before there is either.
    remarks: [{code, level, text, numbers}] of the method "posterior": what is to be said of it, in the order of the report; before a batch is complete, and by other
    methods, "code-changed" and "accepted-problems" alone, where `graincal calibrate --accept` began it. A code never changes
    its meaning, and `graincal.campaign.found.remark.CODES` has all of them; level is "finding", "doubt" or "condition"; text is one or two sentences in plain characters; numbers is
    what they rest on. What takes emulators to tell is not among them (`BY_EMULATORS`): `Result.remarks` has it too.
    stopped_by, stopped_because: the criterion and a sentence. next_command: what to type to go on with it; None while it runs, and where it has what it was to find.
    seconds: run times of all evaluations together; seconds_left: until the iteration under way is complete, roughly.
    seconds_to_end: {as_most_go, at_most} until the campaign is at its end, roughly: as most campaigns go, and by its limits; each None where it is not known, and itself where neither is, or
    where it does not run.
    """
    folder = Path(folder)
    store = Store.open(folder)
    with said_of_damage(store.database.path):
        return _status(folder, store)


def _status(folder: Path, store: Store) -> dict[str, Any]:
    running, finished = is_running(folder), store.meta("stopped_by") is not None
    hand = by_hand(store.calibration)
    left = sum(len(waiting(store, number)) for number in hand)
    counts, (timed, seconds) = store.counts(), store.took()
    seconds_left = 0.0 if finished else _seconds_left(store, seconds / timed if timed else None)
    result = Record(store, store.calibration) if store.iterations() else None
    return {
        "folder": str(folder),
        "state": "finished" if finished else "running" if running else "waiting" if left else "interrupted",
        "graincal": store.provenance["graincal"],
        "started": store.meta("started"),
        "updated": store.last_ended(),
        "method": store.description["method"],
        "seed": store.description["seed"],
        "parameters": list(store.calibration.space.names),
        "units": dict(zip(store.calibration.space.names, store.calibration.space.units)),
        "experiments": [experiment.name for experiment in store.calibration.experiments],
        "evaluations": counts["evaluated"],
        "failures": counts["failed"],
        "failure_kinds": _failure_kinds(store),
        "stopped": counts["stopped"],
        "first_look": status(folder / LOOK) | {"seconds_to_end": None, "next_command": None} if holds_campaign(folder / LOOK) else None,
        **({"by_hand": left} if hand else {}),
        "iteration": _under_way(store),
        "iterations": _iterations(result) if result else [],
        "best": _candidate(result.best, result.space) if result else None,
        "most_probable": _candidate(result.most_probable, result.space) if result else None,
        "answer": _answer(result) if result else None,
        "settled": store.meta("stopped_by") == "posterior_shift",
        "posterior": _posterior(result) if result else None,
        "fits_about_as_well": _fits(result) if result else None,
        **({"recorded": [each.as_json() for each in recorded_of_answer(result)]} if result and result.recorded_names else {}),
        "remarks": [each.as_json() for each in (remarks(result) if result else (*changed_code(store.meta(CHANGED)), *accepted_problems(store.accepted)))],
        "stopped_by": store.meta("stopped_by"),
        "stopped_because": store.meta("stopped_because"),
        "next_command": None if running and not finished else next_command(folder, store.calibration, store.meta("stopped_by")),
        "seconds": seconds,
        "seconds_left": seconds_left,
        "seconds_to_end": asdict(to_end.no_sooner(seconds_left or 0.0)) if running and not finished and (to_end := to_end_of(store)) else None,
    }


def _failure_kinds(store: Store) -> dict[str, int]:
    kinds: Counter[str] = Counter()
    for kind, reason, count in store.failure_kinds():
        # As stored by a version before, they may be anything.
        kinds[Failure(kind, reason).kind] += count
    return dict(kinds)


def _under_way(store: Store) -> dict[str, int] | None:
    index = _earliest(store)
    return None if index is None else {"index": index} | store.counts(index)


def _earliest(store: Store) -> int | None:
    """The iteration under way, or the last; of several under way the earliest, which all others wait for."""
    last = store.last_iteration()
    return None if last is None else min(last, len(store.iterations()))


def _iterations(result: Record) -> list[dict[str, Any]]:
    figures = [_figures(iteration, best) for iteration, best in zip(result.iterations, result.best_errors)]
    return [each | learnt.figures() for each, learnt in zip(figures, result.learnt)] if result.learnt else figures


def _answer(result: Record) -> dict[str, Any] | None:
    if not (result.learnt and result.learnt[-1].answer):
        return None
    answer = result.answer if runs_at_answer(result.iterations[-1].samples, result.space) else None
    if answer is None:
        answer = Answer(np.array(result.learnt[-1].answer), np.empty(0, dtype=np.int64), np.empty(0))
    theta = dict(zip(result.space.names, answer.theta.tolist()))
    return {"theta": theta, "errors": [_number(error) for error in answer.errors], "mean": _number(answer.mean), "spread": _number(answer.spread)}


def _posterior(result: Record) -> dict[str, Any] | None:
    if not (result.learnt and result.learnt[-1].mean):
        return None
    learnt, names = result.learnt[-1], result.space.names
    return {
        "mean": dict(zip(names, learnt.mean)),
        "std": dict(zip(names, learnt.std)),
        "interval_90": {name: [low, high] for name, low, high in zip(names, learnt.low, learnt.high)},
    }


def _fits(result: Record) -> dict[str, Any] | None:
    # What was not stored with the batch takes longer than a status may.
    fits = result.learnt[-1].fits_about_as_well if result.learnt else None
    if fits is None:
        return None
    return {"runs": fits.count, "enough": fits.enough, "range": {name: [low, high] for name, low, high in zip(result.space.names, fits.low, fits.high)}}


def _figures(iteration: Iteration, best: float) -> dict[str, Any]:
    return {
        "index": iteration.index,
        "samples": len(iteration.samples),
        "failed": int(iteration.failed.sum()),
        "stopped": 0 if iteration.stopped is None else int(iteration.stopped.sum()),
        "s": _number(iteration.s),
        "s_per_state": _number(iteration.s_per_state),
        "effective_sample_size": _number(iteration.effective_sample_size),
        "gl_error": _number(iteration.gl_error),
        "error": _number(iteration.error),
        "smallest_error": _number(iteration.smallest_error),
        "best_error": _number(best),
    }


def _candidate(candidate: Candidate | None, space: ParameterSpace) -> dict[str, Any] | None:
    if candidate is None:
        return None
    theta = dict(zip(space.names, candidate.theta.tolist()))
    return {"sample": candidate.sample, "iteration": candidate.iteration, "error": candidate.error, "theta": theta}


def _seconds_left(store: Store, mean: float | None) -> float | None:
    """The mean run time, s, for each evaluation that waits, shared by the workers."""
    index = _earliest(store)
    if index is None or mean is None:
        return None
    waiting = sum(len(store.waiting(index, experiment)) for experiment in range(len(store.calibration.experiments)))
    return mean * math.ceil(waiting / store.calibration.number_of_workers)


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
