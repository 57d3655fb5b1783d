"""A lock on a folder that one process writes to: held as long as a file of it is open."""

from __future__ import annotations

import fcntl
import time
from typing import IO

_PATIENCE = 1.0
"""Seconds to wait for a lock: a reader that looks whether it is held holds it for an instant itself."""


def locked(file: IO[str]) -> bool:
    """Whether an open file could be locked for this process, until it is closed."""
    deadline = time.monotonic() + _PATIENCE
    while True:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return True
        except BlockingIOError:
            if time.monotonic() > deadline:
                return False
            time.sleep(0.05)
        except OSError:
            # A file system that knows no locks: the database's own still keep two writers from mixing their pages.
            return True
