"""graincal status --watch: how far a campaign is, in a terminal, as it goes."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rich.console import Group, RenderableType
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.text import Text

from graincal.campaign.found.status import status
from graincal.cli.saying import say
from graincal.notation.console import PrintableConsole
from graincal.notation.printable import printable

PERIOD = 1.0
"""Seconds between two looks."""

_COLOURS = {"running": "cyan", "finished": "green", "interrupted": "yellow", "waiting": "yellow"}


def watch_status(folder: Path, lines: Callable[[dict[str, Any]], list[str]]) -> None:
    """Draw the lines of a status again each second until no process runs the campaign; where there is no terminal, print them when they change. Ctrl-C ends it, and not the campaign."""
    console = PrintableConsole(highlight=False)
    try:
        if console.is_terminal:
            _draw(console, folder, lines)
        else:
            _print(folder, lines)
    except KeyboardInterrupt:
        say("No longer watching; the campaign goes on.", err=True)


def _draw(console: PrintableConsole, folder: Path, lines: Callable[[dict[str, Any]], list[str]]) -> None:
    # What was drawn stays when it ends; while it goes on, what does not fit on the screen is cut.
    with Live(console=console, auto_refresh=False) as live:
        while True:
            found = status(folder)
            live.update(_picture(found, lines(found)), refresh=True)
            if found["state"] != "running":
                return
            time.sleep(PERIOD)


def _print(folder: Path, lines: Callable[[dict[str, Any]], list[str]]) -> None:
    said = ""
    while True:
        found = status(folder)
        if (text := "\n".join(lines(found))) != said:
            say(text)
            said = text
        if found["state"] != "running":
            return
        time.sleep(PERIOD)


def _picture(found: dict[str, Any], lines: list[str]) -> Group:
    first, *others = (printable(line, None) for line in lines)
    parts: list[RenderableType] = [Text(first, style=f"bold {_COLOURS[found['state']]}"), *map(Text, others)]
    look = found["first_look"]
    now = look["iteration"] if look and look["state"] != "finished" else found["iteration"]
    if now and found["state"] == "running":
        parts.insert(2, ProgressBar(total=now["samples"], completed=now["evaluated"], width=60))
    return Group(*parts)
