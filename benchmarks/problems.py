"""Calibration problems in closed form: five parameters over the paper's ranges, curves that look like laboratory tests, evaluations that cost nothing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import graincal as gc

SPACE = gc.ParameterSpace.paper()
STRAIN = np.linspace(0, 0.2, 51)[1:]

# A truth lies in this inner part of each range.
INNER = 0.7


@dataclass(frozen=True)
class Problem:
    """curves: theta (N, 5) to responses (N, T, J) of the named observables, at STRAIN (T,)."""

    name: str
    observables: tuple[str, ...]
    curves: Callable[[NDArray[np.float64]], NDArray[np.float64]]

    def truth(self, seed: int) -> NDArray[np.float64]:
        """The parameters (5,) behind the reference of that seed."""
        return SPACE.from_unit(0.5 + INNER * (np.random.default_rng([seed, 0]).random(SPACE.size) - 0.5))

    def reference(self, seed: int, noise: float = 0.0) -> gc.Reference:
        """The curves of that seed's truth, and independent errors of this part of each peak, which the reference then states."""
        values = self.curves(self.truth(seed)[None])[0]
        deviations = noise * np.abs(values).max(axis=0)
        values = values + deviations * np.random.default_rng([seed, 1]).standard_normal(values.shape)
        errors = dict(zip(self.observables, deviations.tolist())) if noise else None
        return gc.Reference(STRAIN, dict(zip(self.observables, values.T)), measurement_errors=errors)


def _unit(theta: NDArray[np.float64]) -> NDArray[np.float64]:
    """The parameters on the unit cube, each (N, 1), to be set against strains."""
    return SPACE.to_unit(theta).T[:, :, None]


def monotone(theta: NDArray[np.float64]) -> NDArray[np.float64]:
    """A stress ratio that rises to a limit, and hardens from there: stiffness over two decades, limit, sharpness of the bend, hardening."""
    stiffness, sharpness, friction, rolling, hardening = _unit(theta)
    limit = 0.3 + 2.2 * friction * (0.6 + 0.8 * rolling)
    strain = STRAIN * 10 ** (1 + 2 * stiffness) * (0.6 + 0.8 * rolling) / limit
    bend = 0.7 + 1.6 * sharpness
    return (1 + limit * strain / (1 + strain**bend) ** (1 / bend) + 4 * hardening**2 * STRAIN)[:, :, None]


def triaxial(theta: NDArray[np.float64]) -> NDArray[np.float64]:
    """A drained triaxial test: the stress ratio has a peak and softens, the volumetric strain contracts and dilates; soft grains do neither much."""
    stiffness, poisson, friction, rolling, limit = _unit(theta)
    angle = 60 * friction
    peak = 1.2 + 1.2 * np.sin(np.radians(0.75 * angle)) + 0.9 * rolling * np.tanh(angle / 25) * (0.4 + 0.6 * limit) + 0.25 * limit
    residual = peak - (0.25 + 0.5 * rolling) * 0.6 * (0.3 + stiffness) * (peak - 1.2)
    rise = 1 - np.exp(-STRAIN * 10 ** (1.2 + 1.3 * stiffness) * (1.15 - 0.15 * poisson))
    softening = 1 - np.exp(-((STRAIN / 0.08) ** 2))
    stress_ratio = 1 + ((peak - 1) + (residual - peak) * softening) * rise
    contraction = 0.03 * (1 - 0.75 * stiffness) * (1 + 0.2 * poisson) * (1 - np.exp(-60 * STRAIN))
    dilation = 0.3 * (peak - 1.6) * (0.4 + 0.6 * stiffness) * STRAIN * (1 - np.exp(-((STRAIN / 0.03) ** 2)))
    return np.stack([stress_ratio, contraction - dilation], axis=2)


def two_modes(theta: NDArray[np.float64]) -> NDArray[np.float64]:
    """A ridge, along which friction and rolling friction make up for each other, and on it two modes, the same to either side of the middle of ν."""
    stiffness, poisson, friction, rolling, limit = _unit(theta)
    strength = 2.2 * (0.5 + friction) * (0.7 + rolling)
    rise = 1 - np.exp(-STRAIN * 10 ** (1.2 + stiffness))
    bump = 3 * (2 * poisson - 1) ** 2 * (STRAIN / 0.05) * np.exp(-STRAIN / 0.05)
    return (1 + strength * rise + bump + 8 * (limit - 0.5) * STRAIN)[:, :, None]


PROBLEMS = {
    problem.name: problem
    for problem in (
        Problem("monotone", ("stress_ratio",), monotone),
        Problem("triaxial", ("stress_ratio", "volumetric_strain"), triaxial),
        Problem("two modes", ("stress_ratio",), two_modes),
    )
}
