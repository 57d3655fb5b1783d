"""How good a calibration is, and whether it had samples enough (Hartmann, Cheng, Thornton 2022, section 5 and Fig. 17)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from graincal.data import ParameterSpace
from graincal.inference.driving.iteration import Iteration
from graincal.inference.driving.stop import Stop
from graincal.parameter_space import LOG

OPTIMAL_ERROR = 2.0
POOR_ERROR = 5.0
NO_FIT_ERROR = 20.0
"""Percent, beyond which a response is another one: the paper's grades are of results that fit more or less."""


@dataclass(frozen=True)
class Grade:
    """The word "optimal" or "sub-optimal", or "no fit" or "no result", with sentences that say why."""

    word: str
    reasons: tuple[str, ...]


def grade(iteration: Iteration, stop: Stop = Stop()) -> Grade:
    """The grade of the result of an iteration: optimal where the most probable sample's error (Eq. 6) is below 2 %, and sub-optimal above; no fit above
    20 %, and no result where everything failed.

    An s still well above its threshold (more than four times it, twice the standard deviation) is a sign of a sub-optimal result,
    and is named among the reasons.
    """
    if iteration.unweighted:
        word = "no result" if iteration.failed.all() else "no fit" if iteration.smallest_error > NO_FIT_ERROR else "sub-optimal"
        return Grade(word, (f"There are no weights: {iteration.unweighted}.",))
    error = iteration.error
    if error < OPTIMAL_ERROR:
        reasons = [f"The most probable sample's error of {error:.2f} % is below {OPTIMAL_ERROR:g} %."]
    elif error <= POOR_ERROR:
        reasons = [f"The most probable sample's error of {error:.2f} % is between {OPTIMAL_ERROR:g} and {POOR_ERROR:g} %."]
    else:
        reasons = [f"The most probable sample's error of {error:.2f} % is above {NO_FIT_ERROR if error > NO_FIT_ERROR else POOR_ERROR:g} %."]
    threshold = Stop.s if stop.s is False else stop.s
    if iteration.s > 4 * threshold:
        reasons.append(
            f"s = {iteration.s:.3g} ({iteration.s_per_state:.2g} per state) is well above its threshold of {threshold:g}, "
            f"a sign of a sub-optimal result; the paper's threshold of {Stop.s:g} is for about 50 states, here there are {len(iteration.weights)}."
        )
    word = "optimal" if error < OPTIMAL_ERROR else "sub-optimal" if error <= NO_FIT_ERROR else "no fit"
    return Grade(word, tuple(reasons))


def sample_size_advice(space: ParameterSpace, alpha: float) -> str | None:
    """A sentence where alpha is small for the width of the ranges, else None.

    The paper found alpha = 10 enough where log E spans up to four decades, and asks 10 more for each two further. It is applied to
    every parameter on a logarithmic scale: those whose unit or name begins with "log", and those whose prior is uniform in the logarithm.
    """
    widths = {
        name: math.log10(high / low) if scale == LOG else high - low
        for name, unit, scale, low, high in zip(space.names, space.units, space.scales, space.low, space.high)
        if unit.startswith("log") or name.startswith("log") or scale == LOG
    }
    if not widths:
        return None
    widest = max(widths, key=widths.__getitem__)
    wanted = 10 + 10 * math.ceil((max(widths[widest], 4) - 4) / 2)
    if alpha >= wanted:
        return None
    return f"The range of {widest} spans {widths[widest]:g} decades; alpha = {wanted} is advised (it is {alpha:g}), 10 more for each two decades above four."
