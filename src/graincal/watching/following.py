"""Reads a campaign again whenever it has changed, for those who follow it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from graincal.campaign.found.status import status
from graincal.campaign.stored.database import NAME
from graincal.campaign.stored.log import is_running
from graincal.campaign.stored.store import LOOK, Store, holds_campaign
from graincal.data import InputError
from graincal.watching.board import Board
from graincal.watching.evaluations import evaluations
from graincal.watching.figures import figures

PERIOD = 1.0
"""Seconds between two looks whether something changed."""


def follow(folder: Path, board: Board) -> None:
    """Begin to put on the board what is to be seen of a campaign, until the board ends. Figures take longer than the rest, which does not wait for them."""

    shown: list[Path] = []

    def state() -> None:
        board.put("status", status(folder))
        runs = under_way(folder)
        board.put("evaluations", evaluations(Store.open(runs)) | {"look": runs != folder})

    def drawn() -> None:
        runs = under_way(folder)
        if shown != [runs]:
            board.forget("figure")
            shown[:] = [runs]
        for figure in figures(runs):
            board.put(f"figure {figure['name']}", figure | {"look": runs != folder})

    for read in (state, drawn):
        threading.Thread(target=_repeat, args=(read, folder, board), daemon=True).start()


def under_way(folder: Path) -> Path:
    """The folder whose runs are to be seen: that of the first look, until the campaign itself has samples."""
    look = folder / LOOK
    return look if holds_campaign(look) and Store.open(folder).last_iteration() is None else folder


def _repeat(read: Callable[[], None], folder: Path, board: Board) -> None:
    seen: Any = None
    while not board.ended:
        board.wait_for_streams()
        if (now := _fingerprint(folder)) != seen:
            seen = now
            _attempt(read, board)
        time.sleep(PERIOD)


def _attempt(read: Callable[[], None], board: Board) -> None:
    try:
        read()
        trouble = ""
    except InputError as error:
        trouble = str(error)
    # What is read changes meanwhile. The page says what is wrong, and the next change brings another attempt.
    except Exception as error:
        trouble = f"This cannot be shown ({type(error).__name__}: {error})."
    board.put(f"trouble {read.__name__}", {"of": read.__name__, "text": trouble})


def _fingerprint(folder: Path) -> tuple[Any, ...]:
    """Another one whenever something was stored, or the process that runs the campaign came or went."""
    found: list[Any] = [is_running(folder)]
    for path in (folder / NAME, folder / LOOK / NAME):
        try:
            stat = path.stat()
            found.append((stat.st_mtime_ns, stat.st_size))
        except OSError:
            found.append(None)
    return tuple(found)
