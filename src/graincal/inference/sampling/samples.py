"""Where samples lie in the box: those of iteration 0, and how many they are; and the same parameters several times."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from graincal.data import InputError, ParameterSpace

MOST_SAMPLES = 1_000_000

APART = 1e-6
"""How far apart samples are that stand for the same parameters, in parts of the ranges: enough to be another run in float32 too."""


WAYS = 1000
"""In which they are looked for, where constraints leave not every one."""

NEAR_MIDDLE = 1000
"""Points among which one near the middle is looked for."""


def number_of_samples(parameters: int, alpha: float = 10) -> int:
    """The samples of each iteration, N = alpha n ln n rounded to the nearest integer, and at least 2 alpha.

    The lower bound only matters for one or two parameters, where n ln n is 0 and 1.4.
    Source: Hartmann, Cheng, Thornton (2022), Eq. 4; alpha = 10 and n = 5 give 80.
    Raises InputError if alpha is not a positive number or leaves fewer than two samples.

    >>> number_of_samples(5)
    80
    """
    if not (math.isfinite(alpha) and alpha > 0):
        raise InputError(f"filter.alpha must be a positive number, not {alpha}.")
    count = round(alpha * max(2.0, parameters * math.log(parameters)))
    if count > MOST_SAMPLES:
        raise InputError(f"filter.alpha = {alpha:g} asks for {count} samples an iteration, and at most {MOST_SAMPLES} can be held.")
    if count < 2:
        raise InputError(f"filter.alpha = {alpha} leaves {count} samples for {parameters} parameter(s), and at least 2 are needed.")
    return count


def halton(space: ParameterSpace, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """`count` points (count, n) that fill the prior evenly: a scrambled Halton sequence, without the points that the constraints exclude.

    Scrambling makes every point uniform on the box; the plain sequence begins in its corner. Raises InputError where the constraints leave nothing.
    """
    from scipy.stats import qmc

    unit = allowed(qmc.Halton(d=space.size, scramble=True, seed=rng).random, count, space)
    # low + 1 * (high - low) may round to the number after high.
    return np.clip(space.from_unit(unit), space.low, space.high)


def middle_of(space: ParameterSpace) -> NDArray[np.float64]:
    """The middle of the box, (n,), or where constraints exclude it a point near it that they leave."""
    middle = space.from_unit(np.full(space.size, 0.5))
    if space.contains(middle).all():
        return middle
    theta = halton(space, NEAR_MIDDLE, np.random.default_rng(0))
    return theta[np.argmin(np.sum((space.to_unit(theta) - 0.5) ** 2, axis=1))]


def replicates(theta: NDArray[np.float64], count: int, space: ParameterSpace) -> NDArray[np.float64]:
    """The same parameters (n,) so many times, (count, n): a millionth of the ranges apart, or a deterministic simulator would give the same run each time."""
    inwards = np.where(theta < space.from_unit(np.full(space.size, 0.5)), 1.0, -1.0)
    if space.constraints:
        # Next to a constraint not every way leads where it holds.
        ways = np.concatenate([inwards[None], np.random.default_rng(0).choice([-1.0, 1.0], (WAYS, space.size))])
        inwards = next((way for way in ways if space.contains(space.moved(theta, APART * np.arange(count)[:, None] * way)).all()), inwards)
    return space.moved(theta, APART * np.arange(count)[:, None] * inwards)


def allowed(draw: Callable[[int], NDArray[np.float64]], count: int, space: ParameterSpace) -> NDArray[np.float64]:
    """The first `count` points (count, n) of a sequence on the unit cube that the prior holds possible; draw(N) gives the next N points. Without constraints those are its first.

    Raises InputError where the constraints leave nothing.
    """
    if not space.constraints:
        return draw(count)
    kept = np.empty((0, space.size))
    while len(kept) < count:
        # With some to spare, so that mostly one more time is enough.
        unit = draw(int(np.ceil(1.1 * (count - len(kept)) / space.part)) + 10)
        kept = np.concatenate([kept, unit[space.allows(unit)]])
    return kept[:count]
