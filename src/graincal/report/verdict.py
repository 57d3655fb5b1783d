"""What the posterior says, for readers: the remarks under their headings, the evidence, and the rules."""

from __future__ import annotations

import numpy as np

from graincal.campaign.found.emulated import Emulated
from graincal.campaign.found.findings import FEW
from graincal.campaign.found.record import Record
from graincal.campaign.found.remark import CODES, Remark
from graincal.campaign.found.remarks import IDENTIFIED, RIDGE, WEAKLY, WORDS, code_of, remarks
from graincal.data import ParameterSpace
from graincal.inference.posterior.likely_runs import WITHIN, LikelyRuns
from graincal.inference.sampling.posterior import PROBABILITY
from graincal.notation import numbers

_HEADINGS = {
    "Caution": ("preliminary", "mostly-unsure"),
    "Parameters": tuple(WORDS),
    "Identifiability": ("identifiability", "identifiability-open"),
    "Ridges": ("ridges",),
    "Modes": ("modes",),
    "Fit": ("nothing-found", "too-few-responses", "fits-about-as-well", "few-fit-about-as-well"),
    "Answer": (
        "answer",
        "answer-runs",
        "answer-runs-alike",
        "answer-runs-failed",
        "answer-not-run",
        "answer-is-best",
        "another-is-closer",
        "best-by-chance",
        "errors-lead-to",
    ),
    "Not fitted": ("recorded-errors",),
    "End": ("under-way", "settled", "stopped"),
}
"""Where each remark stands; all others are of trust."""

_HEADING_OF = {code: "Trust" for codes in CODES.values() for code in codes} | {code: heading for heading, codes in _HEADINGS.items() for code in codes}

_IN_ONE = ("Caution", "Answer")
"""Headings whose remarks are one paragraph."""


def verdicts(emulated: Emulated) -> tuple[str, ...]:
    """For each parameter "identified", "weakly identified" or "not identified", or "not settled" for all."""
    return tuple(WORDS[code_of(emulated.result, part)] for part in emulated.shrinkage)


def found(result: Record, emulated: Emulated | None) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """What was found: headings, and the paragraphs under each."""
    return under_headings(remarks(result, emulated.known if emulated else None), evidence(emulated) if emulated else "")


def found_briefly(result: Record, emulated: Emulated | None) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """The same without the evidence."""
    return under_headings(remarks(result, emulated.known if emulated else None))


def under_headings(said: tuple[Remark, ...], of_evidence: str = "") -> tuple[tuple[str, tuple[str, ...]], ...]:
    """Remarks under their headings, in the order given, and the evidence before the end."""
    paragraphs: dict[str, list[str]] = {}
    for each in said:
        if of_evidence and _HEADING_OF[each.code] == "End":
            paragraphs["Evidence"] = [of_evidence]
        paragraphs.setdefault(_HEADING_OF[each.code], []).append(each.text)
    return tuple((heading, (" ".join(texts),) if heading in _IN_ONE else tuple(texts)) for heading, texts in paragraphs.items())


def rule(space: ParameterSpace) -> str:
    """The thresholds of the verdicts, for readers."""
    plain = space.is_even
    return (
        f"Once the posterior has settled, a parameter is called identified where its posterior standard deviation (sd) is below {IDENTIFIED:g} of the prior's{' (the range over √12)' if plain else ''}, "
        f"weakly identified up to {WEAKLY:g}, and else not. A ridge is a pair correlated by more than {RIDGE:g}, up or down. Intervals hold {100 * PROBABILITY:.0f} % of the probability, "
        + (
            "given the measurement errors and the ranges, which are the prior: every value in them was equally probable before the test."
            if plain
            else "given the measurement errors and the prior."
        )
    )


def fits_rule(fits: LikelyRuns) -> str:
    """Which runs fit about as well, for readers."""
    if fits.repeated:
        near = f"at most {WITHIN:g} standard deviations below the median of the {fits.repeated} runs at the answer (their own deviation, or √(n / 2) for n parameters where that is more)"
    else:
        near = f"at most {WITHIN:g} √(n / 2) below the largest (over a Gaussian posterior of n parameters its standard deviation is √(n / 2))"
    few = "" if fits.enough else " They are too few to outline a range."
    return (
        f"Runs that fit about as well: the values of the {numbers.count(fits.count, 'run')} whose log likelihood, by its own response, is {near}. "
        f"No emulator has a part in it, and more values may fit that were not run.{few}"
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


def evidence(emulated: Emulated) -> str:
    """The evidence, and how well it is known."""
    result = emulated.result
    half, deviation = emulated.evidence_of_half_ranges, result.learnt[-1].log_evidence_std
    halved = (
        f"{half:.2f} if each range were half as wide about the posterior's mean"
        if np.isfinite(half)
        else "nothing would be left of it in half of each range about the posterior's mean"
    )
    if np.isnan(half):
        halved = "what it would be in half of each range is not known, for the constraints leave too little of that"
    return (
        f"log p(reference) = {emulated.emulation.log_evidence:.2f} ± {max(deviation, 0.005):.2g} (natural logarithm; ± one sd over the responses that the emulator holds "
        f"possible and over the draws that estimate it), and {halved}: it depends on the ranges. "
        f"{_of_runs(emulated)}{_before(result)}It compares models on the same reference, errors and ranges, and says nothing by itself."
    )


def _of_runs(emulated: Emulated) -> str:
    """What the places of the runs say, weighted by the emulated likelihood instead of draws from it, where enough of them carry weight: it ought to be the same."""
    emulation, posterior = emulated.emulation, emulated.posterior
    carried = emulation.effective_runs
    if carried < FEW:
        return ""
    theta = emulated.result.knowledge.evaluations.theta[: len(emulation.weights)]
    apart = np.max(np.abs(emulation.weights @ theta - posterior.mean()) / posterior.std())
    return f"By the weights of the runs, worth {carried:.0f} of equal weight, log p(reference) is {emulation.log_evidence_of_runs:.2f}, and means are at most {apart:.2g} sd from the posterior's. "


def _before(result: Record) -> str:
    """What the evidence was two batches earlier, which says more of how well it is known than its deviation while it rises."""
    earlier = result.learnt[-3].log_evidence if len(result.learnt) > 2 else np.nan
    return f"Two batches earlier it was {earlier:.2f}. " if np.isfinite(earlier) else ""
