"""Tests that may be made next: those that are looked at by default, and how others are said in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.asked.calibration import check_observables
from graincal.campaign.asked.experiment import Experiment
from graincal.data import InputError, MeasurementError, Reference
from graincal.models import Model, StressPathTest, TableTest
from graincal.models.another_test import another_test
from graincal.models.stress_path import STRAINS
from graincal.notation import numbers
from graincal.suggestion import did_you_mean

LAST_STRAIN = 0.2
"""Of a test that is driven by strain, axial, as a fraction."""

LAST_STRESS = 20.0
"""Of a test that is driven by a stress, in confining pressures."""

SEATING = 0.1
"""A compression begins at this part of the experiment's confining pressure, as in a laboratory: it goes from a light load through that pressure to twice as much."""

MEASURED = {
    "triaxial": ("stress_ratio", "volumetric_strain"),
    "constant-mean-stress": ("stress_ratio", "volumetric_strain"),
    "undrained": ("deviatoric_stress", "excess_pore_pressure"),
    "oedometric": ("axial_strain",),
    "isotropic": ("volumetric_strain",),
}
"""The observables of each kind of test. Of a compression the strain, which is nothing at its beginning, and not the void ratio, of whose peak the strain makes little."""

CONTROLS = {"oedometric": "axial_stress", "isotropic": "mean_stress"}
"""Of the tests that are driven by a stress."""

EXTENSION, TO = "extension", "to"
"""Words behind a kind."""


@dataclass(frozen=True, eq=False)
class CandidateTest:
    """A test that may be made: its name, the model that runs it, the control values `at` (T,) at which it is measured, the observables, and how exactly these are measured.

    measurement_errors: `MeasurementError`s or standard deviations by observable; for one that is left out, 1 % of the peak of its mean response.
    Raises InputError for fewer than two control values, values that do not increase, and observables that the model does not return.
    """

    name: str
    model: Model
    at: NDArray[np.float64]
    observables: Sequence[str]
    measurement_errors: Mapping[str, MeasurementError | float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "observables", tuple(self.observables))
        object.__setattr__(self, "measurement_errors", MappingProxyType(dict(self.measurement_errors)))
        object.__setattr__(self, "at", np.asarray(self.at, dtype=np.float64))
        if len(self.reference(np.ones((np.size(self.at), len(self.observables)))).control) < 2:
            raise InputError(f'test "{self.name}": at least two control values were expected.')
        check_observables(self.model, self.observables)

    @property
    def control_name(self) -> str:
        """What the control values are of."""
        control = getattr(self.model, "control", None)
        return control if isinstance(control, str) else "axial_strain"

    def reference(self, values: NDArray[np.float64], *, simulated: bool = False) -> Reference:
        """What the test would measure: values (T, J) of the observables."""
        return Reference(
            self.at, dict(zip(self.observables, np.transpose(values))), None, self.measurement_errors, control_name=self.control_name, simulated=simulated
        )


def candidate_test(words: str, experiment: Experiment) -> CandidateTest:
    """A test on the grains of an experiment, said as KIND [extension] [PRESSURE] [to LAST], such as "undrained", "triaxial extension 2e5", "oedometric 1e4 to 8e5", "triaxial 1e6 to 0.1".

    PRESSURE: the confining pressure, Pa; by default that of the experiment, or a tenth of it for a compression. LAST: the last control value, axial strain as a fraction or stress in Pa;
    by default 0.2, or twenty times the confining pressure. Raises InputError for anything else.
    """
    kind, *rest = words.split() or [""]
    if kind not in MEASURED:
        raise InputError(f'test "{words}": the first word must be one of {", ".join(MEASURED)}, not "{kind}"{did_you_mean(kind, MEASURED)}.')
    control = CONTROLS.get(kind, STRAINS[0])
    if rest[:1] == [EXTENSION]:
        if kind in CONTROLS:
            raise InputError(f'test "{words}": there is no {EXTENSION} of this kind, which is driven by a stress.')
        control, rest = STRAINS[1], rest[1:]
    pressure = _number(rest.pop(0), words, "a confining pressure in Pa") if rest and rest[0] != TO else None
    last = _number(rest[1], words, "the last strain, or stress in Pa,") if len(rest) == 2 and rest[0] == TO else None
    if rest and last is None:
        raise InputError(f'test "{words}": KIND [{EXTENSION}] [PRESSURE] [{TO} LAST] was expected, such as "triaxial 1e6 to 0.1".')
    return _candidate(experiment, kind, control, pressure, last)


