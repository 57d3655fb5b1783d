"""What the work in a folder was made with, so that other data or another size never pass for it."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict
from pathlib import Path

from graincal.campaign.trouble import FolderError
from graincal.data import InputError
from graincal.files import unreadable
from graincal.studies.settings import Setup

NAME = "made-with.json"


def check_made_with(setup: Setup, folder: Path) -> None:
    """Keep in the folder how large its studies are and which files they read. Files may be added later. Raises InputError where the folder holds work of another size, or of a file that is another now."""
    path, now = folder / NAME, {"size": asdict(setup.size), "files": _files(setup)}
    kept = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {"size": now["size"], "files": {}}
    if kept["size"] != now["size"]:
        how = "with" if setup.size.particles is None else "without"
        raise InputError(f"{folder}: the work in this folder was made {how} --quick, and reproduce needs a folder of its own.")
    if others := [name for name, digest in now["files"].items() if kept["files"].get(name, digest) != digest]:
        raise InputError(f"{setup.data / others[0]}: the work in {folder} was made with another file of this name, and reproduce needs a folder of its own.")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps({"size": now["size"], "files": kept["files"] | now["files"]}, indent=1), encoding="utf-8")
    except OSError as error:
        raise FolderError.of(folder, error) from error


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
