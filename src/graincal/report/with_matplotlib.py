"""Figures by Matplotlib, to print."""

from __future__ import annotations

import math
from functools import singledispatch
from pathlib import Path
from typing import Any

import matplotlib
import matplotlib.figure
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from graincal.report.drawing import Axis, Band, Bars, Figure, Level, Line, Mark, Panel, Points
from graincal.report.markup import to_mathtext
from graincal.report.palette import Style

_POINTS_PER_PIXEL = 0.6
_DASHES: dict[str, Any] = {"solid": "-", "dash": (0, (5, 2)), "dot": (0, (1, 1.5)), "dashdot": (0, (5, 1.5, 1, 1.5))}
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


def save(figure: Figure, path: Path) -> None:
    """Draw a figure and write it in the format of the path's suffix."""
    with matplotlib.rc_context(_SETTINGS):
        drawn = draw(figure)
        drawn.savefig(path, dpi=200, bbox_inches="tight")


def draw(figure: Figure) -> matplotlib.figure.Figure:
    """A figure as Matplotlib's, without pyplot and its global state."""
    columns = min(figure.columns, len(figure.panels))
    rows = math.ceil(len(figure.panels) / columns)
    size = (1.35 * columns + 0.6, 1.35 * rows + 0.6) if figure.square else (2.7 * columns + 0.3, 2.3 * rows + 0.4)
    drawn = matplotlib.figure.Figure(figsize=size, layout="constrained")
    grid = drawn.subplots(rows, columns, squeeze=False)
    for panel, axes in zip(figure.panels, grid.flat):
        _draw_panel(panel, axes)
    for axes in grid.flat[len(figure.panels) :]:
        axes.set_axis_off()
    if figure.key:
        handles = [_handle(mark) for mark in figure.key]
        drawn.legend(handles=handles, loc="outside lower center", ncols=max(1, min(len(handles), 2 * columns)), handlelength=2.2)
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
        getattr(axes, f"{which}axis").set_minor_locator(matplotlib.ticker.NullLocator())
    if axis.limits:
        getattr(axes, f"set_{which}lim")(*axis.limits)


def _stroke(style: Style) -> dict[str, Any]:
    return {"color": style.colour, "linewidth": style.width * _POINTS_PER_PIXEL, "linestyle": _DASHES[style.dash], "alpha": style.opacity}


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
    stroke = {"linewidths": style.width * _POINTS_PER_PIXEL}
    fill = {"facecolors": "none", "edgecolors": colours, **stroke} if style.symbol == "ring" else {"color": colours, **(stroke if style.symbol == "cross" else {"linewidths": 0})}
    axes.scatter(mark.x, mark.y, s=sizes, marker=_SYMBOLS[style.symbol], alpha=style.opacity, zorder=3, **fill)


@_add.register
def _(mark: Bars, axes: Axes) -> None:
    axes.stairs(mark.heights if mark.base is None else mark.heights + mark.base, mark.edges, baseline=0 if mark.base is None else mark.base,
                fill=True, color=mark.style.colour, alpha=mark.style.opacity)  # fmt: skip


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
