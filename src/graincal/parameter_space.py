"""The unknown parameters, what is known of them beforehand, and samples of them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from numbers import Real
from typing import TYPE_CHECKING, Any, Final, SupportsFloat

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graincal.arrays import read_only
from graincal.constraint import Constraint, Left, left
from graincal.errors import InputError
from graincal.notation.printable import printable
from graincal.suggestion import did_you_mean

if TYPE_CHECKING:
    from typing_extensions import TypeIs

LINEAR: Final = "linear"
LOG: Final = "log"
SCALES = (LINEAR, LOG)
"""In what the prior of a parameter is uniform: in its value, or in the logarithm of that."""


@dataclass(frozen=True, init=False, eq=False)
class ParameterSpace:
    """The unknown parameters and their prior: uniform over the box of their ranges, as far as constraints leave it.

    `ranges` maps each name to (low, high), in the order of theta's columns, or to a number: such a parameter is fixed, no unknown, and every model is given its value in its place. `units` maps names to units, for
    axes and tables. `per_experiment` names the parameters that have a value of their own in each experiment; a calibration makes an unknown for each of these values (`for_experiments`).
    `scale` maps names to "linear", the default, or "log": the prior is uniform in the logarithm of the value, which stays the value itself for models and everybody else.
    `constraints` are conditions on the parameters, such as "v0 < v1", by names and arithmetic (`notation.expression`): the prior is uniform where all of them hold. What they leave is found when it is first needed;
    InputError is raised then where that is nothing, or too little.

    >>> ParameterSpace({"log_E": (7, 11), "phi": (0, 60)}, units={"log_E": "log10 Pa", "phi": "deg"}).names
    ('log_E', 'phi')
    """

    names: tuple[str, ...]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    units: tuple[str, ...]
    scales: tuple[str, ...]
    per_experiment: tuple[str, ...]
    parameters: tuple[str, ...]
    """For each of theta's columns, the name of the parameter that it is a value of: that of the column, unless it is one of several values."""
    experiments: tuple[int | None, ...]
    """For each of theta's columns, the number of the one experiment whose value it is, from 0; None for all of them."""
    fixed: Mapping[str, float]
    """The values of the parameters that are no unknowns."""
    units_of_fixed: Mapping[str, str]
    order: tuple[str, ...]
    """The parameters as models are given them: those with a range and those that are fixed."""
    constraints: tuple[Constraint, ...]

    def __init__(
        self,
        ranges: Mapping[str, tuple[float, float] | float],
        units: Mapping[str, str] | None = None,
        per_experiment: Collection[str] = (),
        *,
        scale: Mapping[str, str] | None = None,
        constraints: Sequence[str] = (),
    ) -> None:
        units, scale = dict(units or {}), dict(scale or {})
        fixed = {name: _number(name, limits) for name, limits in ranges.items() if _is_number(limits)}
        boxed = {name: limits for name, limits in ranges.items() if not _is_number(limits)}
        if not boxed:
            raise InputError("parameters: at least one parameter with its range is needed.")
        for name, limits in boxed.items():
            _check_range(name, limits, scale.get(name, LINEAR))
        _check_known("units", units, ranges)
        _check_known("per_experiment", per_experiment, boxed, fixed)
        _check_known("scale", scale, boxed, fixed)
        if isinstance(constraints, str):
            raise InputError(f'constraints must be a list of conditions, such as ["v0 < v1"], not "{constraints}".')
        names = tuple(boxed)
        self._set(
            names=names,
            low=read_only([limits[0] for limits in boxed.values()], ndim=1, what="low"),
            high=read_only([limits[1] for limits in boxed.values()], ndim=1, what="high"),
            units=tuple(units.get(name, "") for name in names),
            scales=tuple(scale.get(name, LINEAR) for name in names),
            per_experiment=tuple(name for name in names if name in per_experiment),
            parameters=names,
            experiments=(None,) * len(names),
            fixed=fixed,
            units_of_fixed={name: units.get(name, "") for name in fixed},
            order=tuple(ranges),
            constraints=tuple(Constraint.read(source, names, fixed) for source in constraints),
        )

    def __repr__(self) -> str:
        from graincal.notebook import space_as_text

        return space_as_text(self)

    def _repr_html_(self) -> str:
        """What a notebook shows: a table of the ranges."""
        from graincal.notebook import space_as_html

        return space_as_html(self)

    @classmethod
    def paper(cls) -> ParameterSpace:
        """The ranges of Hartmann, Cheng, Thornton (2022), Table 2."""
        return cls(
            {"log_E": (7, 11), "nu": (0, 0.5), "phi": (0, 60), "beta_m": (0, 1), "eta_m": (0, 1)},
            units={"log_E": "log10 Pa", "phi": "deg"},
        )

    @property
    def size(self) -> int:
        """The number of parameters n."""
        return len(self.names)

    # The prior

    @property
    def log_box_volume(self) -> float:
        """The log of the box's volume, in the parameters' own units, or their logarithms where these are what the prior is uniform in."""
        return float(np.log(self._widths).sum())

    @property
    def log_volume(self) -> float:
        """The log of the volume that constraints leave of the box, in the same: minus the log density of the prior."""
        return self.log_box_volume + float(np.log(self.part)) if self.constraints else self.log_box_volume

    @property
    def is_even(self) -> bool:
        """Whether the prior of each parameter is even over its range."""
        return not self.constraints and LOG not in self.scales

    @property
    def part(self) -> float:
        """The part of the box's volume that constraints leave."""
        return self._left.share if self.constraints else 1.0

    @property
    def deviation(self) -> NDArray[np.float64]:
        """The standard deviations of the prior on the unit cube, (n,)."""
        return self._left.deviation if self.constraints else np.full(self.size, 1 / np.sqrt(12))

    @cached_property
    def _left(self) -> Left:
        return left(self.constraints, self.size, self._in_box)

    def check_constraints(self) -> None:
        """Raise InputError where the constraints leave nothing, or where one of them leaves everything."""
        if self.constraints and (idle := self._left.idle):
            raise InputError(
                f'constraint.require = "{idle[0]}" holds all over the ranges, so that it would change nothing; a condition that excludes some of them was expected.'
            )

    def contains(self, theta: ArrayLike) -> NDArray[np.bool_]:
        """Which rows of theta (N, n) the prior holds possible, in the box and where all constraints hold: (N,)."""
        theta = np.atleast_2d(theta)
        inside = self.in_ranges(theta)
        return self._meeting(theta, inside) if self.constraints else inside

    def in_ranges(self, theta: ArrayLike) -> NDArray[np.bool_]:
        """Which rows of theta (N, n) lie in the box, whatever the constraints say: (N,)."""
        theta = np.atleast_2d(theta)
        return np.all((theta >= self.low) & (theta <= self.high), axis=1)

    def allows(self, unit: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which points (N, n), in coordinates of the unit cube, the prior holds possible: (N,)."""
        inside = np.all((unit >= 0) & (unit <= 1), axis=1)
        return self._meeting(self._in_box(unit), inside) if self.constraints else inside

    def _meeting(self, theta: NDArray[np.float64], inside: NDArray[np.bool_]) -> NDArray[np.bool_]:
        met = inside.copy()
        met[inside] = np.all([constraint.holds(theta[inside]) for constraint in self.constraints], axis=0)
        return met

    # The unit cube

    def from_unit(self, unit: ArrayLike) -> NDArray[np.float64]:
        """Map the unit cube (N, n) onto the box."""
        unit = np.asarray(unit, dtype=np.float64)
        theta = self.low + unit * (self.high - self.low)
        if (log := self._log).any():
            theta[..., log] = self.low[log] * np.exp(unit[..., log] * self._widths[log])
        return theta

    def to_unit(self, theta: ArrayLike) -> NDArray[np.float64]:
        """Map the box (N, n) onto the unit cube."""
        theta = np.asarray(theta, dtype=np.float64)
        unit = (theta - self.low) / (self.high - self.low)
        if (log := self._log).any():
            # What is told of no such space may hold values without a logarithm.
            with np.errstate(divide="ignore", invalid="ignore"):
                unit[..., log] = np.log(theta[..., log] / self.low[log]) / self._widths[log]
        return unit

    def moved(self, theta: ArrayLike, by: ArrayLike) -> NDArray[np.float64]:
        """theta (N, n) moved by so many widths of the box, (N, n)."""
        theta, by = np.asarray(theta, dtype=np.float64), np.asarray(by, dtype=np.float64)
        moved = theta + by * (self.high - self.low)
        if (log := self._log).any():
            moved[..., log] = (theta * np.exp(by * self._widths))[..., log]
        return moved

    def within(self, low: NDArray[np.float64], high: NDArray[np.float64]) -> ParameterSpace:
        """The same unknowns with other ranges, (n,) each."""
        return self._of_columns(
            range(self.size), self.names, low=read_only(low, ndim=1, what="low"), high=read_only(high, ndim=1, what="high"), constraints=self.constraints
        )

    def _in_box(self, unit: NDArray[np.float64]) -> NDArray[np.float64]:
        # low + 1 * (high - low) may round to the number after high.
        return np.clip(self.from_unit(unit), self.low, self.high)

    @cached_property
    def _log(self) -> NDArray[np.bool_]:
        return np.array([scale == LOG for scale in self.scales])

    @cached_property
    def _widths(self) -> NDArray[np.float64]:
        """Of the box, in what the prior is uniform in."""
        widths = self.high - self.low
        widths[self._log] = np.log(self.high[self._log] / self.low[self._log])
        return widths

    # Several experiments

    def for_experiments(self, experiments: Sequence[str]) -> ParameterSpace:
        """The unknowns of a calibration of these experiments, by their names: of a parameter in `per_experiment`, one for each experiment, side by side.

        With one experiment each parameter has one value, whether in `per_experiment` or not. A constraint on such a parameter holds in each experiment. Raises InputError where two unknowns would bear one name.

        >>> ParameterSpace({"phi": (0, 60), "eta_m": (0, 1)}, per_experiment=["eta_m"]).for_experiments(["0.5 MPa", "1 MPa"]).names
        ('phi', 'eta_m (0.5 MPa)', 'eta_m (1 MPa)')
        """
        if self._told_apart:
            expected = [name if number is None else _of_experiment(name, experiments, number) for name, number in zip(self.parameters, self.experiments)]
            if list(self.names) != expected:
                raise InputError(f"parameters: {', '.join(self.names)} are those of other experiments than {', '.join(experiments)}.")
            return self
        if not self.per_experiment:
            # The same, with what was found of its constraints.
            return self
        own = self.per_experiment if len(experiments) > 1 else ()
        columns = [(k, number) for k, name in enumerate(self.names) for number in (range(len(experiments)) if name in own else (None,))]
        names = [self.names[k] if number is None else _of_experiment(self.names[k], experiments, number) for k, number in columns]
        if twice := next((name for name in names if names.count(name) > 1), None):
            raise InputError(f'parameters: two unknowns would be called "{twice}"; give the parameters, or the experiments, other names.')
        parameters, numbers = tuple(self.names[k] for k, _ in columns), tuple(number for _, number in columns)
        constraints = []
        for constraint in self.constraints:
            for number in range(len(experiments)) if own and set(constraint.columns) & set(own) else (None,):
                constraints.append(constraint.at({name: columns.index((k, number if name in own else None)) for name, k in constraint.columns.items()}))
        return self._of_columns([k for k, _ in columns], names, per_experiment=own, parameters=parameters, experiments=numbers, constraints=tuple(constraints))

    def of_experiment(self, experiment: int) -> ParameterSpace:
        """The parameters as the model of an experiment (by its number, from 0) knows them: as they were before `for_experiments`, all of one value."""
        seen = self._seen(experiment)
        known = [constraint for constraint in self.constraints if set(constraint.columns.values()) <= set(seen)]
        constraints = tuple(constraint.at({name: seen.index(column) for name, column in constraint.columns.items()}) for constraint in known)
        return self._of_columns(seen, [self.parameters[k] for k in seen], constraints=constraints)

    def columns(self, experiment: int) -> slice | NDArray[np.intp]:
        """An index of the columns of theta that the model of an experiment sees, in the order of `of_experiment`; where that is all, it copies nothing."""
        seen = self._seen(experiment)
        return slice(None) if len(seen) == self.size else np.array(seen, dtype=np.intp)

    def seen_by(self, experiment: int, samples: Samples) -> Samples:
        """The samples as the model of an experiment sees them: each with the values that belong to it, under the parameters' own names, and with those that are fixed, in `order`."""
        seen = tuple(self.parameters[k] for k in self._seen(experiment))
        theta = samples.theta[:, self.columns(experiment)]
        if not self.fixed:
            return Samples(samples.ids, theta, seen)
        columns = [np.full(len(samples), self.fixed[name]) if name in self.fixed else theta[:, seen.index(name)] for name in self.order]
        return Samples(samples.ids, np.column_stack(columns), self.order)

    def check_experiments(self, count: int) -> None:
        """Raise InputError where parameters have a value for each experiment, and the unknowns are not those of so many experiments."""
        told_apart = {number for number in self.experiments if number is not None}
        if self.per_experiment and told_apart != (set(range(count)) if count > 1 else set()):
            raise InputError(
                f"parameters: {', '.join(self.per_experiment)} is to have a value of its own in each experiment, and for {count} reference{'s' * (count > 1)} "
                f"space.for_experiments(names) with as many names was expected."
            )

    @property
    def _told_apart(self) -> bool:
        return any(number is not None for number in self.experiments)

    def _seen(self, experiment: int) -> list[int]:
        return [k for k, number in enumerate(self.experiments) if number is None or number == experiment]

    def _of_columns(self, columns: Sequence[int], names: Sequence[str], **others: Any) -> ParameterSpace:
        """A space of some columns of this one, under other names, all of one value; with other fields where they are given."""
        columns, space = list(columns), object.__new__(ParameterSpace)
        low, high = self.low[columns], self.high[columns]
        for array in (low, high):
            array.setflags(write=False)
        kept: dict[str, Any] = {
            "units": tuple(self.units[k] for k in columns),
            "scales": tuple(self.scales[k] for k in columns),
            "experiments": (None,) * len(columns),
        }
        kept |= {"fixed": self.fixed, "units_of_fixed": self.units_of_fixed, "order": self.order}
        space._set(**{"names": tuple(names), "low": low, "high": high, "per_experiment": (), "parameters": tuple(names), **kept, **others})
        return space

    def _set(self, **fields: Any) -> None:
        for name, value in fields.items():
            object.__setattr__(self, name, value)


def _is_number(limits: tuple[float, float] | float) -> TypeIs[float]:
    return isinstance(limits, Real) and not isinstance(limits, bool)


def _number(name: str, value: SupportsFloat) -> float:
    """The value of a fixed parameter. Raises InputError for one that is not finite."""
    try:
        number = float(value)
    except OverflowError:
        number = np.inf
    if not np.isfinite(number):
        raise InputError(f"parameters.{name}: fixed must be a finite number, not {number!r}.")
    return number


def _check_range(name: str, limits: Any, scale: str) -> None:
    """Raise InputError for what is no range, or none of this scale."""
    limits = list(limits) if isinstance(limits, tuple) else limits
    try:
        low, high = (float(limit) for limit in limits)
    except (TypeError, ValueError, OverflowError):
        low = high = np.nan
    if not (np.isfinite(low) and np.isfinite(high) and low < high and np.isfinite(high - low)):
        raise InputError(f"parameters.{name}: range must be [low, high] with finite low < high, not {limits!r}.")
    if scale not in SCALES:
        raise InputError(f'parameters.{name}: scale must be "linear" or "log", not "{printable(scale, 60)}"{did_you_mean(scale, SCALES)}.')
    if scale == LOG and not (low > 0 and np.isfinite(high / low)):
        raise InputError(f'parameters.{name}: scale = "log" needs a range of numbers above 0, not {limits!r}.')


def _check_known(what: str, given: Collection[str], known: Collection[str], fixed: Collection[str] = ()) -> None:
    """Raise InputError for names that are no parameters, or those of fixed ones where that makes no sense."""
    if both := sorted(set(given) & set(fixed)):
        raise InputError(f"{what}: {', '.join(both)} is fixed, and a parameter with a range was expected.")
    if unknown := sorted(set(given) - set(known)):
        raise InputError(f"{what}: {', '.join(unknown)} is not among the parameters {', '.join(known)}.")


def _of_experiment(name: str, experiments: Sequence[str], number: int) -> str:
    """What a parameter's value in one experiment is called."""
    return f"{name} ({experiments[number]})" if number < len(experiments) else name


@dataclass(frozen=True, eq=False)
class Samples:
    """Points of the parameter space to be evaluated: `ids` (N,) integers, `theta` (N, n) in the order of `names`."""

    ids: NDArray[np.int64]
    theta: NDArray[np.float64]
    names: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.ids)

    def __repr__(self) -> str:
        return f"Samples({len(self)} of {', '.join(self.names)})"

    def take(self, rows: Sequence[int] | NDArray[np.integer] | NDArray[np.bool_] | slice) -> Samples:
        """The given rows (indices, a mask or a slice), in that order."""
        return Samples(self.ids[rows], self.theta[rows], self.names)
