"""Positions along a path that a stress drives up and down: how far it has gone from its confining pressure, as the sum of |Δ ln σ| on its way.

A position increases also where the stress falls and rises again, and it is the same for proportional stresses. So it puts in order what a cycle of loading
and unloading is compared at.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graincal.errors import InputError

POSITION = "position"
"""The control whose values are positions: of the axial stress, or of the mean stress."""


def positions(stresses: ArrayLike, start: float, within: float = 0.0) -> NDArray[np.float64]:
    """How far a path has gone at each of the stresses (T,) that it comes to one after the other, from `start`, in the same unit; where a stress is repeated, a
    position is too. A path that goes back by no more than `within`, of ln σ, goes on the same way: the position of such a row is below that of rows before it.
    Raises InputError for stresses that are not above 0."""
    logs = _logarithms(stresses, start)
    if not within:
        return np.abs(np.diff(logs, prepend=0.0)).cumsum()
    turned, way = _turned(logs, within)
    corners, ways = np.append(0.0, logs[turned]), way * (-1.0) ** np.arange(len(turned) + 1)
    passed = np.abs(np.diff(corners, prepend=0.0)).cumsum()
    leg = np.searchsorted(turned, np.arange(len(logs)), side="left")
    # A row that lies behind the start has not left it.
    return np.maximum(passed[leg] + ways[leg] * (logs - corners[leg]), 0.0)


def turning_points(stresses: ArrayLike, start: float, within: float = 0.0) -> tuple[float, ...]:
    """Those of the stresses (T,) at which their path from `start` turns around, to go back by more than `within`, of ln σ. Raises InputError for stresses that are
    not above 0."""
    turned, _ = _turned(_logarithms(stresses, start), within)
    return tuple(float(stress) for stress in np.asarray(stresses, dtype=np.float64)[turned])


def stresses_at(at: ArrayLike, start: float, turns: Sequence[float] = ()) -> NDArray[np.float64]:
    """The stresses at positions (...) of the path from `start` that turns around at `turns` and then goes on, in their unit; without turns it goes up."""
    at = np.asarray(at, dtype=np.float64)
    corners = np.append(0.0, _logarithms(turns, start))
    passed = np.abs(np.diff(corners, prepend=0.0)).cumsum()
    ways = first_way(start, turns) * (-1.0) ** np.arange(len(corners))
    leg = np.clip(np.searchsorted(passed, at, side="right") - 1, 0, None)
    # Nothing so large or small is a stress: whoever asks for it is told so.
    with np.errstate(over="ignore", under="ignore"):
        return start * np.exp(corners[leg] + ways[leg] * (at - passed[leg]))


def first_way(start: float, turns: Sequence[float]) -> float:
    """1.0 where a path goes up first, and -1.0 where it goes down to its first turn."""
    return -1.0 if len(turns) and turns[0] < start else 1.0


def legs(values: ArrayLike) -> list[slice]:
    """The stretches of values (T,) that go one way, each with the value at which the one before it ended."""
    ways = np.sign(np.diff(np.asarray(values, dtype=np.float64)))
    moving = np.flatnonzero(ways)
    ends = [0, *moving[1:][np.diff(ways[moving]) != 0], len(ways)]
    return [slice(int(first), int(last) + 1) for first, last in zip(ends, ends[1:])]


def _turned(logs: NDArray[np.float64], within: float) -> tuple[NDArray[np.intp], float]:
    """The rows at which a path (T,) from 0 turns around to go back by more than `within`, and its first way, 1.0 up or -1.0 down: the furthest row of each leg, and the last
    of several, also where the stress then stood still."""
    turned: list[int] = []
    way, first, furthest, at, low, high = 0.0, 1.0, 0.0, -1, 0.0, 0.0
    for row, value in enumerate(logs.tolist()):
        if not way:
            low, high = min(low, value), max(high, value)
            if value - low > within or high - value > within:
                way = first = 1.0 if value - low > within else -1.0
                furthest, at = value, row
        elif way * (value - furthest) >= 0:
            furthest, at = value, row
        elif way * (furthest - value) > within:
            turned.append(at)
            way, furthest, at = -way, value, row
    return np.array(turned, dtype=np.intp), first


def _logarithms(stresses: ArrayLike, start: float) -> NDArray[np.float64]:
    """Of the ratios to the start."""
    stresses = np.asarray(stresses, dtype=np.float64)
    if stresses.ndim != 1 or not (np.isfinite(start) and start > 0) or not np.all(np.isfinite(stresses) & (stresses > 0)):
        raise InputError("stresses of a path must be one row of finite numbers above 0, and so must the stress that it starts from.")
    return np.log(stresses / start)
