"""The five parameters of a contact law: their units, where they mean something, and how to say that values do not."""

from __future__ import annotations

from collections.abc import Mapping
from numbers import Real
from typing import Any

import numpy as np

from graincal.data import InputError, ParameterSpace
from graincal.models.plausibility import POSSIBLE_LOG_MODULI, modulus_itself, unusual_angle, unusual_log_modulus

PARAMETERS = ("log_E", "nu", "phi", "beta_m", "eta_m")
"""Hartmann, Cheng, Thornton (2022), Table 1: log10 of the modulus in Pa, stiffness ratio, friction angle in degrees, rolling stiffness and strength.
With the law "hertz-mindlin", the modulus and Poisson's ratio are those of the grains."""

UNITS = {"log_E": ("log10 Pa", "log10(Pa)", "log10 [Pa]", "log Pa", "log(Pa)"), "phi": ("deg", "°", "degree", "degrees")}
"""How the unit of a parameter may be written, the usual way first; those that do not stand here are plain numbers."""
_NO_UNIT = ("-", "1")

_LINEAR_BOUNDS = {"log_E": POSSIBLE_LOG_MODULI, "nu": (0.0, np.inf), "phi": (0.0, 90.0), "beta_m": (0.0, np.inf), "eta_m": (0.0, np.inf)}
_BOUNDS = {"linear": _LINEAR_BOUNDS, "hertz-mindlin": _LINEAR_BOUNDS | {"nu": (0.0, 0.5)}}
"""Where each contact law means something; each parameter below its upper bound."""


def outside(name: str, value: float, law: str) -> bool:
    """Whether a value of that parameter means nothing to the contact law."""
    low, high = _BOUNDS[law][name]
    return not (np.isfinite(value) and low <= value < high)


def meant(name: str, *values: Any) -> str:
    """How to write what was probably meant by values outside the bounds."""
    return modulus_itself(*values) if name == "log_E" and all(isinstance(value, Real) for value in values) else ""


def limits_of(name: str, law: str) -> str:
    """The bounds of a parameter, in words."""
    low, high = _BOUNDS[law][name]
    limits = [f"at least {low:g}"] * bool(np.isfinite(low)) + [f"below {high:g}"] * bool(np.isfinite(high))
    return " and ".join(limits)


def unusual_parameters(values: Mapping[str, tuple[float, ...]]) -> list[str]:
    """What is to be said of values or ends of ranges that another unit was probably meant for, each by the parameter's name with its place before it."""
    said = []
    for place, given in values.items():
        name = place.rpartition(".")[2]
        said += [unusual_log_modulus(place, *given)] if name == "log_E" else [unusual_angle(place, *given)] if name == "phi" else []
    return [doubt for doubt in said if doubt]


def check_units(space: ParameterSpace) -> None:
    """Raise InputError for a unit that a contact parameter does not have: values are never converted."""
    for name, unit in (*zip(space.names, space.units), *space.units_of_fixed.items()):
        known = UNITS.get(name, _NO_UNIT)
        if name in PARAMETERS and unit and unit not in known:
            raise InputError(
                f'parameters.{name}.unit must be "{known[0]}" or left out, in which the contact law takes {name}, not "{unit}": nothing is converted, so write the {"value" if name in space.fixed else "range"} in that unit.'
            )


def check_ranges(space: ParameterSpace, law: str) -> None:
    """Raise InputError for a range in which the contact law does not mean something throughout, and for such a value of a parameter that is fixed."""
    for name, value in space.fixed.items():
        if name in PARAMETERS and outside(name, value, law):
            raise InputError(f"parameters.{name}.fixed must be {limits_of(name, law)}, where the contact law means something, not {value:g}{meant(name, value)}.")
    for name, low, high in zip(space.names, space.low, space.high):
        if name not in PARAMETERS:
            continue
        place, limits = f"parameters.{name}.range must hold numbers", f"[{low:g}, {high:g}]"
        if name == "log_E" and (outside(name, low, law) or outside(name, high, law)):
            raise InputError(f"{place} {limits_of(name, law)}, the log10 of the modulus in Pa, not {limits}{meant(name, low, high)}.")
        if outside(name, low, law) or outside(name, high, law):
            raise InputError(f"{place} {limits_of(name, law)}, where the contact law means something, not {limits}.")
