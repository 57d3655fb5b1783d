"""graincal --version."""

from __future__ import annotations

import typer


def print_version(wanted: bool) -> None:
    """Print version, commit, compiler and instruction set, if wanted, and exit."""
    if wanted:
        from graincal import __version__, _native

        typer.echo(f"graincal {__version__} (commit {_native.commit}, {_native.compiler}, {_native.instruction_set})")
        raise typer.Exit()
