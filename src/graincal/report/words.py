"""What was found, in sentences (in markup)."""

from __future__ import annotations

from collections.abc import Sequence

from graincal.campaign.found.answer import Candidate
from graincal.campaign.found.emulated import Emulated
from graincal.campaign.found.findings import FEW, Finding, effective_samples, find, legend, trade_offs
from graincal.campaign.found.record import Record
from graincal.campaign.found.recorded import in_words, recorded_of_answer
from graincal.data import ParameterSpace
from graincal.inference import IterativeBayesianFilter, Posterior, sample_size_advice
from graincal.inference.iterative.close_fits import close_fits
from graincal.inference.sampling.groups import find_groups
from graincal.notation import numbers
from graincal.notation.markup import to_plain
from graincal.notation.quantities import parameters, quantity
from graincal.report import verdict
from graincal.report.answer import errors_of


def found(result: Record, findings: Sequence[Finding]) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """What was found: headings, and the paragraphs under each."""
    said = []
    posterior, answer, close = result.posterior, result.most_probable, close_fits(result.iterations)
    if findings and posterior is not None and answer is not None and close is not None:
        said.append(("Parameters", (legend(close, answer.iteration), *(" ".join(finding.sentences()) for finding in findings))))
        if grouped := groups(result.space, posterior):
            said.append(("Groups", (grouped,)))
        if correlated := trade_offs(result.space, posterior):
            said.append(("Correlations", (correlated,)))
    recorded = [("Not fitted", (words,))] if (words := in_words(recorded_of_answer(result))) else []
    return (*said, ("Fit", (" ".join(fit(result)),)), *recorded, ("Grade", (" ".join(grade(result)),)), ("End", (" ".join(ending(result)),)))


def summarise(result: Record) -> str:
    """What was found, in plain lines for a terminal; the evidence, which compares models, stands in the report."""
    if result.has_posterior:
        said = verdict.found_briefly(result, Emulated.of(result))
    else:
        said = found(result, find(result.space, result.iterations, result.truth))
    return "\n".join(to_plain(text) for _, paragraphs in said for text in paragraphs)


def groups(space: ParameterSpace, posterior: Posterior) -> str:
    """The separate groups of parameter values that carry the weight; empty for a single one."""
    found = find_groups(space, posterior)
    if not found:
        return ""
    listed = []
    for group in found:
        centre = ", ".join(f"{shown.label} {numbers.value(value, 3)}" for shown, value in zip(parameters(space), group.centre))
        listed.append(f"{100 * group.share:.0f} % about {centre}")
    rest = 1 - sum(group.share for group in found)
    listed += [f"{100 * rest:.0f} % elsewhere"] if rest >= 0.005 else []
    return (
        f"The weight lies in {len(found)} separate groups of parameter values: {'; '.join(listed)}. Means, ± and correlations are over all of them, and a mean "
        "may lie where no sample does. Which group is heavier says little: another seed may well settle on another."
    )


def fit(result: Record) -> tuple[str, ...]:
    """How close the responses come to the reference."""
    best, answer = result.best, result.most_probable
    if best is None:
        return (f"All {numbers.count(result.evaluations, 'sample')} failed, so that nothing was found.",)
    if answer is None:
        return (
            f"The smallest error of {numbers.count(result.evaluations, 'sample')}, that of the best, is {numbers.percent(best.error)} ({_name(best)}): {_by_observable(result, best)}.",
        )
    said = [
        "The most probable sample is that of the largest weight in the last iteration with weights; the best is that of the smallest error of all iterations."
    ]
    said += [f"The most probable response ({_name(answer)}) is {numbers.percent(answer.error)} from the reference: {_by_observable(result, answer)}."]
    if best.sample == answer.sample:
        said.append(f"It is also the best of {numbers.count(result.evaluations, 'sample')}.")
    else:
        said.append(f"The best of {numbers.count(result.evaluations, 'sample')} ({_name(best)}) is {numbers.percent(best.error)} from it.")
    return tuple(said)


def grade(result: Record) -> tuple[str, ...]:
    """The grade, and why."""
    found = result.grade
    assert found is not None, "the paper's method has one"
    return (f"{found.word[0].upper()}{found.word[1:]}.", *found.reasons)


def ending(result: Record) -> tuple[str, ...]:
    """What stopped the calibration, or that nothing has yet."""
    done = numbers.count(len(result.iterations), "iteration")
    if result.stopped_because is None:
        return (f"Not at its end: {done} {'is' if len(result.iterations) == 1 else 'are'} complete, and what stands here is what they say so far.",)
    said = [f"Stopped after {done}: {result.stopped_because[0].lower()}{result.stopped_because[1:]}"]
    answer = result.most_probable
    if answer and answer.iteration != result.iterations[-1].index:
        said.append(f"Weights are those of iteration {answer.iteration}, the last that has any.")
    return tuple(said)


def cautions(result: Record) -> tuple[str, ...]:
    """What the spreads of this method mean, and what else to know before trusting them."""
    if result.posterior is None:
        return ()
    filter = result.calibration.blank_filter()
    assert isinstance(filter, IterativeBayesianFilter), "others have other words (verdict.py)"
    said = [
        "The spreads of the weighted samples depend on the number of iterations and on the effective sample size asked for "
        f"({100 * filter.effective_sample_size:.3g} % of the samples), not on the noise of the measurement. "
        "Read them to compare parameters with each other, not as confidence intervals."
    ]
    carried = effective_samples(result.posterior)
    if carried < FEW:
        said.append(f"The weight rests on about {numbers.count(max(1, round(carried)), 'sample')}: moments and correlations are rough.")
    if advice := sample_size_advice(result.space, filter.alpha):
        said.append(advice)
    return tuple(said)


def errors_rule() -> str:
    """What ε is, for readers."""
    return (
        "The error ε of a response: for each observable its distances from the reference, summed over its rows, in percent of the reference's summed absolute values (Eq. 5); and the mean of "
        "these, weighted where the calibration says so (Eq. 6). Equations are those of Hartmann, Cheng and Thornton (2022), Computers and Geotechnics 141, 104491."
    )


def _name(candidate: Candidate) -> str:
    return f"sample {candidate.sample}, iteration {candidate.iteration}"


def _by_observable(result: Record, candidate: Candidate) -> str:
    """The errors (Eq. 5) of a candidate in each observable of each experiment, as a list."""
    parts = []
    for experiment, errors in zip(result.experiments, errors_of(result, candidate)):
        listed = ", ".join(f"{quantity(name).label} {numbers.percent(error)}" for name, error in errors.items())
        parts.append(f"{experiment.name} ({listed})" if len(result.experiments) > 1 else listed)
    return "; ".join(parts)
