"""The built-in model: a drained triaxial test by graincal's own DEM engine."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from numbers import Real
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graincal import _native
from graincal.data import Failure, InputError, Response, Samples
from graincal.dem.batch import Run, run_batch
from graincal.dem.packing import Packing
from graincal.dem.stress_path import drained_triaxial
from graincal.execution import available_cores

PARAMETERS = ("log_E", "nu", "phi", "beta_m", "eta_m")
"""Hartmann, Cheng, Thornton (2022), Table 1: log10 of the modulus in Pa, stiffness ratio, friction angle in degrees, rolling stiffness and strength.
With the law "hertz-mindlin", the modulus and Poisson's ratio are those of the grains."""

LAWS = {"linear": _native.LinearLaw, "hertz-mindlin": _native.HertzLaw}
"""The contact laws by name (docs/contact-laws.md)."""

STEPS_EXPONENT = {"linear": 1 / 2, "hertz-mindlin": 1 / 3}
"""The steps of a run grow with this power of the modulus: the stiffness of a Hertz contact under a given force goes with the modulus to the power 2/3."""

DENSITY = 2650.0
"""Density of quartz grains, kg/m^3, before scaling."""

RETURNED = (
    "axial_strain", "volumetric_strain", "stress_ratio", "void_ratio", "mean_stress", "deviatoric_stress", "coordination_number", "contacts",
    "a_c", "a_n", "a_t", "unbalanced_force", "steps", "flagged",
)  # fmt: skip
"""The columns of a response: strains logarithmic and stresses in Pa, compression positive; Z, a_c, a_n, a_t by Eq. 8-11 of the paper."""

_LINEAR_BOUNDS = {"log_E": (-np.inf, 300.0), "nu": (0.0, np.inf), "phi": (0.0, 90.0), "beta_m": (0.0, np.inf), "eta_m": (0.0, np.inf)}
_BOUNDS = {"linear": _LINEAR_BOUNDS, "hertz-mindlin": _LINEAR_BOUNDS | {"nu": (0.0, 0.5)}}
"""Where each contact law means something; each parameter below its upper bound."""

_NOTHING_RUN = {"steps": 0, "seconds": 0.0, "particle_steps": 0, "flagged": 0, "consolidation_flagged": 0}

_FAILURES = {
    "diverged": "the simulation diverged: a particle's motion ran away or a stress was not finite",
    "cell_too_small": "the periodic cell became too small for its largest particles",
    "out_of_steps": "the simulation reached its limit of {limit} steps",
    "out_of_memory": "the simulation found no memory for its neighbour lists",
}


