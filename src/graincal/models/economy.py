"""What a stress path test may do to take fewer steps, and how its density scaling follows from an inertial number (docs/fewer-steps.md)."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Real
from typing import Any

import numpy as np

from graincal import _native
from graincal.data import InputError
from graincal.dem.packing import Packing
from graincal.dem.stress_path import AXIAL_RATE
from graincal.suggestion import did_you_mean

DENSITY = 2650.0
"""Density of quartz grains, kg/m^3, before scaling."""

TIME_STEP_BOUNDS = ("grain", "contact")


@dataclass(frozen=True, eq=False, kw_only=True)
class Economy:
    """Options of a stress path test that trade the paper's protocol for fewer steps; by default it is the paper's.

    time_step_bound: "grain", from the stiffness about each grain alone as YADE's, or "contact", from both grains of each contact and the damping.
    mass_exponent: grains' masses go with this power of the radius, the sample's mass unchanged: 3 for grains of one density; at 1 small grains do not limit
    the time step. inertia_factor: on the grains' moments of inertia. settling_damping: of the motion, once every axis has arrived at its strain or stress.
    strain_ramp: the share of each strain increment over which its rate rises, and over which it falls again, from 0 to 0.5.
    """

    time_step_bound: str = "grain"
    mass_exponent: float = 3.0
    inertia_factor: float = 1.0
    settling_damping: float = 0.2
    strain_ramp: float = 0.0

    @property
    def economy(self) -> _native.Economy:
        """The options as the engine has them."""
        numbers = {name: float(getattr(self, name)) for name in _NUMBERS}
        return _native.Economy(shared_bound=self.time_step_bound == "contact", **numbers)

    @property
    def economies(self) -> dict[str, Any]:
        """The options that are not the paper's protocol, with their values."""
        options = {"time_step_bound": self.time_step_bound} | {name: float(getattr(self, name)) for name in _NUMBERS}
        return {name: value for name, value in options.items() if value != getattr(Economy, name)}

    def check_economy(self) -> None:
        """Raise InputError for an option that means nothing."""
        if self.time_step_bound not in TIME_STEP_BOUNDS:
            raise InputError(f"time_step_bound must be {' or '.join(map(repr, TIME_STEP_BOUNDS))}, not {self.time_step_bound!r}{did_you_mean(self.time_step_bound, TIME_STEP_BOUNDS)}.")
        for name, (fits, words) in _NUMBERS.items():
            value = getattr(self, name)
            if not (isinstance(value, Real) and np.isfinite(value) and fits(value)):
                raise InputError(f"{name} must be a number {words}, not {value!r}.")


_NUMBERS = {
    "mass_exponent": (lambda value: 0 <= value <= 3, "from 0 to 3"),
    "inertia_factor": (lambda value: value > 0, "above 0"),
    "settling_damping": (lambda value: 0 < value < 1, "between 0 and 1"),
    "strain_ramp": (lambda value: 0 <= value <= 0.5, "from 0 to 0.5"),
}


def inertial_number(packing: Packing, pressure: float, density_scaling: float) -> float:
    """I = ε̇ d sqrt(ρ / p): how far from quasi-static axial loading is. d is the mean diameter of the grains; pressure in Pa."""
    return AXIAL_RATE * 2 * packing.radii.mean() * np.sqrt(DENSITY * density_scaling / pressure)


def density_scaling_of(packing: Packing, pressure: float, inertial: float) -> float:
    """The density scaling at which axial loading has this inertial number: p (I / (ε̇ d))² / ρ."""
    return pressure * (inertial / (AXIAL_RATE * 2 * packing.radii.mean())) ** 2 / DENSITY
