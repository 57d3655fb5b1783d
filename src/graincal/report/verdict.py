"""What the posterior says, in sentences (in markup), and when not to trust it."""

from __future__ import annotations

import numpy as np

from graincal.campaign import Result
from graincal.inference.early_stop import MOST_DROPPED
from graincal.inference.posterior import PROBABILITY
from graincal.models import StressPathTest
from graincal.notation import numbers
from graincal.notation.quantities import Quantity, parameters, quantity
from graincal.report.emulated import Emulated, allows_discrepancy
from graincal.report.findings import FEW

IDENTIFIED, WEAKLY = 0.3, 0.7
"""Posterior over prior standard deviation, below which a parameter is identified, and up to which weakly."""
RIDGE = 0.8
"""The correlation, up or down, from which a pair of parameters is a ridge."""
ROUGH = 0.1
"""The emulator's held-out error, as a part of the spread of the responses, above which it is rough."""
LEAST_COVERAGE = 0.8
MUCH_UNSURE = 0.2
"""Of the probability, where the emulator does not know, from which the intervals are wide for it."""
MOSTLY_UNSURE = 0.5
"""The same, from which all that is said is preliminary, whether it has settled or not."""
FAR_TAILS = 0.6
"""Standard deviations over the width of the interval of 90 %, from which some of the probability lies far out: a Gaussian's is 0.3."""
MANY_RUNS, LARGEST_K = 200, 0.7
MANY_FAILURES = 0.1
FAR = 3.0
"""How many times the error that measurement errors lead to, from which the answer is far from the reference."""
UNLIKE = 2.0
"""How many times as far as one more sibling a packing is from the mean of its siblings, from which it is said to be another kind."""
EDGE = 0.01
"""Of a range: as near to its end the answer is at it."""


def verdicts(emulated: Emulated) -> tuple[str, ...]:
    """For each parameter "identified", "weakly identified" or "not identified"."""
    return tuple("identified" if part < IDENTIFIED else "weakly identified" if part <= WEAKLY else "not identified" for part in emulated.shrinkage)


def found(result: Result, emulated: Emulated | None) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """What was found: headings, and the paragraphs under each."""
    if emulated is None:
        return (("Fit", (_nothing(result),)), ("End", (_ending(result),)))
    said = [("Caution", (warning,))] if (warning := _preliminary(result, emulated)) else []
    said += [("Parameters", tuple(_sentence(emulated, k) for k in range(result.space.size))), ("Identifiability", (_identified(emulated),))]
    if ridges := _ridges(emulated):
        said.append(("Ridges", (ridges,)))
    if modes := _modes(emulated):
        said.append(("Modes", (modes,)))
    said.append(("Answer", (_answer(result, emulated),)))
    said.append(("Trust", doubts(result, emulated)))
    said.append(("Evidence", (_evidence(emulated),)))
    said.append(("End", (_ending(result),)))
    return tuple(said)


