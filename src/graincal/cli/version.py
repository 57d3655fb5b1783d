"""graincal --version."""

from __future__ import annotations

import typer

from graincal.cli.saying import say


def print_version(wanted: bool) -> None:
    """Print version, commit, compiler and instruction set, if wanted, and exit."""
    if wanted:
        from graincal.build import describe

        number, commit, compiler, instruction_set = describe().values()
        say(f"graincal {number} (commit {commit}, {compiler}, {instruction_set})")
        raise typer.Exit()
