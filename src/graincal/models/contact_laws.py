"""The contact laws with their parameters: declared here, and nowhere else. The command line, the keys of a calibration file, checks and documents follow from it (docs/contact-laws.md)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graincal import _native
from graincal.data import InputError, ParameterSpace
from graincal.models.plausibility import POSSIBLE_LOG_MODULI, modulus_itself, unusual_angle, unusual_log_modulus
from graincal.models.proportion import for_engine

_NO_UNIT = ("-", "1")
MODULUS, ANGLE = ("log10 Pa", "log10(Pa)", "log10 [Pa]", "log Pa", "log(Pa)"), ("deg", "°", "degree", "degrees")


@dataclass(frozen=True)
class ContactParameter:
    """A parameter of a contact law: what it is, the bounds between which it means something, the upper one excluded, and how its unit may be written, the usual way first."""

    name: str
    meaning: str
    low: float
    high: float
    units: tuple[str, ...] = _NO_UNIT

    def excludes(self, value: float) -> bool:
        """Whether a value means nothing."""
        return not (np.isfinite(value) and self.low <= value < self.high)

    @property
    def limits(self) -> str:
        """The bounds, in words."""
        return " and ".join([f"at least {self.low:g}"] * bool(np.isfinite(self.low)) + [f"below {self.high:g}"] * bool(np.isfinite(self.high)))

    def meant(self, *values: Any) -> str:
        """How to write what was probably meant by values outside the bounds."""
        return modulus_itself(*values) if self.units == MODULUS and all(isinstance(value, Real) for value in values) else ""

    def unusual(self, place: str, *values: float) -> str | None:
        """What is to be said of values, or of the ends of a range, that another unit was probably meant for; None for others."""
        return unusual_log_modulus(place, *values) if self.units == MODULUS else unusual_angle(place, *values) if self.units == ANGLE else None


@dataclass(frozen=True)
class ContactLaw:
    """A contact law by the name that `law` chooses it by, with its parameters in the order of theta.

    steps_exponent: the steps of a run grow with this power of the modulus. engine: makes the engine's law of a modulus in the engine's unit, a ratio, a coefficient of friction, and a rolling stiffness and strength.
    """

    name: str
    said: str
    parameters: tuple[ContactParameter, ...]
    steps_exponent: float
    engine: Callable[[float, float, float, float, float], _native.LinearLaw | _native.HertzLaw]

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters."""
        return tuple(parameter.name for parameter in self.parameters)

    def parameter(self, name: str) -> ContactParameter:
        """That of this name."""
        return self.parameters[self.names.index(name)]

    def of(self, theta: NDArray[np.float64], unit_of_stress: float) -> _native.LinearLaw | _native.HertzLaw:
        """The engine's law of parameters (5,), where a stress of the engine is so many Pa of the test."""
        log_modulus, ratio, friction_angle, rolling_stiffness, rolling_strength = theta
        return self.engine(float(for_engine(10.0**log_modulus, unit_of_stress)), ratio, np.tan(np.radians(friction_angle)), rolling_stiffness, rolling_strength)


_LINEAR = (
    ContactParameter("log_E", "log10 of the contact modulus E", *POSSIBLE_LOG_MODULI, MODULUS),
    ContactParameter("nu", "stiffness ratio ν = kₛ/kₙ", 0.0, np.inf),
    ContactParameter("phi", "inter-particle friction angle φ", 0.0, 90.0, ANGLE),
    ContactParameter("beta_m", "rolling stiffness β", 0.0, np.inf),
    ContactParameter("eta_m", "rolling strength η", 0.0, np.inf),
)
"""Hartmann, Cheng, Thornton (2022), Table 1."""

_HERTZ = (
    replace(_LINEAR[0], meaning="log10 of Young's modulus E of the grains"),
    replace(_LINEAR[1], meaning="Poisson's ratio ν of the grains", high=0.5),
    *_LINEAR[2:],
)

LAWS = {
    law.name: law
    for law in (
        ContactLaw("linear", "that of Hartmann, Cheng, Thornton (2022)", _LINEAR, 1 / 2, _native.LinearLaw),
        # The stiffness of a Hertz contact under a given force goes with the modulus to the power 2/3.
        ContactLaw("hertz-mindlin", "of elastic spheres, which are stiffer under pressure", _HERTZ, 1 / 3, _native.HertzLaw),
    )
}
"""The contact laws by name."""

DEFAULT_LAW = next(iter(LAWS))


def unusual_parameters(values: Mapping[str, tuple[float, ...]]) -> list[str]:
    """What is to be said of values or ends of ranges that another unit was probably meant for, each by the parameter's name with its place before it."""
    known = {parameter.name: parameter for law in LAWS.values() for parameter in law.parameters}
    said = [known[name].unusual(place, *given) for place, given in values.items() if (name := place.rpartition(".")[2]) in known]
    return [doubt for doubt in said if doubt]


def check_units(space: ParameterSpace, law: str) -> None:
    """Raise InputError for a unit that a parameter of the contact law does not have: values are never converted."""
    for name, unit in (*zip(space.names, space.units), *space.units_of_fixed.items()):
        if name in LAWS[law].names and unit and unit not in (known := LAWS[law].parameter(name).units):
            raise InputError(
                f'parameters.{name}.unit must be "{known[0]}" or left out, in which the contact law takes {name}, not "{unit}": nothing is converted, so write the {"value" if name in space.fixed else "range"} in that unit.'
            )


def check_ranges(space: ParameterSpace, law: str) -> None:
    """Raise InputError for a range in which the contact law does not mean something throughout, and for such a value of a parameter that is fixed."""
    for name, value in space.fixed.items():
        if name in LAWS[law].names and (parameter := LAWS[law].parameter(name)).excludes(value):
            raise InputError(f"parameters.{name}.fixed must be a number {parameter.limits}, {_where(law, parameter)}, not {value:g}{parameter.meant(value)}.")
    for name, low, high in zip(space.names, space.low, space.high):
        if name not in LAWS[law].names:
            continue
        parameter = LAWS[law].parameter(name)
        if parameter.excludes(low) or parameter.excludes(high):
            why = ", the log10 of the modulus in Pa" if parameter.units == MODULUS else f", {_where(law, parameter)}"
            raise InputError(f"parameters.{name}.range must hold numbers {parameter.limits}{why}, not [{low:g}, {high:g}]{parameter.meant(low, high)}.")


def _where(law: str, parameter: ContactParameter) -> str:
    """Why a parameter has these bounds: where they are of one law alone, which one that is, and what the parameter is in it."""
    if all(each.parameter(parameter.name).limits == parameter.limits for each in LAWS.values()):
        return "where the contact law means something"
    return f'where the contact law "{law}" means something ({parameter.name} is {parameter.meaning} there)'