def doubts(result: Result, emulated: Emulated) -> tuple[str, ...]:
    """Why not to trust it, a sentence each; one that says so where there is no reason. What it is conditional on comes last."""
    emulation, answer = emulated.emulation, result.answer
    said = []
    if unsettled := _unsettled(result):
        said.append(f"The posterior has not settled: {unsettled}. More evaluations would tell.")
    if not emulation.predicts:
        said.append("The emulator predicts held-out runs no better than their mean does: what is said here of the parameters cannot be relied on.")
    elif max(emulation.held_out) > ROUGH:
        said.append(
            f"The emulator is rough: near the posterior it misses held-out runs by {100 * max(emulation.held_out):.2g} % of the spread of the responses, more than "
            f"{100 * ROUGH:g} %. Intervals are wider for it, and may be in the wrong place."
        )
    if emulated.unsure > MUCH_UNSURE and not result.settled:
        said.append(
            f"{100 * emulated.unsure:.0f} % of the probability lies where too few runs were made to know whether the parameters fit: the intervals say where runs are wanting "
            "as much as what the test says. More evaluations would narrow them, and may move them."
        )
    if emulation.coverage < LEAST_COVERAGE:
        said.append(
            f"The emulator is surer than it should be: {100 * emulation.coverage:.0f} % of held-out runs nearest to the reference lie in its {100 * PROBABILITY:.0f} % intervals. "
            "The posterior is too narrow."
        )
    carrying = int(np.sum(emulation.weights > 0))
    if carrying >= MANY_RUNS and emulation.pareto_k > LARGEST_K:
        said.append(f"A few runs carry most of the weight (Pareto k = {emulation.pareto_k:.2g}, above {LARGEST_K:g}): the runs were not where the posterior is.")
    if result.failures > MANY_FAILURES * result.evaluations:
        said.append(f"{100 * result.failures / result.evaluations:.0f} % of the evaluations failed; the posterior knows of the places where they did by the emulator alone.")
    if emulation.dropped > MOST_DROPPED:
        said.append(
            f"The runs that were stopped early may hold {100 * emulation.dropped:.2g} % of the probability, more than the {100 * MOST_DROPPED:g} % that they were to hold by "
            "what was known when they were: early_stop = false runs them to their end."
        )
    expected, causes = emulated.expected_error(), _causes(result)
    if answer and answer.mean > FAR * expected:
        said.append(
            f"The answer is {numbers.value(answer.mean, 3)} % from the reference, and {causes[0].lower()}{causes[1:]} alone lead to {expected:.2g} %: the model cannot reproduce the test that well, "
            "or the errors are stated too small, or the answer lies where the emulator is wrong. "
            + ("The intervals allow for a discrepancy of the model." if allows_discrepancy(result) else "The intervals leave that out; discrepancy = true allows for it.")
        )
    if answer and FAR * answer.mean < expected:
        said.append(
            f"The answer is {numbers.value(answer.mean, 3)} % from the reference, where {causes[0].lower()}{causes[1:]} lead to {expected:.2g} %: the errors look too large as they "
            "are stated, and the intervals are about in proportion to them."
        )
    low, high = emulated.posterior.interval(PROBABILITY)
    outside = [shown.label for shown, value, lower, upper in zip(parameters(result.space), answer.theta, low, high) if not lower <= value <= upper]
    if outside:
        said.append(
            f"The answer lies outside the {100 * PROBABILITY:.0f} % interval of {_listed(outside)}: it is where the responses are known to fit best, and the interval is of all that may fit."
        )
    at_edge = [shown.label for shown, end in zip(parameters(result.space), _at_edge(result)) if end]
    if at_edge:
        said.append(f"The answer is at the end of the range of {_listed(at_edge)}: where values beyond make sense, widen it.")
    if not said:
        said.append(
            f"Nothing that was looked at speaks against it: the emulator's held-out error is {100 * max(emulation.held_out):.2g} % of the spread of the responses, "
            f"{100 * emulation.coverage:.0f} % of those nearest to the reference lie in its {100 * PROBABILITY:.0f} % intervals, and "
            f"{numbers.count(result.failures, 'evaluation') if result.failures else 'none'} failed."
        )
    return (*said, *_conditions(result))


def rule() -> str:
    """The thresholds of the verdicts, for readers."""
    return (
        f"A parameter is called identified where its posterior standard deviation (sd) is below {IDENTIFIED:g} of the prior's (the range over √12), weakly identified up to "
        f"{WEAKLY:g}, and else not. A ridge is a pair correlated by more than {RIDGE:g}, up or down. Intervals hold {100 * PROBABILITY:.0f} % of the probability, "
        "given the measurement errors and the ranges, which are the prior: every value in them was equally probable before the test."
    )


def emulator_rule() -> str:
    """What an emulator is, for readers."""
    return "The emulator is a regression on all runs (by Gaussian processes): it says how the model would respond at parameters that were not run, and how far off that may be."


def effective_runs() -> str:
    """What that column of the table of batches is, for readers."""
    return (
        "Effective runs: how many of equal weight the runs in the posterior amount to, each weighted by what the emulator says of it, also where it failed. Where they are few, the posterior "
        "rests on the emulator between them."
    )


def _sentence(emulated: Emulated, k: int) -> str:
    result = emulated.result
    shown, name = parameters(result.space)[k], result.space.names[k]
    low, high = emulated.posterior.interval(PROBABILITY)[:, k]
    mean, std = emulated.posterior.mean()[k], emulated.posterior.std()[k]
    said = f"{shown.label} is {verdicts(emulated)[k]}: {numbers.between(low, high)}{_unit(shown)} with {100 * PROBABILITY:.0f} % probability, {numbers.estimate(mean, std)} (mean ± sd)."
    if std > FAR_TAILS * (high - low):
        said += " The sd is large beside the interval, for a small part of the probability lies far from it."
    if (truth := result.truth.get(name)) is not None:
        said += f" The truth, {numbers.short(truth)}{_unit(shown)}, lies {'in' if low <= truth <= high else 'outside'} the interval."
    return said


