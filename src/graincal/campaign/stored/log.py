"""What happened in a campaign, a line each: to the standard logger "graincal", and to DIR/log.txt. Whoever runs the campaign holds that file locked, so that no two write to one folder."""

from __future__ import annotations

import fcntl
import logging
import math
import os
import shlex
from contextlib import suppress
from datetime import datetime
from pathlib import Path

from graincal.campaign.asked.calibration import Calibration, round_of
from graincal.campaign.stored.learnt import Learnt
from graincal.campaign.stored.listener import Listener
from graincal.campaign.stored.lock import locked
from graincal.campaign.stored.trouble import FolderError
from graincal.data import Failure, InputError, Response
from graincal.inference import Iteration
from graincal.notation.printable import printable

NAME = "log.txt"

LONGEST_LINE = 4_000
"""Characters of a line."""


class Lines(Listener):
    """What happens, as lines to the logger "graincal": failures as warnings, all else as information. The package gives it no handler that writes, so it is silent until a program asks for it."""

    _logger = logging.getLogger("graincal")
    _round = "Iteration"

    def write(self, text: str, level: int = logging.INFO) -> None:
        """Add a line."""
        self._logger.log(level, "%s", printable(text, LONGEST_LINE))

    def begins(self, calibration: Calibration) -> None:
        self._round = round_of(calibration.method).capitalize()

    def remark(self, text: str) -> None:
        self.write(text)

    def experiment_begins(self, iteration: int, experiment: str, waiting: int, samples: int) -> None:
        self.write(f'{self._round} {iteration}, "{experiment}": {waiting} of {samples} samples to evaluate.')

    def evaluated(self, sample: int, experiment: str, outcome: Response | Failure) -> None:
        seconds = outcome.details.get("seconds")
        took = "" if seconds is None else f" after {seconds:.3g} s"
        if isinstance(outcome, Response):
            how = f"stopped after {len(outcome.control)} states, for it cannot matter any more," if outcome.stopped else "finished"
        else:
            how = f"failed ({outcome.kind}: {outcome.reason})"
        self.write(f'Sample {sample}, "{experiment}": {how}{took}.', logging.WARNING if isinstance(outcome, Failure) else logging.INFO)

    def iteration_ends(self, iteration: Iteration, replayed: bool, learnt: Learnt | None) -> None:
        if not replayed:
            self.write(f"{self._round} {iteration.index} is complete: {describe_iteration(iteration, learnt)}.")

    def stops(self, by: str, because: str) -> None:
        self.write(f"Stops by {by}. {because}")


class Log(Lines):
    """The log of a campaign's folder, open for writing and locked until it is closed.

    Raises InputError where another process holds it, FolderError where it cannot be written.
    """

    def __init__(self, folder: Path) -> None:
        self.path = folder / NAME
        try:
            self._file = open(self.path, "a", encoding="utf-8")
        except OSError as error:
            raise FolderError.of(self.path, error) from error
        if not locked(self._file):
            self._file.close()
            raise InputError(f"{folder}: another process is running this campaign; `graincal status {shlex.quote(str(folder))}` says how far it is.")

    def write(self, text: str, level: int = logging.INFO) -> None:
        """Add a line, in the file with the time."""
        super().write(text, level)
        try:
            self._file.write(f"{datetime.now().astimezone().isoformat(timespec='seconds')} {printable(text, LONGEST_LINE)}\n")
            self._file.flush()
        except OSError as error:
            raise FolderError.of(self.path, error) from error

    def close(self) -> None:
        """Give the lock back."""
        # What could not be written has been said when it was written.
        with suppress(OSError):
            self._file.close()


def describe_iteration(iteration: Iteration, learnt: Learnt | None) -> str:
    """The figures of an iteration in a line."""
    failed = f"{iteration.failed.sum()} of {len(iteration.failed)} failed"
    if iteration.stopped is not None and iteration.stopped.any():
        failed += f" and {iteration.stopped.sum()} were stopped early"
    if iteration.unweighted:
        return f"{failed}, no weights: {iteration.unweighted}"
    if learnt:
        figures = {
            "doubt": learnt.doubt,
            "posterior shift": learnt.posterior_shift,
            "held-out error": learnt.held_out_error,
            "log evidence": learnt.log_evidence,
        }
        listed = ", ".join(f"{name} {value:.3g}" for name, value in figures.items() if math.isfinite(value))
        return f"{failed}, {listed}, smallest error {iteration.smallest_error:.2f} %"
    return (
        f"{failed}, s = {iteration.s:.3g}, ESS = {iteration.effective_sample_size:.2f}, GL error {iteration.gl_error:.2f} %, "
        f"most probable sample's error {iteration.error:.2f} %"
    )


def is_running(folder: Path) -> bool:
    """Whether a process runs the campaign of a folder at this moment."""
    try:
        file = os.open(folder / NAME, os.O_RDONLY)
    except OSError:
        return False
    try:
        fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        return False
    except BlockingIOError:
        return True
    except OSError:
        return False
    finally:
        os.close(file)
