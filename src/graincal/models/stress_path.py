"""What the built-in models share: a packing that graincal's own DEM engine drives along a stress path."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from numbers import Real
from types import MappingProxyType
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graincal import _native
from graincal.data import Failure, InputError, Response, Samples
from graincal.dem.packing import Packing
from graincal.dem.siblings import siblings
from graincal.execution import Task
from graincal.interpolation import interpolate
from graincal.models.contact_laws import DEFAULT_LAW, LAWS, unusual_parameters
from graincal.models.economy import INERTIAL_NUMBER, INERTIAL_NUMBERS, QUASI_STATIC, Economy, density_scaling_of, inertial_number
from graincal.models.engine_work import EngineWork
from graincal.models.model import Model
from graincal.models.plausibility import impossible_pressure, unusual_pressure
from graincal.models.proportion import ENGINE_PRESSURE, for_engine, from_engine
from graincal.models.rests import REST_EVERY, RESTS_EVERY, strains_at_rest, stresses_at_rest
from graincal.notation import numbers
from graincal.suggestion import did_you_mean

STEPS_BETWEEN_RESTS = 9.0
"""For a modulus of one confining pressure: as on packings of 1,000 and 2,000 in triaxial compression, within a factor of two."""

STRAINS = ("axial_strain", "axial_extension")
"""Controls that are strains: the axial one, or extension counted positive, for a reference must increase."""

RETURNED = (
    "axial_strain", "volumetric_strain", "stress_ratio", "void_ratio", "mean_stress", "deviatoric_stress", "coordination_number", "contacts",
    "a_c", "a_n", "a_t", "unbalanced_force", "steps", "flagged",
)  # fmt: skip
"""The columns of a response: strains logarithmic and stresses in Pa, compression positive; Z, a_c, a_n, a_t by Eq. 8-11 of the paper."""

IN_PASCAL = ("mean_stress", "deviatoric_stress", "axial_stress", "lateral_stress", "excess_pore_pressure", "stress_xx", "stress_yy", "stress_zz")
"""Columns that are stresses."""


class Panel(NamedTuple):
    """What a panel of a test's figure shows: a column of the response over another (the control if it is empty), or over that one's logarithm."""

    column: str
    over: str = ""
    logarithmic: bool = False


class Abscissa(NamedTuple):
    """What curves are drawn over: a quantity by its name, its values (S,), and whether over their logarithm."""

    name: str
    values: NDArray[np.float64]
    logarithmic: bool = False


@dataclass(frozen=True, eq=False)
class StressPathTest(Economy, Model):
    """A test of a packing along a stress path.

    packing: one, or several that are samples of the same material: a sample's id modulo their number says which it runs on, so that the
    scatter between packings is part of what the runs scatter by. `packing` is then the first, from which the grains' density follows where an inertial
    number is given, and `packings` are all of them.
    confining_pressure: Pa, of the isotropic consolidation that the path begins with. The test rests at states of its own (rests.py), whatever rows it is
    compared with. rest_every: the strain from one to the next, 0.004 by default; None for a path that is driven by stress.
    inertial_number: of axial loading at the confining pressure, from which the scaling of the grains' density follows, so that the test is the same at every
    pressure; INERTIAL_NUMBER by default. density_scaling: factor on the grains' density instead (the paper's 1e3).
    fixed: parameters that are not calibrated, with their values. largest_flagged_share: a run in which a larger share of the states was not at rest
    within its step limit is a Failure; fewer are counted in the response's details. step_limit: of a whole run. control: what the values at which the
    test is asked for are of, one of the path's `controls`; by default the first of them.
    law: the name of a contact law, by default that of Hartmann, Cheng, Thornton (2022) (`contact_laws.LAWS`, docs/contact-laws.md). How exact a run is, and how long, are
    Economy's options.

    What one path differs in from another is below: its name in files and on the command line, what it is called, and its stages.
    """

    kind: ClassVar[str]
    title: ClassVar[str]
    controls: ClassVar[tuple[str, ...]]
    also_returned: ClassVar[tuple[str, ...]] = ()
    """Columns of a response beyond RETURNED."""
    shown: ClassVar[tuple[Panel, ...]] = (Panel("stress_ratio"), Panel("volumetric_strain"))
    """The panels of a figure."""
    held: ClassVar[tuple[str, ...]] = ()
    """What the path keeps as it is, so that nobody looks at it."""
    can_be_watched: ClassVar[bool] = True
    """That a rule may stop its runs early."""
    optional: ClassVar[tuple[str, ...]] = ()
    """Fields that may be None."""

    packing: Packing | Sequence[Packing]
    confining_pressure: float
    density_scaling: float | None = None
    fixed: Mapping[str, float] = field(default_factory=dict)
    largest_flagged_share: float = 0.1
    step_limit: int = 20_000_000
    control: str = ""
    law: str = DEFAULT_LAW
    inertial_number: float | None = field(default=None, kw_only=True)
    rest_every: float | None = field(default=None, kw_only=True)
    packings: Sequence[Packing] = field(default=(), kw_only=True)

    @abstractmethod
    def stages(self, confining_pressure: float, at: NDArray[np.float64]) -> list[_native.Stage]:
        """The stages of the path, one of them recorded for each control value (S,); stresses are in the unit of the confining pressure."""

    def __post_init__(self) -> None:
        self._hold_packings()
        object.__setattr__(self, "control", self.control or self.controls[0])
        if self.control not in self.controls:
            raise InputError(
                f"{self.name_with_article} is driven by {' or '.join(self.controls)}, not by {self.control}{did_you_mean(self.control, self.controls)}."
            )
        for name in ("confining_pressure", "density_scaling", "inertial_number", "step_limit"):
            value = getattr(self, name)
            if value is None and name in ("density_scaling", "inertial_number", *self.optional):
                continue
            if not (isinstance(value, Real) and np.isfinite(float(value)) and float(value) > 0):
                raise InputError(f"{name} must be a positive number, not {value!r}.")
        if self.confining_pressure is not None and (wrong := impossible_pressure("confining_pressure", self.confining_pressure)):
            raise InputError(wrong)
        if self.density_scaling is not None and self.inertial_number is not None:
            raise InputError("density_scaling and inertial_number are both given, and one of them was expected.")
        if self.inertial_number is not None and not INERTIAL_NUMBERS[0] <= self.inertial_number <= INERTIAL_NUMBERS[1]:
            low, high = INERTIAL_NUMBERS
            raise InputError(f"inertial_number must be from {low:g} to {high:g}, not {self.inertial_number:g}.")
        self._check_rests()
        self.check_economy()
        if not (isinstance(self.largest_flagged_share, Real) and 0 <= self.largest_flagged_share <= 1):
            raise InputError(f"largest_flagged_share must be a number from 0 to 1, not {self.largest_flagged_share!r}.")
        if self.law not in LAWS:
            raise InputError(f"law must be {' or '.join(map(repr, LAWS))}, not {self.law!r}{did_you_mean(self.law, LAWS)}.")
        if unknown := sorted(set(self.fixed) - set(self.parameters)):
            raise InputError(f"fixed: {unknown[0]} is not among the test's parameters {', '.join(self.parameters)}{did_you_mean(unknown[0], self.parameters)}.")
        for name, value in self.fixed.items():
            parameter = LAWS[self.law].parameter(name)
            if not isinstance(value, Real) or parameter.excludes(value):
                raise InputError(f"fixed.{name} must be a number {parameter.limits}, not {value!r}{parameter.meant(value)}.")
        object.__setattr__(self, "fixed", MappingProxyType(dict(self.fixed)))

    def __repr__(self) -> str:
        at = "" if self.confining_pressure is None else f" at {numbers.pressure(self.confining_pressure)}"
        more = f" and {len(self.packings) - 1} more" if len(self.packings) > 1 else ""
        fixed = "".join(f", {name} = {value:g}" for name, value in self.fixed.items())
        return f"{type(self).__name__}({self.packing}{more}{at}, law {self.law}{fixed})"

    def _hold_packings(self) -> None:
        given = (self.packing,) if isinstance(self.packing, Packing) else tuple(self.packing)
        if not given or not all(isinstance(each, Packing) for each in given):
            raise InputError(f"{self.name_with_article} needs a packing, or a list of them.")
        packings = tuple(self.packings) or given
        # A copy with another packing has that one.
        object.__setattr__(self, "packings", packings if packings[: len(given)] == given else given)
        object.__setattr__(self, "packing", given[0])

    @property
    def alone(self) -> tuple[StressPathTest, ...]:
        """The test on each of its packings by itself."""
        return tuple(replace(self, packing=packing, packings=()) for packing in self.packings) if len(self.packings) > 1 else (self,)

    def on_siblings(self, count: int, threads: int = 1, prepared: Callable[[int], None] = lambda number: None) -> StressPathTest:
        """The test spread over `count` packings like its first, which are prepared where they are not cached: sample by sample, by the ids.

        prepared: hears how many there are so far. Raises InputError where none can be.
        """
        packings = siblings(self.first_packing, count, threads, prepared=prepared)
        return replace(self, packing=packings[0], packings=packings)

    def _check_rests(self) -> None:
        every = self.rest_every
        if every is None:
            return
        if self.control not in STRAINS:
            raise InputError(f"rest_every is a strain, and {self.name_with_article} that is driven by {self.control} rests at states of its own: leave it out.")
        low, high = RESTS_EVERY
        if not (isinstance(every, Real) and low <= every <= high):
            raise InputError(f"rest_every must be a strain from {low:g} to {high:g}, a fraction and not percent, not {every!r}.")

    @property
    def first_packing(self) -> Packing:
        """The packing, of several the first."""
        return self.packings[0]

    @property
    def unit_of_stress(self) -> float:
        """Pa: what the test is the same in units of, its confining pressure."""
        return self.confining_pressure

    @property
    def scaling(self) -> float:
        """The factor on the grains' density that is in effect."""
        if self.density_scaling is not None:
            return float(self.density_scaling)
        return float(density_scaling_of(self.first_packing, self.unit_of_stress, self.density["inertial_number"]))

    @property
    def density(self) -> dict[str, float]:
        """What the grains' density follows from: the scaling that was given, or else the inertial number, by its name."""
        if self.density_scaling is not None:
            return {"density_scaling": float(self.density_scaling)}
        return {"inertial_number": float(INERTIAL_NUMBER if self.inertial_number is None else self.inertial_number)}

    @property
    def strain_between_rests(self) -> float | None:
        """From one state at rest to the next; None for a path that is driven by stress."""
        if self.control not in STRAINS:
            return None
        return float(REST_EVERY if self.rest_every is None else self.rest_every)

    @property
    def inertia(self) -> float:
        """The inertial number of axial loading that is in effect."""
        return self.density.get("inertial_number", float(inertial_number(self.first_packing, self.unit_of_stress, self.scaling)))

    @property
    def density_in_words(self) -> str:
        """What the grains' density follows from, and the inertial number."""
        ((name, value),) = self.density.items()
        said = f"{name.replace('_', ' ')} {value:.6g}"
        return said if name == "inertial_number" else f"{said}, an inertial number of {self.inertia:.3g}"

    @property
    def returned(self) -> tuple[str, ...]:
        """The names of what a response holds."""
        return tuple(dict.fromkeys((*RETURNED, *self.also_returned, self.control)))

    @property
    def turns_in_words(self) -> str:
        """Where a path turns around that is known to; empty for others."""
        return ""

    def abscissa(self, at: NDArray[np.float64]) -> Abscissa:
        """What curves of this test are drawn over at the control values (S,): these."""
        return Abscissa(self.control, at)

    @property
    def name_with_article(self) -> str:
        """What the test is called, in a sentence."""
        return f"{'an' if self.title[0] in 'aeiou' else 'a'} {self.title}"

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the contact law's parameters, in the order of theta."""
        return LAWS[self.law].names

    def arrange(self, samples: Samples) -> NDArray[np.float64]:
        """The samples' theta with the fixed values put in, (N, 5) in the order of `parameters`. Raises InputError for a name too many or too few."""
        given = [*samples.names, *self.fixed]
        if sorted(given) != sorted(self.parameters):
            missing = [name for name in self.parameters if name not in given]
            wrong = [f"{name} is not one of them{did_you_mean(name, missing)}" for name in given if name not in self.parameters]
            wrong += [f"{', '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing"] if missing else []
            wrong += [f"{name} is given twice" for name in self.parameters if given.count(name) > 1]
            raise InputError(f"{self.name_with_article} needs each of {', '.join(self.parameters)} once, as a parameter or fixed: {'; '.join(wrong)}.")
        columns = {name: samples.theta[:, k] for k, name in enumerate(samples.names)}
        columns |= {name: np.full(len(samples), value) for name, value in self.fixed.items()}
        return np.stack([columns[name] for name in self.parameters], axis=1)

    def tasks(self, samples: Samples, at: ArrayLike) -> list[Task]:
        """A simulation for each sample.

        at (T,): control values that the response must cover: strains logarithmic, as fractions; stresses in Pa. The response is on the states at which the test
        rests on its way (`states`), the same for whatever rows end within the same step. A sample outside the bounds of the contact law is a Failure. Raises InputError for parameters too many or
        too few, and for values that cannot be reached.
        """
        states, theta = self.states(at), self.arrange(samples)
        alone = [EngineWork(test, states) for test in self.alone]
        lengths = relative_run_lengths(self.steps_exponent, theta)
        work = [alone[id % len(alone)] for id in samples.ids]
        return [Task(each, values, cost=float(length) * each.test.first_packing.count) for each, values, length in zip(work, theta, lengths)]

    @property
    def steps_exponent(self) -> float:
        """The steps of a run grow with this power of the modulus."""
        return LAWS[self.law].steps_exponent

    def steps_between_rests(self, moduli: NDArray[np.float64]) -> NDArray[np.float64]:
        """About how many steps there are from one rest to the next, for moduli in units of the confining pressure (N,)."""
        return STEPS_BETWEEN_RESTS * moduli**self.steps_exponent

    def expected_particle_steps(self, samples: Samples, at: ArrayLike) -> NDArray[np.float64]:
        """About what runs of samples cost, (N,): the grains times the steps. Between two rests the steps go with a power of the modulus over the pressure, and against the inertial number."""
        # A modulus where its logarithm was expected is refused elsewhere.
        with np.errstate(over="ignore"):
            moduli = 10.0 ** self.arrange(samples)[:, 0]
        steps = len(self.states(at)) * self.steps_between_rests(moduli / self.unit_of_stress) * INERTIAL_NUMBER / self.inertia
        return self.first_packing.count * steps

    def simulate(self, thetas: ArrayLike, at: ArrayLike, threads: int | None = None) -> list[Response | Failure]:
        """Simulate each row of thetas (N, n), in the order of `parameters` less the fixed ones; returns the outcomes in that order, at the control values `at` (T,)."""
        names = tuple(name for name in self.parameters if name not in self.fixed)
        thetas = np.atleast_2d(np.asarray(thetas, dtype=np.float64))
        if thetas.shape[1] != len(names):
            raise InputError(f"theta must have the {len(names)} columns {', '.join(names)}, not {thetas.shape[1]}.")
        samples = Samples(np.arange(len(thetas)), thetas, names)
        outcomes, rows = dict(self.evaluate(samples, at, workers=threads)), np.asarray(at, dtype=np.float64)
        return [outcome if isinstance(outcome := outcomes[row], Failure) else interpolate(outcome, rows) for row in range(len(samples))]

    def states(self, at: ArrayLike) -> NDArray[np.float64]:
        """The control values (S,) of the states at which the test rests on its way through all of `at` (T,). Raises InputError for what the path cannot reach."""
        every = self.strain_between_rests
        if every is not None:
            return strains_at_rest(checked_strains(at), every)
        return stresses_at_rest(checked_stresses(at, self.control), self.confining_pressure)

    def stages_through(self, states: NDArray[np.float64]) -> list[_native.Stage]:
        """The path through states (S,) as the engine is given it."""
        return self.stages(ENGINE_PRESSURE, for_engine(states, self.unit_of_stress) if self.control in IN_PASCAL else states)

    def contact_law(self, theta: NDArray[np.float64]) -> _native.LinearLaw | _native.HertzLaw:
        """That of parameters (5,), in the order of `parameters`, as the engine is given it."""
        return LAWS[self.law].of(theta, self.unit_of_stress)

    def response_of(
        self, recorded: Mapping[str, NDArray[np.float64]], states: NDArray[np.float64], details: Mapping[str, float] = MappingProxyType({})
    ) -> Response:
        """Of the states recorded, the first or all of those that were to be."""
        columns = {**recorded, **self.derived(recorded)}
        values = {name: from_engine(columns[name], self.unit_of_stress) if name in IN_PASCAL else columns[name] for name in self.returned}
        return self.response(states[: len(columns["steps"])], values, details)

    def response(self, control: NDArray[np.float64], values: Mapping[str, NDArray[np.float64]], details: Mapping[str, float]) -> Response:
        """What this test returned (S,) at its states (S,), as a Response that knows its pressure and which of its values are stresses."""
        return Response(control, values, details, self.control, self.unit_of_stress, tuple(name for name in IN_PASCAL if name in values))

    def derived(self, c: Mapping[str, NDArray[np.float64]]) -> dict[str, NDArray[np.float64]]:
        """What follows from the recorded states, whose columns are given; stresses are the engine's, at ENGINE_PRESSURE."""
        lateral = 0.5 * (c["stress_xx"] + c["stress_yy"])
        # A sample that has lost its contacts has no lateral stress: its ratio is not finite, and whoever compares it says so.
        with np.errstate(divide="ignore", invalid="ignore"):
            stress_ratio = c["stress_zz"] / lateral
        return {
            "axial_strain": c["strain_z"],
            "axial_extension": -c["strain_z"],
            "volumetric_strain": c["strain_x"] + c["strain_y"] + c["strain_z"],
            "axial_stress": c["stress_zz"],
            "lateral_stress": lateral,
            "stress_ratio": stress_ratio,
            "void_ratio": c["volume"] / self.first_packing.solid_volume - 1,
            "mean_stress": (c["stress_xx"] + c["stress_yy"] + c["stress_zz"]) / 3,
            "deviatoric_stress": c["stress_zz"] - lateral,
        }


