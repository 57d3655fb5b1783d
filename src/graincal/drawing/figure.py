"""What a figure is, apart from any way to draw it: panels with axes and marks. Both renderers draw these records and compute nothing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graincal.drawing.palette import Style

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Axis:
    """An axis: its label in markup, limits and ticks (position, text) where they are not left to the renderer. Text empty: no tick labels."""

    label: str = ""
    limits: tuple[float, float] | None = None
    log: bool = False
    ticks: tuple[tuple[float, str], ...] | None = None


@dataclass(frozen=True, eq=False)
class Line:
    """A line through (x, y). A mark with a name appears in the figure's key."""

    x: Array
    y: Array
    style: Style
    name: str = ""


@dataclass(frozen=True, eq=False)
class Band:
    """The area between low and high over x."""

    x: Array
    low: Array
    high: Array
    style: Style
    name: str = ""


@dataclass(frozen=True, eq=False)
class Points:
    """Points, each of its own colour and size where these are given, with a note to read when pointed at."""

    x: Array
    y: Array
    style: Style
    name: str = ""
    colours: tuple[str, ...] = ()
    sizes: tuple[float, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Bars:
    """A histogram: heights (B,) between edges (B + 1,), standing on `base` (B,) or on zero."""

    edges: Array
    heights: Array
    style: Style
    name: str = ""
    base: Array | None = None


@dataclass(frozen=True)
class Level:
    """A straight line across the panel: at a value of x (upright) or of y."""

    at: float
    style: Style
    name: str = ""
    upright: bool = False


Mark = Line | Band | Points | Bars | Level


@dataclass(frozen=True, eq=False)
class Panel:
    """A pair of axes with marks in the order of drawing; or no axes but a number in a coloured cell."""

    title: str = ""
    x: Axis = Axis()
    y: Axis = Axis()
    marks: tuple[Mark, ...] = ()
    cell: tuple[str, str] | None = None
    """Text and background colour of a panel that is a cell of a table."""


@dataclass(frozen=True, eq=False)
class Figure:
    """Panels that belong together: name (a word, for files), title and caption (sentences in markup), and a key for all of them.

    columns: how many panels stand side by side where there is room.
    square: the panels are a square matrix, row by row.
    """

    name: str
    title: str
    caption: str
    panels: tuple[Panel, ...]
    columns: int = 3
    square: bool = False

    @property
    def key(self) -> tuple[Mark, ...]:
        """The first mark of each name."""
        first: dict[str, Mark] = {}
        for panel in self.panels:
            for mark in panel.marks:
                if mark.name:
                    first.setdefault(mark.name, mark)
        return tuple(first.values())


def counting_axis(label: str, first: float, last: float, margin: float = 0.3) -> Axis:
    """An axis of whole numbers, iterations or batches, from the first to the last, of which nine are labelled at most."""
    every = max(1, int(last - first + 1) // 8)
    return Axis(label, (first - margin, last + margin), ticks=tuple((float(number), f"{number:.0f}") for number in np.arange(first, last + 1, every)))


def log_axis(label: str, values: Array, *, limits: tuple[float, float] | None = None) -> Axis:
    """A logarithmic axis for values that span decades, with ticks that can be read; a linear one otherwise."""
    positive = values[np.isfinite(values) & (values > 0)]
    if limits is None and not positive.size:
        return Axis(label)
    low, high = limits or (positive.min() / 1.2, positive.max() * 1.2)
    if high < 5 * low:
        return Axis(label, limits)
    decades = np.log10(high / low)
    steps = (1, 2, 3, 4, 5, 7) if decades < 1.2 else (1, 2, 5) if decades < 3 else (1,)
    every = max(1, int(decades // 5))
    powers = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1, every)
    ticks = [step * 10.0**power for power in powers for step in steps]
    return Axis(label, (low, high), True, tuple((tick, tick_text(tick)) for tick in ticks if low <= tick <= high))


def tick_text(tick: float) -> str:
    """A round number on a logarithmic axis: `0.5`, `10^{7}`, `2·10^{7}`."""
    if 1e-3 <= tick < 1e5:
        return f"{tick:g}"
    power = int(np.floor(np.log10(tick) + 1e-9))
    step = round(tick / 10.0**power)
    return f"{step}·10^{{{power}}}".removeprefix("1·").replace("-", "−")
