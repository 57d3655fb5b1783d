"""The command that goes on with a campaign: every message that ends a run ends with it."""

from __future__ import annotations

import os
import shlex

from graincal.campaign.asked.calibration import LIMITS, Calibration
from graincal.campaign.found.by_hand import by_hand
from graincal.inference import PosteriorFilter

_CANNOT_GO_ON = ("failures", "effective_sample_size", "proposal")
"""What ends a campaign that no command goes on with: it has to be begun again by another calibration file."""


def what_it_does(stopped_by: str | None) -> str:
    """What `next_command` does, as it stands before the command: `go on with`, `begin again by`."""
    return "begin again by" if stopped_by in _CANNOT_GO_ON else "go on with"


def going_on(folder: str | os.PathLike[str]) -> str:
    """The command that goes on with a campaign that was interrupted."""
    return f"graincal resume {shlex.quote(os.fspath(folder))}"


def next_command(folder: str | os.PathLike[str], calibration: Calibration, stopped_by: str | None) -> str | None:
    """The command that goes on with a campaign; after a limit, with twice that limit. None where it has what it was to find.

    stopped_by: the criterion that ended it, None for one that is not at its end.
    """
    if stopped_by is None:
        return f"graincal ask {shlex.quote(os.fspath(folder))}" if by_hand(calibration) else going_on(folder)
    if stopped_by in _CANNOT_GO_ON:
        return "graincal calibrate CALIBRATION.toml -o NEW_FOLDER"
    if stopped_by not in LIMITS:
        return None
    return f"{going_on(folder)} --{stopped_by.replace('_', '-')} {2 * _limit(calibration, stopped_by):.10g}"


def _limit(calibration: Calibration, name: str) -> float:
    """The limit in effect: that which is set, or that which the method has by itself."""
    if name == "max_iterations":
        return calibration.stop.most_iterations
    filter = calibration.blank_filter() if name == "max_evaluations" else None
    limit = filter.most_evaluations if isinstance(filter, PosteriorFilter) else getattr(calibration.stop, name)
    assert limit is not None, "it ended the campaign"
    return limit
