"""Responses on other control values than those asked for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from graincal.data import Failure, Response


def covers(control: NDArray[np.float64], at: NDArray[np.float64]) -> bool:
    """Whether `at` lies within an increasing `control`, to rounding."""
    slack = 1e-9 * max(abs(control[0]), abs(control[-1]))
    return bool(np.all((at >= control[0] - slack) & (at <= control[-1] + slack)))


def span(control: NDArray[np.float64]) -> str:
    """The range of control values, to print."""
    return f"{control.min():g} to {control.max():g}"


def interpolate(response: Response, at: NDArray[np.float64]) -> Response | Failure:
    """The response at the control values `at` (T,), linear between its own; a Failure where they do not reach so far."""
    if np.array_equal(response.control, at):
        return response
    if not covers(response.control, at):
        reason = f"the response covers the control values {span(response.control)}, and {span(at)} were asked for."
        return Failure("output", reason, response.details)
    return Response(at, {name: np.interp(at, response.control, values) for name, values in response.values.items()}, response.details)
