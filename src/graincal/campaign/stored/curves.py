"""Responses as CSV files: a header and plain numbers, in SI units and fractions."""

from __future__ import annotations

from pathlib import Path

from graincal.campaign.stored.trouble import FolderError
from graincal.data import Response


def as_table(response: Response, control: str = "axial_strain") -> str:
    """A response as CSV: the control first, then all that the model returned, every digit of it."""
    columns = {control: response.control} | dict(response.values)
    rows = [",".join(repr(float(value)) for value in row) for row in zip(*columns.values())]
    return "\n".join([",".join(columns), *rows]) + "\n"


def write_curve(path: Path, response: Response, control: str = "axial_strain") -> None:
    """Write a response as CSV. Raises FolderError where that cannot be."""
    try:
        path.write_text(as_table(response, control), encoding="utf-8", errors="backslashreplace")
    except OSError as error:
        raise FolderError.of(path, error) from error
