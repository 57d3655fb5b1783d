"""Writing a report, and its figures."""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from graincal.campaign import FolderError
from graincal.campaign.found.record import Record
from graincal.drawing import with_matplotlib
from graincal.report.contents import compose, figures
from graincal.report.prediction import predict_response

PREDICTED = 2.0
"""The confining pressure of the prediction, as a multiple of the calibration's."""


def write_report(result: Record, path: str | Path, *, predict: float | None = PREDICTED) -> Path:
    """Write what was found as one HTML file, readable without a network, and return its path. A file that is there is replaced once all is written.

    predict: simulate the triaxial experiment of the highest confining pressure at so many times that pressure, as `predict_response` says: some draws from the posterior, or the answer
    once; it takes half a minute, or as long as one evaluation, and is left out where that took longer than two minutes. None leaves it out in any case.
    Raises FolderError where the file cannot be written.
    """
    path = Path(path)
    text = compose(result, predict_response(result, predict)).render()
    unfinished = path.with_name(f".{path.name}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        unfinished.write_text(text, encoding="utf-8", errors="backslashreplace")
        os.replace(unfinished, path)
    except OSError as error:
        # Where nothing can be written, nothing can be removed.
        with suppress(OSError):
            unfinished.unlink(missing_ok=True)
        raise FolderError.of(path, error) from error
    return path


def write_figures(result: Record, folder: str | Path, formats: Sequence[str] = ("png", "pdf"), *, predict: float | None = PREDICTED) -> list[Path]:
    """Write the report's figures by Matplotlib, to print, and return the files' paths: `responses.png`, `responses.pdf`, ...

    formats: those that Matplotlib writes. predict: as in `write_report`.
    Raises InputError for another format, FolderError where a file cannot be written.
    """
    with_matplotlib.check_formats(formats)
    folder = Path(folder)
    paths = []
    for figure in figures(result, predict_response(result, predict)):
        for suffix in formats:
            path = folder / f"{figure.name}.{suffix}"
            try:
                folder.mkdir(parents=True, exist_ok=True)
                with_matplotlib.save(figure, path)
            except OSError as error:
                raise FolderError.of(path, error) from error
            paths.append(path)
    return paths
