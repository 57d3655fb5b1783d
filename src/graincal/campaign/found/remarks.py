"""What a calibration by the method "posterior" found, as remarks made from the numbers: the report, the terminal and programs all say these."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from graincal.campaign.found.by_emulators import ByEmulators
from graincal.campaign.found.recorded import in_words, recorded_of_answer
from graincal.campaign.found.remark import Remark, remark
from graincal.campaign.found.trust import accepted_problems, causes, cautions, changed_code, conditions, doubts, has_settled
from graincal.inference.posterior.likely_runs import LikelyRuns
from graincal.inference.sampling.posterior import PROBABILITY
from graincal.notation import numbers
from graincal.notation.quantities import parameters
from graincal.notation.words import continued, listed

if TYPE_CHECKING:
    from graincal.campaign.found.answer import Answer
    from graincal.campaign.found.record import Record
    from graincal.inference.sampling.posterior import Posterior

IDENTIFIED, WEAKLY = 0.3, 0.7
"""Posterior over prior standard deviation, below which a parameter is identified, and up to which weakly."""
RIDGE = 0.8
"""The correlation, up or down, from which a pair of parameters is a ridge."""
FAR_TAILS = 0.6
"""Standard deviations over the width of the interval of 90 %, from which some of the probability lies far out: a Gaussian's is 0.3."""
CLOSER = 3.0
"""Standard deviations of the runs at the answer, by which another run is closer than their scatter explains."""

WORDS = {"identified": "identified", "weakly-identified": "weakly identified", "not-identified": "not identified", "interval-so-far": "not settled"}
"""What is said of one parameter, by the code: its verdict."""


def remarks(result: Record, known: ByEmulators | None = None) -> tuple[Remark, ...]:
    """Everything that is to be said of a result, in the order of a report; by other methods that problems were accepted or code was changed, and nothing else.

    Without what is known by emulators, all that can be told at once by what is stored; what is said then is said in the same words with it.
    """
    accepted = (*changed_code(result.code_changed), *accepted_problems(result.accepted))
    if not result.has_posterior:
        return accepted
    found, answer = result.found, result.answer
    if found is None or answer is None:
        return (_nothing(result), *_fitting(result, known), *_recorded(result), *accepted, _ending(result))
    return (
        *cautions(result, found, known),
        *_of_parameters(result, found.posterior),
        _identifiability(result),
        *_ridges(result, found.posterior),
        *_modes(result, known),
        *_fitting(result, known),
        *_answer(result, answer, known),
        *_recorded(result),
        *doubts(result, found, answer, known),
        *conditions(result, found),
        *accepted,
        _ending(result),
    )


def code_of(result: Record, shrinkage: float) -> str:
    """The code of what is said of a parameter whose posterior has so much of the prior's standard deviation: a posterior that has not settled says nothing of what is identified."""
    if not has_settled(result):
        return "interval-so-far"
    return "identified" if shrinkage < IDENTIFIED else "weakly-identified" if shrinkage <= WEAKLY else "not-identified"


def _of_parameters(result: Record, posterior: Posterior) -> list[Remark]:
    space, said = result.space, []
    moments = (posterior.mean(), posterior.std(), *posterior.interval(), result.shrinkage)
    for shown, name, mean, std, low, high, shrinkage in zip(parameters(space), space.names, *moments):
        code = code_of(result, shrinkage)
        verdict = f"{shown.label}, so far" if code == "interval-so-far" else f"{shown.label} is {WORDS[code]}"
        text = f"{verdict}: {numbers.between(low, high)}{shown.behind}{shown.without_log(low, high)} with {100 * PROBABILITY:.0f} % probability, {numbers.estimate(mean, std)} (mean ± sd)."
        if std > FAR_TAILS * (high - low):
            text += " The sd is large beside the interval, for a small part of the probability lies far from it."
        if (truth := result.truth.get(name)) is not None:
            text += f" The truth, {numbers.short(truth)}{shown.behind}, lies {'in' if low <= truth <= high else 'outside'} the interval."
        said.append(remark(code, text, parameter=name, mean=mean, std=std, interval_90=[low, high], std_over_prior=shrinkage, truth=truth))
    return said


