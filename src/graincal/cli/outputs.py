"""Where a command may write: looked at before anything is computed, so that no run is lost to a path that it cannot be written to."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from graincal.data import InputError
from graincal.files import unwritable
from graincal.suggestion import did_you_mean

FIGURES = (".png", ".pdf", ".svg")
"""The suffixes of figures."""


def check_file(path: Path, inputs: Iterable[Path] = ()) -> bool:
    """Whether a file is there already that would be replaced. Raises InputError for one of the inputs, and for a place that cannot be written to."""
    for read in inputs:
        if path.exists() and read.exists() and path.samefile(read):
            raise InputError(f"{path}: this is one of the files that are read, and is not overwritten; name another.")
    there = path.exists()
    # A pipe or a device takes what it is given; opening it twice would end it.
    if not there or path.is_file() or path.is_dir():
        try:
            path.open("ab").close()
        except OSError as error:
            raise InputError(unwritable(path, error)) from None
        if not there:
            path.unlink()
    return there


def check_table(path: Path, inputs: Iterable[Path] = ()) -> bool:
    """As check_file, for a table in CSV: a figure's name is not meant."""
    if path.suffix.lower() in FIGURES:
        raise InputError(f"{path}: this is to be a table in CSV, and a name such as {path.with_suffix('.csv')} was expected; a figure is drawn by --plot.")
    return check_file(path, inputs)


def check_figure(path: Path, inputs: Iterable[Path] = ()) -> bool:
    """As check_file, for a figure: its suffix must be one that Matplotlib writes."""
    from matplotlib.figure import Figure

    known = Figure().canvas.get_supported_filetypes()
    if path.suffix.lower().removeprefix(".") not in known:
        meant = did_you_mean(path.suffix, FIGURES) if path.suffix else ""
        raise InputError(f"{path}: the suffix says what a figure is written as, and {', '.join(FIGURES)} or another that Matplotlib writes was expected{meant}.")
    return check_file(path, inputs)


def check_folder(path: Path) -> None:
    """Raise InputError for a folder that cannot be written to, or made."""
    there = next(folder for folder in (path.absolute(), *path.absolute().parents) if folder.exists())
    if not there.is_dir():
        raise InputError(f"{there}: this is a file, and a folder to write to was expected.")
    check_file(there / f".{path.name}.trial")


def refuse_the_same(*paths: Path | None) -> None:
    """Raise InputError where two outputs are one file."""
    given = [path.absolute() for path in paths if path is not None]
    if len(set(given)) < len(given):
        raise InputError(f"{given[0]}: two outputs have this name, and one for each was expected.")
