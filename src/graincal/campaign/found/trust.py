"""When not to trust what a calibration by the method "posterior" says, and what it takes for granted, as remarks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.asked.doubt import Doubt
from graincal.campaign.found.remark import Remark, remark
from graincal.inference.likelihood.early_stop import MOST_DROPPED
from graincal.inference.posterior.settling import CONFIRMED, MOST_LOST
from graincal.inference.sampling.posterior import PROBABILITY
from graincal.models import StressPathTest
from graincal.notation import numbers
from graincal.notation.quantities import parameters, quantity
from graincal.notation.words import continued, listed

if TYPE_CHECKING:
    from graincal.campaign.found.answer import Answer
    from graincal.campaign.found.by_emulators import ByEmulators
    from graincal.campaign.found.record import Record
    from graincal.inference.posterior.emulation import Found
    from graincal.inference.sampling.posterior import Posterior

ROUGH = 0.1
"""The emulator's held-out error, as a part of the spread of the responses, above which it is rough."""
LEAST_COVERAGE = 0.8
MUCH_UNSURE = 0.2
"""Of the probability, where the emulator does not know, from which the intervals are wide for it."""
MOSTLY_UNSURE = 0.5
"""The same, from which all that is said is preliminary by more than its intervals."""
MANY_RUNS, LARGEST_K = 200, 0.7
MANY_FAILURES = 0.1
FAR = 3.0
"""How many times the error that measurement errors lead to, from which the answer is far from the reference."""
UNLIKE = 2.0
"""How many times as far as one more sibling a packing is from the mean of its siblings, from which it is said to be another kind."""
EDGE = 0.01
"""Of a range: as near to its end the answer is at it."""


def has_settled(result: Record) -> bool:
    """Whether the posterior is known, so that more evaluations would say the same. One whose emulator predicts nothing any more is not, whatever the campaign ended by."""
    return result.settled and result.found is not None and result.found.predicts


def cautions(result: Record, found: Found, known: ByEmulators | None) -> list[Remark]:
    """What is to be read before anything else, where more evaluations may say something else; nothing where they would not."""
    if has_settled(result):
        return []
    said = [remark("preliminary", "Preliminary: the posterior has not settled. What follows may yet move.", doubt=result.learnt[-1].doubt)]
    if known and found.predicts and known.unsure > MOSTLY_UNSURE:
        text = f"{100 * known.unsure:.0f} % of the probability lies where too few runs were made: it may move by more than its intervals say."
        said.append(remark("mostly-unsure", text, unsure=known.unsure, limit=MOSTLY_UNSURE))
    return said


def doubts(result: Record, found: Found, answer: Answer, known: ByEmulators | None) -> list[Remark]:
    """Why not to trust it. One that says so where there is no reason, as far as that is known."""
    said = [
        *_not_settled(result, found),
        *_of_emulator(result, found, known),
        *_of_runs(result, found),
        *(_of_errors(result, found, answer, known) if known else []),
        *_of_answer(result, answer, found.posterior),
        *_of_packings(result),
    ]
    return said if said or known is None else [_nothing_against(result, found)]


def conditions(result: Record, found: Found) -> list[Remark]:
    """What the posterior takes for granted."""
    said, packings = _scatter(result), _packings(result)
    for number, code, (these, one) in ((1, "one-packing", ("this packing", "one packing")), (2, "two-packings", ("these two packings", "two"))):
        names = [each.name for each, count, _ in packings if isinstance(each.model, StressPathTest) and not count and len(each.model.packings) == number]
        if names:
            of = f" in {listed(names)}" if len(result.experiments) > 1 else ""
            text = f"It is conditional on {these}{of}: another of the same grading and void ratio would move the parameters, by how much {one} cannot tell."
            said.append(remark(code, text, experiments=names, packings=number))
    unstated = dict.fromkeys(name for each in result.experiments for name in each.reference.names if name not in each.reference.measurement_errors)
    if unstated:
        labels = listed(list(dict.fromkeys(quantity(name).label for name in unstated)))
        text = f"No measurement error is stated of {labels}, and 1 % of the peak was taken: the larger it is, the wider the intervals are."
        said.append(remark("error-assumed", text, observables=list(unstated), part_of_peak=0.01))
    return said