def default_tests(experiment: Experiment, others: Sequence[Experiment] = ()) -> list[CandidateTest]:
    """The tests that are looked at where none are named, on the grains of an experiment with a built-in test, less those of `others`."""
    pressure = _pressure_of(experiment)
    tests = [
        _candidate(experiment, "triaxial", STRAINS[0], 0.4 * pressure),
        _candidate(experiment, "triaxial", STRAINS[0], 2 * pressure),
        _candidate(experiment, "undrained", STRAINS[0]),
        _candidate(experiment, "triaxial", STRAINS[1]),
        _candidate(experiment, "constant-mean-stress", STRAINS[0]),
        _candidate(experiment, "oedometric", CONTROLS["oedometric"]),
        _candidate(experiment, "isotropic", CONTROLS["isotropic"]),
    ]
    return [test for test in tests if not any(_the_same(test.model, other.model) for other in (experiment, *others))]


def _candidate(experiment: Experiment, kind: str, control: str, pressure: float | None = None, last: float | None = None) -> CandidateTest:
    by_stress = kind in CONTROLS
    if pressure is None:
        pressure = (SEATING if by_stress else 1) * _pressure_of(experiment)
    assert isinstance(experiment.model, StressPathTest), "other tests are derived from a built-in one"
    model = another_test(experiment.model, kind, confining_pressure=pressure, control=control)
    end = last if last is not None else LAST_STRESS * pressure if by_stress else LAST_STRAIN
    if by_stress and end <= pressure:
        raise InputError(f"the last stress of an {kind} test must be above its confining pressure of {pressure:g} Pa, not {end:g} Pa.")
    stated = experiment.reference.measurement_errors
    name = f"{kind.replace('-', ' ')}{f' {EXTENSION}' if control == STRAINS[1] else ''}, {numbers.pressure(pressure)}"
    if last is not None:
        name += f" to {numbers.pressure(last)}" if by_stress else f" to {100 * last:g} %"
    observables = MEASURED[kind]
    # Of what the experiment measures too, as exactly as there.
    return CandidateTest(name, model, rows_to(model, end), observables, {each: stated[each] for each in observables if each in stated})


def rows_to(model: StressPathTest, last: float) -> NDArray[np.float64]:
    """The states at rest on the way to the last control value, which is one of them."""
    states = model.states([last])
    return np.append(states[states < last * (1 - 1e-9)], last)


def _pressure_of(experiment: Experiment) -> float:
    if not isinstance(experiment.model, StressPathTest) or experiment.model.confining_pressure is None:
        raise InputError(
            f'experiment "{experiment.name}" has no confining pressure that other tests could be at: name tests with a pressure, such as "triaxial 1e5".'
        )
    return float(experiment.model.confining_pressure)


def _the_same(test: Model, other: Model) -> bool:
    """Whether another model makes the same built-in test: of the compressions, whatever its stresses."""
    if not isinstance(test, StressPathTest) or not isinstance(other, StressPathTest) or isinstance(other, TableTest) or test.kind != other.kind:
        return False
    return test.kind in CONTROLS or (test.control == other.control and bool(np.isclose(test.confining_pressure, other.confining_pressure, rtol=0.05)))


def _number(text: str, words: str, expected: str) -> float:
    """The number above 0 that a word is."""
    try:
        number = float(text)
    except ValueError:
        number = np.nan
    if not (np.isfinite(number) and number > 0):
        raise InputError(f'test "{words}": {expected} was expected as a number above 0, not "{text}".')
    return number