def _identified(emulated: Emulated) -> str:
    labels, said = [shown.label for shown in parameters(emulated.result.space)], []
    if _preliminary(emulated.result, emulated):
        said.append("So far:")
    for word in ("identified", "weakly identified", "not identified"):
        if members := [label for label, verdict in zip(labels, verdicts(emulated)) if verdict == word]:
            said.append(f"{word[0].upper()}{word[1:]}: {_listed(members)}.")
    return " ".join(said)


def _preliminary(result: Result, emulated: Emulated) -> str:
    """What is to be read before anything else, where more evaluations would say something else; nothing where they would not."""
    if result.settled:
        return ""
    if emulated.unsure > MOSTLY_UNSURE:
        return f"Preliminary: {100 * emulated.unsure:.0f} % of the probability lies where too few runs were made. What follows may yet move by more than its intervals say."
    return "Preliminary: the posterior has not settled. What follows may yet move." if _unsettled(result) else ""


def _unsettled(result: Result) -> str:
    """Why the posterior cannot be said to have settled, as a clause; nothing where it has, or ended for another reason than a limit."""
    if result.settled or result.stopped_by not in (None, "max_evaluations", "max_iterations"):
        return ""
    known, enough = result.learnt[-1], result.stop.posterior_shift
    if result.found is None or not result.found.predicts:
        return "the emulator predicts nothing by which to tell"
    if enough is False:
        return ""
    if known.doubt > enough:
        return f"what the emulator does not know moves means and spreads by {known.doubt:.2g} standard deviations, and {enough:g} is enough"
    if not np.isfinite(known.confirmed):
        return "fresh runs at draws from it, which would confirm it, were not made"
    return f"fresh runs at draws from it left {known.confirmed:.2g} times the probability there, or moved it"


def _ridges(emulated: Emulated) -> str:
    labels, correlation = [shown.label for shown in parameters(emulated.result.space)], emulated.posterior.correlation()
    pairs = [(correlation[i, j], i, j) for i in range(len(labels)) for j in range(i) if abs(correlation[i, j]) > RIDGE]
    if not pairs:
        return ""
    listed = ", ".join(f"{labels[j]} and {labels[i]} ({numbers.signed(r)})" for r, i, j in sorted(pairs, key=lambda pair: -abs(pair[0])))
    return f"{listed}: what such a pair shares is known better than either of the two alone."


def _modes(emulated: Emulated) -> str:
    if not emulated.modes:
        return ""
    shares = _listed([f"{100 * mode.share:.0f} %" for mode in emulated.modes])
    return f"The probability lies in {len(emulated.modes)} separate groups of values, of {shares}: the table of modes lists them. Means and correlations are over all of them."


def _answer(result: Result, emulated: Emulated) -> str:
    answer, best = result.answer, result.best
    listed = ", ".join(f"{shown.label} {numbers.value(value, 3)}{_unit(shown)}" for shown, value in zip(parameters(result.space), answer.theta))
    said = [f"The answer, which fits best as far as the emulator knows: {listed}."]
    known = np.isfinite(answer.errors)
    repeated = bool(known.any()) and answer.spread <= numbers.least_spread(answer.mean)
    if known.any():
        said.append(f"Run {numbers.count(len(answer.errors), 'time')} again, it is {numbers.repeated(answer.mean, answer.spread)} % from the reference (ε; mean ± sd of the runs).")
        if repeated:
            said.append("The runs, a millionth of the ranges apart, are alike: the model does not scatter.")
    if len(answer.errors) and not known.all():
        said.append(f"{(~known).sum()} of its runs failed.")
    if not len(answer.errors):
        said.append("It has not been run again yet.")
    if best and best.sample in answer.samples:
        closest = f"The luckiest of them, at {best.error:.3g} %, is the closest of all {numbers.count(result.evaluations, 'run')}."
        said.append(f"None of {numbers.count(result.evaluations, 'run')} is closer." if repeated else closest)
    elif best and best.error < answer.mean - FAR * max(answer.spread, numbers.least_spread(answer.mean)):
        said.append(
            f"Sample {best.sample} is closer by ε, {best.error:.3g} %, and by more than these runs scatter: the answer is chosen by the likelihood, which forgives errors that are "
            "alike along a curve, as those of a device, sooner than ε does."
        )
    elif best:
        said.append(f"The luckiest of {numbers.count(result.evaluations, 'run')} (sample {best.sample}) is {best.error:.3g} % from it; that its error is the least is partly chance.")
    said.append(f"{_causes(result)} alone lead to {emulated.expected_error():.2g} %.")
    return " ".join(said)


