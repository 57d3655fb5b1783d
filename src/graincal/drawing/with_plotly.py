"""Figures as Plotly's descriptions, which its script draws in a browser."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import singledispatch
from typing import Any

import numpy as np

from graincal.drawing.figure import Axis, Band, Bars, Figure, Level, Line, Mark, Panel, Points
from graincal.drawing.palette import DASHES, Style
from graincal.notation.markup import to_html

_SYMBOLS = {"circle": "circle", "ring": "circle-open", "cross": "x-thin-open", "diamond": "diamond", "square": "square"}
_INK, _LINES, _FONT = "#222222", "#e4e4e4", "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"
_GAP = 0.012
"""Between the cells of a matrix, as a share of its width."""

Description = dict[str, Any]


def describe(panel: Panel) -> Description:
    """One panel as a plot of its own."""
    data, shapes = _marks(panel, "x", "y")
    layout = _layout({"l": 56, "r": 12, "t": 8, "b": 46})
    layout |= {"xaxis": _axis(panel.x), "yaxis": _axis(panel.y), "shapes": shapes}
    return {"data": data, "layout": layout}


def describe_square(figure: Figure) -> Description:
    """The panels of a square figure as one plot, row by row from the top."""
    n = figure.columns
    layout = _layout({"l": 60, "r": 12, "t": 8, "b": 56})
    layout |= {"shapes": [], "annotations": []}
    data: list[Description] = []
    for place, panel in enumerate(figure.panels):
        row, column = divmod(place, n)
        across, up = _domain(column, n), _domain(n - 1 - row, n)
        if panel.cell:
            layout["shapes"].append(_cell(across, up, panel.cell[1]))
            layout["annotations"].append(_number(across, up, panel.cell[0]))
            continue
        suffix = str(place + 1) if place else ""
        marks, shapes = _marks(panel, f"x{suffix}", f"y{suffix}")
        data += marks
        layout["shapes"] += shapes
        layout[f"xaxis{suffix}"] = _axis(panel.x) | {"domain": across, "anchor": f"y{suffix}", "mirror": True, "tickfont": {"size": 11}}
        layout[f"yaxis{suffix}"] = _axis(panel.y) | {"domain": up, "anchor": f"x{suffix}", "mirror": True, "tickfont": {"size": 11}}
    return {"data": data, "layout": layout}


def _layout(margin: dict[str, int]) -> Description:
    return {
        "autosize": True,
        "margin": margin | {"pad": 0},
        "font": {"family": _FONT, "size": 12, "color": _INK},
        "paper_bgcolor": "#ffffff",
        "plot_bgcolor": "#ffffff",
        "showlegend": False,
        "barmode": "overlay",
        "hovermode": "closest",
        "hoverlabel": {"bgcolor": "#ffffff", "bordercolor": "#888888", "font": {"family": _FONT, "size": 12, "color": _INK}},
    }


def _axis(axis: Axis) -> Description:
    described: Description = {
        "title": {"text": to_html(axis.label), "standoff": 8},
        "showline": True,
        "linecolor": "#555555",
        "gridcolor": _LINES,
        "zeroline": False,
        "ticks": "outside",
        "ticklen": 4,
        "automargin": True,
        "hoverformat": ".4~g",
        "exponentformat": "power",
    }
    if axis.log:
        described["type"] = "log"
    if axis.limits:
        described["range"] = [math.log10(limit) for limit in axis.limits] if axis.log else list(axis.limits)
    if axis.ticks is not None:
        described |= {"tickmode": "array", "tickvals": [at for at, _ in axis.ticks], "ticktext": [to_html(text) for _, text in axis.ticks]}
        if not axis.ticks:
            described |= {"ticks": "", "showticklabels": False}
    return described


def _marks(panel: Panel, x: str, y: str) -> tuple[list[Description], list[Description]]:
    """Traces and shapes of a panel on the axes of these names."""
    data: list[Description] = []
    shapes: list[Description] = []
    for mark in panel.marks:
        if isinstance(mark, Level):
            shapes.append(_level(mark, x, y))
        else:
            data += [trace | {"xaxis": x, "yaxis": y, "name": to_html(mark.name), "showlegend": False} for trace in _traces(mark)]
    return data, shapes


@singledispatch
def _traces(mark: Mark) -> list[Description]:
    raise TypeError(f"no way to draw {type(mark).__name__}")


@_traces.register
def _(mark: Line) -> list[Description]:
    style = mark.style
    return [{"type": "scatter", "mode": "lines", "x": _plain(mark.x), "y": _plain(mark.y), "line": _stroke(style), "opacity": style.opacity}]


@_traces.register
def _(mark: Band) -> list[Description]:
    x, outline = _plain(mark.x), _plain(mark.high)
    around = {"x": x + x[::-1], "y": outline + _plain(mark.low)[::-1]}
    fill = {"fill": "toself", "fillcolor": mark.style.colour, "line": {"width": 0}, "hoverinfo": "skip"}
    return [{"type": "scatter", "mode": "lines", **around, **fill, "opacity": mark.style.opacity}]


@_traces.register
def _(mark: Points) -> list[Description]:
    style = mark.style
    colour = list(mark.colours) or style.colour
    marker: Description = {"symbol": _SYMBOLS[style.symbol], "color": colour, "size": _plain(mark.sizes) or style.size, "opacity": style.opacity}
    marker["line"] = {"width": style.width, "color": colour} if style.symbol in ("ring", "cross") else {"width": 0}
    trace = {"type": "scatter", "mode": "markers", "x": _plain(mark.x), "y": _plain(mark.y), "marker": marker}
    if mark.notes:
        trace |= {"text": [to_html(note) for note in mark.notes], "hoverinfo": "text"}
    return [trace]


@_traces.register
def _(mark: Bars) -> list[Description]:
    edges = np.asarray(mark.edges)
    trace: Description = {
        "type": "bar",
        "x": _plain((edges[1:] + edges[:-1]) / 2),
        "y": _plain(mark.heights),
        "width": _plain(np.diff(edges)),
        "offsetgroup": "0",
    }
    trace["marker"] = {"color": mark.style.colour, "opacity": mark.style.opacity, "line": {"width": 0}}
    return [trace | ({} if mark.base is None else {"base": _plain(mark.base)})]


def _stroke(style: Style) -> Description:
    return {"color": style.colour, "width": style.width, "dash": ",".join(f"{length}px" for length in DASHES[style.dash]) or "solid"}


def _level(mark: Level, x: str, y: str) -> Description:
    along = {"x0": mark.at, "x1": mark.at, "y0": 0, "y1": 1} if mark.upright else {"x0": 0, "x1": 1, "y0": mark.at, "y1": mark.at}
    names = {"xref": x, "yref": f"{y} domain"} if mark.upright else {"xref": f"{x} domain", "yref": y}
    # Above: below, a grid line at the same place would hide it.
    return {"type": "line", "layer": "above", "line": _stroke(mark.style), **along, **names}


def _domain(place: int, n: int) -> list[float]:
    width = (1 - (n - 1) * _GAP) / n
    return [place * (width + _GAP), min(1.0, place * (width + _GAP) + width)]


def _cell(across: list[float], up: list[float], colour: str) -> Description:
    corners = {"x0": across[0], "x1": across[1], "y0": up[0], "y1": up[1]}
    return {"type": "rect", "xref": "paper", "yref": "paper", "layer": "below", "fillcolor": colour, "line": {"width": 0}, **corners}


def _number(across: list[float], up: list[float], text: str) -> Description:
    middle = {"x": sum(across) / 2, "y": sum(up) / 2, "xref": "paper", "yref": "paper", "xanchor": "center", "yanchor": "middle"}
    return {"text": to_html(text), "showarrow": False, "font": {"size": 14}, **middle}


def _plain(values: Iterable[float]) -> list[float | None]:
    """Six digits are more than a screen shows; JSON has no NaN."""
    return [float(f"{value:.6g}") if math.isfinite(value) else None for value in map(float, values)]
