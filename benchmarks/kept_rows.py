"""Rows of results that a program appends one by one to a CSV file, so that it can be stopped and go on."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path


def read_rows(file: Path | None) -> list[dict[str, str]]:
    """The rows kept so far; none without a file."""
    if file is None or not file.exists():
        return []
    with open(file, newline="", encoding="utf-8") as lines:
        return list(csv.DictReader(lines))


def append_row(file: Path | None, row: dict[str, str], fields: Sequence[str]) -> None:
    """Keep one more, if there is a file to keep it in."""
    if file is None:
        return
    new = not file.exists()
    with open(file, "a", newline="", encoding="utf-8") as lines:
        writer = csv.DictWriter(lines, fields)
        if new:
            writer.writeheader()
        writer.writerow(row)
