"""What of a panel's curves is in sight: axes are not stretched by what lies far from the measured points, and the noise of rounding is not drawn as data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from graincal.drawing.figure import Array, Band, Line, Mark, Panel, Points
from graincal.notation.numbers import value
from graincal.notation.words import listed

NOISE = 1e-9
"""In the unit of an axis: a curve whose values are all below it is zero but for rounding."""
FAR = 3.0
"""Spans of the measured points, by which curves may reach beyond these before an axis is cut."""
_MARGIN = 1.0
"""Spans of the measured points beyond these, that a cut axis shows."""


def in_sight(panels: Sequence[Panel]) -> tuple[tuple[Panel, ...], str]:
    """The panels, without noise and with axes cut where curves go far beyond the measured points (`Points`), and a sentence that says which were cut; empty for none."""
    quiet = [_without_noise(panel) for panel in panels]
    shown = [_cut(panel) for panel in quiet]
    cut = [
        f"{panel.title or panel.y.label} (curves go from {' to '.join(value(end, 3) for end in _extent(panel.marks))})"
        for panel, limited in zip(quiet, shown)
        if limited is not panel
    ]
    return tuple(shown), f"Axes are cut in {listed(cut)}." if cut else ""


def _heights(mark: Mark) -> Array:
    parts = [mark.low, mark.high] if isinstance(mark, Band) else [mark.y] if isinstance(mark, (Line, Points)) else []
    heights = np.concatenate(parts) if parts else np.empty(0)
    return heights[np.isfinite(heights)]


def _extent(marks: Sequence[Mark]) -> tuple[float, float]:
    """The least and the largest height of marks; NaN for none."""
    heights = np.concatenate([np.empty(0), *(_heights(mark) for mark in marks)])
    return (float(heights.min()), float(heights.max())) if heights.size else (np.nan, np.nan)


def _without_noise(panel: Panel) -> Panel:
    low, high = _extent(panel.marks)
    if not max(abs(low), abs(high)) < NOISE:
        return panel
    marks = [
        replace(mark, low=0 * mark.low, high=0 * mark.high)
        if isinstance(mark, Band)
        else replace(mark, y=0 * mark.y)
        if isinstance(mark, (Line, Points))
        else mark
        for mark in panel.marks
    ]
    return replace(panel, marks=tuple(marks), y=replace(panel.y, limits=(-1.0, 1.0)))


def _cut(panel: Panel) -> Panel:
    low, high = _extent([mark for mark in panel.marks if isinstance(mark, Points)])
    lowest, highest = _extent(panel.marks)
    span = high - low
    if panel.y.limits or panel.y.log or not span > NOISE or (lowest > low - FAR * span and highest < high + FAR * span):
        return panel
    # A side that is not far is shown whole.
    return replace(panel, y=replace(panel.y, limits=(max(lowest, low - _MARGIN * span) - 0.05 * span, min(highest, high + _MARGIN * span) + 0.05 * span)))
