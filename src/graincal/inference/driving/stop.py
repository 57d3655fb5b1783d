"""When to stop iterating (Hartmann, Cheng, Thornton 2022, Eq. 12)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from numbers import Real
from typing import Literal

from graincal.data import InputError
from graincal.inference.driving.iteration import Iteration

ITERATIONS = 20
"""The limit of the paper's method where none is set."""


@dataclass(frozen=True)
class Stop:
    """The criteria, any of which stops; False switches one off.

    `s`: s is at most this. The paper's 0.01, a standard deviation of 10 % at each state, is for about 50 states: s grows with their number.
    `gl_error_increment`: the GL error (Eq. 7) changed by at most this many percentage points against the previous iteration.
    `error`: the most probable sample's error (Eq. 6) is at most this, in percent.
    `error_increment`: that error changed by at most this many percentage points against the previous iteration.
    `max_iterations`: so many iterations are complete, iteration 0 included. None for ITERATIONS by the paper's method and no limit by `PosteriorFilter`.
    `max_evaluations`: the next iteration would bring the evaluations above this. An iteration is never shortened: its number of samples is
    part of the method (Eq. 4).
    `hours`: so many hours of wall time are over, in all sittings: no further iteration is begun. A campaign looks at the clock, and keeps what that said, so that it can be gone on with.
    `posterior_shift`: for `PosteriorFilter`, which looks at this and the limits alone: what the emulator does not know moves no parameter's posterior mean
    by more than so many standard deviations, nor the logarithm of the width of its interval of 68 % by more than that over 0.6 (a standard deviation over what it holds possible); and fresh runs fit as the posterior says.
    Raises InputError for values that are not positive numbers (increments and errors may be 0), and when nothing would ever stop.
    """

    s: float | Literal[False] = 0.01
    gl_error_increment: float | Literal[False] = 0.2
    error: float | Literal[False] = 2.0
    error_increment: float | Literal[False] = 0.2
    max_iterations: int | Literal[False] | None = None
    max_evaluations: int | Literal[False] = False
    hours: float | Literal[False] = False
    posterior_shift: float | Literal[False] = 0.2

    def __post_init__(self) -> None:
        for name in (field.name for field in fields(self)):
            value = getattr(self, name)
            if value is False or (value is None and name == "max_iterations"):
                continue
            count = name.startswith("max_")
            number = isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(value) and float(value) >= 0
            if not number or (count and (value < 1 or value != int(value))):
                kind = "a whole number above 0" if count else "a number, not negative,"
                raise InputError(f"stop.{name} must be {kind} or false, not {value!r}.")
        if all(getattr(self, field.name) is False for field in fields(self)):
            raise InputError("stop: every criterion is switched off, so that nothing would end the calibration.")

    @property
    def most_iterations(self) -> int | Literal[False]:
        """The limit on iterations of the paper's method."""
        return ITERATIONS if self.max_iterations is None else self.max_iterations

    def reached(self, iterations: Sequence[Iteration]) -> dict[str, str]:
        """The criteria that the last of the iterations so far meets: their names, in the order of Eq. 12, with a clause that says it in words."""
        last = iterations[-1]
        evaluations = sum(len(iteration.samples) for iteration in iterations)
        changes = {}
        if len(iterations) > 1:
            before = iterations[-2]
            changes = {"gl_error": abs(last.gl_error - before.gl_error), "error": abs(last.error - before.error)}
        met = {}
        for name, value, words in (
            ("s", last.s, "the covariance coefficient s = {:.3g} is at most {:g}"),
            ("gl_error_increment", changes.get("gl_error"), "the GL error changed by {:.2g} percentage points, at most {:g}"),
            ("error", last.error, "the most probable sample's error of {:.2f} % is at most {:g} %"),
            ("error_increment", changes.get("error"), "the most probable sample's error changed by {:.2g} percentage points, at most {:g}"),
        ):
            limit = getattr(self, name)
            if limit is not False and value is not None and value <= limit:
                met[name] = words.format(value, limit)
        most = self.most_iterations
        if most is not False and len(iterations) >= most:
            met["max_iterations"] = f"the limit of {most} iteration{'s' if most > 1 else ''} is reached"
        if self.max_evaluations is not False and evaluations + len(last.samples) > self.max_evaluations:
            met["max_evaluations"] = (
                f"{evaluations} evaluations are done, and the {len(last.samples)} of another iteration would exceed the limit of {self.max_evaluations}"
            )
        return met
