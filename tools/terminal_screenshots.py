"""Pictures of a terminal in which a command of graincal runs: while it runs, and at its end.

The command runs in a pseudo terminal of 100 columns, whose screens are kept as they change (pyte), and two of them are drawn by a headless Chromium.

    pip install pyte
    python tools/terminal_screenshots.py docs/images/calibrate graincal calibrate calibration.toml -o campaign

writes docs/images/calibrate_running.png, two thirds through the screens that say how many evaluations are done, and docs/images/calibrate_end.png.
"""

import html
import os
import pty
import select
import shlex
import sys
import time
from pathlib import Path

import pyte
from browser_pictures import take_page

COLUMNS, LINES = 100, 60
LINE_HEIGHT, CHARACTER_WIDTH = 20, 8.43
"""Pixels, of a monospaced font of 14 pixels."""

UNDER_WAY = " runs, "
"""A screen while it runs has this in it: how many runs of the round are done."""

_COLOURS = {
    "default": "#d4d4d4",
    "black": "#3b3b3b",
    "red": "#f48771",
    "green": "#89d185",
    "brown": "#e5c07b",
    "blue": "#6cb6ff",
    "magenta": "#d7a1f9",
    "cyan": "#4ec9b0",
    "white": "#ffffff",
}
_STYLE = f"margin: 0; padding: 14px 16px; background: #1e1e1e; color: {_COLOURS['default']}; font: 14px/{LINE_HEIGHT}px 'DejaVu Sans Mono', monospace"


def record(command: list[str]) -> list[list[str]]:
    """Run a command, and give its screens in the order of their changes, each as lines of HTML without the empty ones at the end."""
    screen = pyte.Screen(COLUMNS, LINES)
    stream = pyte.ByteStream(screen)
    stream.feed(b"$ " + shlex.join(command).encode() + b"\r\n")
    child, terminal = pty.fork()
    if child == 0:
        os.environ.update(TERM="xterm-256color", COLUMNS=str(COLUMNS), LINES=str(LINES))
        os.execvp(command[0], command)
    screens: list[list[str]] = []
    drawn = time.monotonic()
    while (data := _read(terminal)) is not None:
        stream.feed(data)
        # A live table is drawn line by line: a screen is whole once nothing comes for a moment.
        if (not data or time.monotonic() - drawn > 2) and (now := _lines(screen)) != (screens or [[]])[-1]:
            screens.append(now)
            drawn = time.monotonic()
    os.waitpid(child, 0)
    return [*screens, _lines(screen)]


def _read(terminal: int) -> bytes | None:
    """What the command wrote within a moment; None when it has ended."""
    if not select.select([terminal], [], [], 0.05)[0]:
        return b""
    try:
        return os.read(terminal, 65536) or None
    except OSError:
        return None


def _lines(screen: pyte.Screen) -> list[str]:
    lines = ["".join(_characters(screen, row)).rstrip() for row in range(screen.lines)]
    while lines and not lines[-1]:
        lines.pop()
    return lines


def _characters(screen: pyte.Screen, row: int):
    for column in range(screen.columns):
        cell = screen.buffer[row][column]
        text = html.escape(cell.data)
        colour = _COLOURS.get(cell.fg, f"#{cell.fg}")
        style = (f"color: {colour};" if cell.fg != "default" else "") + ("font-weight: bold;" if cell.bold else "")
        yield f'<span style="{style}">{text}</span>' if style and text.strip() else text


def draw(lines: list[str], path: Path) -> None:
    """Write a screen as a picture."""
    size = round(COLUMNS * CHARACTER_WIDTH) + 32, len(lines) * LINE_HEIGHT + 28
    take_page(
        f'<!doctype html><meta charset="utf-8"><body style="margin: 0"><pre style="{_STYLE}; min-height: 100vh">' + "\n".join(lines) + "</pre>", size, path
    )


def main(name: Path, command: list[str]) -> None:
    """Write the two pictures."""
    screens = record(command)
    under_way = [each for each in screens if any(UNDER_WAY in line for line in each)]
    if not under_way:
        sys.exit(f"no screen said {UNDER_WAY!r} while the command ran. It ended with:\n" + html.unescape("\n".join(screens[-1])))
    draw(under_way[len(under_way) * 2 // 3], name.with_name(f"{name.name}_running.png"))
    draw(screens[-1], name.with_name(f"{name.name}_end.png"))


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(Path(sys.argv[1]), sys.argv[2:])
