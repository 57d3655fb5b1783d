"""Figures by Matplotlib, to print."""

from __future__ import annotations

import io
import math
from collections.abc import Iterable
from functools import singledispatch
from pathlib import Path
from typing import Any

import matplotlib
import matplotlib.figure
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import NullLocator

from graincal.drawing.figure import Axis, Band, Bars, Figure, Level, Line, Mark, Panel, Points
from graincal.drawing.palette import DASHES, Style
from graincal.errors import InputError
from graincal.notation.glyphs import missing_glyphs_unsaid
from graincal.notation.markup import to_mathtext

_POINTS_PER_PIXEL = 0.6
_SYMBOLS = {"circle": "o", "ring": "o", "cross": "x", "diamond": "D", "square": "s"}
_SETTINGS = {
    "font.size": 8,
    "axes.titlesize": 8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.6,
    "legend.frameon": False,
    # Type 3 fonts, the default, are refused by many journals.
    "pdf.fonttype": 42,
}


def check_formats(formats: Iterable[str]) -> None:
    """Raise InputError for a format that Matplotlib does not write."""
    known = matplotlib.figure.Figure().canvas.get_supported_filetypes()
    for name in formats:
        if name not in known:
            raise InputError(f'formats: "{name}" cannot be written; expected some of {", ".join(known)}.')


def save(figure: Figure, path: Path) -> None:
    """Draw a figure and write it in the format of the path's suffix."""
    with matplotlib.rc_context(_SETTINGS), missing_glyphs_unsaid():
        drawn = draw(figure)
        drawn.savefig(path, dpi=200, bbox_inches="tight")


def to_svg(figure: Figure) -> str:
    """Draw a figure as an SVG element, to stand in a page."""
    written = io.StringIO()
    with matplotlib.rc_context(_SETTINGS), missing_glyphs_unsaid():
        draw(figure).savefig(written, format="svg", bbox_inches="tight", metadata={"Date": None})
    text = written.getvalue()
    # Without what stands above it in a file.
    return text[text.index("<svg") :]


def show(figure: Figure) -> np.ndarray:
    """Draw a figure as one of pyplot's, which a notebook or `pyplot.show` then shows, and return its axes: (rows, columns), in the order of the panels."""
    from matplotlib import pyplot

    with matplotlib.rc_context(_SETTINGS):
        drawn = draw(figure, pyplot.figure(layout="constrained"))
    columns = min(figure.columns, len(figure.panels))
    return np.array(drawn.axes, dtype=object).reshape(-1, columns)


def draw(figure: Figure, on: matplotlib.figure.Figure | None = None) -> matplotlib.figure.Figure:
    """A figure as Matplotlib's, without pyplot and its global state, or on an empty one of somebody's own."""
    columns = min(figure.columns, len(figure.panels))
    rows = math.ceil(len(figure.panels) / columns)
    size = (1.35 * columns + 0.6, 1.35 * rows + 0.6) if figure.square else (2.7 * columns + 0.3, 2.3 * rows + 0.4)
    drawn = matplotlib.figure.Figure(layout="constrained") if on is None else on
    drawn.set_size_inches(size)
    grid = drawn.subplots(rows, columns, squeeze=False)
    for panel, axes in zip(figure.panels, grid.flat):
        _draw_panel(panel, axes)
    for axes in grid.flat[len(figure.panels) :]:
        axes.set_axis_off()
    if figure.key:
        handles = [_handle(mark) for mark in figure.key]
        drawn.legend(handles=handles, loc="outside lower center", ncols=max(1, min(len(handles), columns if columns > 1 else 2)), handlelength=2.2)
    return drawn


def _draw_panel(panel: Panel, axes: Axes) -> None:
    if panel.cell:
        text, colour = panel.cell
        axes.set(xticks=[], yticks=[], facecolor=colour)
        axes.text(0.5, 0.5, text, ha="center", va="center", transform=axes.transAxes)
        return
    axes.set_title(to_mathtext(panel.title))
    axes.set_xlabel(to_mathtext(panel.x.label))
    axes.set_ylabel(to_mathtext(panel.y.label))
    for mark in panel.marks:
        _add(mark, axes)
    _set_axis(panel.x, axes, "x")
    _set_axis(panel.y, axes, "y")


def _set_axis(axis: Axis, axes: Axes, which: str) -> None:
    if axis.log:
        getattr(axes, f"set_{which}scale")("log")
    if axis.ticks is not None:
        getattr(axes, f"set_{which}ticks")([at for at, _ in axis.ticks], [to_mathtext(text) for _, text in axis.ticks])
        getattr(axes, f"{which}axis").set_minor_locator(NullLocator())
    if axis.limits:
        getattr(axes, f"set_{which}lim")(*axis.limits)


def _stroke(style: Style) -> dict[str, Any]:
    # Matplotlib measures dashes in widths of the line.
    dashes = tuple(length / style.width for length in DASHES[style.dash])
    return {"color": style.colour, "linewidth": style.width * _POINTS_PER_PIXEL, "linestyle": (0, dashes or None), "alpha": style.opacity}


@singledispatch
def _add(mark: Mark, axes: Axes) -> None:
    raise TypeError(f"no way to draw {type(mark).__name__}")


@_add.register
def _(mark: Line, axes: Axes) -> None:
    axes.plot(mark.x, mark.y, **_stroke(mark.style))


@_add.register
def _(mark: Band, axes: Axes) -> None:
    axes.fill_between(mark.x, mark.low, mark.high, color=mark.style.colour, alpha=mark.style.opacity, linewidth=0)


@_add.register
def _(mark: Points, axes: Axes) -> None:
    style = mark.style
    sizes = [(size * _POINTS_PER_PIXEL) ** 2 for size in mark.sizes] or (style.size * _POINTS_PER_PIXEL) ** 2
    colours = list(mark.colours) or style.colour
    if style.symbol == "ring":
        paint: dict[str, Any] = {"facecolors": "none", "edgecolors": colours, "linewidths": style.width * _POINTS_PER_PIXEL}
    else:
        paint = {"color": colours, "linewidths": style.width * _POINTS_PER_PIXEL if style.symbol == "cross" else 0}
    axes.scatter(mark.x, mark.y, s=sizes, marker=_SYMBOLS[style.symbol], alpha=style.opacity, zorder=3, **paint)


@_add.register
def _(mark: Bars, axes: Axes) -> None:
    base = np.zeros_like(mark.heights) if mark.base is None else mark.base
    axes.stairs(mark.heights + base, mark.edges, baseline=base, fill=True, color=mark.style.colour, alpha=mark.style.opacity)


@_add.register
def _(mark: Level, axes: Axes) -> None:
    (axes.axvline if mark.upright else axes.axhline)(mark.at, **_stroke(mark.style))


def _handle(mark: Mark) -> Artist:
    """A mark in the key."""
    label, style = to_mathtext(mark.name), mark.style
    if isinstance(mark, (Band, Bars)):
        return Patch(facecolor=style.colour, alpha=style.opacity, label=label, linewidth=0)
    if isinstance(mark, Points):
        hollow = {"markerfacecolor": "none"} if style.symbol == "ring" else {}
        size = style.size * _POINTS_PER_PIXEL
        return Line2D([], [], linestyle="", marker=_SYMBOLS[style.symbol], color=style.colour, markersize=size, label=label, **hollow)
    return Line2D([], [], label=label, **_stroke(style))
