"""Small curves and time spans in a line of text."""

from __future__ import annotations

import re
from collections.abc import Sequence
from textwrap import fill

import numpy as np
from numpy.typing import NDArray

_BLOCKS = "▁▂▃▄▅▆▇█"


def sparkline(values: Sequence[float], low: float | None = None, high: float | None = None) -> str:
    """The values as a row of bars between `low` and `high` (their smallest and their largest by default); a gap where there is none."""
    finite = [value for value in values if np.isfinite(value)]
    if not finite:
        return " " * len(values)
    low = min(finite) if low is None else low
    height = (max(finite) if high is None else high) - low
    shares = [(value - low) / height if height > 0 else 0.5 for value in values]
    return "".join(_BLOCKS[round(share * (len(_BLOCKS) - 1))] if np.isfinite(share) else " " for share in shares)


def resample(control: NDArray[np.float64], values: NDArray[np.float64], width: int = 40) -> list[float]:
    """The values at `width` evenly spaced controls."""
    return np.interp(np.linspace(control[0], control[-1], width), control, values).tolist()


def duration(seconds: float) -> str:
    """A time span to read, in sentences with "about" too."""
    if seconds <= 0:
        return "0 s"
    if seconds < 1:
        return f"{max(seconds, 0.01):.1g} s"
    if seconds < 60:
        return f"{seconds:.0f} s"
    if seconds < 5400:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h"


_COMMAND = re.compile(r"(?<=:) (?P<command>graincal \S.*)$")
"""At the end of a line."""


def between_words(text: str, width: int) -> str:
    """Lines of prose broken between words to be at most so wide, with what follows a break indented. Commands of graincal to copy stay whole: those on lines of their own, and those at the end of a line, which get one."""
    return "\n".join(_between_words(line, width) for line in text.split("\n"))


def _between_words(line: str, width: int) -> str:
    start = line.lstrip(" ")
    if len(line) <= width or start.startswith("graincal "):
        return line
    if command := _COMMAND.search(line):
        return f"{_between_words(line[: command.start()], width)}\n{' ' * (len(line) - len(start) + 2)}{command['command']}"
    return fill(line, width, subsequent_indent=" " * (len(line) - len(start) + 2), break_long_words=False, break_on_hyphens=False)
