"""The command line."""

import typer

from graincal import __version__, _native

app = typer.Typer(name="graincal", no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"graincal {__version__} (commit {_native.commit}, {_native.compiler}, {_native.instruction_set})")
        raise typer.Exit()


@app.callback()
def _root(
    version: bool = typer.Option(False, "--version", callback=_print_version, is_eager=True, help="Print version, commit, compiler and instruction set."),
) -> None:
    """Calibrate DEM contact parameters against laboratory tests."""


def main() -> None:
    app()
