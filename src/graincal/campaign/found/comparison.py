"""Which of several models explains and predicts best: campaigns on the same references, compared."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from graincal.campaign.asked.calibration import POSTERIOR
from graincal.campaign.asked.description import describe
from graincal.campaign.found.record import Record
from graincal.data import InputError
from graincal.inference.likelihood.scoring import Score


@dataclass(frozen=True)
class Contender:
    """A campaign's log evidence with its sd, whether its posterior had settled, and how it predicted a test that none of them was fitted to, if there is one."""

    name: str
    log_evidence: float
    log_evidence_std: float
    settled: bool
    score: Score | None

    def may_be_above(self, best: Contender) -> bool:
        """Whether its evidence may be above that of the best, for all that is known.

        An evidence is the mean over the responses that the emulator holds possible. Few of them may make up most of it, where the emulator knows little, and the
        deviation is then of how far below the mean nearly all of them are. Above it little may lie: more than twenty times as much has a probability of less
        than a twentieth, by Markov's inequality.
        """
        return best.log_evidence - 2 * best.log_evidence_std < self.log_evidence + math.log(20)


def compare(results: Mapping[str, Record | str | Path], scores: Mapping[str, Score] | None = None) -> list[Contender]:
    """The campaigns by name, the best first: by the log score of a held-out test where `scores` has one for each, else by log evidence.

    >>> compare({"linear": result, "hertz": "hertz_campaign"})                                   # doctest: +SKIP

    results: a result each, or the folder of its campaign. scores: `predict(...).against(reference)` of each.

    An evidence depends on the ranges of the parameters: the wider they are for nothing, the smaller it is. A prediction does not.
    Raises InputError for fewer than two campaigns, for others than of the method "posterior", and where references or errors differ.
    """
    if len(results) < 2:
        raise InputError("a comparison needs two campaigns or more.")
    read = {name: result if isinstance(result, Record) else Record.read(result) for name, result in results.items()}
    for name, result in read.items():
        if result.calibration.method != POSTERIOR:
            raise InputError(f'{name}: its method is "{result.calibration.method}", and only campaigns of the method "{POSTERIOR}" have an evidence.')
        if not math.isfinite(result.log_evidence):
            raise InputError(f"{name}: its evidence is not known, for too few of its runs gave a response to emulate; more evaluations were expected.")
    _refuse_different_data(read)
    contenders = [
        Contender(name, result.log_evidence, result.learnt[-1].log_evidence_std, result.settled, scores[name] if scores else None)
        for name, result in read.items()
    ]
    return sorted(contenders, key=lambda each: -(each.score.log_score if each.score else each.log_evidence))


def _refuse_different_data(results: Mapping[str, Record]) -> None:
    (first, reference), *others = ((name, _data(result)) for name, result in results.items())
    for name, data in others:
        for key, value in data.items():
            if value != reference[key]:
                raise InputError(f"{name} and {first} differ in {key}, so that they cannot be compared: the same references and errors were expected.")


def _data(result: Record) -> dict[str, object]:
    """What a likelihood is of: the references, without their notes and what is not fitted, and what is assumed of their errors."""
    experiments: Sequence[Mapping] = describe(result.calibration)["experiments"]
    references = [{key: value for key, value in each["reference"].items() if key not in ("notes", "variance_shares", "recorded")} for each in experiments]
    asked = result.calibration.filter_options.get("packing_scatter", True)
    scatter = [asked and result.knows_packings(number) for number in range(len(result.experiments))] if asked else False
    thinned = [thinning.thinned for thinning in result.calibration.blank_filter().thinnings]
    options = {f"filter.{name}": value for name, value in result.calibration.error_options.items()}
    return {
        "the number of experiments": len(references),
        "their references": references,
        "whether the scatter of packings counts": scatter,
        "which references are thinned (filter.thin)": thinned,
        **options,
    }
