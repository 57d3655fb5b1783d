"""What a command says on the terminal: nothing of it moves a cursor but what graincal itself draws."""

from __future__ import annotations

import shutil
import sys

import typer

from graincal.notation.printable import printable
from graincal.notation.text import between_words


def say(text: object, *, prose: bool = True, err: bool = False, nl: bool = True) -> None:
    """Print a text, lines and all; those of prose are broken between words in a terminal."""
    said = printable(text, None, lines=True)
    stream = sys.stderr if err else sys.stdout
    typer.echo(between_words(said, shutil.get_terminal_size().columns) if prose and stream.isatty() else said, err=err, nl=nl)
