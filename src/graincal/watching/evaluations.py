"""The evaluations of a campaign as a table, and what one of them printed."""

from __future__ import annotations

import os
import re
import stat
from typing import Any

from graincal.campaign.asked.file_names import file_name
from graincal.campaign.run.evaluations import FILES
from graincal.campaign.stored.evaluated import STOPPED
from graincal.campaign.stored.store import Store
from graincal.models.command.folders import PRINTED
from graincal.models.command.work import COLOURS, PRINTED_OUTPUT
from graincal.notation.printable import printable

MOST_ROWS = 500
"""Evaluations that a page shows, those that ended last before those that wait."""

MOST_PRINTED = 64 * 1024
"""Bytes of what an evaluation printed, the last."""


def evaluations(store: Store) -> dict[str, Any]:
    """{total, rows: [{sample, experiment, name, state, ended, seconds, attempts, error: kind and reason of a failure, printed: whether something is kept}]}; ended is ISO 8601."""
    query = f"""
        SELECT sample, experiment, state, {STOPPED}, ended, seconds, attempts, kind, reason FROM evaluation
        ORDER BY ended IS NULL, ended DESC, sample, experiment LIMIT {MOST_ROWS}"""
    names = [experiment.name for experiment in store.calibration.experiments]
    rows = [
        {
            "sample": sample,
            "experiment": experiment,
            "name": names[experiment] if experiment < len(names) else str(experiment),
            "state": "stopped early" if state == "finished" and stopped else state,
            "ended": ended,
            "seconds": seconds,
            "attempts": attempts,
            "error": printable(f"{kind}: {reason}") if state == "failed" else "",
            "printed": store.folder is not None and store.folder.joinpath(*_way_to(store, sample, experiment)).is_dir(),
        }
        for sample, experiment, state, stopped, ended, seconds, attempts, kind, reason in store.database.rows(query)
    ]
    return {"total": store.database.rows("SELECT count(*) FROM evaluation")[0][0], "rows": rows}


def printed(store: Store, sample: int, experiment: int) -> str | None:
    """The last that the last attempt at an evaluation printed, made printable; None where nothing is kept of it."""
    if store.folder is None or not 0 <= experiment < len(store.calibration.experiments):
        return None
    try:
        folder = os.open(store.folder, os.O_RDONLY | os.O_DIRECTORY)
        for part in _way_to(store, sample, experiment):
            folder = _open_in(folder, part, os.O_DIRECTORY)
        attempts = [name for name in os.listdir(folder) if re.fullmatch("attempt-[0-9]{1,9}", name)]
        if not attempts:
            os.close(folder)
            return None
        folder = _open_in(folder, max(attempts, key=lambda name: int(name.removeprefix("attempt-"))), os.O_DIRECTORY)
    except OSError:
        return None
    try:
        found = [text for name in (PRINTED, PRINTED_OUTPUT) if (text := _tail(folder, name)) is not None]
    finally:
        os.close(folder)
    return "\n".join(text for text in found if text) if found else None


def _way_to(store: Store, sample: int, experiment: int) -> tuple[str, ...]:
    """The folders that lead from the campaign's to an evaluation's."""
    several, name = len(store.calibration.experiments) > 1, store.calibration.experiments[experiment].name
    return (FILES, *([file_name(name)] if several else []), f"{sample:05}")


def _open_in(folder: int, name: str, flags: int) -> int:
    """Open what lies in an open folder, which is closed. No link is followed: a program may have put one there that leads to somebody's secrets."""
    try:
        return os.open(name, os.O_RDONLY | os.O_NOFOLLOW | os.O_CLOEXEC | flags, dir_fd=folder)
    finally:
        os.close(folder)


def _tail(folder: int, name: str) -> str | None:
    """The end of a file in an open folder; None where it is no plain file."""
    try:
        # A pipe would wait for its writer.
        file = _open_in(os.dup(folder), name, os.O_NONBLOCK)
    except OSError:
        return None
    try:
        about = os.fstat(file)
        if not stat.S_ISREG(about.st_mode):
            return None
        data = os.pread(file, MOST_PRINTED, max(0, about.st_size - MOST_PRINTED))
    except OSError:
        return None
    finally:
        os.close(file)
    text = COLOURS.sub("", data.decode("utf-8", errors="replace")).expandtabs(8)
    return printable(text, None, lines=True)
