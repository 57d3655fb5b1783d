"""A folder of its own for what is new: refused where something is in it already, and held by one process."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from graincal.campaign.stored.log import Log
from graincal.campaign.stored.trouble import FolderError


def claim(folder: Path, refuse_occupied: Callable[[bool], None]) -> Log:
    """Make a folder where there is none, and open its log, which locks it until it is closed.

    refuse_occupied(locked): raises InputError where the folder holds something already; it is asked before this process holds the folder, and after. Raises that too where another process holds it, FolderError where it cannot be written.
    """
    refuse_occupied(False)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FolderError.of(folder, error) from error
    log = Log(folder)
    try:
        # Once more under the lock: another process may have begun here.
        refuse_occupied(True)
    except BaseException:
        log.close()
        raise
    return log
