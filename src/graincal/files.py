"""What it means that a file or folder cannot be read, or cannot be written: one sentence that names it and what was expected."""

from __future__ import annotations

import errno
import os
from pathlib import Path

from graincal.errors import InputError

_FULL = (errno.ENOSPC, errno.EDQUOT)
_FORBIDDEN = (errno.EROFS, errno.EACCES, errno.EPERM)


def unreadable(path: str | os.PathLike[str], error: OSError, expected: str) -> str:
    """The sentence for a file that cannot be read, where `expected` was looked for ("a packing file")."""
    if isinstance(error, FileNotFoundError):
        return f"{path}: there is no such file, and {expected} was expected here."
    if isinstance(error, IsADirectoryError):
        return f"{path}: this is a folder, and {expected} was expected here."
    return f"{path}: this cannot be read ({error.strerror}), and {expected} was expected here."


def check_name(path: str | os.PathLike[str], expected: str) -> None:
    """Raise InputError for what no file can be called, where `expected` was looked for."""
    if "\0" in os.fspath(path):
        raise InputError(f"{path}: no file can have the character \\x00 in its name, and {expected} was expected here.")


def is_unicode(path: str | os.PathLike[str]) -> bool:
    """Whether a name is text: that of a file from an old system may be bytes of another encoding."""
    try:
        os.fspath(path).encode("utf-8")
    except UnicodeEncodeError:
        return False
    return True


def unwritable(path: str | os.PathLike[str], error: OSError) -> str:
    """The sentence for a file or folder that cannot be written, or that cannot be made."""
    if error.errno in _FULL:
        return f"{path}: the disk is full; what was finished before is safe, so make room and go on from there."
    if isinstance(error, IsADirectoryError):
        return f"{path}: this is a folder, and the name of a file to write was expected."
    if isinstance(error, FileExistsError):
        return f"{error.filename or path}: this is a file, and a folder to write to was expected."
    if isinstance(error, (FileNotFoundError, NotADirectoryError)) and not Path(path).parent.is_dir():
        return f"{path}: this cannot be written, for there is no folder {Path(path).parent}, and one that exists was expected."
    if error.errno in _FORBIDDEN:
        return f"{path}: this cannot be written ({error.strerror}): name another place, as by -o, or copy the folder to where it may be written."
    return f"{path}: this cannot be written ({error.strerror}), and a place that may be written to was expected."
