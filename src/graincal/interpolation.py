"""Responses between the states of a model: what they are at the control values that somebody asks for.

Between two states a response is a shape-preserving cubic (Fritsch and Carlson 1980, SIAM J. Numer. Anal. 17): it rises only where the states rise, and it
makes no peak of its own. Stresses are met over their logarithms, as compression curves are drawn.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from graincal.data import Failure, Response

SLACK = 1e-9
"""Control values that differ by less than this part of the largest are the same: they went through a unit, or a table."""

_HELD = ("flagged",)
"""Marks, which are set between two states where either has it."""


def covers(control: NDArray[np.float64], at: NDArray[np.float64]) -> bool:
    """Whether all of `at` lies within an increasing `control`, to rounding."""
    return bool(np.all(at >= control[0] - _slack(control)) and within_reach(control, at) == len(at))


def within_reach(control: NDArray[np.float64], at: NDArray[np.float64]) -> int:
    """How many of the first of `at` (T,) do not lie beyond the end of `control`."""
    beyond = at > control[-1] + _slack(control)
    return int(np.argmax(beyond)) if beyond.any() else len(at)


def span(control: NDArray[np.float64]) -> str:
    """The range of control values, to print."""
    return f"{control.min() + 0.0:g} to {control.max() + 0.0:g}"


def interpolate(response: Response, at: NDArray[np.float64]) -> Response | Failure:
    """The response at the control values `at` (T,) instead of its own; a Failure where its own do not reach so far.

    A path that turns around, up and down, is followed from its first state on: `at` then turns where the states do. Of a response that was stopped early
    the first of `at` are given that no further state would change.
    """
    if np.array_equal(response.control, at):
        return response
    along, asked = _positions(response, at)
    if response.stopped:
        # The slope at a state follows from the two beside it.
        asked = asked[: within_reach(along[:-1], asked)] if len(along) > 2 else asked[:0]
    elif not covers(along, asked):
        reason = f"the response covers the control values {span(response.control)}, and {span(at)} were asked for."
        return Failure("output", reason, response.details)
    values = _between(along, _turns(response), response.values, np.clip(asked, along[0], along[-1]))
    return replace(response, control=at[: len(asked)], values=values)


def _slack(control: NDArray[np.float64]) -> float:
    return SLACK * max(abs(control[0]), abs(control[-1]))


def _positions(response: Response, at: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """How far along the path the states are (S,), increasing, and what is asked for (T,)."""
    control = response.control
    if response.control_name in response.in_pascal:
        control, at = np.log(control), np.log(at)
    if np.all(np.diff(control) > 0):
        return control, at
    return np.append(0, np.abs(np.diff(control)).cumsum()), np.abs(np.diff(at, prepend=control[0])).cumsum()


def _turns(response: Response) -> NDArray[np.intp]:
    """The states at which a path turns around, with its first and last."""
    control = response.control
    turned = 1 + np.flatnonzero(np.diff(np.sign(np.diff(control))))
    known = [state for turn in response.turns for state in np.flatnonzero(np.abs(control - turn) <= _slack(control))]
    return np.array([0, *sorted({*turned, *known} - {0, len(control) - 1}), len(control) - 1])


def _between(
    along: NDArray[np.float64], turns: NDArray[np.intp], columns: Mapping[str, NDArray[np.float64]], asked: NDArray[np.float64]
) -> dict[str, NDArray[np.float64]]:
    """Columns (S, ...) at `asked` (T,), each leg between two turns by itself, for a curve has an edge where its path turns."""
    values = {name: np.empty((len(asked), *column.shape[1:])) for name, column in columns.items()}
    begun = 0
    for first, last in zip(turns, turns[1:]) if len(along) > 1 else ():
        ended = len(asked) if last == turns[-1] else within_reach(along[: last + 1], asked)
        rows, states = slice(begun, ended), slice(first, last + 1)
        leg, places = along[states], np.clip(asked[rows], along[first], along[last])
        for name, column in columns.items():
            values[name][rows] = _on_leg(leg, column[states], places, held=name in _HELD)
        begun = ended
    return values if len(along) > 1 else {name: np.full((len(asked), *column.shape[1:]), column[0]) for name, column in columns.items()}


def _on_leg(leg: NDArray[np.float64], column: NDArray[np.float64], places: NDArray[np.float64], *, held: bool) -> NDArray[np.float64]:
    """One column (S, ...) between the states of one leg: several runs' side by side, where there are more."""
    after = np.clip(np.searchsorted(leg, places), 1, len(leg) - 1)
    nearest = np.where(places - leg[after - 1] < leg[after] - places, after - 1, after)
    # Rows that are states have what these have, digit for digit, and need no library.
    on_state = np.abs(places - leg[nearest]) <= _slack(leg)
    if on_state.all():
        return column[nearest]
    on_states = on_state.reshape(-1, *[1] * (column.ndim - 1))
    if held:
        return np.where(on_states, column[nearest], np.maximum(column[after - 1], column[after]))
    from scipy.interpolate import PchipInterpolator

    finite = np.isfinite(column)
    if column.ndim > 1 and not finite.all():
        return np.stack([_on_leg(leg, each, places, held=held) for each in np.moveaxis(column, -1, 0)], axis=-1)
    between = np.full((len(places), *column.shape[1:]), np.nan)
    # A ratio of two stresses that have gone is no number, and there is none beside it: each stretch of numbers is by itself.
    whole = finite if column.ndim == 1 else np.ones(len(leg), dtype=bool)
    for stretch in np.split(np.arange(len(leg)), 1 + np.flatnonzero(np.diff(whole))):
        inside = (places >= leg[stretch[0]]) & (places <= leg[stretch[-1]])
        if whole[stretch[0]] and len(stretch) > 1:
            between[inside] = PchipInterpolator(leg[stretch], column[stretch])(places[inside])
    return np.where(on_states, column[nearest], between)