def unusual(test: StressPathTest) -> list[str]:
    """What is to be said of a test that is far from quasi-static, or at a pressure, or with a fixed modulus, that another unit was probably meant for."""
    pressure, inertia = test.confining_pressure, test.inertia
    said: list[str | None] = (
        [f"the inertial number is {inertia:.3g}; above {QUASI_STATIC:g} the grains' inertia changes the curve."] if inertia > QUASI_STATIC else []
    )
    said += [unusual_pressure("confining_pressure", pressure)] if pressure is not None else []
    said += [unusual_pressure("a turn", turn) for turn in getattr(test, "turns", ())]
    said += unusual_parameters({f"fixed.{name}": (value,) for name, value in test.fixed.items()})
    return [doubt for doubt in said if doubt]


def checked_strains(at: ArrayLike) -> NDArray[np.float64]:
    """One row of axial strains, (T,). Raises InputError for anything else."""
    strains = one_row(at)
    if strains is None or np.any(np.abs(strains) >= 1):
        largest = float(strains[np.argmax(np.abs(strains))]) if strains is not None and len(strains) else 0.0
        meant = f": if {largest:g} % is meant, write {largest / 100:g}" if 1 <= abs(largest) < 100 else ""
        raise InputError(f"axial strains must be one row of fractions between -1 and 1 (not percent), at least one{meant}.")
    return strains


def checked_stresses(at: ArrayLike, name: str) -> NDArray[np.float64]:
    """One row of stresses, (T,). Raises InputError for anything else."""
    stresses = one_row(at)
    if stresses is None or np.any(stresses <= 0):
        raise InputError(f"values of {name} must be one row of numbers above 0 (in Pa), at least one.")
    return stresses


def one_row(at: ArrayLike) -> NDArray[np.float64] | None:
    """The values (T,), or None for what is not one row of finite numbers."""
    try:
        values = np.asarray(at, dtype=np.float64)
    except (TypeError, ValueError):
        return None
    return values if values.ndim == 1 and values.size and np.all(np.isfinite(values)) else None


def relative_run_lengths(steps_exponent: float, theta: NDArray[np.float64]) -> NDArray[np.float64]:
    """How the numbers of steps of samples (N, 5) compare with one another, (N,), where they grow with this power of the modulus."""
    # The critical step falls with the root of the stiffness; smooth grains take longer to come to rest.
    # Whatever a modulus may be: one that has no meaning is refused where it is run.
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        return 10.0 ** (steps_exponent * theta[:, 0]) / (0.1 + np.sin(np.radians(theta[:, 2])))
