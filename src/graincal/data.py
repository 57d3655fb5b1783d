"""The plain records that pass between layers: parameters, samples, references, responses. Arrays are float64 and read-only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from numbers import Real
from os import PathLike
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, SupportsFloat

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graincal.arrays import read_only
from graincal.errors import InputError
from graincal.notation.printable import as_text, printable
from graincal.parameter_space import ParameterSpace, Samples

__all__ = ["LONGEST_NAME", "Failure", "InputError", "MeasurementError", "ParameterSpace", "Reference", "Response", "Samples"]

if TYPE_CHECKING:
    from graincal.laboratory import Test


@dataclass(frozen=True)
class MeasurementError:
    """How exactly an observable was measured; variances add.

    absolute: standard deviation in the observable's own unit. relative: standard deviation as a share of each value. Both are errors of a device
    (load cell, volume change, membrane), which are correlated at neighbouring states. step: of a display, or of reading a printed curve, in the
    observable's own unit; its error is uniform, of variance step^2 / 12. noise: standard deviation of what differs from row to row, in the observable's
    own unit. The errors of both are independent from row to row.
    Raises InputError for a number that is negative or not finite, or when all are zero.
    """

    absolute: float = 0.0
    relative: float = 0.0
    step: float = 0.0
    noise: float = 0.0

    def __post_init__(self) -> None:
        for name in ("absolute", "relative", "step", "noise"):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, (int, float)) or not (np.isfinite(value) and value >= 0):
                raise InputError(f"a measurement error's {name} must be a number, not negative, not {value!r}.")
        if not (self.absolute or self.relative or self.step or self.noise):
            raise InputError("a measurement error needs an absolute or relative standard deviation, a step or a noise above 0.")

    def independent_variance(self) -> float:
        """Of one row: of the step and the noise."""
        return self.step**2 / 12 + self.noise**2


def _checked_errors(given: Mapping[str, MeasurementError | float], names: Sequence[str]) -> dict[str, MeasurementError]:
    """Measurement errors by observable. Raises InputError for one of no observable, and for a number that is not positive."""
    if unknown := set(given) - set(names):
        raise InputError(f"reference: measurement errors are given for {', '.join(sorted(unknown))}, the observables are {', '.join(names)}.")
    errors = {}
    for name, error in given.items():
        if not isinstance(error, MeasurementError) and not (np.isfinite(error) and error > 0):
            raise InputError(f"reference: the measurement error of {name} must be a positive number, not {error}.")
        errors[name] = error if isinstance(error, MeasurementError) else MeasurementError(absolute=float(error))
    return errors


@dataclass(frozen=True, init=False, eq=False)
class Reference:
    """What a test measured: observables on a control variable, plain SI units and fractions, compression positive, logarithmic strain.

    `control` (T,) is strictly increasing; `observables` maps names to (T,); `variance_shares` maps the same names to the relative variance w~
    (equal by default; the smaller, the more trusted); `measurement_errors` maps names to `MeasurementError`s, or to absolute standard deviations.
    `recorded` maps names to (T,) too: what was measured beside the observables and is not fitted. No filter sees it; a model must return it, and how far its responses are from it is told
    (Hartmann, Cheng, Thornton 2022, section 4.4).
    `control_step`: the step to which the control was read, in its unit. `simulated`: whether a simulation made this reference, which then scatters
    like one. Both, and the measurement errors, matter to the posterior alone. `notes` say what was done when it was read, and `read_as` what its columns were read as.
    For programs beside the notes: `cut` is whether rows were left out beyond a last control that somebody chose; `at_pressure` names the stresses, and the stress ratio, that a constant
    lateral stress made; `turned` the quantities whose sign was changed; and `idle` holds those of the notes that say of an option that it changed nothing.
    Raises InputError for lengths that differ, values that are not finite, a control that does not increase, or a quantity that is both observable and recorded.
    """

    control: NDArray[np.float64]
    observables: Mapping[str, NDArray[np.float64]]
    variance_shares: Mapping[str, float]
    measurement_errors: Mapping[str, MeasurementError]
    control_name: str
    control_step: float
    simulated: bool
    recorded: Mapping[str, NDArray[np.float64]]
    notes: tuple[str, ...] = field(default=())
    read_as: tuple[str, ...] = field(default=())
    cut: bool = False
    at_pressure: tuple[str, ...] = field(default=())
    turned: tuple[str, ...] = field(default=())
    idle: tuple[str, ...] = field(default=())

    def __init__(
        self,
        control: ArrayLike,
        observables: Mapping[str, ArrayLike],
        variance_shares: Mapping[str, float] | None = None,
        measurement_errors: Mapping[str, MeasurementError | float] | None = None,
        *,
        control_name: str = "axial_strain",
        control_step: float = 0.0,
        simulated: bool = False,
        recorded: Mapping[str, ArrayLike] | None = None,
        notes: tuple[str, ...] = (),
        read_as: tuple[str, ...] = (),
        cut: bool = False,
        at_pressure: tuple[str, ...] = (),
        turned: tuple[str, ...] = (),
        idle: tuple[str, ...] = (),
    ) -> None:
        control = read_only(control, ndim=1, what=f"reference: {control_name}")
        columns, beside = (
            {name: read_only(values, ndim=1, what=f"reference: {name}") for name, values in each.items()} for each in (observables, recorded or {})
        )
        if not columns:
            raise InputError("reference: at least one observable is needed.")
        if twice := [name for name in beside if name in columns]:
            raise InputError(f"reference: {twice[0]} is an observable, which is fitted, and cannot be recorded without being fitted too.")
        if control.size == 0:
            raise InputError(f"reference: {control_name} has no values.")
        for name, values in {control_name: control, **columns, **beside}.items():
            if values.size != control.size:
                raise InputError(f"reference: {name} has {values.size} values and {control_name} {control.size}.")
            if not np.all(np.isfinite(values)):
                raise InputError(f"reference: {name} is not a finite number in row {1 + int(np.argmin(np.isfinite(values)))}.")
        if not np.all(np.diff(control) > 0):
            row = 2 + int(np.argmin(np.diff(control) > 0))
            raise InputError(f"reference: {control_name} must increase from row to row, and does not at row {row}.")
        shares = {name: 1.0 / len(columns) for name in columns} if variance_shares is None else dict(variance_shares)
        if set(shares) != set(columns):
            raise InputError(f"reference: variance shares are given for {', '.join(shares)}, the observables are {', '.join(columns)}.")
        for name, share in shares.items():
            if not (np.isfinite(share) and share > 0):
                raise InputError(f"reference: the variance share of {name} must be a positive number, not {share}.")
        if not (np.isfinite(control_step) and control_step >= 0):
            raise InputError(f"reference: the step of {control_name} must be a number, not negative, not {control_step}.")
        errors = _checked_errors(measurement_errors or {}, tuple(columns))
        object.__setattr__(self, "control", control)
        object.__setattr__(self, "observables", MappingProxyType(columns))
        object.__setattr__(self, "recorded", MappingProxyType(beside))
        object.__setattr__(self, "variance_shares", MappingProxyType({name: float(shares[name]) for name in columns}))
        object.__setattr__(self, "measurement_errors", MappingProxyType(errors))
        object.__setattr__(self, "control_name", control_name)
        object.__setattr__(self, "control_step", float(control_step))
        object.__setattr__(self, "simulated", bool(simulated))
        object.__setattr__(self, "cut", bool(cut))
        for name, said in {"notes": notes, "read_as": read_as, "at_pressure": at_pressure, "turned": turned, "idle": idle}.items():
            object.__setattr__(self, name, tuple(said))

    def __repr__(self) -> str:
        from graincal.notebook import as_text

        return as_text(self)

    def _repr_html_(self) -> str:
        """What a notebook shows: a table of what was read, the notes, and the curves."""
        from graincal.notebook import as_html

        return as_html(self)

    @property
    def names(self) -> tuple[str, ...]:
        """The observables' names, in the order of the columns of `values`."""
        return tuple(self.observables)

    @property
    def measured(self) -> Mapping[str, NDArray[np.float64]]:
        """The observables and what was recorded beside them, by name: (T,) each."""
        return {**self.observables, **self.recorded}

    @property
    def values(self) -> NDArray[np.float64]:
        """The observables y, (T, J)."""
        return np.stack(list(self.observables.values()), axis=1)

    @property
    def shares(self) -> NDArray[np.float64]:
        """The variance shares w~, (J,)."""
        return np.array([self.variance_shares[name] for name in self.names])

    def of_one(self, name: str, error: MeasurementError) -> Reference:
        """One of the observables by itself, with its measurement error."""
        return Reference(
            self.control,
            {name: self.observables[name]},
            None,
            {name: error},
            control_name=self.control_name,
            control_step=self.control_step,
            simulated=self.simulated,
            notes=self.notes,
            cut=self.cut,
        )

    @classmethod
    def read(
        cls,
        path: str | PathLike[str],
        control: str = "axial_strain",
        observables: Sequence[str] | Mapping[str, float] = ("stress_ratio", "volumetric_strain"),
        **options: Any,
    ) -> Reference:
        """Read a laboratory file into SI units and fractions.

        observables: names, or a mapping of names to variance shares. recorded: names of what is read beside them and not fitted. Other options and errors are those of `graincal.laboratory.read_test`, which are also the keys of
        [experiment.reference] in a calibration file: columns (by header, number or letter), units, strain, compression, unloading, until, stage, rows, zero, sheet, encoding,
        sample_volume, sample_height, confining_pressure, turns; and measurement_errors.
        """
        from graincal.laboratory import read_test

        return cls.of(read_test(path, control=control, observables=observables, **options))

    @classmethod
    def of(cls, test: Test) -> Reference:
        """The reference that a laboratory file was read as."""
        return cls(**vars(test))


