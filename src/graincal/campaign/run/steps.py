"""How a campaign goes, as records for a function of somebody's own, and what `progress` may be."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from graincal.campaign.asked.calibration import Calibration, round_of
from graincal.campaign.stored.learnt import Learnt
from graincal.campaign.stored.listener import Listener
from graincal.data import Failure, InputError, Response
from graincal.inference import Iteration


@dataclass(frozen=True)
class Step:
    """Where a campaign is.

    round: "batch" or "iteration", of the number `number`. done of `total`: evaluations of this round that have ended; failed, stopped: those of them that failed, and that were stopped early.
    evaluations: all that have ended since the start or since `resume`. seconds_left: of this round, by the time that its evaluations took so far; NaN while none has ended.
    smallest_error: percent, Eq. 6 (Hartmann, Cheng, Thornton 2022), of the complete rounds; NaN before the first. complete: whether the round is complete.
    """

    round: str
    number: int
    done: int
    total: int
    failed: int
    stopped: int
    evaluations: int
    seconds_left: float
    smallest_error: float
    complete: bool = False


ProgressOption = bool | Callable[[Step], object] | None
"""What `progress` may be: True for a live table, a function that is given each Step, or nothing."""


class Steps(Listener):
    """Gives a function each step: after each evaluation, and when a round is complete. What the function raises breaks the campaign off."""

    def __init__(self, tell: Callable[[Step], object]) -> None:
        self._tell = tell

    def begins(self, calibration: Calibration) -> None:
        self._round = round_of(calibration.method)
        self._number = self._done = self._total = self._failed = self._stopped = self._evaluations = 0
        self._smallest, self._began = math.nan, time.monotonic()

    def experiment_begins(self, iteration: int, experiment: str, waiting: int, samples: int) -> None:
        # Beside what is left of a round before it, which this one was asked for ahead of.
        self._total = self._total - self._done + waiting
        self._number, self._done, self._failed, self._stopped, self._began = iteration, 0, 0, 0, time.monotonic()

    def evaluates_beside(self, waiting: int) -> None:
        self._total += waiting

    def evaluated(self, sample: int, experiment: str, outcome: Response | Failure) -> None:
        self._done += 1
        self._evaluations += 1
        self._failed += isinstance(outcome, Failure)
        self._stopped += isinstance(outcome, Response) and outcome.stopped
        self._tell(self._step())

    def iteration_ends(self, iteration: Iteration, replayed: bool, learnt: Learnt | None) -> None:
        self._smallest = float(min((error for error in (self._smallest, iteration.smallest_error) if math.isfinite(error)), default=math.nan))
        if not replayed:
            self._tell(self._step(number=iteration.index, complete=True))

    def _step(self, number: int | None = None, complete: bool = False) -> Step:
        left = (time.monotonic() - self._began) / self._done * max(self._total - self._done, 0) if self._done else math.nan
        return Step(
            self._round,
            self._number if number is None else number,
            self._done,
            self._total,
            self._failed,
            self._stopped,
            self._evaluations,
            left,
            self._smallest,
            complete,
        )


@contextmanager
def listening(progress: ProgressOption) -> Iterator[Sequence[Listener]]:
    """The listeners that `progress` asks for, which show nothing any more when the context ends. Raises InputError for what is none."""
    if callable(progress):
        yield (Steps(progress),)
    elif progress is True:
        from graincal.campaign.run.progress import Progress as Shown
        from graincal.notation.console import PrintableConsole

        with Shown(PrintableConsole(highlight=False, markup=False)) as shown:
            yield (shown,)
    elif progress is None or progress is False:
        yield ()
    else:
        raise InputError(f"progress: True, False or a function that is given each step was expected, not {progress!r}.")
