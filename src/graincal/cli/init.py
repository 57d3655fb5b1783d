"""graincal init."""

from __future__ import annotations

import shlex
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from graincal.campaign.file.own_simulator import OwnSimulator
from graincal.cli.asking import Asking, in_a_terminal
from graincal.cli.columns import Column, Compression, Measure, Rows, Sheet, Stage, Strain, first_and_last, named_columns, signs
from graincal.cli.saying import say
from graincal.data import InputError
from graincal.files import unwritable

if TYPE_CHECKING:
    from graincal.dem.packing import Packing
    from graincal.laboratory import Known, NotUnderstood, Understanding
    from graincal.laboratory.table import Table


class Kind(str, Enum):
    """The kinds of tests that are read."""

    triaxial = "triaxial"
    undrained = "undrained"
    constant_mean_stress = "constant-mean-stress"
    oedometric = "oedometric"
    isotropic = "isotropic"


def init(
    context: typer.Context,
    file: Annotated[Path, typer.Argument(help="A laboratory file: delimited text, a spreadsheet, AGS4 data.", metavar="lab.csv")],
    strain: Measure = None,
    confining_pressure: Annotated[float | None, typer.Option(min=0, help="Effective confining pressure, in Pa.")] = None,
    kind: Annotated[Kind | None, typer.Option(help="The kind of test; triaxial is drained.")] = None,
    column: Column = None,
    stress_unit: Annotated[str | None, typer.Option(help="The unit of stresses whose headers state none, such as kPa.", metavar="UNIT")] = None,
    compression: Compression = None,
    stage: Stage = None,
    rows: Rows = None,
    sheet: Sheet = None,
    encoding: Annotated[str | None, typer.Option(help="How the text is encoded, such as cp1251.", metavar="NAME")] = None,
    sample_height: Annotated[float | None, typer.Option(min=0, help="Height of the sample where a displacement is 0, in m.")] = None,
    sample_volume: Annotated[float | None, typer.Option(min=0, help="Volume of the sample where a change of volume is 0, in m3.")] = None,
    packing: Annotated[
        Path | None, typer.Option(help="The packing file to simulate with; without, one is prepared when the calibration is first read.", metavar="FILE")
    ] = None,
    void_ratio: Annotated[float | None, typer.Option(min=0, help="Void ratio of the packing that is prepared.")] = None,
    relative_density: Annotated[
        float | None, typer.Option(help="Relative density, instead of a void ratio: 0 for the loosest, 1 for the densest packing of the grading's spheres.")
    ] = None,
    grading: Annotated[
        str | None,
        typer.Option(
            help="Grading of the packing that is prepared: toyoura, d50=0.14,Cu=1.5 (in mm), or a CSV file with the columns 'size \\[mm],passing \\[%]'."
        ),
    ] = None,
    particles: Annotated[int | None, typer.Option(min=2, help="Number of spheres in the packing that is prepared; 1000 by default.")] = None,
    model: Annotated[
        OwnSimulator | None,
        typer.Option(help="What runs the test, where graincal's engine does not: a function of Python, a program, YADE with your script, or you by hand."),
    ] = None,
    output: Annotated[Path, typer.Option("--output", "-o", help="The calibration file to write; nothing is overwritten.", metavar="FILE")] = Path(
        "calibration.toml"
    ),
) -> None:
    """Look at a laboratory file, show what it proves, and write a calibration file to edit.

    What the file does not prove is a question: a key that says "?" until it is answered, in the file or by an option. In a terminal it is asked.
    """
    from graincal import Packing
    from graincal.campaign.file.own_simulator import asked_without_the_engine
    from graincal.campaign.file.propose import propose, propose_unknown
    from graincal.cli.outputs import check_file
    from graincal.cli.preparing import asked_preparation, check_alone, out_of_reach
    from graincal.laboratory import NotUnderstood, describe
    from graincal.laboratory.table import read_table

    given: dict[str, Any] = dict(
        kind=kind,
        strain=strain,
        confining_pressure=confining_pressure,
        void_ratio=void_ratio,
        column=column,
        stress_unit=stress_unit,
        compression=compression,
        stage=stage,
        rows=rows,
        sheet=sheet,
        encoding=encoding,
        sample_height=sample_height,
        sample_volume=sample_volume,
    )
    _look_at_pressure(given)
    check_alone(packing, void_ratio, relative_density, grading, particles)
    _check_no_packing(model, {"--packing": packing, "--relative-density": relative_density, "--grading": grading, "--particles": particles})
    _known(**given)
    grains = Packing.read(packing) if packing else None
    check_file(output)
    preparation = asked_preparation(relative_density, grading, particles)

    def look(given: dict[str, Any]) -> Understanding:
        found = _look(file, given, model is not None or grains is not None or preparation.void_ratio is not None)
        return asked_without_the_engine(found) if model else found

    try:
        found = Asking(context, look, _look_at_pressure, given).understood() if in_a_terminal() else look(given)
    except NotUnderstood as refusal:
        table = read_table(file, encoding=encoding, sheet=sheet)
        _write(output, propose_unknown(table, packing=packing, folder=output.parent, preparation=preparation, simulator=model))
        _say_columns(table, refusal)
        say(f'\nWritten to {output}. Answer what says "?", then: graincal check {shlex.quote(str(output))}')
        return
    _write(output, propose(found, packing=packing, folder=output.parent, preparation=preparation, simulator=model))
    say("\n".join(describe(found)))
    if packing and grains:
        say(_compared(packing, grains, found.void_ratio))
    elif preparation.void_ratio is not None:
        say("\n".join(preparation.because))
    elif not model and found.void_ratio is not None and (note := out_of_reach(found.void_ratio, preparation)):
        say(note)
    many = len(found.questions) > 1
    asked = f'Answer the {len(found.questions)} question{"s" * many} where it says "?"' if found.questions else "Read the lines that say CHECK"
    if model:
        asked = 'Answer what says "?", of your simulator too'
    say(f"\nWritten to {output}. {asked}, then: graincal check {shlex.quote(str(output))}")


