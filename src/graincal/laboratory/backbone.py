"""Where a control variable turns back, and how lines of a file are named."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray


def turned_back(control: ArrayLike) -> NDArray[np.bool_]:
    """Which values (T,) lie below an earlier one: unloading, and reloading until it rejoins the backbone."""
    control = np.asarray(control, dtype=np.float64)
    return control < np.maximum.accumulate(control)


def repeated(control: ArrayLike) -> NDArray[np.bool_]:
    """Which values (T,) equal the largest earlier one, so that the control stood still."""
    control = np.asarray(control, dtype=np.float64)
    return np.concatenate([[False], control[1:] == np.maximum.accumulate(control)[:-1]])


def outrun(control: ArrayLike) -> NDArray[np.bool_]:
    """Which values (T,) a later one does not exceed: those of a control that wavers on its way, of which the last row at each value stays."""
    control = np.asarray(control, dtype=np.float64)
    later = np.minimum.accumulate(control[::-1])[::-1]
    return np.concatenate([control[:-1] >= later[1:], [False]]) if control.size else np.zeros(0, dtype=bool)


def noise(values: ArrayLike) -> float:
    """About the standard deviation from row to row of values (T,) whose course is smooth over three rows; 0 of fewer than five."""
    values = np.asarray(values, dtype=np.float64)
    return float(1.4826 * np.median(np.abs(np.diff(values, 2))) / np.sqrt(6)) if len(values) >= 5 else 0.0


def first_movement(values: ArrayLike) -> float:
    """How far the first of the values (T,) that differs from their beginning by a hundredth of their whole range lies from it; 0 without any."""
    numbers = np.asarray(values, dtype=np.float64)
    away = numbers - numbers[0]
    moved = np.flatnonzero(np.abs(away) > 0.01 * np.ptp(away))
    return float(away[moved[0]]) if moved.size else 0.0


def through_zero(stresses: ArrayLike) -> NDArray[np.float64]:
    """Stresses (T,) of a path, with half of the smaller neighbour in the place of a 0 on its way: a logarithm has no 0, and the path turns around below its neighbours. Leading zeros stay."""
    values = np.asarray(stresses, dtype=np.float64)
    found = values.copy()
    loaded = np.flatnonzero(values > 0)
    for first, last in runs(values == 0):
        before, behind = loaded[loaded < first], loaded[loaded > last]
        if before.size:
            found[first : last + 1] = 0.5 * min(values[before[-1]], values[behind[0]] if behind.size else np.inf)
    return found


def runs(chosen: ArrayLike) -> list[tuple[int, int]]:
    """The first and last index of each run of chosen rows (T,) of booleans."""
    padded = np.concatenate([[False], np.asarray(chosen, dtype=bool), [False]])
    edges = np.flatnonzero(padded[1:] != padded[:-1])
    return [(int(start), int(end) - 1) for start, end in zip(edges[::2], edges[1::2], strict=True)]


def spans(chosen: ArrayLike, lines: Sequence[int]) -> list[tuple[int, int]]:
    """The first and last line of each run of chosen rows, which stand on `lines`."""
    return [(lines[first], lines[last]) for first, last in runs(chosen)]


def say_lines(spans: Sequence[tuple[int, int]], at_most: int = 8) -> str:
    """Lines to read: `line 7`, `lines 3-9, 14 and 5 more places`."""
    words = [str(first) if first == last else f"{first}-{last}" for first, last in spans]
    more = len(words) - at_most
    listed = ", ".join(words[:at_most]) + (f" and {more} more place{'s' if more > 1 else ''}" if more > 0 else "")
    return ("line " if len(words) == 1 and spans[0][0] == spans[0][1] else "lines ") + listed
