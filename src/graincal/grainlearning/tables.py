"""The text tables that GrainLearning and its YADE scripts write: names in the first line, then rows."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from graincal.errors import InputError
from graincal.files import unreadable

LARGEST = 256 * 2**20
"""Bytes of a file that are read."""

BESIDES = ("description", "key")
"""Columns of a table of samples that are no parameters, beside those whose names begin with an exclamation mark."""


@dataclass(frozen=True)
class TextTable:
    """Names of columns, and the cells of the rows as they are written."""

    path: Path
    names: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def numbers(self, name: str) -> NDArray[np.float64]:
        """A column (T,). Raises InputError where a cell is no number."""
        column = self.names.index(name)
        try:
            return np.array([float(row[column]) for row in self.rows])
        except ValueError:
            raise InputError(f"{self.path}: the column {name} holds something else than numbers.") from None


def read_table(path: Path) -> TextTable:
    """A table whose first line has its columns' names, perhaps behind a #, parted by spaces, tabs or commas. Raises InputError for what is none."""
    try:
        if path.stat().st_size > LARGEST:
            raise InputError(f"{path}: it has more than {LARGEST / 2**20:,.0f} MiB, and a table of GrainLearning was expected.")
        lines = [line for line in path.read_text(encoding="utf-8-sig").splitlines() if line.strip()]
    except OSError as error:
        raise InputError(unreadable(path, error, "a table of GrainLearning")) from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: a text file was expected.") from None
    if not lines:
        raise InputError(f"{path}: it is empty, and a table of GrainLearning was expected.")
    names, *rows = (_cells(line) for line in (lines[0].lstrip("# \t"), *(line for line in lines[1:] if not line.lstrip().startswith("#"))))
    for number, row in enumerate(rows, 1):
        if len(row) != len(names):
            raise InputError(f"{path}: row {number} has {len(row)} cells, and one for each of {', '.join(names)} was expected.")
    if len(set(names)) < len(names):
        raise InputError(f"{path}: a name stands twice in its first line, {', '.join(names)}.")
    return TextTable(path, names, tuple(rows))


def read_samples(path: Path) -> dict[int, dict[str, float]]:
    """A table of samples, `smcTable0.txt` or `name_Iter0_Samples.txt`: the number of each sample -> its parameters by name."""
    table = read_table(path)
    names = [name for name in table.names if not name.startswith("!") and name not in BESIDES]
    columns = {name: table.numbers(name) for name in names}
    keys = table.numbers("key").astype(int) if "key" in table.names else range(len(table.rows))
    return {int(key): {name: float(column[row]) for name, column in columns.items()} for row, key in enumerate(keys)}


def _cells(line: str) -> tuple[str, ...]:
    return tuple(re.split(r"[\s,]+", line.strip(" \t,")))
