"""graincal export."""

from __future__ import annotations

from enum import Enum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from graincal.cli.options import Folder
from graincal.cli.saying import say

if TYPE_CHECKING:
    from graincal.result import Result


class Format(str, Enum):
    """What can be exported to."""

    csv = "csv"
    json = "json"
    netcdf = "netcdf"
    yade = "yade"
    lammps = "lammps"
    pfc = "pfc"


def export(
    folder: Folder,
    to: Annotated[
        Format,
        typer.Option(
            help="Tables as CSV, one JSON document, or the posterior as NetCDF for ArviZ; or the contact law at the answer, as lines for another DEM program."
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="A folder to write to, instead of export in the campaign's; nothing in it is overwritten.", metavar="FOLDER"),
    ] = None,
) -> None:
    """Write samples, weights, errors and responses of the complete iterations for other programs, or the answer as the contact law of another DEM program."""
    from graincal.campaign.found.export import export_csv, export_json
    from graincal.cli.outputs import check_folder
    from graincal.result import Result

    write = {Format.csv: export_csv, Format.json: export_json, Format.netcdf: _netcdf}.get(to) or partial(_contact, to.value)
    result, target = Result.read(folder), output or folder / "export"
    check_folder(target)
    before = set(target.glob("*"))
    written = write(result, target, replace=output is None)
    for path in written:
        say(path)
    if replaced := before.intersection(written):
        say(f"{len(replaced)} of these replaced the files of an earlier export.", err=True)


def _netcdf(result: Result, folder: Path, *, replace: bool) -> list[Path]:
    from graincal.campaign.found.netcdf import export_netcdf

    return export_netcdf(result, result.emulated, folder, replace=replace)


def _contact(program: str, result: Result, folder: Path, *, replace: bool) -> list[Path]:
    from graincal.campaign.found.export_contact import export_contact
    from graincal.campaign.found.trust import has_settled
    from graincal.data import InputError
    from graincal.report.answer import answer_of, name_of_answer

    answer = answer_of(result)
    if answer is None:
        raise InputError(f"{result.folder}: all of its evaluations failed, so there is no answer to export.")
    called = name_of_answer(result)
    if result.has_posterior and not has_settled(result):
        say("The posterior has not settled: the answer may yet move.", err=True)
        called = f"{called}, which may yet move (the posterior has not settled),"
    return export_contact(result, answer.theta, called, program, folder, replace=replace)
