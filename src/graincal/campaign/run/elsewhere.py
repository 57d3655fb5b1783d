"""Evaluations of a campaign that run elsewhere: by Parsl, or by an executor that the calibration names."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import TYPE_CHECKING
from uuid import uuid4

from graincal.campaign.asked.calibration import Calibration
from graincal.campaign.asked.place import PARSL, Place
from graincal.campaign.stored.listener import Listener
from graincal.campaign.stored.store import Store
from graincal.data import InputError
from graincal.execution.threads import Done
from graincal.models import Model
from graincal.models.named_function import find_function

if TYPE_CHECKING:
    from graincal.execution.elsewhere import Elsewhere

LABEL = "label"
"""The key under which a store keeps what its jobs are known by, before the first of them is submitted."""


OF_BLOCKS = ".graincal"
"""The folder in the home folder for what blocks need of campaigns that they do not see."""


def check_place(place: Place | None) -> None:
    """Raise InputError where evaluations cannot be handed over from here. A named function's module is imported for that."""
    if place is None:
        return
    if place.executor == PARSL:
        from graincal.execution.providers import Blocks

        Blocks(**place.blocks).check()
    else:
        _function(place)


def backend_elsewhere(calibration: Calibration, store: Store, listeners: Sequence[Listener]) -> Callable[[Done], Elsewhere] | None:
    """What makes the scheduler's backend; None where evaluations run in workers of graincal's own. Raises InputError as `check_place`."""
    place = calibration.place
    if place is None:
        return None
    if store.folder is None:
        raise InputError(f"evaluations by {place} need a campaign that is kept in a folder.")
    check_place(place)

    def say(text: str) -> None:
        for listener in listeners:
            listener.remark(text)

    models = [experiment.model for experiment in calibration.experiments]

    folder = store.folder

    def make(done: Done) -> Elsewhere:
        if place.executor == PARSL:
            from graincal.execution.parsl import OnBlocks
            from graincal.execution.providers import Blocks

            timeouts = [seconds for model in models if (seconds := _timeout(model)) is not None]
            longest, cores = max(timeouts) if len(timeouts) == len(models) else None, max(getattr(model, "cores", 1) for model in models)
            label = _label(store, folder)
            return OnBlocks(Blocks(**place.blocks), label, done, _seen_by_blocks(folder, label, models, say), say, longest=longest, cores=cores)
        from graincal.execution.elsewhere import OnNamedExecutor

        return OnNamedExecutor(_executor(place), done, folder, say, needs_folder=any(map(_keeps_files, models)))

    return make


def _timeout(model: Model) -> float | None:
    """The seconds that an evaluation may take; None where nothing is said."""
    limits = getattr(model, "limits", None)
    return getattr(model, "timeout", None) if limits is None else limits.time_limit


def _keeps_files(model: Model) -> bool:
    """Whether an evaluation writes into the campaign's folder, from where it runs."""
    folders = getattr(model, "folders", None)
    return folders is not None and folders.scratch is None


def _seen_by_blocks(folder: Path, label: str, models: Sequence[Model], say: Callable[[str], None]) -> Path:
    """Where the blocks' own files lie, on a file system that the nodes share: the campaign's folder, or one in the home folder where all models run in `scratch`, for the campaign may then lie on a disk of this machine."""
    if not all(_runs_in_scratch(model) for model in models):
        return folder
    home = Path.home() / OF_BLOCKS / label
    home.mkdir(mode=0o700, parents=True, exist_ok=True)
    say(f"All models have scratch: what blocks need and print is in {home}, which the nodes must see; they need not see {folder}.")
    return home


def _runs_in_scratch(model: Model) -> bool:
    folders = getattr(model, "folders", None)
    return folders is not None and folders.scratch is not None


def _label(store: Store, folder: Path) -> str:
    """The same for all sittings of a campaign, and another one for a copy of its folder, whose jobs are others."""
    store.keep(LABEL, uuid4().hex[:12])
    return f"graincal-{store.meta(LABEL)}-{hashlib.sha256(str(folder.resolve()).encode('utf-8', 'surrogateescape')).hexdigest()[:6]}"


def _function(place: Place) -> Callable[[], Executor]:
    try:
        return find_function(place.executor, Path(place.folder) if place.folder else None)
    except InputError as error:
        raise InputError(f"run.executor: {error}") from error


def _executor(place: Place) -> Executor:
    try:
        executor = _function(place)()
    except InputError:
        raise
    except Exception as error:
        raise InputError(f"run.executor: {place.executor} failed ({type(error).__name__}: {error}).") from error
    if not isinstance(executor, Executor):
        raise InputError(f"run.executor: {place.executor} must return a concurrent.futures.Executor, not {type(executor).__name__}.")
    return executor
