"""Files of runs that were made by hand: <id>.csv, a curve, or <id>.failed, why there is none."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from graincal.campaign.asked.experiment import Experiment
from graincal.campaign.found.replay import INFEASIBLE
from graincal.campaign.run.waiting import CURVE, FAILED
from graincal.data import Failure, InputError, Response
from graincal.files import unreadable
from graincal.laboratory import read_reference

LONGEST_REASON_FILE = 64 * 1024
"""Bytes that are read of why a run failed."""


@dataclass(frozen=True)
class ToldFile:
    """A file that says what the run of a sample gave."""

    id: int
    path: Path


def files_of_experiment(folders: Sequence[Path], refused: list[str]) -> Iterator[ToldFile]:
    """The files in these folders, in the order of their samples; those that cannot be taken are refused, a sentence each."""
    found: dict[int, Path] = {}
    twice: set[int] = set()
    for path in (path for folder in folders for path in others_in(folder)):
        if not (path.stem.isascii() and path.stem.isdecimal()):
            refused.append(f"{path}: the id of a sample was expected as the name of the file, such as 12{path.suffix}.")
        elif (id := int(path.stem)) in found:
            refused.append(f"{path}: {found[id].name} is of the same sample, and a single file was expected.")
            twice.add(id)
        else:
            found[id] = path
    yield from (ToldFile(id, path) for id, path in sorted(found.items()) if id not in twice)


def others_in(folder: Path) -> list[Path]:
    """The files of a folder that have the ending of one that is told; what else lies there is nobody's business."""
    try:
        return sorted(path for path in folder.iterdir() if path.suffix in (CURVE, FAILED) and path.is_file() and not path.name.startswith("."))
    except OSError as error:
        raise InputError(unreadable(folder, error, "a folder of runs")) from None


def read_outcome(file: ToldFile, experiment: Experiment) -> Response | Failure:
    """What a file says of a run in an experiment. Raises InputError for one that cannot be read."""
    if file.path.suffix == FAILED:
        return _failure(file.path)
    try:
        return experiment.compared(_curve(file.path, experiment))
    except InputError as error:
        said = str(error)
        raise InputError(said if said.startswith(str(file.path)) else f"{file.path}: {said}") from None


def _failure(path: Path) -> Failure:
    """A reason that begins with `infeasible:` says that no run is possible at these parameters; any other says nothing of them."""
    try:
        with open(path, "rb") as file:
            text = file.read(LONGEST_REASON_FILE).decode("utf-8", errors="replace").removeprefix("\ufeff").strip()
    except OSError as error:
        raise InputError(unreadable(path, error, "the reason why a run failed")) from None
    kind, colon, reason = text.partition(":")
    if colon and kind.strip().lower() == INFEASIBLE:
        return Failure(INFEASIBLE, reason.strip() or "no reason was given.")
    return Failure("failed", text or "no reason was given.")


def _curve(path: Path, experiment: Experiment) -> Response:
    reference = experiment.reference
    found = read_reference(path, reference.control_name, tuple(reference.measured))
    return Response(found.control, dict(found.observables), control_name=reference.control_name)