@dataclass(frozen=True, eq=False)
class Response:
    """What a model returned for one sample: `values` maps names of observables and quantities of interest to (S,), on `control` (S,).

    `control` are the model's own states, which cover what was asked for; `graincal.interpolation.interpolate` gives the values between them.
    `details` holds scalars about the evaluation (steps, flagged states, seconds of wall time; a "stopped" that is not 0 says that it ended early, on
    request, and `control` with it). `control_name`: what the control is of. `confining_pressure`: Pa, where the test has one that all its stresses are in
    proportion to; `in_pascal` names the values that are stresses. `turns`: control values at which the path turns around while its control goes on."""

    control: NDArray[np.float64]
    values: Mapping[str, NDArray[np.float64]]
    details: Mapping[str, float] = field(default_factory=dict)
    control_name: str = ""
    confining_pressure: float | None = None
    in_pascal: tuple[str, ...] = ()
    turns: tuple[float, ...] = ()

    def __repr__(self) -> str:
        flagged = f", {self.details['flagged']:g} flagged" if "flagged" in self.details else ""
        return f"Response({len(self.control)} states{flagged}: {', '.join(self.values)})"

    def _repr_html_(self) -> str:
        """What a notebook shows: a table of the values in their units, and the first curves."""
        from graincal.notebook import response_as_html

        return response_as_html(self)

    @property
    def stopped(self) -> bool:
        """Whether the evaluation ended early, on request: these are the first of its states."""
        return bool(self.details.get("stopped"))

    def observables(self, names: tuple[str, ...]) -> NDArray[np.float64]:
        """The named values as columns, (S, J)."""
        return np.stack([self.values[name] for name in names], axis=1)

    def at_pressure(self, confining_pressure: float) -> Response:
        """The response of the same test at another confining pressure (Pa), with moduli and the grains' density in the same proportion.

        In units of its confining pressure the test is the same, grain for grain. So strains and ratios stay, and what is in Pa, the control too, is
        multiplied. With log_E the log10 of the modulus in Pa, it is that of log_E + log10(confining_pressure / self.confining_pressure).
        Raises InputError for a response that does not say its pressure, and for a pressure that is not positive.
        """
        if self.confining_pressure is None:
            raise InputError("this response does not say at which confining pressure its test was run, and so it cannot be taken to another one.")
        if not (np.isfinite(confining_pressure) and confining_pressure > 0):
            raise InputError(f"confining_pressure must be a positive number, not {confining_pressure!r}.")
        factor = confining_pressure / self.confining_pressure
        values = {name: factor * column if name in self.in_pascal else column for name, column in self.values.items()}
        control = factor * self.control if self.control_name in self.in_pascal else self.control
        return replace(self, control=control, values=values, confining_pressure=float(confining_pressure))


