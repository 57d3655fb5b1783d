"""Options that say how a laboratory file is read: which of its rows and columns, and what these mean."""

from __future__ import annotations

import re
from collections.abc import Sequence
from enum import Enum
from pathlib import Path
from typing import Annotated, Any, TypeVar

import typer

from graincal.data import InputError

Said = TypeVar("Said")


class Strain(str, Enum):
    """The measures of strain that laboratories and simulations print."""

    engineering = "engineering"
    logarithmic = "logarithmic"


Column = Annotated[
    list[str] | None,
    typer.Option(
        help="A column, by number, letter or name, and its unit, such as axial_strain=2:% or deviator_stress=q:kPa. May be given several times.",
        metavar="QUANTITY=COLUMN[:UNIT]",
    ),
]
Measure = Annotated[Strain | None, typer.Option(help="The measure of its strains, engineering or logarithmic.", metavar="MEASURE")]
Compression = Annotated[
    list[str] | None,
    typer.Option(
        help="The sign of compression in a column, positive or negative, such as axial_strain=negative. May be given several times.", metavar="QUANTITY=SIGN"
    ),
]
Stage = Annotated[str | None, typer.Option(help="The stage of a machine's file that is the shear, by its number or word.", metavar="NAME")]
Rows = Annotated[str | None, typer.Option(help="The first and the last line of the file to be read, such as 38-53.", metavar="FIRST-LAST")]
Sheet = Annotated[str | None, typer.Option(help="The sheet of a spreadsheet, or the group of AGS4 data.", metavar="NAME")]


def said_of_file(
    beside: str,
    file: Path | None,
    column: Sequence[str] | None,
    strain: Strain | None,
    compression: Sequence[str] | None,
    stage: str | None,
    rows: str | None,
    sheet: str | None,
) -> dict[str, Any]:
    """What options say of a file, that of the option `beside`, as options of `read_test`; only those that are given.

    Raises InputError where they say something of no file, or of a calibration file, which says all this itself.
    """
    given = {"column": column, "strain": strain, "compression": compression, "stage": stage, "rows": rows, "sheet": sheet}
    option = next((name for name, value in given.items() if value), None)
    if option and file is None:
        raise InputError(f"--{option} says how the file of {beside} is read, and that is missing.")
    if option and file and file.suffix == ".toml":
        raise InputError(f"{file}: a calibration file says itself how its laboratory files are read, so --{option} cannot stand beside it.")
    named = named_columns(column)
    said = {
        "columns": {quantity: place for quantity, (place, _) in named.items()},
        "units": {quantity: unit for quantity, (_, unit) in named.items() if unit is not None},
        "strain": strain and strain.value,
        "compression": signs(compression),
        "stage": stage,
        "rows": first_and_last(rows),
        "sheet": sheet,
    }
    return {key: value for key, value in said.items() if value}


def named_columns(column: Sequence[str] | None) -> dict[str, tuple[str | int, str | None]]:
    """The columns and units of --column, by quantity. Raises InputError for a quantity that is named twice."""
    return _each_once("--column", [_named_column(each) for each in column or ()])


def _named_column(text: str) -> tuple[str, tuple[str | int, str | None]]:
    """A quantity with its column and unit: `axial_strain=2:%`. A unit stands behind the last colon, if one that is known does."""
    from graincal.laboratory.units import find_unit

    quantity, equals, place = text.partition("=")
    quantity, place = quantity.strip(), place.strip()
    if not equals or not quantity or not place:
        raise InputError(f"--column must be a quantity and its column, such as axial_strain=2:%, not {text!r}.")
    before, colon, behind = place.rpartition(":")
    if colon and before and (find_unit(behind) is not None and behind.strip() or before.strip().isdecimal()):
        return quantity, (_place(before), behind.strip())
    return quantity, (_place(place), None)


def first_and_last(rows: str | None) -> tuple[int, int] | None:
    """The two lines of --rows: `38-53`."""
    if rows is None:
        return None
    if not (parts := re.fullmatch(r"(\d+)\s*[-,:]\s*(\d+)", rows.strip())):
        raise InputError(f"--rows must be the first and the last line to be read, such as 38-53, not {rows!r}.")
    return int(parts[1]), int(parts[2])


def signs(compression: Sequence[str] | None) -> dict[str, str]:
    """The sign of compression by quantity: `volumetric_strain=negative`."""
    return _each_once("--compression", [_sign(each) for each in compression or ()])


def _each_once(option: str, said: Sequence[tuple[str, Said]]) -> dict[str, Said]:
    quantities = [quantity for quantity, _ in said]
    if twice := next((quantity for quantity in quantities if quantities.count(quantity) > 1), None):
        raise InputError(f"{option} names {twice} twice, and each quantity once was expected.")
    return dict(said)


def _place(text: str) -> str | int:
    return int(text) if text.strip().isdecimal() else text.strip()


def _sign(text: str) -> tuple[str, str]:
    quantity, _, sign = (part.strip() for part in text.partition("="))
    if sign not in ("positive", "negative"):
        raise InputError(f"--compression must be a quantity and its sign, such as volumetric_strain=negative, not {text!r}.")
    return quantity, sign
