"""What a command says on the terminal: nothing of it moves a cursor but what graincal itself draws."""

from __future__ import annotations

import shutil
import sys

import typer

from graincal.notation.printable import printable
from graincal.notation.text import between_words


def say(text: object, *, err: bool = False, nl: bool = True) -> None:
    """Print a text, lines and all; in a terminal they are broken between words."""
    said = printable(text, None, lines=True)
    stream = sys.stderr if err else sys.stdout
    typer.echo(between_words(said, shutil.get_terminal_size().columns) if stream.isatty() else said, err=err, nl=nl)