def _identifiability(result: Record) -> Remark:
    of_each = dict(zip(result.space.names, result.shrinkage))
    if not has_settled(result):
        return remark(
            "identifiability-open", "Which parameters are identified cannot be said yet: only a posterior that has settled tells.", std_over_prior=of_each
        )
    labels, said = [shown.label for shown in parameters(result.space)], []
    for code in ("identified", "weakly-identified", "not-identified"):
        if members := [label for label, shrinkage in zip(labels, result.shrinkage) if code_of(result, shrinkage) == code]:
            said.append(f"{WORDS[code].capitalize()}: {listed(members)}.")
    return remark("identifiability", " ".join(said), std_over_prior=of_each)


def _ridges(result: Record, posterior: Posterior) -> list[Remark]:
    names, labels, correlation = result.space.names, [shown.label for shown in parameters(result.space)], posterior.correlation()
    pairs = [(correlation[i, j], i, j) for i in range(len(labels)) for j in range(i) if abs(correlation[i, j]) > RIDGE]
    if not pairs:
        return []
    pairs.sort(key=lambda pair: -abs(pair[0]))
    shown = ", ".join(f"{labels[j]} and {labels[i]} ({numbers.signed(r)})" for r, i, j in pairs)
    text = f"{'' if has_settled(result) else 'So far: '}{shown}: what such a pair shares is known better than either of the two alone."
    return [remark("ridges", text, pairs=[{"parameters": [names[j], names[i]], "correlation": r} for r, i, j in pairs])]


def _modes(result: Record, known: ByEmulators | None) -> list[Remark]:
    if known is None or not known.shares:
        return []
    shares = listed([f"{100 * share:.0f} %" for share in known.shares])
    the = "The" if has_settled(result) else "So far the"
    text = f"{the} probability lies in {len(known.shares)} separate groups of values, of {shares}: the table of modes lists them. Means and correlations are over all of them."
    return [remark("modes", text, shares=known.shares)]


def _fitting(result: Record, known: ByEmulators | None) -> list[Remark]:
    """The runs that fit about as well: no emulator has a part in it, and so it holds at any moment."""
    fits = result.fits_about_as_well if known else result.learnt[-1].fits_about_as_well
    if fits is None:
        return []
    figures = {"runs": fits.count, "parameters": len(fits.low), "range": dict(zip(result.space.names, map(list, zip(fits.low, fits.high))))}
    values = listed(
        [
            f"{shown.label} {numbers.between(low, high)}{shown.behind}{shown.without_log(low, high)}"
            for shown, low, high in zip(parameters(result.space), fits.low, fits.high)
        ]
    )
    fit = f"{numbers.count(fits.count, 'run')} fit{'s' * (fits.count == 1)} about as well as {_measured_by(fits)}"
    if fits.enough:
        alone = (
            " Runs at the answer scatter so much that one run by itself tells little; the posterior learns from all runs together." if fits.scattered else ""
        )
        return [remark("fits-about-as-well", f"{fit}: {values}. These were run; values between and beside them may fit as well.{alone}", **figures)]
    return [remark("few-fit-about-as-well", f"{fit}: {values}. They are too few to outline a range of {numbers.count(len(fits.low), 'parameter')}.", **figures)]


def _measured_by(fits: LikelyRuns) -> str:
    return "the answer" if fits.repeated else "the most likely run"


