"""Responses as CSV files: a header and plain numbers, in SI units and fractions."""

from __future__ import annotations

import re
from pathlib import Path

from graincal.campaign.trouble import FolderError
from graincal.data import Response


def as_table(response: Response, control: str = "axial_strain") -> str:
    """A response as CSV: the control first, then all that the model returned, every digit of it."""
    columns = {control: response.control} | dict(response.values)
    rows = [",".join(repr(float(value)) for value in row) for row in zip(*columns.values())]
    return "\n".join([",".join(columns), *rows]) + "\n"


def write_curve(path: Path, response: Response, control: str = "axial_strain") -> None:
    """Write a response as CSV. Raises FolderError where that cannot be."""
    try:
        path.write_text(as_table(response, control), encoding="utf-8")
    except OSError as error:
        raise FolderError.of(path, error) from error


def file_name(experiment: str) -> str:
    """The name of an experiment as part of a file's name."""
    return re.sub(r"[^\w.-]+", "_", experiment).strip("_.") or "experiment"
