"""Compression tests: a stress drives them, up and down where they are told to turn around."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from numbers import Real
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graincal.data import InputError, Response
from graincal.models.plausibility import impossible_pressure
from graincal.models.proportion import in_units_of
from graincal.models.rests import positions_at_rest
from graincal.models.stress_path import Abscissa, StressPathTest, one_row
from graincal.positions import POSITION, first_way, positions, stresses_at

STEPS_BETWEEN_STRESSES = 300.0
"""From one stress at rest to the next, whatever the modulus: stiff grains take shorter steps, and are strained less. On a packing of 500, by the linear law, within
a factor of three for moduli of 500 to 5·10^7 confining pressures."""


@dataclass(frozen=True, eq=False, repr=False)
class CompressionTest(StressPathTest):
    """A path that can be driven by one stress, and then also by its position: how far that stress has gone, as the sum of |Δ ln σ| from the confining pressure.

    turns: Pa, with control "position": the stresses at which the path turns around, in order. It goes from the confining pressure to the first of them, upwards
    where there are none, and on without bound after the last.
    """

    turns: Sequence[float] = field(default=(), kw_only=True)

    stress: ClassVar[str]
    """The stress that positions are of."""

    def __post_init__(self) -> None:
        super().__post_init__()
        turns = self._checked_turns()
        object.__setattr__(self, "turns", turns)
        if turns and self.control != POSITION:
            raise InputError(
                f'turns are those of a path whose control is {POSITION}, and this one\'s is {self.control}: write control = "{POSITION}", or leave them out.'
            )
        before, way = float(self.confining_pressure), first_way(1.0, self.turns_in_units)
        for number, (turn, ratio, ratio_before) in enumerate(zip(turns, self.turns_in_units, (1.0, *self.turns_in_units)), start=1):
            if way * (ratio - ratio_before) <= 0:
                beyond = "above" if way > 0 else "below"
                where = f"the confining pressure, {before:g} Pa" if number == 1 else f"the one before it, {before:g} Pa"
                raise InputError(f"turns: the path turns around at each of them, so number {number} was expected {beyond} {where}, and it is {turn:g} Pa.")
            before, way = turn, -way

    def _checked_turns(self) -> tuple[float, ...]:
        given = self.turns
        listed = isinstance(given, Sequence | np.ndarray) and not isinstance(given, str)
        if not listed or not all(isinstance(turn, Real) and not isinstance(turn, bool) and np.isfinite(turn) and turn > 0 for turn in given):
            raise InputError(f"turns must be a list of positive numbers (in Pa), not {given!r}.")
        for turn in given:
            if wrong := impossible_pressure("a turn", turn):
                raise InputError(wrong)
        return tuple(float(turn) for turn in given)

    @property
    def turns_in_units(self) -> tuple[float, ...]:
        """The turns in units of the confining pressure: of proportional tests the same to the last digit."""
        return tuple(in_units_of(self.confining_pressure, self.turns).tolist())

    @property
    def turns_in_words(self) -> str:
        """Where the path turns around."""
        return f"turns around at {', '.join(f'{turn / 1e3:g}' for turn in self.turns)} kPa of {self.stress.replace('_', ' ')}" if self.turns else ""

    @property
    def returned(self) -> tuple[str, ...]:
        """The names of what a response holds: a position is its control alone, which no state can miss."""
        return tuple(name for name in super().returned if name != POSITION)

    @property
    def driven_by_stress(self) -> bool:
        """Whether its rests are stresses, and not strains."""
        return self.control in (self.stress, POSITION)

    @property
    def steps_exponent(self) -> float:
        """The steps of a run grow with this power of the modulus."""
        return 0.0 if self.driven_by_stress else super().steps_exponent

    def steps_between_rests(self, moduli: NDArray[np.float64]) -> NDArray[np.float64]:
        """About how many steps there are from one rest to the next, for moduli in units of the confining pressure (N,)."""
        return np.full(len(moduli), STEPS_BETWEEN_STRESSES) if self.driven_by_stress else super().steps_between_rests(moduli)

    def stress_at(self, position: ArrayLike) -> NDArray[np.float64]:
        """The stress that drives the path, in Pa, at positions (...)."""
        return self.confining_pressure * stresses_at(position, 1.0, self.turns_in_units)

    def states(self, at: ArrayLike) -> NDArray[np.float64]:
        """The control values (S,) at which the test rests; positions are those of the rests of the path, whatever is asked for, up to the first that is not before the last of `at` (T,)."""
        if self.control != POSITION:
            return super().states(at)
        asked = one_row(at)
        if asked is None or asked[0] < 0 or np.any(np.diff(asked) <= 0):
            raise InputError(f"values of {POSITION} must be one increasing row of numbers, not below 0, at least one.")
        if wrong := impossible_pressure(f"{self.stress} at position {asked[-1]:g}", float(self.stress_at(asked[-1]))):
            raise InputError(wrong)
        return positions_at_rest(asked[-1], self.turns_in_units)

    def driving_stresses(self, confining_pressure: float, at: NDArray[np.float64]) -> NDArray[np.float64]:
        """The stresses to drive to for the control values (S,), in the unit of the confining pressure."""
        return confining_pressure * in_units_of(1.0, stresses_at(at, 1.0, self.turns_in_units)) if self.control == POSITION else at

    def response(self, control: NDArray[np.float64], values: Mapping[str, NDArray[np.float64]], details: Mapping[str, float]) -> Response:
        """As of any test; over positions it says where its path turns around."""
        response = super().response(control, values, details)
        return replace(response, turns=tuple(positions(self.turns_in_units, 1.0).tolist())) if self.control == POSITION else response

    def abscissa(self, at: NDArray[np.float64]) -> Abscissa:
        """What curves are drawn over: the logarithm of the stress for positions, which nobody reads off an axis."""
        return Abscissa(self.stress, self.stress_at(at), logarithmic=True) if self.control == POSITION else super().abscissa(at)
