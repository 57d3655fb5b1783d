"""Laboratory tests in closed form: what is true, before anything is written.

| family | path | equations (x: axial strain, without sign) |
|---|---|---|
| drained dense | lateral stress constant | R = 1 + 2.2 x/(x + 0.004) + b (x/0.05) exp(1 - x/0.05); contraction, then dilation |
| drained loose | lateral stress constant | R = 1 + a x/(x + 0.02); contraction alone |
| drained extension | lateral stress constant | R = 1 - a x/(x + 0.004), down to about 0.35; contraction, then dilation |
| undrained contractive | volume constant | lateral = p0 (1 - 0.6 (1 - exp(-x/0.01))); R = 1 + 1.7 x/(x + 0.004) |
| undrained dilative | volume constant | lateral falls by a third and then rises; R = 1 + 1.9 x/(x + 0.006) |
| undrained extension | volume constant | lateral falls; R = 1 - 0.6 x/(x + 0.006) |
| constant mean stress | (axial + 2 lateral)/3 constant | q = p 1.3 x/(x + 0.005); contraction, then dilation |
| oedometer | no lateral strain | e = e0 - Cc log10(s/s0) on first loading, e + Cs log10 on unloading and reloading |
| isotropic | three equal stresses | the same over the mean stress, as a cycle or one way |

Stresses are effective, in Pa; strains logarithmic, fractions; compression and contraction positive, for all that is here.

    R = axial/lateral          q = axial - lateral         p' = (axial + 2 lateral)/3
    s' = (axial + lateral)/2   t = (axial - lateral)/2     total stress = effective stress + u
    volumetric = axial + 2 radial strain                   e = (1 + e0) exp(-volumetric) - 1         n = e/(1 + e)
    engineering strain = 1 - exp(-logarithmic strain), of lengths and of volumes alike

Of a test without change of volume u = back pressure + excess, with excess = p0 - lateral: the total lateral stress is constant.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DRAINED = ("drained dense", "drained loose", "drained extension")
UNDRAINED = ("undrained contractive", "undrained dilative", "undrained extension")
COMPRESSION_LINES = ("oedometer", "isotropic cycle", "isotropic one way")
FAMILIES = (*DRAINED, *UNDRAINED, "constant mean stress", *COMPRESSION_LINES)
STRAIN = np.array([0, 0.0004, 0.0011, 0.002, 0.0035, 0.005, 0.008, 0.012, 0.018, 0.026, 0.036, 0.05, 0.066, 0.084, 0.104, 0.126, 0.15, 0.175, 0.2, 0.22])


@dataclass(frozen=True)
class Truth:
    """One test, state by state; `void_ratio` is measured from `initial_void_ratio`, that of the first state."""

    family: str
    axial_strain: Array
    volumetric_strain: Array
    axial_stress: Array
    lateral_stress: Array
    pore_pressure: Array
    initial_void_ratio: float
    pressure: float
    """Before shearing, effective."""
    back_pressure: float

    @property
    def kind(self) -> str:
        if self.family in DRAINED:
            return "triaxial"
        if self.family in UNDRAINED:
            return "undrained"
        return {"oedometer": "oedometric", "constant mean stress": "constant-mean-stress"}.get(self.family, "isotropic")

    @property
    def extends(self) -> bool:
        return self.family.endswith("extension")

    @property
    def has_pressure(self) -> bool:
        return self.family not in COMPRESSION_LINES

    def of(self, quantity: str) -> Array:
        """The quantity at every state, as the table above defines it."""
        return QUANTITIES[quantity](self) if quantity in QUANTITIES else getattr(self, quantity)


QUANTITIES: dict[str, Callable[[Truth], Array]] = {
    "radial_strain": lambda test: (test.volumetric_strain - test.axial_strain) / 2,
    "deviator_stress": lambda test: test.axial_stress - test.lateral_stress,
    "mean_stress": lambda test: (test.axial_stress + 2 * test.lateral_stress) / 3,
    "s": lambda test: (test.axial_stress + test.lateral_stress) / 2,
    "t": lambda test: (test.axial_stress - test.lateral_stress) / 2,
    "stress_ratio": lambda test: test.axial_stress / test.lateral_stress,
    "deviator_to_mean_stress": lambda test: test.of("deviator_stress") / test.of("mean_stress"),
    "total_axial_stress": lambda test: test.axial_stress + test.pore_pressure,
    "total_lateral_stress": lambda test: test.lateral_stress + test.pore_pressure,
    "excess_pore_pressure": lambda test: test.pore_pressure - test.pore_pressure[0],
    "void_ratio": lambda test: (1 + test.initial_void_ratio) * np.exp(-test.volumetric_strain) - 1,
    "porosity": lambda test: 1 - 1 / (1 + test.of("void_ratio")),
}


def truth(family: str, rng: random.Random, pressure: float | None = None) -> Truth:
    """A test of the family; what the equations leave open is drawn."""
    pressure = pressure or rng.choice([50e3, 80e3, 100e3, 150e3, 200e3, 300e3, 400e3])
    if family in COMPRESSION_LINES:
        return _compression_line(family, rng)
    x = STRAIN[: rng.randint(15, len(STRAIN))]
    axial_strain = -x if family.endswith("extension") else x
    if family in UNDRAINED:
        return _undrained(family, x, axial_strain, pressure, rng)
    volumetric = _volume(family, x, rng)
    void_ratio = 0.8 if family == "drained loose" else 0.68
    if family == "constant mean stress":
        q = pressure * rng.uniform(1.2, 1.4) * x / (x + 0.005)
        axial, lateral = pressure + 2 / 3 * q, pressure - q / 3
    else:
        lateral = np.full_like(x, pressure)
        axial = lateral * _drained_ratio(family, x, rng)
    back = rng.choice([100e3, 200e3, 300e3, 400e3])
    return Truth(family, axial_strain, volumetric, axial, lateral, np.full_like(x, back), void_ratio, pressure, back)


def _drained_ratio(family: str, x: Array, rng: random.Random) -> Array:
    if family == "drained dense":
        return 1 + 2.2 * x / (x + 0.004) + rng.uniform(0.6, 0.9) * (x / 0.05) * np.exp(1 - x / 0.05)
    if family == "drained loose":
        return 1 + rng.uniform(1.7, 2.3) * x / (x + 0.02)
    return 1 - rng.uniform(0.6, 0.68) * x / (x + 0.004)


def _volume(family: str, x: Array, rng: random.Random) -> Array:
    if family == "drained loose":
        return rng.uniform(0.03, 0.045) * (1 - np.exp(-x / 0.06))
    return 0.3 * x * np.exp(-x / 0.01) - rng.uniform(0.03, 0.05) * (1 - np.exp(-((x / 0.09) ** 2)))


def _undrained(family: str, x: Array, axial_strain: Array, pressure: float, rng: random.Random) -> Truth:
    fall = 1 - np.exp(-x / 0.004)
    rise = x / (x + 0.05)
    lateral, ratio = {
        "undrained contractive": (1 - 0.6 * (1 - np.exp(-x / 0.01)), 1 + rng.uniform(1.5, 1.9) * x / (x + 0.004)),
        "undrained dilative": (1 - 0.35 * fall + rng.uniform(0.9, 1.4) * rise, 1 + rng.uniform(1.7, 2.1) * x / (x + 0.006)),
        "undrained extension": (1 - 0.2 * fall, 1 - rng.uniform(0.55, 0.65) * x / (x + 0.006)),
    }[family]
    back = rng.choice([200e3, 300e3, 400e3])
    return Truth(family, axial_strain, np.zeros_like(x), pressure * lateral * ratio, pressure * lateral, back + pressure * (1 - lateral), 0.68, pressure, back)


def _compression_line(family: str, rng: random.Random) -> Truth:
    up = np.array([10, 20, 40, 80, 160, 320.0])
    stress = up * 2 if family == "isotropic one way" else np.concatenate([up, up[-2:0:-1], up[2:], [640.0, 1280.0]])
    stress = stress * 1e3 * rng.choice([0.5, 1, 2])
    cc, cs = rng.uniform(0.04, 0.08), rng.uniform(0.006, 0.01)
    largest = np.maximum.accumulate(stress)
    void_ratio = 0.8 - cc * np.log10(largest / stress[0]) + cs * np.log10(largest / stress)
    volumetric = -np.log((1 + void_ratio) / 1.8)
    axial_strain = volumetric if family == "oedometer" else volumetric / 3
    lateral = 0.45 * stress if family == "oedometer" else stress
    return Truth(family, axial_strain, volumetric, stress, lateral, np.zeros_like(stress), 0.8, float(stress[0]), 0.0)


def with_stages(test: Truth, from_zero: bool) -> tuple[Truth, list[int]]:
    """The test behind a saturation and a consolidation, and the number of each row's stage; `from_zero`: each stage counts its strains anew."""
    up, on = np.linspace(0.1, 1, 6), np.linspace(0, 1, 7)
    axial = [-0.0002 * up, 0.008 * on, test.axial_strain]
    volumetric = [-0.0004 * up, 0.015 * on, test.volumetric_strain]
    if not from_zero:
        axial, volumetric = [_one_after_another(parts) for parts in (axial, volumetric)]
    lateral = [np.full(6, 10e3), 10e3 + (test.pressure - 10e3) * on, test.lateral_stress]
    deviator = [np.full(6, 1e3), 2e3 * (1 - on) ** 0.5, test.of("deviator_stress")]
    pore = [test.back_pressure * up, np.full(7, test.back_pressure), test.pore_pressure]
    joined = [np.concatenate(parts) for parts in (axial, volumetric, lateral, deviator, pore)]
    whole = replace(
        test, axial_strain=joined[0], volumetric_strain=joined[1], axial_stress=joined[2] + joined[3], lateral_stress=joined[2], pore_pressure=joined[4]
    )
    return whole, [1] * 6 + [2] * 7 + [3] * len(test.axial_strain)


def _one_after_another(parts: list[Array]) -> list[Array]:
    ends = np.cumsum([0.0] + [part[-1] for part in parts[:-1]])
    return [part + end for part, end in zip(parts, ends, strict=True)]
