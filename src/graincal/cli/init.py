"""graincal init."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from graincal.data import InputError
from graincal.files import unwritable


class Strain(str, Enum):
    """The measures of strain that laboratories and simulations print."""

    engineering = "engineering"
    logarithmic = "logarithmic"


def init(
    file: Annotated[Path, typer.Argument(help="A laboratory file: delimited text with a header.", metavar="lab.csv")],
    strain: Annotated[Strain | None, typer.Option(help="The measure of its strains, if you know it.")] = None,
    confining_pressure: Annotated[float | None, typer.Option(min=0, help="In Pa, if you know it.")] = None,
    packing: Annotated[Path | None, typer.Option(help="The packing file to simulate with; without, one is prepared when the calibration is first read.", metavar="FILE")] = None,
    void_ratio: Annotated[float | None, typer.Option(min=0, help="Of the packing that is prepared, if you know it.")] = None,
    output: Annotated[Path, typer.Option("--output", "-o", help="The calibration file to write; nothing is overwritten.", metavar="FILE")] = Path("calibration.toml"),
) -> None:
    """Look at a laboratory file, show what is understood, and write a calibration file to edit.

    Headers are known in English, German and French; an axial strain and one observable are needed at the least.
    """
    from graincal import Packing
    from graincal.cli.outputs import check_file
    from graincal.laboratory import describe, look, propose
    from graincal.models.plausibility import impossible_pressure, unusual_pressure

    if confining_pressure is not None and (doubt := impossible_pressure("--confining-pressure", confining_pressure)):
        raise InputError(doubt)
    if confining_pressure is not None and (doubt := unusual_pressure("--confining-pressure", confining_pressure)):
        typer.echo(f"Note: {doubt}")
    if packing and void_ratio is not None:
        raise InputError("--packing has a void ratio of its own, so --void-ratio cannot stand beside it.")
    found = look(file)
    grains = Packing.read(packing) if packing else None
    known = {"strain": strain and strain.value, "confining_pressure": confining_pressure, "packing": packing, "void_ratio": void_ratio}
    text = propose(found, **known, folder=output.parent)
    typer.echo("\n".join(describe(found, strain=known["strain"], confining_pressure=confining_pressure)))
    if grains:
        measured = f"; the file says {found.void_ratio:g} for the sample before shearing" if found.void_ratio else ""
        typer.echo(f"{packing}: {grains.count} particles at a void ratio of {grains.void_ratio:.3f}{measured}.")
    check_file(output)
    try:
        output.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError(unwritable(output, error)) from None
    typer.echo(f"\nWritten to {output}. Edit the lines that say CHECK, then: graincal check {output}")