def _answer(result: Record, answer: Answer, known: ByEmulators | None) -> list[Remark]:
    evaluations = result.evaluations
    theta = ", ".join(
        f"{shown.label} {numbers.value(value, 3)}{shown.behind}{shown.without_log(value)}" for shown, value in zip(parameters(result.space), answer.theta)
    )
    said = [remark("answer", f"The answer, which fits best as far as the emulator knows: {theta}.", theta=dict(zip(result.space.names, answer.theta)))]
    has_error = np.isfinite(answer.errors)
    figures = {"errors": answer.errors, "mean": answer.mean, "spread": answer.spread}
    if has_error.any():
        runs = numbers.count(len(answer.errors), "run")
        text = f"{runs} at the answer, a millionth of the ranges apart, {'are' if len(answer.errors) > 1 else 'is'} {numbers.repeated(answer.mean, answer.spread)} % from the reference (ε; mean ± sd of the runs)."
        said.append(remark("answer-runs", text, **figures))
        if _alike(answer):
            said.append(remark("answer-runs-alike", "They give the same curve: the model does not scatter.", **figures))
    if len(answer.errors) and not has_error.all():
        said.append(remark("answer-runs-failed", f"{(~has_error).sum()} of its runs failed.", failed=(~has_error).sum(), runs=len(answer.errors)))
    if not len(answer.errors):
        said.append(remark("answer-not-run", "It has not been run again yet."))
    if best := result.best:
        figures |= {"sample": best.sample, "error": best.error, "evaluations": evaluations}
        if best.sample in answer.samples:
            closest = f"The luckiest of them, at {best.error:.3g} %, is the closest of all {numbers.count(evaluations, 'run')}."
            said.append(remark("answer-is-best", f"None of {numbers.count(evaluations, 'run')} is closer." if _alike(answer) else closest, **figures))
        elif best.error < answer.mean - CLOSER * max(answer.spread, numbers.least_spread(answer.mean)):
            text = (
                f"Sample {best.sample} is closer by ε, {best.error:.3g} %, and by more than these runs scatter: the answer is chosen by the likelihood, which gives "
                "less weight than ε to an error that is the same along the curve, as that of a device."
            )
            said.append(remark("another-is-closer", text, **figures))
        else:
            text = f"The luckiest of {numbers.count(evaluations, 'run')} (sample {best.sample}) is {best.error:.3g} % from the reference; that its error is the least is partly chance."
            said.append(remark("best-by-chance", text, **figures))
    if known:
        said.append(remark("errors-lead-to", f"{causes(result)} alone lead to {known.expected_error:.2g} %.", expected_error=known.expected_error))
    return said


def _recorded(result: Record) -> list[Remark]:
    """What was measured and not fitted, of which no emulator and no weight knows."""
    recorded = recorded_of_answer(result)
    return [remark("recorded-errors", in_words(recorded), recorded=[each.as_json() for each in recorded])] if recorded else []


def _alike(answer: Answer) -> bool:
    return bool(answer.spread <= numbers.least_spread(answer.mean))


def _nothing(result: Record) -> Remark:
    evaluations = numbers.count(result.evaluations, "sample")
    if result.best is None:
        return remark("nothing-found", f"All {evaluations} failed, so that nothing was found.", evaluations=result.evaluations)
    best = result.best
    text = f"Too few of {evaluations} have a response for a posterior; the smallest error is {best.error:.3g} % (sample {best.sample})."
    return remark("too-few-responses", text, evaluations=result.evaluations, sample=best.sample, error=best.error)


def _ending(result: Record) -> Remark:
    done = f"{len(result.iterations)} batch{'es' * (len(result.iterations) > 1)}"
    if look := result.calibration.first_look:
        done += f" and a first look of {len(look.theta)} evaluations by cheaper models"
    if result.stopped_because is None:
        are = "is" if len(result.iterations) == 1 else "are"
        return remark(
            "under-way",
            f"Not at its end: {done} {are} complete, and what stands here is what they say so far.",
            batches=len(result.iterations),
            evaluations=result.evaluations,
        )
    code = "settled" if has_settled(result) else "stopped"
    return remark(
        code,
        f"Stopped after {done}: {continued(result.stopped_because)}",
        stopped_by=result.stopped_by,
        batches=len(result.iterations),
        evaluations=result.evaluations,
    )
