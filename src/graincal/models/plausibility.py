"""Pressures and moduli that are impossible, or so unusual that another unit was probably meant."""

from __future__ import annotations

import math

POSSIBLE_PRESSURES = (1.0, 1e12)
"""Pa. A grain of sand weighs more on its own cross section than the lower; no solid is as stiff as the upper."""
USUAL_PRESSURES = (1e3, 1e8)
"""Pa. Below is the weight of some centimetres of soil; above, grains are crushed."""
POSSIBLE_LOG_MODULI = (0.0, 20.0)
"""log10 Pa. No solid comes near 10^12 Pa, and a modulus of 1 Pa is none: beyond is the modulus itself, or its log10 in another unit."""
USUAL_LOG_MODULI = (6.0, 12.0)
"""log10 Pa, from rubber to diamond."""


def impossible_pressure(name: str, pressure: float) -> str | None:
    """What is wrong with a positive pressure (Pa) that no test has; None for one that is possible."""
    low, high = POSSIBLE_PRESSURES
    if low <= pressure <= high:
        return None
    return f"{name} is {pressure:g} Pa, and {low:g} to {high:g} Pa was expected{_other_unit(pressure)}."


def unusual_pressure(name: str, pressure: float) -> str | None:
    """What is to be said of a pressure (Pa) that few tests have; None for a usual one."""
    low, high = USUAL_PRESSURES
    if low <= pressure <= high:
        return None
    return f"{name} is {pressure:g} Pa, and tests are made at {low:g} to {high:g} Pa{_other_unit(pressure)}."


def unusual_log_modulus(name: str, *values: float) -> str | None:
    """What is to be said of log10 moduli (Pa), a value or the ends of a range, that few solids have; None for usual ones, and for those
    that are impossible and refused."""
    low, high = USUAL_LOG_MODULI
    if all(low <= value <= high for value in values) or not all(POSSIBLE_LOG_MODULI[0] <= value < POSSIBLE_LOG_MODULI[1] for value in values):
        return None
    moduli = " to ".join(f"{10.0**value:.3g}" for value in values)
    return f"{name} = {' to '.join(f'{value:g}' for value in values)} is a modulus of {moduli} Pa, and {10**low:.0e} to {10**high:.0e} Pa is usual ({low:g} to {high:g})."


def unusual_angle(name: str, *values: float) -> str | None:
    """What is to be said of angles in degrees, a value or the ends of a range, that were probably meant in radians; None for others."""
    if not 0 < max(values) <= math.pi / 2:
        return None
    shown, degrees = (" to ".join(f"{factor * value:.4g}" for value in values) for factor in (1, 180 / math.pi))
    return f"{name} = {shown} is in degrees; if {shown} rad is meant, write {degrees}."


def modulus_itself(*values: float) -> str:
    """How to write what is probably the modulus (Pa) and not its log10; nothing for what can be none."""
    if not all(value >= POSSIBLE_LOG_MODULI[1] for value in values):
        return ""
    moduli, logarithms = " to ".join(f"{value:g}" for value in values), ", ".join(f"{math.log10(value):.4g}" for value in values)
    return f"; for a modulus of {moduli} Pa write {logarithms if len(values) == 1 else f'[{logarithms}]'}"


def _other_unit(pressure: float) -> str:
    """The unit in which the number would be usual."""
    meant = {"MPa": 1e6, "kPa": 1e3} if pressure < 1 else {"kPa": 1e3, "MPa": 1e6} if pressure < USUAL_PRESSURES[0] else {}
    usual = [(unit, pressure * factor) for unit, factor in meant.items() if USUAL_PRESSURES[0] <= pressure * factor <= USUAL_PRESSURES[1]]
    return f"; if {pressure:g} {usual[0][0]} is meant, write {usual[0][1]:g}" if usual else ""