def _is_scatter(result: Record) -> bool:
    """Whether the emulator misses held-out runs by much, and that is for the most part what runs at one place differ by."""
    found = result.found
    return found is not None and max(found.held_out) > ROUGH and result.scatter is not None and result.scatter.is_most


def _scatter(result: Record) -> list[Remark]:
    """That runs at one place differ, where that is most of what the emulator misses held-out runs by: no emulator misses them by less."""
    if not _is_scatter(result) or result.scatter is None:
        return []
    of_runs, missed = result.scatter
    text = (
        f"The runs at the answer differ by {100 * of_runs:.2g} % of the peak (sd, in the mean over the states): the simulator scatters, as few grains do. That is most of the "
        f"{100 * missed:.2g} % of the peak by which the emulator misses held-out runs, and no emulator misses them by less. The posterior is of the mean of such runs: the more they scatter, the more "
        "of them it takes."
    )
    return [remark("runs-scatter", text, scatter=of_runs, missed=missed)]


def accepted_problems(accepted: Sequence[Doubt]) -> tuple[Remark, ...]:
    """That a campaign was begun in spite of problems; nothing without any."""
    if not accepted:
        return ()
    text = (
        f"It was begun in spite of {numbers.count(len(accepted), 'problem')} that graincal check finds, which --accept accepted: {' '.join(map(str, accepted))}"
    )
    return (remark("accepted-problems", text, problems=[doubt.as_json() for doubt in accepted]),)


def changed_code(files: str | None) -> tuple[Remark, ...]:
    """That files of its functions' code were changed between two sittings; nothing where none was."""
    if not files:
        return ()
    text = f"Code of its functions was changed between two sittings ({files}), so that its evaluations may be those of two models."
    return (remark("code-changed", text, files=files.split(", ")),)


def causes(result: Record) -> str:
    """What keeps even the true parameters' responses away from the reference."""
    return "Measurement errors and the scatter of runs" if any(each.reference.simulated for each in result.experiments) else "Measurement errors"


def allows_discrepancy(result: Record) -> bool:
    """Whether the model may be unable to reproduce some test."""
    return any(errors.discrepancies.any() for errors in result.knowledge.errors)


def _not_settled(result: Record, found: Found) -> list[Remark]:
    if has_settled(result):
        return []
    known, enough = result.learnt[-1], result.stop.posterior_shift
    figures = {"doubt": known.doubt, "enough": None if enough is False else enough, "confirmed": known.confirmed, "confirmed_enough": CONFIRMED}
    because, then = _why_not_settled(result, found), "" if enough is False else " More evaluations would tell."
    return [remark("not-settled", f"The posterior has not settled: {because}.{then}", **figures)]


def _why_not_settled(result: Record, found: Found) -> str:
    known, enough = result.learnt[-1], result.stop.posterior_shift
    if not found.predicts:
        return "the emulator predicts nothing by which to tell"
    if found.lost > MOST_LOST:
        return f"{100 * found.lost:.0f} % of its probability lies where runs give nothing, and at most {100 * MOST_LOST:g} % may"
    if enough is False:
        return "with posterior_shift = false nothing asks whether it has"
    if known.doubt > enough:
        return f"what the emulator does not know moves means and spreads by {known.doubt:.2g} standard deviations, and {enough:g} is enough"
    if not np.isfinite(known.confirmed):
        return "fresh runs at draws from it, which would confirm it, were not made"
    if not CONFIRMED[0] <= known.confirmed <= CONFIRMED[1]:
        return f"fresh runs at draws from it left {known.confirmed:.2g} times the probability there, and {CONFIRMED[0]:g} to {CONFIRMED[1]:g} is enough"
    return "the last fresh runs at draws from it moved it"


