"""How long a campaign takes to its end, by the time that its evaluations took so far."""

from __future__ import annotations

import math
import time

from graincal.campaign.asked.calibration import Calibration
from graincal.notation.text import duration


class Outlook:
    """Counts the evaluations of a sitting. Nothing is known before as many have ended as run at once, nor where somebody makes some by hand."""

    def __init__(self, calibration: Calibration) -> None:
        self._experiments, self._workers = len(calibration.experiments), calibration.number_of_workers
        self._by_hand = any(map(calibration.is_by_hand, range(self._experiments)))
        self._sizes: dict[int, int] = {}
        self._ended, self._began = 0, math.nan
        self._expected: int | None = None
        self._at_most: int | None = None
        self._until = math.inf

    def expects(self, evaluations: int | None, at_most: int | None, seconds: float | None) -> None:
        """As of `Listener.expects`."""
        self._expected, self._at_most = evaluations, at_most
        self._until = math.inf if seconds is None else time.monotonic() + seconds

    def asks(self, number: int, samples: int) -> None:
        """A round of this number has so many samples, and its evaluations begin."""
        self.holds(number, samples)
        if math.isnan(self._began):
            self._began = time.monotonic()

    def holds(self, number: int, samples: int) -> None:
        """A round of this number has so many samples, whether they are evaluated now or were before. Said of a round again, it counts once."""
        self._sizes[number] = samples

    def evaluated(self) -> None:
        """An evaluation of one sample in one experiment has ended."""
        self._ended += 1

    def words(self, waiting: int) -> str:
        """The time to the end, where so many evaluations wait of the rounds so far; nothing where it is not known."""
        if self._by_hand or not self._ended or self._ended < min(self._workers, self._experiments * max(self._sizes.values())):
            return ""
        expected, at_most = self._seconds(self._expected, waiting), min(self._seconds(self._at_most, waiting), self._seconds_by_clock())
        settles = sum(self._sizes.values()) < (self._expected or 0) < (self._at_most or math.inf) and expected < at_most
        said = [f"about {duration(expected)} as most campaigns go"] if settles else []
        said += [f"at most about {duration(at_most)}"] if math.isfinite(at_most) else []
        return f"to the end {', '.join(said)}" if said else ""

    @property
    def _pace(self) -> float:
        """Seconds for an evaluation, with what the method takes between rounds."""
        return (time.monotonic() - self._began) / self._ended

    def _seconds(self, evaluations: int | None, waiting: int) -> float:
        """Until so many samples are evaluated; infinite for None."""
        if evaluations is None:
            return math.inf
        return self._pace * (waiting + self._experiments * max(evaluations - sum(self._sizes.values()), 0))

    def _seconds_by_clock(self) -> float:
        """Until the limit on hours is over, and the round that is under way then has ended."""
        return max(self._until - time.monotonic(), 0.0) + self._pace * self._experiments * max(self._sizes.values())
