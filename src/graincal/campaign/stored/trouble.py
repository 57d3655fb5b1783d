"""What can be wrong with a campaign's folder."""

from __future__ import annotations

import errno
import sqlite3
from pathlib import Path

from graincal.data import InputError
from graincal.files import unreadable, unwritable


class FolderError(InputError):
    """A campaign's folder cannot be read or written. The message is one sentence that names the file."""

    @classmethod
    def of(cls, path: Path | str, error: OSError | sqlite3.Error, *, reading: bool = False) -> FolderError:
        """What an error of the system or of the database means for a file that was to be written, or read."""
        if isinstance(error, sqlite3.Error) and getattr(error, "sqlite_errorcode", None) == sqlite3.SQLITE_FULL:
            error = OSError(errno.ENOSPC, str(error))
        if isinstance(error, OSError):
            return cls(unreadable(path, error, "a file of the campaign") if reading else unwritable(path, error))
        return cls(
            f"{path}: this cannot be read ({error}), and the store of a campaign was expected here."
            if reading
            else f"{path}: this cannot be written ({error})."
        )
