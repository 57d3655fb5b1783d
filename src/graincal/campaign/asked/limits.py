"""What limits on a calibration come to: which of them ends it, and after how many evaluations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from graincal.campaign.asked.calibration import POSTERIOR, Calibration, Filter, round_of
from graincal.campaign.asked.doubt import Doubt
from graincal.inference.posterior.posterior_filter import REPLICATES, PosteriorFilter
from graincal.inference.posterior.settling import FRESH
from graincal.notation import numbers

MANY = 20_000
"""Evaluations, as the limit, from which some fresh runs more or less change nothing of what is said."""

UNUSED = 0.05
"""Of a limit on evaluations: what is left of it by more than this is said."""


@dataclass(frozen=True)
class Limits:
    """first: evaluations of the first round. evaluations, rounds: the most that there can be, None for no limit. ended_by: the limit that ends it, where no criterion does before: "max_evaluations" or
    "max_iterations"; "" for neither. asked: the limit on evaluations in effect, None for none."""

    first: int
    evaluations: int | None
    rounds: int | None
    ended_by: str
    asked: int | None

    @classmethod
    def of(cls, calibration: Calibration, filter: Filter) -> Limits:
        """Those of a calibration and its filter before the first round."""
        first, asked, most_rounds = len(filter.under_way[0]), _limit_on_evaluations(calibration, filter), _limit_on_rounds(calibration)
        if asked is None and most_rounds is None:
            return cls(first, None, None, "", None)
        at_end = REPLICATES if calibration.method == POSTERIOR else 0

        def further(count: int) -> tuple[list[int], bool]:
            """What a further round may come to within the limit on evaluations, and whether one would exceed it."""
            sizes = _sizes(calibration, filter, first, count, most=asked)
            fitting = [count + size for size in sizes if asked is None or count + size + at_end <= asked]
            return fitting, len(fitting) < len(sizes)

        # By as few rounds as lead to each number of evaluations; and by as many as there can be.
        reached, ended, counts, rounds = {first}, set(), {first}, 1
        while counts:
            if rounds == most_rounds:
                ended.add("max_iterations")
                break
            outcomes = [further(count) for count in counts]
            if any(exceeds for _, exceeds in outcomes):
                ended.add("max_evaluations")
            counts = {count for fitting, _ in outcomes for count in fitting} - reached
            reached |= counts
            rounds += 1
        slowest, rounds = first, 1
        while rounds != most_rounds and (fitting := further(slowest)[0]):
            slowest, rounds = min(fitting), rounds + 1
        return cls(first, max(reached) + at_end, rounds, "max_evaluations" if "max_evaluations" in ended else "max_iterations", asked)

    def as_json(self) -> dict[str, Any]:
        """The limits as `graincal check --json` has them."""
        return {"first_round": self.first, "evaluations_at_most": self.evaluations, "rounds_at_most": self.rounds, "ended_by": self.ended_by or None}


def limit_doubts(calibration: Calibration, filter: Filter) -> list[Doubt]:
    """Limits that are set, and that another one undercuts or that are not used to the last."""
    stop, limits, round_ = calibration.stop, Limits.of(calibration, filter), round_of(calibration.method)
    rounds = numbers.count(limits.rounds or 0, round_).replace("batchs", "batches")
    if limits.evaluations is None:
        return []
    if stop.max_evaluations is not False and limits.ended_by == "max_iterations" and limits.evaluations < stop.max_evaluations:
        limit = _limit_on_rounds(calibration)
        said = "which the method has by itself, " if stop.max_iterations is None else ""
        text = f"max_evaluations = {stop.max_evaluations} is never reached: max_iterations = {limit}, {said}ends it after {limits.evaluations} evaluations at the most."
        return [Doubt("limit-never-reached", text)]
    if stop.max_iterations and limits.ended_by == "max_evaluations" and limits.rounds is not None and limits.rounds < stop.max_iterations:
        by = (
            f"max_evaluations = {limits.asked}"
            if stop.max_evaluations is not False
            else f"the limit of {limits.asked} evaluations, which is there where none is set,"
        )
        return [Doubt("limit-never-reached", f"max_iterations = {stop.max_iterations} is never reached: {by} ends it after {rounds} at the most.")]
    if stop.max_evaluations is not False and limits.ended_by == "max_evaluations" and limits.evaluations < (1 - UNUSED) * stop.max_evaluations:
        answer = f", the {REPLICATES} runs at the answer among them" if calibration.method == POSTERIOR else ""
        text = f"of max_evaluations = {stop.max_evaluations} at most {limits.evaluations} are made{answer}: another {round_} would exceed it, and none is cut short."
        return [Doubt("limit-not-used", text)]
    return []


def _limit_on_evaluations(calibration: Calibration, filter: Filter) -> int | None:
    if isinstance(filter, PosteriorFilter):
        return filter.most_evaluations
    return None if calibration.stop.max_evaluations is False else calibration.stop.max_evaluations


def _limit_on_rounds(calibration: Calibration) -> int | None:
    if calibration.method == "sequential-monte-carlo":
        return 1
    most = calibration.stop.max_iterations if calibration.method == POSTERIOR else calibration.stop.most_iterations
    return most or None


def _sizes(calibration: Calibration, filter: Filter, first: int, count: int, most: int | None) -> list[int]:
    """The evaluations that the round after so many may have: of the filter "posterior" a batch, or fresh runs once it seems to have settled."""
    if not isinstance(filter, PosteriorFilter):
        return [first]
    batch = filter.batch_after(count)
    without_fresh = calibration.stop.posterior_shift is False or batch == FRESH or (most or 0) > MANY
    return [batch] if without_fresh else [batch, FRESH]
