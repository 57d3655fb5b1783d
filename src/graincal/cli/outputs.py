"""Where a command may write: looked at before anything is computed, so that no run is lost to a path that it cannot be written to."""

from __future__ import annotations

from pathlib import Path

from graincal.data import InputError
from graincal.files import unwritable
from graincal.suggestion import did_you_mean

FIGURES = (".png", ".pdf", ".svg")
"""The suffixes of figures."""


def check_file(path: Path, option: str = "-o") -> None:
    """Raise InputError for a file that holds something already, and for a place that cannot be written to. What is there is left as it is."""
    try:
        path.open("xb").close()
    except FileExistsError:
        _check_what_is_there(path, option)
    except OSError as error:
        raise InputError(unwritable(path, error)) from None
    else:
        path.unlink()


def _check_what_is_there(path: Path, option: str) -> None:
    if path.is_dir():
        raise InputError(unwritable(path, IsADirectoryError()))
    if not path.exists():
        raise InputError(f"{path}: this is a link to nowhere, and the name of a file to write was expected.")
    # A pipe or a device takes what it is given, and a file that is empty has nothing to lose: a shell may have made it for /dev/stdout.
    if path.is_file() and path.stat().st_size > 0:
        raise InputError(f"{path}: this file is there already and is not overwritten; delete it, or name another by {option}.")


def check_table(path: Path) -> None:
    """As check_file, for a table in CSV: a figure's name is not meant."""
    if path.suffix.lower() in FIGURES:
        raise InputError(f"{path}: this is to be a table in CSV, and a name such as {path.with_suffix('.csv')} was expected; a figure is drawn by --plot.")
    check_file(path)


def check_figure(path: Path) -> None:
    """As check_file, for a figure: its suffix must be one that Matplotlib writes."""
    from matplotlib.figure import Figure

    known = Figure().canvas.get_supported_filetypes()
    if path.suffix.lower().removeprefix(".") not in known:
        meant = did_you_mean(path.suffix, FIGURES) if path.suffix else ""
        raise InputError(
            f"{path}: the suffix says what a figure is written as, and {', '.join(FIGURES)} or another that Matplotlib writes was expected{meant}."
        )
    check_file(path, "--plot")


def check_folder(path: Path) -> None:
    """Raise InputError for a folder that cannot be written to, or made."""
    there = next(folder for folder in (path.absolute(), *path.absolute().parents) if folder.exists())
    if not there.is_dir():
        raise InputError(f"{there}: this is a file, and a folder to write to was expected.")
    trial = there / ".graincal.trial"
    try:
        trial.open("xb").close()
        trial.unlink()
    except OSError as error:
        raise InputError(unwritable(path, error)) from None


def check_outputs(table: Path | None, figure: Path | None) -> None:
    """As check_file, for the table and the figure of one command, either of which may not be asked for."""
    if table and figure and table.absolute() == figure.absolute():
        raise InputError(f"{table}: two outputs have this name, and one for each was expected.")
    if table:
        check_table(table)
    if figure:
        check_figure(figure)
