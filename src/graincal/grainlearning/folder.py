"""A folder of GrainLearning's simulation data: tables of samples, and a file for each run."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from graincal.errors import InputError
from graincal.files import unreadable
from graincal.grainlearning.pickled import NotPlain, read_dictionary
from graincal.grainlearning.tables import read_samples, read_table

MOST_FILES = 1_000_000
"""Files below the folder that are looked at."""

SAME = 1e-5
"""Parameters of a run and of its table that differ by more than this part of them are others; GrainLearning's own limit."""

_RUN = re.compile(r"(?P<name>.*)_Iter(?P<iteration>\d+)_Sample(?P<sample>\d+)(?P<rest>_sim\.txt|(_sim)?\.npy)")
_TABLE = re.compile(r"smcTable(?P<iteration>\d+)\.txt|(?P<name>.*)_Iter(?P<other>\d+)_Samples\.txt")


@dataclass(frozen=True, eq=False)
class ForeignRun:
    """A run of another tool: its file, its parameters by name, and its curve's columns by name, (T,) each."""

    path: Path
    parameters: Mapping[str, float]
    columns: Mapping[str, NDArray[np.float64]]


@dataclass(frozen=True)
class FoundRuns:
    """The runs of a folder, in the order of iterations and samples; reason -> how many were left out for it."""

    runs: tuple[ForeignRun, ...]
    left_out: Mapping[str, int]


def read_folder(folder: Path) -> FoundRuns:
    """The runs in a folder and below it: `name_Iter0_Sample00.npy`, or `name_Iter0_Sample00_sim.txt` with its `_param.txt`, with the parameters that these files hold, or else those of the table of samples beside them.

    A run whose parameters differ from its table's is left out. Raises InputError for a folder that holds none, or runs of several models, and for a file that cannot be read.
    """
    files = _files(folder)
    found = sorted(
        ((match, path) for path in files if (match := _RUN.fullmatch(path.name))),
        key=lambda each: (int(each[0]["iteration"]), int(each[0]["sample"]), str(each[1])),
    )
    if not found:
        raise InputError(
            f"{folder}: there are no runs of GrainLearning here, and files such as name_Iter0_Sample00.npy or name_Iter0_Sample00_sim.txt were expected."
        )
    if len(names := sorted({match["name"] for match, _ in found})) > 1:
        raise InputError(f"{folder}: it holds runs of several models, {', '.join(names)}, and the folder of a single one was expected.")
    tables = {(path.parent, _iteration_of(path)): read_samples(path) for path in files if _TABLE.fullmatch(path.name)}
    runs, seen = [], set()
    left_out: dict[str, int] = {}
    for match, path in found:
        key = (path.parent, int(match["iteration"]), int(match["sample"]))
        table = tables.get(key[:2], {})
        run, reason = (None, "of which there are two files") if key in seen else _run(path, table.get(key[2]))
        seen.add(key)
        if run is None:
            left_out[reason] = left_out.get(reason, 0) + 1
        else:
            runs.append(run)
    if without := sum(len(set(table) - {sample for *place, sample in seen if tuple(place) == where}) for where, table in tables.items()):
        left_out["of a table without a file"] = without
    return FoundRuns(tuple(runs), left_out)


def _files(folder: Path) -> list[Path]:
    if not folder.is_dir():
        raise InputError(f"{folder}: a folder of GrainLearning's simulation data was expected.")
    found = []
    for path in folder.rglob("*"):
        found.append(path)
        if len(found) > MOST_FILES:
            raise InputError(f"{folder}: there are more than {MOST_FILES:,} files here, and a folder of GrainLearning's simulation data was expected.")
    return sorted(found)


def _iteration_of(path: Path) -> int:
    match = _TABLE.fullmatch(path.name)
    assert match is not None, "a table is known by its name"
    return int(match["iteration"] or match["other"])


def _run(path: Path, of_table: Mapping[str, float] | None) -> tuple[ForeignRun | None, str]:
    """A run, or why it is left out."""
    parameters, columns = _of_npy(path) if path.suffix == ".npy" else _of_text(path)
    if of_table is not None:
        # Other numbers may stand in the run's file too, such as how long it took.
        parameters = {name: parameters.get(name, value) for name, value in of_table.items()}
        if not all(np.isclose(parameters[name], value, rtol=SAME, atol=0) for name, value in of_table.items()):
            return None, "with other parameters than their table has"
    return (ForeignRun(path, parameters, columns), "") if parameters else (None, "without parameters")


def _of_npy(path: Path) -> tuple[dict[str, float], dict[str, NDArray[np.float64]]]:
    try:
        content = read_dictionary(path)
    except NotPlain as error:
        raise InputError(f"{path}: {error}.") from None
    except OSError as error:
        raise InputError(unreadable(path, error, "a run of GrainLearning")) from None
    # A YADE script may keep its parameters as arrays of one number.
    numbers = {name: float(np.ravel(value)[0]) for name, value in content.items() if np.size(value) == 1}
    return numbers, {name: value for name, value in content.items() if np.ndim(value) == 1 and np.size(value) > 1}


def _of_text(path: Path) -> tuple[dict[str, float], dict[str, NDArray[np.float64]]]:
    table = read_table(path)
    beside = path.with_name(path.name.removesuffix("_sim.txt") + "_param.txt")
    return _single_row(beside) if beside.is_file() else {}, {name: table.numbers(name) for name in table.names}


def _single_row(path: Path) -> dict[str, float]:
    table = read_table(path)
    if len(table.rows) != 1:
        raise InputError(f"{path}: it has {len(table.rows)} rows, and the parameters of one run were expected.")
    found = {}
    for name in table.names:
        try:
            found[name] = float(table.rows[0][table.names.index(name)])
        except ValueError:
            # A script writes whatever its table has: a description too.
            continue
    return found