LONGEST_KIND, LONGEST_REASON, LONGEST_NAME = 50, 1_000, 500
"""Characters of a failure's kind and reason, and of names that a model gives."""


@dataclass(frozen=True)
class Failure:
    """An evaluation that gave no usable response: `kind` is a word ("diverged", "flagged", "error", ...; each model says its own), `reason` a sentence.

    Whatever it is made of, it can be shown, sent and stored: kind and reason are made printable and cut to 50 and 1,000 characters, a kind that is no text is "error", and of details those are kept that are numbers under a
    name (NaN and infinities too).
    """

    kind: str
    reason: str
    details: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        kind = "_".join(printable(self.kind, LONGEST_KIND).split()) if isinstance(self.kind, str) else ""
        object.__setattr__(self, "kind", kind or "error")
        object.__setattr__(self, "reason", printable(self.reason, LONGEST_REASON))
        object.__setattr__(self, "details", _numbers_by_name(self.details))

    def __repr__(self) -> str:
        return f"Failure({self.kind}: {self.reason})"


def _numbers_by_name(details: Mapping[str, float]) -> dict[str, float]:
    """Those of somebody's details that are numbers, by their names."""
    found: dict[str, float | None] = {}
    # A mapping of a class of somebody's may do anything.
    try:
        for name, value in list(details.items()):
            if isinstance(name, str) and isinstance(value, (Real, np.bool_)):
                found[printable(as_text(name), LONGEST_NAME)] = _as_float(value)
    except Exception:
        pass
    return {name: value for name, value in found.items() if value is not None}


def _as_float(value: SupportsFloat) -> float | None:
    try:
        return float.__float__(float(value))
    # A whole number beyond all floats, or a class of somebody's.
    except Exception:
        return None
