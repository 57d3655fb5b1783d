"""The states at which a test comes to rest. They are the test's own: a laboratory's rows are met by interpolation between them, so that one run serves all.

A test that is driven by strain rests at 0, at FIRST_STRAINS, where the response turns fastest, and then at all multiples of `rest_every`. One that is
driven by stress rests at its confining pressure times 10^(k / STATES_PER_DECADE). Where a path turns around it rests too, and a stress close to there is
passed by: between states that are hardly apart a slope would be that of what they scatter by.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from graincal.interpolation import SLACK
from graincal.positions import positions, stresses_at

FIRST_STRAINS = (0.0005, 0.001, 0.002, 0.003)
"""As fractions; those below `rest_every`."""

REST_EVERY = 0.004
"""The strain from one rest to the next, as in Hartmann, Cheng, Thornton (2022)."""

RESTS_EVERY = (1e-5, 0.05)
"""What REST_EVERY may be instead. Between states further apart than the curve's bends, interpolation would make up a curve."""

STATES_PER_DECADE = 8
"""Stored responses are on these states: another choice is another format of the store (`VERSION` in campaign/store.py)."""

CLEAR_OF_TURNS = 0.1
"""Of the step from one stress to the next: one that is so close to a turn is no rest."""


def strains_at_rest(at: NDArray[np.float64], every: float) -> NDArray[np.float64]:
    """The strains (S,) at which a test rests that goes from 0 through all of `at` (T,), each between -1 and 1."""
    first = [strain for strain in FIRST_STRAINS if strain < every * (1 - SLACK)]
    sizes = np.append(first, every * np.arange(1, 2 + np.ceil(np.abs(at).max() / every)))
    return _route(at, 0.0, np.concatenate([-sizes[::-1], [0.0], sizes]))


def stresses_at_rest(at: NDArray[np.float64], confining_pressure: float) -> NDArray[np.float64]:
    """The stresses (S,) at which a test rests that goes from its confining pressure through all of `at` (T,), in the unit of both."""
    decades = np.log10(at / confining_pressure)
    low, high = np.floor(min(decades.min(), 0) * STATES_PER_DECADE) - 1, np.ceil(max(decades.max(), 0) * STATES_PER_DECADE) + 1
    return confining_pressure * 10.0 ** _route(decades, 0.0, np.arange(low, high + 1) / STATES_PER_DECADE, CLEAR_OF_TURNS / STATES_PER_DECADE)


def positions_at_rest(last: float, turns: Sequence[float]) -> NDArray[np.float64]:
    """The positions (S,) at which a test rests that turns around at these stresses, in units of its confining pressure, and goes on: up to the first that is
    not before the `last` that is asked for, so that a run to there is the beginning of any longer one."""
    turned = positions(turns, 1.0)
    # At the least so far beyond the last turn that the leg has a rest that is clear of it.
    end = max(last, (turned[-1] if len(turned) else 0.0) + np.log(10) / STATES_PER_DECADE)
    passed = stresses_at_rest(np.append(turns, stresses_at(end, 1.0, turns)), 1.0)
    rests = positions(passed, 1.0)
    return rests[: 1 + int(np.searchsorted(rests, last * (1 - 0.1 * SLACK)))]


def _route(at: NDArray[np.float64], start: float, grid: NDArray[np.float64], clear: float = 0.0) -> NDArray[np.float64]:
    """From the start through all of `at`, by the values of an increasing grid: each leg to where the path turns around, the last one to the first value of the
    grid that is not before its end, whatever rows lie on it. Values nearer to a turn than `clear` are passed by."""
    # Closer than the interpolation takes values for the same, which then reaches all that was asked for.
    slack = 0.1 * SLACK * np.abs(grid).max()
    clear = max(clear, slack)
    ways = np.sign(np.diff(at, prepend=start))
    moving = np.flatnonzero(ways)
    turns = moving[1:][np.diff(ways[moving]) != 0] - 1
    states = [start]
    for row in (*turns, len(at) - 1):
        end, here = at[row], states[-1]
        after, before = (clear if len(states) > 1 else slack), (clear if row != len(at) - 1 else slack)
        between = grid[(grid > here + after) & (grid < end - before)] if end > here else grid[(grid < here - after) & (grid > end + before)][::-1]
        states += between.tolist()
        if abs(end - states[-1]) <= slack:
            continue
        on_grid = grid[np.argmin(np.abs(grid - end))]
        beyond = grid[grid >= end - slack][0] if end > here else grid[grid <= end + slack][-1]
        states.append(float(beyond if row == len(at) - 1 else on_grid if abs(on_grid - end) <= slack else end))
    return np.array(states)
