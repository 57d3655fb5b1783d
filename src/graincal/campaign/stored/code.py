"""The code of named functions and of programs: what a campaign runs, and what was changed in it between two sittings."""

from __future__ import annotations

import ast
import hashlib
import json
import os
import pwd
import shlex
from collections.abc import Iterator
from pathlib import Path

from graincal.campaign.asked.calibration import Calibration
from graincal.campaign.asked.place import Place
from graincal.campaign.stored.database import NAME
from graincal.campaign.stored.store import Store
from graincal.campaign.stored.trouble import FolderError
from graincal.data import InputError
from graincal.models import CommandModel, PythonModel

CODE = "code"
"""The key under which a store keeps a digest of each file that its named functions are made of, as it was when these were first run."""

CHANGED = "code changed"
"""The key under which a store keeps what was changed in these between two sittings, from which on evaluations may be those of another model."""

_LINES = ("worker_init", "scheduler_options")
"""The keys of a cluster's blocks that are lines of a script."""

_MOST = 1_000
"""Files of which digests are kept."""


def files_of(calibration: Calibration) -> dict[str, Path]:
    """The files, by their names in their folders, of the modules of named functions that lie in the folder of the calibration, and of those that they import from there; and those that programs are given."""
    found: dict[str, Path] = {}
    for experiment in calibration.experiments:
        model = experiment.model
        if isinstance(model, CommandModel):
            found |= model.files
        if not isinstance(model, PythonModel) or not isinstance(model.function, str) or model.folder is None:
            continue
        waiting = [model.function.partition(":")[0]]
        while waiting and len(found) < _MOST:
            for path in _files_of(waiting.pop(), model.folder):
                name = path.relative_to(model.folder).as_posix()
                if name not in found:
                    found[name] = path
                    waiting += _imported(path)
    return found


def digests_of(calibration: Calibration) -> dict[str, str]:
    """A digest of each of the files that can be read."""
    found = {}
    for name, path in sorted(files_of(calibration).items()):
        try:
            found[name] = hashlib.sha256(path.read_bytes()).hexdigest()
        except OSError:
            continue
    return found


def look_at_code(store: Store, calibration: Calibration) -> str | None:
    """Keep digests of the code, where none are kept yet, and say what was changed in it since then; None for nothing. A store of before keeps those of its next sitting."""
    now = digests_of(calibration)
    if not now and store.meta(CODE) is None:
        return None
    store.keep(CODE, json.dumps(now))
    kept = store.meta(CODE)
    assert kept is not None, "it was kept a moment ago, or before"
    before = json.loads(kept)
    names = ", ".join(sorted(name for name in {*before, *now} if before.get(name) != now.get(name)))
    if not names:
        return None
    said = f"{names}: this code was changed since the campaign was begun, so that evaluations of before and from now on may be those of two models; a new campaign is of the code as it is."
    store.keep(CHANGED, names)
    return said


def refuse_strangers_code(store: Store, place: Place | None = None) -> None:
    """Raise InputError where the store's database belongs to another user, and going on with it would run functions or programs that it names, or lines of its jobs' scripts: that is for a person to decide, who is shown which.

    place: where it is to run now, if not where it was begun."""
    if store.folder is None:
        return
    database = store.folder / NAME
    try:
        owner = database.stat().st_uid
    except OSError as error:
        raise FolderError.of(database, error, reading=True) from error
    if owner == os.getuid():
        return
    look = store.calibration.look
    experiments = (*store.calibration.experiments, *(look.experiments if look else ()))
    code = {(each.model.function, each.model.folder) for each in experiments if isinstance(each.model, PythonModel) and isinstance(each.model.function, str)}
    code |= {(shlex.join(each.model.command), each.model.folder) for each in experiments if isinstance(each.model, CommandModel)}
    runs = [f"{name}{f' of {folder}' if folder else ''}" for name, folder in sorted(code, key=str)]
    places = {str(each): each for each in (store.calibration.place, place) if each}
    runs += [f"{each}{''.join(f', {key} = {json.dumps(each.blocks[key])}' for key in _LINES if key in each.blocks)}" for each in places.values()]
    if runs:
        said = "; ".join(runs)
        raise InputError(
            f"{database}: this campaign belongs to another user ({_user(owner)}), and to go on with it runs code: {said}. Where you trust that, go on by --trust, or trust=True in Python."
        )


def _user(number: int) -> str:
    try:
        return pwd.getpwuid(number).pw_name
    except KeyError:
        return str(number)


def _files_of(module: str, folder: Path) -> Iterator[Path]:
    """Those of a module that lies in the folder: its own, and those of the packages that it is in."""
    parts = module.split(".")
    for depth in range(1, len(parts) + 1):
        path = folder.joinpath(*parts[:depth])
        for file in (path.with_name(f"{path.name}.py"), path / "__init__.py"):
            try:
                if file.is_file():
                    yield file
            # A name that no file can have.
            except (OSError, ValueError):
                continue


def _imported(path: Path) -> list[str]:
    """The names of modules that a file imports, as far as it can be read as Python; relative ones are taken as from its folder."""
    try:
        tree = ast.parse(path.read_bytes())
    except (OSError, SyntaxError, ValueError, RecursionError, MemoryError):
        return []
    names = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names += [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    return names
