"""What is to be said of a calibration by the method "posterior", as records that programs read by their codes and people by their sentences."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any, Literal

import numpy as np

from graincal.notation.markup import to_plain

Level = Literal["finding", "doubt", "condition"]

CODES: dict[Level, dict[str, str]] = {
    "finding": {
        "identified": "a parameter is identified",
        "weakly-identified": "a parameter is weakly identified",
        "not-identified": "a parameter is not identified",
        "interval-so-far": "where a parameter lies by what is known so far, while the posterior has not settled",
        "identifiability": "which parameters are identified, weakly or not",
        "identifiability-open": "that this cannot be said yet",
        "ridges": "pairs of parameters that are strongly correlated",
        "modes": "the probability lies in separate groups of values",
        "fits-about-as-well": "the values of the runs that fit about as well as the answer",
        "few-fit-about-as-well": "such runs are too few to outline a range",
        "answer": "where the answer is",
        "answer-runs": "how far the runs at the answer are from the reference",
        "answer-runs-alike": "these runs give the same curve: the model does not scatter",
        "answer-runs-failed": "some of these runs failed",
        "answer-not-run": "the answer has not been run again yet",
        "answer-is-best": "no run is closer than those at the answer",
        "another-is-closer": "another run is closer, by more than chance",
        "best-by-chance": "another run is closer, partly by chance",
        "recorded-errors": "how far the answer is from what was recorded and not fitted",
        "errors-lead-to": "how far the errors alone keep a response from the reference",
        "nothing-against": "nothing that was looked at speaks against the posterior",
        "under-way": "the campaign is not at its end",
        "settled": "it ended for its posterior was known",
        "stopped": "it ended for another reason",
    },
    "doubt": {
        "preliminary": "what is said may yet move",
        "mostly-unsure": "most of the probability lies where too few runs were made",
        "not-settled": "why the posterior cannot be said to have settled",
        "emulator-predicts-nothing": "the emulator predicts no better than the mean of the runs does",
        "emulator-rough": "the emulator misses held-out runs by much",
        "runs-wanting": "much of the probability lies where too few runs were made",
        "emulator-too-sure": "the emulator's intervals hold too few of the held-out runs",
        "few-runs-carry": "a few runs carry most of the weight",
        "many-failures": "many evaluations failed",
        "runs-fail-there": "some of the probability lies where runs give nothing: they fail, or parameters are impossible",
        "stopped-runs-count": "runs that were stopped early may hold more of the probability than they were to",
        "answer-far": "the answer is further from the reference than the errors explain",
        "errors-too-large": "the answer is closer to the reference than the stated errors lead to",
        "answer-outside-interval": "the answer lies outside an interval",
        "answer-at-end-of-range": "the answer is at the end of a range",
        "unlike-siblings": "the packing is of another kind than its siblings",
        "nothing-found": "all samples failed",
        "too-few-responses": "too few samples have a response for a posterior",
    },
    "condition": {
        "code-changed": "the code of a model was changed between two sittings",
        "accepted-problems": "it was begun in spite of problems that were found before, which were accepted",
        "runs-scatter": "runs at the same parameters differ, and the posterior is of their mean",
        "one-packing": "what is found is of this packing",
        "two-packings": "what is found is of these two packings",
        "error-assumed": "a measurement error was not stated, and one was taken",
    },
}
"""Every code by its level, and what it says: a contract for programs."""

LEVELS: dict[str, Level] = {code: level for level, codes in CODES.items() for code in codes}

BY_EMULATORS = ("modes", "errors-lead-to", "nothing-against", "mostly-unsure", "runs-wanting", "answer-far", "errors-too-large")
"""Codes of what takes emulators, or some seconds, to tell: `Result.remarks` and the report have them, and the status of a campaign does not."""

IDENTIFIED = ("identified", "weakly-identified", "not-identified")
"""The codes of what is said of a single parameter once the posterior has settled."""


def _pairs(*groups: tuple[str, ...]) -> set[frozenset[str]]:
    """Each of a group with each of the next groups."""
    return {frozenset(pair) for k, group in enumerate(groups) for later in groups[k + 1 :] for pair in product(group, later)}


EXCLUSIVE: frozenset[frozenset[str]] = frozenset(
    _pairs(("settled",), ("stopped",), ("under-way",))
    | _pairs(
        (*IDENTIFIED, "identifiability", "settled"), ("preliminary", "mostly-unsure", "not-settled", "interval-so-far", "identifiability-open", "runs-wanting")
    )
    | _pairs((*IDENTIFIED, "identifiability", "settled"), ("under-way", "stopped", "emulator-predicts-nothing"))
    | _pairs(("emulator-predicts-nothing",), ("emulator-rough", "runs-wanting", "mostly-unsure"))
    | _pairs(("nothing-against",), tuple(CODES["doubt"]))
    | _pairs(("answer-far",), ("errors-too-large",))
    | _pairs(("answer-not-run",), ("answer-runs", "answer-runs-alike", "answer-runs-failed", "answer-is-best", "another-is-closer"))
    | _pairs(("answer-is-best",), ("another-is-closer",), ("best-by-chance",))
    | _pairs(("runs-scatter",), ("answer-runs-alike", "answer-not-run", "emulator-rough"))
    | _pairs(("fits-about-as-well",), ("few-fit-about-as-well",))
    | _pairs(("nothing-found",), ("too-few-responses",))
    | _pairs(("nothing-found", "too-few-responses"), (*IDENTIFIED, "interval-so-far", "answer", "settled"))
)
"""Pairs of codes that contradict each other: no result has both."""


@dataclass(frozen=True)
class Remark:
    """One thing that is to be said.

    code: one of CODES, which never changes its meaning. level: "finding" (what was found), "doubt" (why not to trust it) or "condition" (what it takes for granted). text: one or two sentences, in
    markup (notation/markup.py). numbers: what it rests on, as JSON has it: None for what is not known, errors ε in percent, parameters in their own units.
    """

    code: str
    level: Level
    text: str
    numbers: Mapping[str, Any]

    @property
    def plain(self) -> str:
        """The text in plain characters."""
        return to_plain(self.text)

    def as_json(self) -> dict[str, Any]:
        """The remark as `graincal status --json` has it, its text in plain characters."""
        return {"code": self.code, "level": self.level, "text": self.plain, "numbers": dict(self.numbers)}


def remark(code: str, text: str, **numbers: Any) -> Remark:
    """A remark of a code, whose level is that of the code; numbers may be NumPy's."""
    return Remark(code, LEVELS[code], text, {name: _as_json(value) for name, value in numbers.items()})


def _as_json(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {name: _as_json(each) for name, each in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [_as_json(each) for each in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value
