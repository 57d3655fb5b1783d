"""graincal ask."""

from __future__ import annotations

from enum import Enum
from typing import Annotated

import typer

from graincal.cli.options import Folder
from graincal.data import InputError


class Table(str, Enum):
    """The tables that parameters are printed as."""

    csv = "csv"
    yade = "yade"


def ask(
    folder: Folder,
    experiment: Annotated[str | None, typer.Option(help="The runs of this experiment alone.", metavar="NAME")] = None,
    format: Annotated[Table, typer.Option(help="A table of CSV, or one for yade-batch.")] = Table.csv,
) -> None:
    """Print the runs that wait to be made by hand: the id of each, and its parameters.

    It prints the same until graincal tell has taken what the runs gave.
    """
    from graincal.campaign.run.asking import as_csv, as_yade_table
    from graincal.campaign.run.asking import ask as read

    found = read(folder, experiment)
    if format is Table.csv:
        return typer.echo(as_csv(found), nl=False)
    if len(found) > 1:
        raise InputError(f"a table of YADE is of one experiment, and --experiment with one of {', '.join(each.experiment for each in found)} was expected.")
    typer.echo(as_yade_table(found[0]), nl=False)
