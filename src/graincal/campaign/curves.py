"""Responses as CSV files: a header and plain numbers, in SI units and fractions."""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

from graincal.campaign.trouble import FolderError
from graincal.data import Response

LONGEST, _DIGEST = 110, 12
"""Bytes of an experiment's name in that of a file, and those of a digest at its end: with what stands before and behind it, less than the 143 that the narrowest file systems take."""


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


def file_name(experiment: str) -> str:
    """The name of an experiment as part of a file's name: a long one is cut, and then has a digest of the whole name at its end, so that names that differ lead to names that differ."""
    name = re.sub(r"[^\w.-]+", "_", experiment).strip("_.") or "experiment"
    whole = name.encode("utf-8")
    if len(whole) <= LONGEST:
        return name
    return f"{whole[: LONGEST - _DIGEST - 1].decode('utf-8', errors='ignore')}-{hashlib.sha256(experiment.encode('utf-8', errors='surrogatepass')).hexdigest()[:_DIGEST]}"
