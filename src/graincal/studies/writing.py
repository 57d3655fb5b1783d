"""What studies found, as files: tables, figures and one page."""

from __future__ import annotations

import csv
import traceback
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from graincal.campaign.stored.trouble import FolderError
from graincal.data import InputError
from graincal.drawing.with_matplotlib import save
from graincal.studies.page import render
from graincal.studies.plan import Plan
from graincal.studies.records import Findings, Table
from graincal.studies.settings import ITERATIVE, Setup
from graincal.studies.study import Done, Study

PAGE = "index.html"
COLUMNS = ("setting", "quantity", "paper", "graincal median", "low", "high", "floor")


def write(studies: Sequence[Study], setup: Setup, done: Done, plan: Plan, folder: Path, title: str, failed: Mapping[str, str]) -> tuple[Path, dict[str, str]]:
    """Write all of it; the page's path, and the studies whose numbers could not be evaluated, by name, with why.

    Raises FolderError where the folder cannot be written.
    """
    found, broken = _found(studies, setup, done)
    try:
        for name in ("tables", "figures"):
            (folder / name).mkdir(parents=True, exist_ok=True)
        for findings in found.values():
            for table in findings.tables:
                _write_table(folder / "tables" / table.file, table)
            for number, figure in findings.numbered_figures.items():
                save(figure, folder / "figures" / f"figure-{number:02d}.png")
        (folder / PAGE).write_text(render(found, setup, done, plan, title, failed, broken), encoding="utf-8")
    except OSError as error:
        raise FolderError.of(folder, error) from error
    return folder / PAGE, broken


def _found(studies: Sequence[Study], setup: Setup, done: Done) -> tuple[dict[Study, Findings], dict[str, str]]:
    """What each study finds. A file that cannot be read, or a mistake in the code of one study, costs hours of others no page: it is said, with its place, and the others are written."""
    found, broken = {}, {}
    for study in studies:
        try:
            found[study] = study.findings(setup, done)
        except InputError as error:
            found[study], broken[study.name] = Findings(), str(error)
        except Exception as error:
            place = traceback.extract_tb(error.__traceback__)[-1]
            where = f"{Path(place.filename).name}, line {place.lineno}"
            found[study], broken[study.name] = Findings(), f"by a mistake in graincal: {type(error).__name__}: {error} ({where})."
    return found, broken


def _write_table(path: Path, table: Table) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for row in table.rows:
            setting = row.setting if row.method in ("", ITERATIVE) else f"{row.setting}, {row.method}"
            numbers = (row.paper, row.median, row.low, row.high, row.floor)
            writer.writerow((setting, row.quantity, *("" if number is None or not np.isfinite(number) else f"{number:.6g}" for number in numbers)))
