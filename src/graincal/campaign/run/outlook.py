"""How long a campaign takes to its end, by the time that the evaluations of this sitting took so far."""

from __future__ import annotations

import math
import time
from dataclasses import replace

from graincal.campaign.asked.calibration import Calibration
from graincal.campaign.found.to_end import Ahead


class Outlook:
    """Counts the evaluations of a sitting. Nothing is known before as many have ended as run at once, nor where somebody makes some by hand."""

    def __init__(self, calibration: Calibration) -> None:
        self._ahead = Ahead(len(calibration.experiments), calibration.number_of_workers)
        self._by_hand = any(map(calibration.is_by_hand, range(len(calibration.experiments))))
        self._sizes: dict[int, int] = {}
        self._ended, self._began = 0, math.nan

    def expects(self, evaluations: int | None, at_most: int | None, seconds: float | None) -> None:
        """As of `Listener.expects`."""
        self._ahead = replace(self._ahead, evaluations=evaluations, at_most=at_most, until=math.inf if seconds is None else time.monotonic() + seconds)

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

    def words(self, waiting: int, left: float = 0.0) -> str:
        """The time to the end, where so many evaluations wait of the rounds so far, and the round under way takes so many seconds still; nothing where it is not known."""
        if self._by_hand:
            return ""
        now = time.monotonic()
        to_end = self._ahead.to_end(now, now - self._began, self._ended, waiting, self._sizes.values())
        return str(to_end.no_sooner(left)) if to_end else ""
