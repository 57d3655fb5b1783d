"""What a stress path test may do to take less time, and how its density scaling follows from an inertial number (docs/fewer-steps.md)."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Real
from typing import Any, Literal

import numpy as np

from graincal import _native
from graincal.data import InputError
from graincal.dem.packing import Packing
from graincal.dem.stress_path import AXIAL_RATE
from graincal.suggestion import did_you_mean

DENSITY = 2650.0
"""Density of quartz grains, kg/m^3, before scaling."""

TIME_STEP_BOUNDS = ("grain", "contact")

PRECISIONS = ("float64", "float32")
"""Of forces, velocities, the contacts' memory and the sums over one particle's contacts. Positions and what is found from them alone are float64 in
either, and so are sums over a packing, but for blocks of up to 64 pairs of which the stress is made."""

Accuracy = Literal["standard", "reference"]

ACCURACIES: dict[Accuracy, dict[str, Any]] = {
    "standard": {"time_step_bound": "contact", "mass_exponent": 1.0, "precision": "float32"},
    "reference": {"time_step_bound": "grain", "mass_exponent": 3.0, "precision": "float64"},
}
"""What each accuracy stands for, the default first. Their mean curves cannot be told apart (docs/fewer-steps.md)."""

INERTIAL_NUMBER = 1.36e-3
"""Of axial loading, at every confining pressure: that of the density scaling of 1,000 in Hartmann, Cheng, Thornton (2022), at 0.5 MPa on their packing of 1,000
particles (docs/density-scaling.md)."""

INERTIAL_NUMBERS = (1e-6, 0.1)
"""Those of a test that can be run and is still one of a packing at rest. At the lower a test takes a thousand times the steps of the default."""

QUASI_STATIC = 3e-3
"""Above this inertial number stresses are those of the grains' inertia too (docs/density-scaling.md)."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Economy:
    """Options of a stress path test that trade the paper's protocol for a shorter run.

    accuracy: "standard", or "reference", the protocol of the paper step by step as YADE's: it stands for the next three, each of which may be set by itself.
    time_step_bound: "grain", from the stiffness about each grain alone as YADE's, or "contact", from both grains of each contact and the damping.
    mass_exponent: grains' masses go with this power of the radius, the sample's mass unchanged: 3 for grains of one density; at 1 small grains do not limit
    the time step. precision: "float64" or "float32", in which forces, velocities and the contacts' memory are computed; positions and overlaps are float64 in either.
    inertia_factor: on the grains' moments of inertia. settling_damping: of the motion, once every axis has arrived at its strain or stress.
    strain_ramp: the share of each strain increment over which its rate rises, and over which it falls again, from 0 to 0.5.
    """

    accuracy: Accuracy = next(iter(ACCURACIES))
    time_step_bound: str | None = None
    mass_exponent: float | None = None
    precision: str | None = None
    inertia_factor: float = 1.0
    settling_damping: float = 0.2
    strain_ramp: float = 0.0

    def setting(self, name: str) -> Any:
        """An option as it is in effect: as it was given, or else as the accuracy has it."""
        given = getattr(self, name)
        return ACCURACIES[self.accuracy][name] if given is None else given

    @property
    def settings(self) -> dict[str, Any]:
        """All options but the accuracy, as they are in effect."""
        return {name: self.setting(name) for name in ("time_step_bound", "precision")} | {name: float(self.setting(name)) for name in _NUMBERS}

    @property
    def economies(self) -> dict[str, Any]:
        """The fewest options that say what is in effect, with their values: the accuracy, unless it is the default, and what departs from it."""
        settings = self.settings
        others = {name: value for name, value in settings.items() if name not in ACCURACIES[self.accuracy] and value != getattr(Economy, name)}
        candidates = []
        for accuracy, stands_for in ACCURACIES.items():
            said = {} if accuracy == Economy.accuracy else {"accuracy": accuracy}
            said |= {name: settings[name] for name, value in stands_for.items() if settings[name] != value}
            candidates.append(said)
        return min(candidates, key=len) | others

    @property
    def economy(self) -> _native.Economy:
        """The options as the engine has them."""
        numbers = {name: float(self.setting(name)) for name in _NUMBERS}
        return _native.Economy(shared_bound=self.setting("time_step_bound") == "contact", **numbers)

    def check_economy(self) -> None:
        """Raise InputError for an option that means nothing."""
        for name, choices in {"accuracy": tuple(ACCURACIES), "time_step_bound": TIME_STEP_BOUNDS, "precision": PRECISIONS}.items():
            value = getattr(self, name)
            if value not in choices and not (value is None and name != "accuracy"):
                raise InputError(f"{name} must be {' or '.join(map(repr, choices))}, not {value!r}{did_you_mean(value, choices)}.")
        for name, (fits, words) in _NUMBERS.items():
            value = self.setting(name)
            if not (isinstance(value, Real) and np.isfinite(float(value)) and fits(value)):
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
