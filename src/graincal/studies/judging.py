"""When a conclusion holds, when it does not, and when it cannot be told: by one rule, which favours no side."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from graincal.notation import numbers

HOLDS, DOES_NOT_HOLD, CANNOT_BE_TOLD = "holds", "does not hold", "cannot be told"

EXACT = 0.0
"""The floor of what runs at the same parameters do not change, and of what they change no more than seeds do, which have other runs too: a calibrated
parameter, a number of iterations.
"""

SEED, RUN, NUMBER = "seed", "run", ""
"""What there are several of: calibrations by other random numbers, repeated runs at the same parameters, or one number that stands for all of them,
as a mean does.
"""

SURE = 1.96
"""Standard deviations of an interval of 95 %."""


@dataclass(frozen=True)
class Judgement:
    """Whether something holds, and a sentence that follows from the numbers."""

    verdict: str
    reason: str


@dataclass(frozen=True)
class Elsewhere:
    """The spread of a quantity over the seeds of another setting, which stands for that of a setting with one seed.

    size: in the quantity's unit; NaN where there are no several seeds there either.
    """

    size: float
    where: str


@dataclass(frozen=True)
class Values:
    """A quantity of which a conclusion speaks.

    name: what it is called. values: one a seed or run (`of`), in `unit`. floor: by how much runs at the same parameters differ in it; NaN where that
    is not known. elsewhere: how far seeds spread where there are several, for a setting with one.
    """

    name: str
    values: tuple[float, ...]
    floor: float = np.nan
    unit: str = " %"
    of: str = SEED
    elsewhere: Elsewhere | None = None

    @classmethod
    def of_finite(cls, name: str, values: Iterable[float], floor: float | None, unit: str = " %", of: str = SEED, elsewhere: Elsewhere | None = None) -> Values:
        """Those that are finite. floor: None where it is not known."""
        return cls(name, tuple(float(value) for value in values if np.isfinite(value)), np.nan if floor is None else floor, unit, of, elsewhere)

    @property
    def median(self) -> float:
        return float(np.median(self.values))

    @property
    def spread(self) -> float:
        """From the smallest to the largest; of one seed that of another setting, NaN where none is known."""
        if len(self.values) > 1:
            return max(self.values) - min(self.values)
        if self.of != SEED:
            return 0.0
        return np.nan if self.elsewhere is None else self.elsewhere.size

    def __str__(self) -> str:
        return f"{self.name} is {numbers.value(self.median, 3)}{self.unit}{self._count}"

    @property
    def _count(self) -> str:
        if self.of == NUMBER:
            return ""
        if len(self.values) == 1:
            return f" (one {self.of})"
        return f" ({len(self.values)} {self.of}s: {numbers.value(min(self.values), 3)} to {numbers.value(max(self.values), 3)})"


def sentence(said: str) -> str:
    """Something to begin a sentence with: a word gets a capital, a symbol keeps its letter."""
    first = said.split()[0].split("_")[0]
    return said if len(first) < 2 or not first.isascii() else said[0].upper() + said[1:]


def smaller(one: Values, other: Values) -> Judgement:
    """Whether one quantity is smaller than another, by more than runs at the same parameters differ and more than the seeds spread."""
    return _judge([one, other], lambda: other.median - one.median)


def differ(one: Values, other: Values) -> Judgement:
    """Whether two quantities are apart, in whatever direction, by more than runs at the same parameters differ and more than the seeds spread.

    That they are alike cannot be told.
    """
    return _judge([one, other], lambda: abs(other.median - one.median))


def at_most(one: Values, limit: float) -> Judgement:
    """Whether a quantity is at most a number: where all its values are below, and their median by more than runs at the same parameters differ; and
    is not where all are above, by as much.
    """
    return _judge([one], lambda: limit - one.median, limit)


def at_least(one: Values, limit: float) -> Judgement:
    """The same, whether it is at least a number."""
    return _judge([one], lambda: one.median - limit, limit)


def _judge(compared: Sequence[Values], difference: Callable[[], float], limit: float | None = None) -> Judgement:
    """By a difference that is positive where the conclusion holds."""
    if nothing := [each.name for each in compared if not each.values]:
        return Judgement(CANNOT_BE_TOLD, f"{sentence(nothing[0])} is not known: it was not run.")
    unit, apart = compared[0].unit, difference()
    said = sentence(", and ".join(map(str, compared)))
    if limit is not None:
        said += f"; the limit is {limit:.3g}{unit}"
    if doubt := _doubt(compared, abs(apart), unit, limit):
        return Judgement(CANNOT_BE_TOLD, f"{said}: {doubt}.")
    return Judgement(HOLDS if apart > 0 else DOES_NOT_HOLD, f"{said}.")


def _doubt(compared: Sequence[Values], apart: float, unit: str, limit: float | None) -> str:
    """Why a difference of some size cannot be told; nothing where it can."""
    if any(np.isnan(each.floor) for each in compared):
        return "how far runs at the same parameters differ is not known"
    if apart <= (floor := max(each.floor for each in compared)):
        return f"runs at the same parameters differ by {numbers.value(floor, 2)}{unit}, which is as much" if floor else "there is no difference"
    if any(np.isnan(each.spread) for each in compared):
        return "with one seed it cannot be told how far seeds spread"
    widest = max(compared, key=lambda each: each.spread)
    if limit is not None and len(widest.values) > 1:
        return "" if max(widest.values) < limit or min(widest.values) > limit else f"{widest.of}s lie on both sides"
    if apart > widest.spread:
        return ""
    where = f" of {widest.elsewhere.where}" if len(widest.values) == 1 and widest.elsewhere else ""
    return f"{widest.of}s{where} spread over {numbers.value(widest.spread, 2)}{unit}, which is as much"


def all_of(judgements: Sequence[Judgement]) -> Judgement:
    """Of a conclusion that speaks of several differences: it holds where each does, and does not where one does not."""
    for verdict in (DOES_NOT_HOLD, CANNOT_BE_TOLD):
        if found := [each for each in judgements if each.verdict == verdict]:
            count = f" This is so in {len(found)} of {len(judgements)} comparisons." if len(found) < len(judgements) else ""
            return Judgement(verdict, found[0].reason + count)
    if not judgements:
        return Judgement(CANNOT_BE_TOLD, "Nothing of it was run.")
    return Judgement(
        HOLDS, " ".join(each.reason for each in judgements[:2]) + (f" So it is in all {len(judgements)} comparisons." if len(judgements) > 2 else "")
    )


def correlation_at_least(name: str, correlation: float, count: int, limit: float) -> Judgement:
    """Whether Pearson's coefficient of `count` pairs is at least a number, outside its interval of 95 % (Fisher 1921, Metron 1: its inverse
    hyperbolic tangent has a standard deviation of 1/√(count − 3)).
    """
    if count < 4 or not np.isfinite(correlation):
        return Judgement(CANNOT_BE_TOLD, f"{sentence(name)} is not known: it was not run.")
    wide = SURE / np.sqrt(count - 3)
    low, high = np.tanh(np.arctanh(np.clip(correlation, -0.9999, 0.9999)) + np.array([-wide, wide]))
    said = f"{sentence(name)} is {correlation:.2f}, and its interval of 95 % is {low:.2f} to {high:.2f} by {count} calibrations; the limit is {limit:g}"
    if low <= limit <= high:
        return Judgement(CANNOT_BE_TOLD, f"{said}: it lies within.")
    return Judgement(HOLDS if low > limit else DOES_NOT_HOLD, f"{said}.")


def spread_at(where: str, values: Iterable[float], scale: float = 1.0) -> Elsewhere:
    """How far the seeds of a setting spread, times a factor; unknown for fewer than two."""
    found = [value for value in values if np.isfinite(value)]
    return Elsewhere(scale * (max(found) - min(found)) if len(found) > 1 else np.nan, where)