def _of_emulator(result: Record, found: Found, known: ByEmulators | None) -> list[Remark]:
    worst, said = max(found.held_out), []
    settled, too_sure = has_settled(result), found.coverage < LEAST_COVERAGE
    if not found.predicts:
        text = "The emulator predicts held-out runs no better than their mean does: what is said here of the parameters cannot be relied on."
        said.append(remark("emulator-predicts-nothing", text, held_out_ratio=found.held_out_ratio))
    elif worst > ROUGH and not _is_scatter(result):
        # Fresh runs have shown that a settled posterior is not in the wrong place, and one that is surer than it should be does not widen the intervals enough.
        then = "Intervals may be in the wrong place for it." if too_sure else "Intervals are wider for it, and may be in the wrong place."
        then = "Fresh runs confirmed the posterior nevertheless." if settled else then
        text = f"The emulator is rough: near the posterior it misses held-out runs by {100 * worst:.2g} % of the spread of the responses, more than {100 * ROUGH:g} %. {then}"
        said.append(remark("emulator-rough", text, held_out_error=worst, limit=ROUGH))
    if known and found.predicts and known.unsure > MUCH_UNSURE and not settled:
        # An emulator that is surer than it should be is wrong about how wide they are, too.
        then = "More evaluations would tell." if too_sure else "More evaluations would narrow them, and may move them."
        text = (
            f"{100 * known.unsure:.0f} % of the probability lies where too few runs were made to know whether the parameters fit: the intervals say where runs are wanting "
            f"as much as what the test says. {then}"
        )
        said.append(remark("runs-wanting", text, unsure=known.unsure, limit=MUCH_UNSURE))
    if too_sure:
        text = (
            f"The emulator is surer than it should be: {100 * found.coverage:.0f} % of held-out runs nearest to the reference lie in its {100 * PROBABILITY:.0f} % intervals. "
            "The posterior may be too narrow for it."
        )
        said.append(remark("emulator-too-sure", text, coverage=found.coverage, limit=LEAST_COVERAGE))
    return said


def _of_runs(result: Record, found: Found) -> list[Remark]:
    said = []
    carrying = int(np.sum(found.weights > 0))
    if carrying >= MANY_RUNS and found.pareto_k > LARGEST_K:
        text = f"A few runs carry most of the weight (Pareto k = {found.pareto_k:.2g}, above {LARGEST_K:g}): the runs were not where the posterior is."
        said.append(remark("few-runs-carry", text, pareto_k=found.pareto_k, limit=LARGEST_K, runs=carrying))
    if result.failures > MANY_FAILURES * result.evaluations:
        text = f"{100 * result.failures / result.evaluations:.0f} % of the evaluations failed; the posterior knows of the places where they did by the emulator alone."
        said.append(remark("many-failures", text, failures=result.failures, evaluations=result.evaluations, limit=MANY_FAILURES))
    if found.lost > MANY_FAILURES:
        kinds = [(kind, reason.rstrip(".")) for kind, reason, _ in result.failure_kinds()]
        named = ", ".join(f"{kind} ({reason})" for kind, reason in kinds) or "runs that were known before failed"
        text = f"{100 * found.lost:.0f} % of the probability lies where runs give nothing: {named}. Where that is a limit, a wider one would tell; where parameters are impossible, narrower ranges."
        said.append(remark("runs-fail-there", text, lost=found.lost, limit=MANY_FAILURES, kinds=[kind for kind, _ in kinds]))
    if found.dropped > MOST_DROPPED:
        text = (
            f"The runs that were stopped early may hold {100 * found.dropped:.2g} % of the probability, more than the {100 * MOST_DROPPED:g} % that they were to hold by "
            "what was known when they were: early_stop = false runs them to their end."
        )
        said.append(remark("stopped-runs-count", text, dropped=found.dropped, limit=MOST_DROPPED))
    return said


