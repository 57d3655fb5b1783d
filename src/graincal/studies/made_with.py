"""What the work in a folder was made with, so that other data or another size never pass for it; and a lock, so that two commands never do."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path

from graincal.campaign.stored.lock import locked
from graincal.campaign.stored.trouble import FolderError
from graincal.data import InputError
from graincal.files import unreadable
from graincal.studies.settings import Setup

NAME, LOCK = "made-with.json", "lock"


@contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """Hold a folder of work for this process. Raises InputError where another one holds it, FolderError where it cannot be written."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        file = (folder / LOCK).open("a", encoding="utf-8")
    except OSError as error:
        raise FolderError.of(folder, error) from error
    with file:
        if not locked(file):
            raise InputError(f"{folder}: another process is running studies in this folder; when it has ended, the same command goes on.")
        yield


def check_made_with(setup: Setup, folder: Path) -> None:
    """Keep in the folder how large its studies are and which files they read. Files may be added later.

    Raises InputError where the folder holds work of another size, or of a file that is another now, and where what it keeps of that cannot be read.
    """
    path, now = folder / NAME, {"size": asdict(setup.size), "files": _files(setup)}
    kept = _read(path) if path.exists() else None
    if kept and kept["size"] != now["size"]:
        how = "with" if setup.size.particles is None else "without"
        raise InputError(f"{folder}: the work in this folder was made {how} --quick, and reproduce needs a folder of its own.")
    if kept and (others := [name for name, digest in now["files"].items() if kept["files"].get(name, digest) != digest]):
        raise InputError(f"{setup.data / others[0]}: the work in {folder} was made with another file of this name, and reproduce needs a folder of its own.")
    together = {"size": now["size"], "files": (kept["files"] if kept else {}) | now["files"]}
    if together != kept:
        _write(path, together)


def _read(path: Path) -> dict:
    try:
        kept = json.loads(path.read_text(encoding="utf-8"))
        return {"size": kept["size"], "files": dict(kept["files"])}
    except OSError as error:
        raise InputError(unreadable(path, error, "what the work in this folder was made with")) from None
    except (ValueError, KeyError, TypeError):
        raise InputError(
            f"{path}: this says what the work in its folder was made with, and cannot be understood. "
            "If that work is of the same data and size as now, remove the file; otherwise use another folder."
        ) from None


def _write(path: Path, kept: dict) -> None:
    """At once or not at all, whenever the process ends."""
    beside = path.with_suffix(".part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        beside.write_text(json.dumps(kept, indent=1), encoding="utf-8")
        os.replace(beside, path)
    except OSError as error:
        raise FolderError.of(path.parent, error) from error


def _files(setup: Setup) -> dict[str, str]:
    """The digests of those files of the data folder that studies read."""
    found = {}
    for path in sorted(setup.data.glob("*.csv")):
        if path.name.startswith(("packing_", "toyoura_", "synthetic_reference")):
            try:
                found[path.name] = hashlib.sha256(path.read_bytes()).hexdigest()
            except OSError as error:
                raise InputError(unreadable(path, error, "a curve or a packing")) from None
    return found
