"""graincal import."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from graincal.cli.columns import named_columns
from graincal.cli.options import Quiet
from graincal.cli.saying import say
from graincal.data import InputError

if TYPE_CHECKING:
    from graincal.models.output import Column

import_runs = typer.Typer(no_args_is_help=True, help="Begin a campaign that learns from runs of another tool.")


@import_runs.command(epilog="Example:  graincal import grainlearning sim_data calibration.toml -o campaign")
def grainlearning(
    folder: Annotated[Path, typer.Argument(help="GrainLearning's simulation data: the folder with iter0, iter1 and so on, or one of these.", metavar="FOLDER")],
    file: Annotated[Path, typer.Argument(help="The calibration file, of the model that made these runs.", metavar="calibration.toml")],
    output: Annotated[Path, typer.Option("--output", "-o", help="The campaign's folder; it must hold none yet.", metavar="DIR")],
    column: Annotated[
        list[str] | None,
        typer.Option(
            help="A column of the runs' files and its unit, such as axial_strain=e_z or stress_ratio=ratio. May be given several times.",
            metavar="QUANTITY=COLUMN[:UNIT]",
        ),
    ] = None,
    parameter: Annotated[
        list[str] | None, typer.Option(help="A parameter in those of the runs, such as log_E=log10(E). May be given several times.", metavar="NAME=EXPRESSION")
    ] = None,
    accept: Annotated[bool, typer.Option("--accept", help="Go on in spite of problems that graincal check finds; the report says so.")] = False,
    quiet: Quiet = False,
) -> None:
    """Begin a campaign with the runs that GrainLearning kept: they teach its emulator and carry no weight. graincal resume goes on with it.

    Columns are those that the model's output declares, or that bear the quantities' names; parameters are those that bear the names in the calibration file.
    """
    from dataclasses import replace

    from graincal.campaign.found.foreign_runs import foreign_runs
    from graincal.campaign.run.running import lay_out
    from graincal.cli.running import accepted, look_at

    calibration, problems = accepted(file, look_at(file, quiet=quiet), accept=accept)
    try:
        known = foreign_runs(folder, calibration, _columns(column), _expressions(parameter))
    except InputError as error:
        raise InputError(str(error) if str(error).startswith((str(folder), "--")) else f"{file}: {error}") from None
    source = f"# Begun with the runs of {folder}, which GrainLearning kept, beside what stands below.\n{calibration.source}"
    lay_out(replace(calibration, known=known, source=source), output, problems)
    if not quiet:
        say("\n".join(known.sources))
        say(f"Stored in {output}; go on with:\n  graincal resume {shlex.quote(str(output))}")


def _columns(column: Sequence[str] | None) -> Mapping[str, Column]:
    from graincal.models.output import Column

    return {quantity: Column(place, unit) for quantity, (place, unit) in named_columns(column).items()}


def _expressions(parameter: Sequence[str] | None) -> dict[str, str]:
    found: dict[str, str] = {}
    for text in parameter or ():
        name, equals, expression = (part.strip() for part in text.partition("="))
        if not equals or not name or not expression:
            raise InputError(f"--parameter must be a parameter and an expression, such as log_E=log10(E), not {text!r}.")
        if name in found:
            raise InputError(f"--parameter names {name} twice, and each parameter once was expected.")
        found[name] = expression
    return found
