"""Options that several commands have."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Literal

import typer

from graincal.data import InputError
from graincal.notation.printable import printable

Folder = Annotated[Path, typer.Argument(help="The campaign's folder.", metavar="DIR")]
_WORKERS = typer.Option(help='Evaluations at once, a number or "all"; the result does not depend on it.', metavar="N")
Workers = Annotated[str | None, _WORKERS]
SomeWorkers = Annotated[str, _WORKERS]
"""The same where there is a default."""
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")]


def parse_workers(text: str) -> int | Literal["all"]:
    """What --workers means."""
    if text == "all":
        return "all"
    if re.fullmatch("[0-9]{1,18}", text) and int(text) > 0:
        return int(text)
    raise InputError(f'--workers must be a whole number above 0 or "all", not {printable(text, 60)}.')


def parse_criterion(name: str, text: str) -> float | bool:
    """What the option of a criterion of stopping means; whether the number can be one is for the criterion to say."""
    if text == "false":
        return False
    try:
        return int(text) if name.startswith("max_") else float(text)
    except ValueError:
        kind = "a whole number" if name.startswith("max_") else "a number"
        raise InputError(f"--{name.replace('_', '-')} must be {kind} or false, not {text}.") from None