def _check_no_packing(model: OwnSimulator | None, options: dict[str, Any]) -> None:
    """Raise InputError for options of graincal's packings beside a simulator that has its own."""
    if model and (given := [option for option, value in options.items() if value is not None]):
        raise InputError(f"--model {model.value} has grains of its own, so {given[0]} cannot stand beside it.")


def _say_columns(table: Table, refusal: NotUnderstood) -> None:
    """Why a file is not understood, and the columns that it has."""
    from graincal.laboratory.describe import describe_table, list_columns

    say(
        "\n".join(
            [*describe_table(table), str(refusal), "Its columns, by number and name, with their first values:", *(f"  {line}" for line in list_columns(table))]
        )
    )


def _look(file: Path, given: dict[str, Any], has_void_ratio: bool) -> Understanding:
    """What is understood of the file by values of options, with a question for the void ratio where nothing says it. has_void_ratio: whether the packing does."""
    from graincal.laboratory import understand

    found = understand(file, _known(**given))
    return found if has_void_ratio or found.void_ratio is not None else asked_for_void_ratio(found)


def _look_at_pressure(given: dict[str, Any]) -> None:
    """Say where a pressure in Pa, if one is given, is unusual. Raises InputError for one that cannot be."""
    from graincal.models.plausibility import impossible_pressure, unusual_pressure

    if (confining_pressure := given.get("confining_pressure")) is None:
        return
    if doubt := impossible_pressure("--confining-pressure", confining_pressure):
        raise InputError(doubt)
    if doubt := unusual_pressure("--confining-pressure", confining_pressure):
        say(f"Note: {doubt}")


def asked_for_void_ratio(found: Understanding) -> Understanding:
    """What was understood, with the question for a void ratio that neither the file nor a person says."""
    from dataclasses import replace

    from graincal.laboratory import Question

    question = Question(
        "void_ratio", "The file does not say the void ratio before shearing: what is it?", (), "", "--void-ratio, --relative-density, or --packing FILE"
    )
    return replace(found, questions=(*found.questions, question))


def _compared(packing: Path, grains: Packing, void_ratio: float | None) -> str:
    measured = f"; the file says {void_ratio:g} for the sample before shearing" if void_ratio else ""
    return f"{packing}: {grains.count} particles at a void ratio of {grains.void_ratio:.3f}{measured}."


def _write(output: Path, text: str) -> None:
    try:
        output.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError(unwritable(output, error)) from None


def _known(
    *,
    kind: str | None,
    strain: str | None,
    confining_pressure: float | None,
    void_ratio: float | None,
    column: list[str] | None,
    stress_unit: str | None,
    compression: list[str] | None,
    stage: str | None,
    rows: str | None,
    sheet: str | None,
    encoding: str | None,
    sample_height: float | None,
    sample_volume: float | None,
) -> Known:
    """What the options say of the file."""
    from graincal.laboratory import Known
    from graincal.laboratory.units import find_unit, known_units

    if stress_unit is not None and ((unit := find_unit(stress_unit)) is None or unit.dimension != "pressure"):
        raise InputError(f"--stress-unit is {stress_unit!r}, and one of {known_units('pressure')} was expected.")
    return Known(
        kind=kind and Kind(kind).value,
        strain=strain and Strain(strain).value,
        confining_pressure=confining_pressure,
        void_ratio=void_ratio,
        columns=named_columns(column),
        stress_unit=stress_unit,
        compression=signs(compression),
        stage=stage,
        rows=first_and_last(rows),
        sheet=sheet,
        encoding=encoding,
        sample_height=sample_height,
        sample_volume=sample_volume,
    )