def _causes(result: Result) -> str:
    """What keeps even the true parameters' responses away from the reference."""
    return "Measurement errors and the scatter of runs" if any(result.knowledge.scatters) else "Measurement errors"


def _evidence(emulated: Emulated) -> str:
    result = emulated.result
    half, deviation = emulated.evidence_of_half_ranges, result.learnt[-1].log_evidence_std
    halved = f"{half:.2f} if each range were half as wide about the posterior's mean" if np.isfinite(half) else "nothing would be left of it in half of each range about the posterior's mean"
    return (
        f"log p(reference) = {emulated.emulation.log_evidence:.2f} ± {max(deviation, 0.005):.2g} (natural logarithm; ± one sd over the responses that the emulator holds "
        f"possible and over the draws that estimate it), and {halved}: it depends on the ranges. "
        f"{_of_runs(emulated)}{_before(result)}It compares models on the same reference, errors and ranges, and says nothing by itself."
    )


def _of_runs(emulated: Emulated) -> str:
    """What the places of the runs say, weighted by the emulated likelihood instead of draws from it, where enough of them carry weight: it ought to be the same."""
    emulation, posterior = emulated.emulation, emulated.posterior
    carried = emulation.effective_sample_size
    if carried < FEW:
        return ""
    theta = emulated.result.knowledge.evaluations.theta[: len(emulation.weights)]
    apart = np.max(np.abs(emulation.weights @ theta - posterior.mean()) / posterior.std())
    return f"By the weights of the runs, worth {carried:.0f} of equal weight, log p(reference) is {emulation.log_evidence_of_runs:.2f}, and means are at most {apart:.2g} sd from the posterior's. "


def _before(result: Result) -> str:
    """What the evidence was two batches earlier, which says more of how well it is known than its deviation while it rises."""
    earlier = result.learnt[-3].log_evidence if len(result.learnt) > 2 else np.nan
    return f"Two batches earlier it was {earlier:.2f}. " if np.isfinite(earlier) else ""


def _ending(result: Result) -> str:
    done = f"{len(result.iterations)} batch{'es' * (len(result.iterations) > 1)}"
    if look := result.calibration.first_look:
        done += f" and a first look of {len(look.theta)} evaluations by cheaper models"
    if result.stopped_because is None:
        return f"Not at its end: {done} {'is' if len(result.iterations) == 1 else 'are'} complete, and what stands here is what they say so far."
    return f"Stopped after {done}: {result.stopped_because[0].lower()}{result.stopped_because[1:]}"


def _nothing(result: Result) -> str:
    if result.best is None:
        return f"All {numbers.count(result.evaluations, 'sample')} failed, so that nothing was found."
    return f"Too few of {numbers.count(result.evaluations, 'sample')} have a response for a posterior; the smallest error is {result.best.error:.3g} % (sample {result.best.sample})."


def _conditions(result: Result) -> list[str]:
    """What the posterior takes for granted."""
    said = []
    for number, packings in ((1, ("this packing", "one packing")), (2, ("these two packings", "two"))):
        names = [each.name for each, known in zip(result.experiments, result.knowledge.packings) if isinstance(each.model, StressPathTest) and not known and len(each.model.packings) == number]
        if names:
            of = f" in {_listed(names)}" if len(result.experiments) > 1 else ""
            said.append(f"It is conditional on {packings[0]}{of}: another of the same grading and void ratio would move the parameters, by how much {packings[1]} cannot tell.")
    for each, scatter in zip(result.experiments, result.knowledge.packings):
        if scatter is not None and scatter.apart > UNLIKE:
            said.append(
                f"The packing of {each.name} is not like its {scatter.packings} siblings: {scatter.apart:.2g} times as far from their mean as one more of them would be (in the mean over the states). "
                "That is no scatter, and the parameters are those of this packing."
            )
    unstated = dict.fromkeys(quantity(name).label for each in result.experiments for name in each.reference.names if name not in each.reference.measurement_errors)
    if unstated:
        said.append(f"No measurement error is stated of {_listed(list(unstated))}, and 1 % of the peak was taken: the intervals are about in proportion to it.")
    return said


def _at_edge(result: Result) -> np.ndarray:
    unit = result.space.to_unit(result.answer.theta)
    return (unit < EDGE) | (unit > 1 - EDGE)


def _listed(words: list[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def _unit(shown: Quantity) -> str:
    return f" {shown.unit}" if shown.unit not in ("", "-") else ""
