"""One test of a calibration: a model and the reference it is compared with."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graincal.data import Failure, InputError, Reference, Response, Samples
from graincal.dem.siblings import sibling_particles
from graincal.execution import Outcomes, Task
from graincal.inference.likelihood.errors import curve_error
from graincal.inference.likelihood.packings import Siblings
from graincal.interpolation import interpolate
from graincal.models import Model, PythonModel, StressPathTest
from graincal.models.stress_path import Abscissa

Hopeless = Callable[[int, NDArray[np.float64]], bool]


@dataclass(frozen=True, eq=False)
class Experiment:
    """A test by its name, the model that runs it and the reference that was measured."""

    name: str
    model: Model
    reference: Reference

    def __repr__(self) -> str:
        return f'Experiment "{self.name}": {self.model}\n{self.reference}'

    @property
    def siblings(self) -> Siblings | None:
        """How the model can be run on packings like its own; None where it cannot."""
        if not isinstance(self.model, StressPathTest):
            return None
        # What packings differ by goes with the root of their grains' number.
        return Siblings(len(self.model.packings), sibling_particles(self.model.first_packing) / self.model.first_packing.count)

    def tasks(self, samples: Samples) -> Sequence[Task]:
        """A task for each sample, whose response is on the model's own states, and is to be `compared`."""
        return self.model.tasks(samples, self.reference.control)

    def evaluate(self, samples: Samples, workers: int | None = None, hopeless: Hopeless | None = None) -> Outcomes:
        """Evaluate each sample and yield (row, outcome) in order of completion; a Response is on the model's own states, and can be compared with the reference.

        hopeless(id, rows): whether a sample need not be run to its end, by the observables at the first of the reference's rows (t, J); asked where the model can be watched.
        """
        watch = None if hopeless is None else lambda id, response: hopeless(id, self.so_far(response))
        with closing(self.model.evaluate(samples, self.reference.control, workers, watch)) as outcomes:
            for row, outcome in outcomes:
                yield row, self.compared(outcome)

    def expected_particle_steps(self, samples: Samples) -> NDArray[np.float64] | None:
        """About what runs of samples cost, (N,), in particle-steps of the built-in engine; None for other models."""
        if not isinstance(self.model, StressPathTest):
            return None
        return self.model.expected_particle_steps(samples, self.reference.control)

    def abscissa(self, at: NDArray[np.float64]) -> Abscissa:
        """What curves of this test are drawn over at the control values (S,): most over these, and a cycle over its stress."""
        return self.model.abscissa(at) if isinstance(self.model, StressPathTest) else Abscissa(self.reference.control_name, at)

    def observables(self, response: Response) -> NDArray[np.float64]:
        """What a response is compared with the reference by: its observables at the reference's rows, (T, J); NaN from the row on to which it does not come, for
        it was stopped early."""
        return self.observables_of([response])[0]

    def observables_of(self, responses: Sequence[Response]) -> NDArray[np.float64]:
        """Those of several responses, (N, T, J)."""
        found = np.full((len(responses), *self.reference.values.shape), np.nan)
        for rows, curves in self._met(responses, self.reference.names):
            found[rows, : curves.shape[1]] = curves
        return found

    def recorded_errors(self, responses: Sequence[Response]) -> NDArray[np.float64]:
        """How far responses are from what was recorded and not fitted, (N, R), percent (`curve_error`): over the rows that a response comes to, where it was stopped early; NaN where one of its values
        there is not finite."""
        recorded = self.reference.recorded
        found = np.full((len(responses), len(recorded)), np.nan)
        for rows, curves in self._met(responses, tuple(recorded)) if recorded else ():
            if count := curves.shape[1]:
                errors = curve_error(curves, np.stack([values[:count] for values in recorded.values()], axis=1), axis=-2)
                found[rows] = np.where(np.isfinite(curves).all(axis=1), errors, np.nan)
        return found

    def _met(self, responses: Sequence[Response], names: Sequence[str]) -> Iterator[tuple[list[int], NDArray[np.float64]]]:
        """Quantities (n, t, K) of the responses in these n rows, at the first t of the reference's rows, to which they come."""
        for rows in _alike(responses):
            first = responses[rows[0]]
            values = {name: np.stack([responses[row].values[name] for row in rows], axis=-1) for name in names}
            met = interpolate(replace(first, values=values), self.reference.control)
            if isinstance(met, Response):
                yield rows, np.moveaxis(np.stack([met.values[name] for name in names], axis=1), -1, 0)

    def so_far(self, response: Response) -> NDArray[np.float64]:
        """The observables of a run that goes on, at the first of the reference's rows (t, J) that no further state would change."""
        compared = {name: response.values[name] for name in self.reference.names}
        met = interpolate(replace(response, values=compared, details={**response.details, "stopped": 1}), self.reference.control)
        assert isinstance(met, Response), "one that has not ended need not cover the reference"
        return met.observables(self.reference.names)

    def compared(self, outcome: Response | Failure) -> Response | Failure:
        """An outcome: where it is a response that cannot be compared with the reference, or that misses something that was measured, fitted or not, why."""
        if isinstance(outcome, Failure):
            return outcome
        if missing := [name for name in self.reference.measured if name not in outcome.values]:
            return Failure("output", f"the model returns {', '.join(outcome.values)}, and the reference needs {', '.join(missing)} too.", outcome.details)
        return self.usable(outcome)

    def usable(self, response: Response) -> Response | Failure:
        """The response, which holds all observables, or why these cannot be compared with the reference."""
        met = interpolate(response, self.reference.control)
        return met if isinstance(met, Failure) else not_finite(met, self.reference.names, self.reference.control_name) or response


def no_reference(model: Model, to: float | ArrayLike, observables: Sequence[str], control_name: object = None, recorded: Sequence[str] = ()) -> Reference:
    """What stands for a reference where runs are made for none: control values up to the last one, and nothing that was measured. recorded: what a model must return beside the observables.

    Raises InputError for a last value that is none, and where the model is a function that returns values at a reference's rows alone.
    """
    if isinstance(model, PythonModel) and model.control is None and np.ndim(to) == 0:
        raise InputError(
            f"the function returns values at the rows of a reference, so the last one, {float(np.asarray(to)):g}, does not say at which: leave --to out (in Python, list all rows as to), "
            "or name the function's own values as control."
        )
    control = np.atleast_1d(np.asarray(to, dtype=np.float64))
    if control.ndim != 1 or not np.all(np.isfinite(control)) or control[-1] <= 0:
        raise InputError(f"explore: the last control value must be a positive number, not {to!r}.")
    if len(control) == 1:
        control = control[0] * np.array([0.5, 1.0])
    name = control_name if isinstance(control_name, str) else "axial_strain"
    nothing = np.ones(len(control))
    return Reference(control, dict.fromkeys(observables, nothing), control_name=name, recorded=dict.fromkeys(recorded, nothing))


def not_finite(response: Response, names: Sequence[str], control_name: str) -> Failure | None:
    """Why a response that holds these quantities cannot be used, where one of them is not finite at one of its control values."""
    for name in names:
        finite = np.isfinite(response.values[name])
        if not finite.all():
            return Failure("output", f"{name} is not finite at {control_name} {response.control[np.argmin(finite)]:g}.", response.details)
    return None


def _alike(responses: Sequence[Response]) -> list[list[int]]:
    """Rows of responses that are on the same states, so that all can be interpolated at once."""
    groups: dict[tuple, list[int]] = {}
    for row, response in enumerate(responses):
        groups.setdefault((response.control.tobytes(), response.stopped, response.control_name, response.in_pascal, response.turns), []).append(row)
    return list(groups.values())
