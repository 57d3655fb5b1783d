"""What can be wrong with a campaign's folder."""

from __future__ import annotations

import errno
import sqlite3
from pathlib import Path

from graincal.data import InputError


class FolderError(InputError):
    """A campaign's folder cannot be read or written. The message is one sentence that names the file."""

    @classmethod
    def of(cls, path: Path | str, error: OSError | sqlite3.Error) -> FolderError:
        """What an error of the system or of the database means for a file."""
        if isinstance(error, OSError):
            full, reason = error.errno in (errno.ENOSPC, errno.EDQUOT), error.strerror
        else:
            full, reason = getattr(error, "sqlite_errorcode", None) == sqlite3.SQLITE_FULL, str(error)
        if full:
            return cls(f"{path}: the disk is full; what was finished before is safe, so make room and go on from there.")
        return cls(f"{path}: this cannot be read or written ({reason}).")
