"""What a command says on the terminal: nothing of it moves a cursor but what graincal itself draws."""

from __future__ import annotations

import typer

from graincal.notation.printable import printable


def say(text: object, *, err: bool = False, nl: bool = True) -> None:
    """Print a text, lines and all."""
    typer.echo(printable(text, None, lines=True), err=err, nl=nl)
