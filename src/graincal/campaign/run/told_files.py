"""Files of runs that were made by hand: <id>.csv, a curve, or <id>.failed, why there is none."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from graincal.campaign.asked.experiment import Experiment
from graincal.campaign.found.replay import INFEASIBLE
from graincal.data import Failure, InputError, Response
from graincal.files import unreadable
from graincal.laboratory.quantities import DIMENSIONS
from graincal.models.output import Column, Output
from graincal.models.output.tables import Unreadable, read_columns

FAILED = ".failed"
"""How the name of a file ends that says why a run gave no curve."""

CURVE = ".csv"
"""How the name of a file ends that holds the curve of a run, whatever is declared."""

LONGEST_REASON_FILE = 64 * 1024
"""Bytes that are read of why a run failed."""

UNREAD = ("unreadable", "no_output")
"""Kinds of failures of an output that are a mistake in the file, not in the run."""


@dataclass(frozen=True)
class ToldFile:
    """A file that says what the run of a sample gave."""

    id: int
    path: Path


def ending(experiment: Experiment) -> str:
    """How the names of the files with an experiment's curves end: as its output is declared."""
    output = getattr(experiment.model, "output", None)
    return (Path(output.file).suffix if output else "") or CURVE


def told_in(folder: Path, experiment: Experiment) -> list[Path]:
    """The files of a folder that end as those that are told; what else lies there is left alone."""
    try:
        return sorted(
            path for path in folder.iterdir() if path.suffix in (ending(experiment), CURVE, FAILED) and path.is_file() and not path.name.startswith(".")
        )
    except OSError as error:
        raise InputError(unreadable(folder, error, "a folder of runs")) from None


def files_of_experiment(folders: Sequence[Path], experiment: Experiment, refused: list[str]) -> Iterator[ToldFile]:
    """The files of an experiment in these folders, in the order of their samples; those that cannot be taken are refused, a sentence each."""
    found: dict[int, list[Path]] = {}
    for path in (path for folder in folders for path in told_in(folder, experiment)):
        if _is_id(path.stem):
            found.setdefault(int(path.stem), []).append(path)
        else:
            refused.append(f"{path}: the id of a sample was expected as the name of the file, such as 12{path.suffix}.")
    for id, paths in sorted(found.items()):
        if len(paths) > 1:
            refused.append(f"{paths[0]}: {' and '.join(map(str, paths[1:]))} is of the same sample, and a single file was expected.")
        else:
            yield ToldFile(id, paths[0])


def holds_runs(folder: Path, experiment: Experiment) -> bool:
    """Whether a folder holds files that are named as those that are told."""
    return any(_is_id(path.stem) for path in told_in(folder, experiment))


def _is_id(text: str) -> bool:
    return text.isascii() and text.isdecimal() and len(text) < 18


def read_outcome(file: ToldFile, experiment: Experiment) -> Response | Failure:
    """What a file says of a run in an experiment. Raises InputError for one that cannot be read; a curve that is too short or not finite is a Failure."""
    if file.path.suffix == FAILED:
        return _failure(file.path)
    try:
        output = getattr(experiment.model, "output", None) or _by_names(file.path, experiment)
        outcome = output.read(file.path, experiment.reference.control_name, experiment.reference.control)
    except Unreadable as error:
        raise InputError(_refusal(file.path, str(error))) from None
    if isinstance(outcome, Failure) and outcome.kind in UNREAD:
        raise InputError(_refusal(file.path, outcome.reason))
    return experiment.compared(outcome)


def _refusal(path: Path, reason: str) -> str:
    """A sentence that names the file once, by its whole path."""
    return f"{path}: {reason.removeprefix(f'{path.name}: ')}"


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


def _by_names(path: Path, experiment: Experiment) -> Output:
    """The output of a file whose columns bear the quantities' names: those that are compared, which must be there, and any others that have a number in each row."""
    reference = experiment.reference
    columns = read_columns(path, path.name)
    besides = [
        name for name in (*DIMENSIONS, *(getattr(experiment.model, "returned", None) or ())) if columns.has(name) and np.isfinite(columns.find(name)[0]).all()
    ]
    return Output({name: Column(name) for name in dict.fromkeys((reference.control_name, *reference.measured, *besides))})