def _of_errors(result: Record, found: Found, answer: Answer, known: ByEmulators) -> list[Remark]:
    """How far the answer is from the reference, beside what the errors lead to."""
    mean, expected, cause = answer.mean, known.expected_error, continued(causes(result))
    away = f"The answer is {numbers.value(mean, 3)} % from the reference"
    if mean > FAR * expected:
        text = (
            f"{away}, and {cause} alone lead to {expected:.2g} %: {'its runs scatter, or ' if _is_scatter(result) else ''}the model cannot reproduce the test that well, "
            "or the errors are too small as they are stated or taken, or the answer lies where the emulator is wrong. "
            + (
                "The intervals allow for a discrepancy of the model."
                if allows_discrepancy(result)
                else "The intervals leave that out; discrepancy = true allows for it."
            )
        )
        return [remark("answer-far", text, mean=mean, expected_error=expected)]
    if FAR * mean < expected:
        text = f"{away}, where {cause} lead to {expected:.2g} %: the errors look too large as they are stated or taken, and the intervals are wider for it."
        return [remark("errors-too-large", text, mean=mean, expected_error=expected)]
    return []


def _of_answer(result: Record, answer: Answer, posterior: Posterior) -> list[Remark]:
    names, labels, theta, said = result.space.names, [shown.label for shown in parameters(result.space)], answer.theta, []
    low, high = posterior.interval()
    if (outside := (theta < low) | (theta > high)).any():
        text = (
            f"The answer lies outside the {100 * PROBABILITY:.0f} % interval of {listed(_chosen(labels, outside))}: it is where the responses are known to fit best, and the interval is of all that "
            "may fit."
        )
        where = {name: {"answer": theta[k], "interval_90": [low[k], high[k]]} for k, name in enumerate(names) if outside[k]}
        said.append(remark("answer-outside-interval", text, parameters=where))
    unit = result.space.to_unit(theta)
    if (at_edge := (unit < EDGE) | (unit > 1 - EDGE)).any():
        text = f"The answer is at the end of the range of {listed(_chosen(labels, at_edge))}: where values beyond make sense, widen it."
        where = {name: {"answer": theta[k], "range": [result.space.low[k], result.space.high[k]]} for k, name in enumerate(names) if at_edge[k]}
        said.append(remark("answer-at-end-of-range", text, parameters=where))
    return said


def _of_packings(result: Record) -> list[Remark]:
    said = []
    for experiment, count, apart in _packings(result):
        if count and apart > UNLIKE:
            text = (
                f"The packing of {experiment.name} is not like its {count} siblings: {apart:.2g} times as far from their mean as one more of them would be (in the mean over the states). "
                "That is no scatter, and the parameters are those of this packing. Another seed, or more grains, may give a packing that is like the others."
            )
            said.append(remark("unlike-siblings", text, experiment=experiment.name, siblings=count, apart=apart, limit=UNLIKE))
    return said


def _packings(result: Record) -> list[tuple]:
    """Of each experiment how many siblings its packing has, and how far it is from their mean."""
    learnt = result.learnt[-1]
    return list(zip(result.experiments, learnt.siblings, learnt.apart))


def _nothing_against(result: Record, found: Found) -> Remark:
    failures = result.failures
    text = (
        f"Nothing that was looked at speaks against it: the emulator's held-out error is {100 * max(found.held_out):.2g} % of the spread of the responses, "
        f"{100 * found.coverage:.0f} % of those nearest to the reference lie in its {100 * PROBABILITY:.0f} % intervals, and "
        f"{numbers.count(failures, 'evaluation') if failures else 'none'} failed."
    )
    return remark("nothing-against", text, held_out_error=max(found.held_out), coverage=found.coverage, failures=failures)


def _chosen(labels: list[str], which: NDArray[np.bool_]) -> list[str]:
    return [label for label, chosen in zip(labels, which) if chosen]