@dataclass(frozen=True, eq=False)
class TriaxialTest:
    """A drained triaxial test of a packing, by the protocol of Hartmann, Cheng, Thornton (2022).

    confining_pressure: Pa. density_scaling: factor on the grains' density (the paper's 1e3). fixed: parameters that are not calibrated, with their
    values. largest_flagged_share: a run in which a larger share of the states was not at rest within its step limit is a Failure; fewer are counted in
    the response's details. step_limit: of a whole run. law: "linear", the contact law of that paper, or "hertz-mindlin" (docs/contact-laws.md).
    """

    packing: Packing
    confining_pressure: float
    density_scaling: float = 1e3
    fixed: Mapping[str, float] = field(default_factory=dict)
    largest_flagged_share: float = 0.1
    step_limit: int = 20_000_000
    law: str = "linear"

    def __post_init__(self) -> None:
        for name in ("confining_pressure", "density_scaling", "step_limit"):
            value = getattr(self, name)
            if not (isinstance(value, Real) and np.isfinite(value) and value > 0):
                raise InputError(f"{name} must be a positive number, not {value!r}.")
        if not (isinstance(self.largest_flagged_share, Real) and 0 <= self.largest_flagged_share <= 1):
            raise InputError(f"largest_flagged_share must be a number from 0 to 1, not {self.largest_flagged_share!r}.")
        if self.law not in tuple(LAWS):
            raise InputError(f"law must be {' or '.join(map(repr, LAWS))}, not {self.law!r}.")
        if unknown := set(self.fixed) - set(PARAMETERS):
            raise InputError(f"fixed: {', '.join(sorted(unknown))} is not among the test's parameters {', '.join(PARAMETERS)}.")
        for name, value in self.fixed.items():
            if not isinstance(value, Real) or _outside(name, value, self.law):
                raise InputError(f"fixed.{name} must be a number {_words(name, self.law)}, not {value!r}.")
        object.__setattr__(self, "fixed", MappingProxyType(dict(self.fixed)))

    @property
    def returned(self) -> tuple[str, ...]:
        """The names of what a response holds."""
        return RETURNED

    def arrange(self, samples: Samples) -> NDArray[np.float64]:
        """The samples' theta with the fixed values put in, (N, 5) in the order of PARAMETERS. Raises InputError for a name too many or too few."""
        given = [*samples.names, *self.fixed]
        if sorted(given) != sorted(PARAMETERS):
            raise InputError(f"a triaxial test needs each of {', '.join(PARAMETERS)} once, as a parameter or fixed, and was given {', '.join(given)}.")
        columns = {name: samples.theta[:, k] for k, name in enumerate(samples.names)}
        columns |= {name: np.full(len(samples), value) for name, value in self.fixed.items()}
        return np.stack([columns[name] for name in PARAMETERS], axis=1)

    def evaluate(self, samples: Samples, at: ArrayLike, workers: int | None = None) -> Iterator[tuple[int, Response | Failure]]:
        """Simulate each sample and yield (row, Response or Failure) in order of completion.

        at (T,): axial strains of the recorded states, logarithmic, as fractions. workers: threads, all cores by default. A sample outside the bounds
        of the contact law is a Failure. Raises InputError for parameters too many or too few, and for strains that cannot be reached.
        """
        at = _checked_strains(at)
        theta = self.arrange(samples)
        return self._evaluate(theta, at, workers or available_cores())

    def _evaluate(self, theta: NDArray[np.float64], at: NDArray[np.float64], threads: int) -> Iterator[tuple[int, Response | Failure]]:
        possible = []
        for row, values in enumerate(theta):
            if wrong := [name for name, value in zip(PARAMETERS, values) if _outside(name, value, self.law)]:
                yield row, Failure("parameters", f"{wrong[0]} = {values[PARAMETERS.index(wrong[0])]:g} has no meaning, it must be a number {_words(wrong[0], self.law)}.", _NOTHING_RUN)
            else:
                possible.append(row)
        if not possible:
            return
        runs = run_batch(
            self.packing,
            [_law(self.law, theta[row]) for row in possible],
            drained_triaxial(self.confining_pressure, at),
            density=DENSITY * self.density_scaling,
            expected_steps=_relative_run_lengths(self.law, theta[possible]),
            threads=threads,
            step_limit=self.step_limit,
        )
        for run in runs:
            yield possible[run.index], self._outcome(run, at)

    def simulate(self, thetas: ArrayLike, at: ArrayLike, threads: int | None = None) -> list[Response | Failure]:
        """Simulate each row of thetas (N, n), in the order of PARAMETERS less the fixed ones; returns the outcomes in that order."""
        names = tuple(name for name in PARAMETERS if name not in self.fixed)
        thetas = np.atleast_2d(np.asarray(thetas, dtype=np.float64))
        if thetas.shape[1] != len(names):
            raise InputError(f"theta must have the {len(names)} columns {', '.join(names)}, not {thetas.shape[1]}.")
        samples = Samples(np.arange(len(thetas)), thetas, names)
        outcomes = dict(self.evaluate(samples, at, workers=threads))
        return [outcomes[row] for row in range(len(samples))]

    def _outcome(self, run: Run, at: NDArray[np.float64]) -> Response | Failure:
        flagged = int(run.columns["flagged"].sum())
        details = {"steps": run.steps, "seconds": run.seconds, "particle_steps": run.steps * self.packing.count}
        details |= {"flagged": flagged, "consolidation_flagged": int(run.consolidation_flagged)}
        if run.status != "finished":
            return Failure(run.status, _FAILURES[run.status].format(limit=self.step_limit) + f" (after {run.steps} steps).", details)
        if flagged > self.largest_flagged_share * len(at):
            reason = f"{flagged} of {len(at)} states were not at rest within their step limit, more than the share of {self.largest_flagged_share:g} allowed."
            return Failure("flagged", reason, details)
        return Response(at, self._curve(run.columns), details)

    def _curve(self, c: dict[str, NDArray[np.float64]]) -> dict[str, NDArray[np.float64]]:
        lateral = 0.5 * (c["stress_xx"] + c["stress_yy"])
        derived = {
            "axial_strain": c["strain_z"],
            "volumetric_strain": c["strain_x"] + c["strain_y"] + c["strain_z"],
            "stress_ratio": c["stress_zz"] / lateral,
            "void_ratio": c["volume"] / self.packing.solid_volume - 1,
            "mean_stress": (c["stress_xx"] + c["stress_yy"] + c["stress_zz"]) / 3,
            "deviatoric_stress": c["stress_zz"] - lateral,
        }
        return {name: derived[name] if name in derived else c[name] for name in RETURNED}


def _law(name: str, theta: NDArray[np.float64]) -> _native.LinearLaw | _native.HertzLaw:
    log_modulus, ratio, friction_angle, rolling_stiffness, rolling_strength = theta
    return LAWS[name](10.0**log_modulus, ratio, np.tan(np.radians(friction_angle)), rolling_stiffness, rolling_strength)


def _outside(name: str, value: float, law: str) -> bool:
    low, high = _BOUNDS[law][name]
    return not (np.isfinite(value) and low <= value < high)


def _words(name: str, law: str) -> str:
    low, high = _BOUNDS[law][name]
    limits = [f"at least {low:g}"] * bool(np.isfinite(low)) + [f"below {high:g}"] * bool(np.isfinite(high))
    return " and ".join(limits)


def _checked_strains(at: ArrayLike) -> NDArray[np.float64]:
    try:
        strains = np.asarray(at, dtype=np.float64)
    except (TypeError, ValueError):
        strains = np.empty(0)
    if strains.ndim != 1 or not strains.size or not np.all(np.isfinite(strains)) or np.any(np.abs(strains) >= 1):
        raise InputError("axial strains must be one row of fractions between -1 and 1 (not percent), at least one.")
    return strains


def _relative_run_lengths(law: str, theta: NDArray[np.float64]) -> NDArray[np.float64]:
    # The critical step falls with the root of the stiffness; smooth grains take longer to come to rest.
    return 10.0 ** (STEPS_EXPONENT[law] * theta[:, 0]) / (0.1 + np.sin(np.radians(theta[:, 2])))
