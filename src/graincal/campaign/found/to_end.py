"""How long a campaign takes to its end: the same for the process that runs it, and for those that follow it."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from graincal.campaign.found.by_hand import by_hand
from graincal.campaign.stored.store import Store
from graincal.notation.text import duration


@dataclass(frozen=True)
class ToEnd:
    """Seconds to the end of a campaign; one of them is known. as_most_go: as most campaigns go, None where that is not known, or not before the limit; at_most: None without a limit."""

    as_most_go: float | None
    at_most: float | None

    def no_sooner(self, seconds: float) -> ToEnd:
        """The same, where the round that is under way takes so many seconds still."""
        return ToEnd(*(None if each is None else max(each, seconds) for each in (self.as_most_go, self.at_most)))

    def __str__(self) -> str:
        """In words."""
        said = [f"about {duration(self.as_most_go)} as most campaigns go"] if self.as_most_go is not None else []
        said += [f"at most about {duration(self.at_most)}"] if self.at_most is not None else []
        return f"to the end {', '.join(said)}"


@dataclass(frozen=True)
class Ahead:
    """What a campaign has before it. experiments, workers: their numbers; evaluations: samples that it comes to, as most campaigns go, and at_most, None for what is not known or no limit; until: no
    round begins after this time, s by a clock, infinite without a limit on hours."""

    experiments: int
    workers: int
    evaluations: int | None = None
    at_most: int | None = None
    until: float = math.inf

    def to_end(self, now: float, seconds: float, ended: int, waiting: int, sizes: Collection[int]) -> ToEnd | None:
        """Where so many evaluations ended within so many seconds, with what the method takes between rounds; None before as many have ended as run at once, and where neither is known.

        now: by the clock of `until`. waiting: evaluations of the rounds so far that have not ended; sizes: samples of each of these rounds.
        """
        if not ended or ended < min(self.workers, self.experiments * max(sizes)):
            return None
        pace = seconds / ended

        def until(samples: int | None) -> float:
            return math.inf if samples is None else pace * (waiting + self.experiments * max(samples - sum(sizes), 0))

        # The round that is under way when the time is over goes on to its end.
        by_clock = max(self.until - now, 0.0) + pace * self.experiments * max(sizes)
        expected, at_most = until(self.evaluations), min(until(self.at_most), by_clock)
        settles = sum(sizes) < (self.evaluations or 0) < (self.at_most or math.inf) and expected < at_most
        limited = math.isfinite(at_most)
        return ToEnd(expected if settles else None, at_most if limited else None) if settles or limited else None


def to_end_of(store: Store) -> ToEnd | None:
    """Of a campaign that another process runs, by what its store holds; None where that is not known."""
    calibration, sitting = store.calibration, store.sitting()
    if sitting is None or by_hand(calibration):
        return None
    sizes, waiting = store.rounds()
    begun, ended = store.ended_since(sitting["began"])
    if begun is None or not sizes:
        return None
    now = datetime.now(UTC).timestamp()
    ahead = Ahead(len(calibration.experiments), calibration.number_of_workers, sitting["evaluations"], sitting["at_most"], _clock(sitting))
    return ahead.to_end(now, now - begun, ended, waiting, sizes)


def _clock(sitting: dict[str, Any]) -> float:
    """When the limit on hours is over, s since 1970; infinite without one."""
    return math.inf if sitting["seconds"] is None else datetime.fromisoformat(sitting["began"]).timestamp() + sitting["seconds"]
