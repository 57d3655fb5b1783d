"""The reference that a simulated test is compared with: that of a calibration file, or a laboratory file by its columns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from graincal.campaign import Experiment
from graincal.campaign.file.config import read_references
from graincal.campaign.file.experiments import ExperimentEntry
from graincal.cli.saying import say
from graincal.data import InputError, Reference
from graincal.laboratory.another_file import Before, read_another
from graincal.laboratory.quantities import STRESS_FORMS
from graincal.laboratory.table import read_table
from graincal.laboratory.understanding.remarks import confining_pressures
from graincal.models import TESTS, OedometricTest, StressPathTest, TriaxialTest, UndrainedTest
from graincal.models.compression import CompressionTest
from graincal.models.stress_path import RETURNED, STRAINS
from graincal.positions import POSITION
from graincal.result import Result

OTHER_PRESSURE = 0.05
"""Of a confining pressure: within it a test was made at the same one."""
COMPARED = ("stress_ratio", "volumetric_strain")
COMPARED_OF_KIND = {UndrainedTest.kind: ("deviatoric_stress", "excess_pore_pressure"), OedometricTest.kind: ("axial_stress", "void_ratio")}
"""What tests are compared by, where no experiment says it."""


@dataclass(frozen=True)
class Compared:
    """A test that a reference is compared with, as far as its reading depends on it. observables: those that are compared where the file holds them; recorded: those that are
    read beside them and not scored."""

    kind: str
    title: str
    control: str
    returned: tuple[str, ...]
    confining_pressure: float | None
    observables: tuple[str, ...]
    turns: tuple[float, ...] = ()
    recorded: tuple[str, ...] = ()

    @classmethod
    def drained(cls, confining_pressure: float) -> Compared:
        """A drained triaxial test at a confining pressure (Pa)."""
        return cls(TriaxialTest.kind, TriaxialTest.title, "axial_strain", RETURNED, confining_pressure, COMPARED)

    @classmethod
    def of(cls, test: StressPathTest, experiment: Experiment) -> Compared:
        """A test that is predicted from an experiment: of the same kind it is compared by the experiment's observables."""
        alike = isinstance(experiment.model, StressPathTest) and test.kind == experiment.model.kind
        observables = experiment.reference.names if alike else COMPARED_OF_KIND.get(test.kind, COMPARED)
        recorded = tuple(experiment.reference.recorded) if alike else ()
        return cls(
            test.kind,
            test.title,
            test.control,
            test.returned,
            test.confining_pressure,
            observables,
            tuple(test.turns) if isinstance(test, CompressionTest) else (),
            recorded,
        )

    @property
    def with_article(self) -> str:
        """What the test is called, in a sentence."""
        return f"{'an' if self.title[0] in 'aeiou' else 'a'} {self.title}"

    @property
    def reading(self) -> dict[str, Any]:
        """What the test says of its reference's reading: its lateral stress, if that is constant, and where its path turns around."""
        if self.control == POSITION:
            return {"confining_pressure": self.confining_pressure, "turns": self.turns}
        return {"confining_pressure": self.confining_pressure} if self.kind == TriaxialTest.kind else {}


def read_comparison(
    path: Path, test: Compared, measured_like: Experiment | None = None, *, asked: Mapping[str, Any] | None = None, before: Before | None = None
) -> Reference:
    """The reference of a calibration file (.toml), of several the one of this kind of test at its confining pressure; or a laboratory file's, by the columns that are `asked` for, or
    as another was read `before` (`read_another`). A laboratory file says nothing of its errors: they are taken to be those of an experiment, where one is given.

    Raises InputError where none or several fit, or where the test does not return what the reference holds.
    """
    reference = _of_calibration(path, test) if path.suffix == ".toml" else _of_laboratory(path, test, measured_like, asked or {}, before)
    if reference.control_name != test.control:
        raise InputError(f"{path}: the reference's control is {reference.control_name}, and {test.with_article} is compared over {test.control} here.")
    if missing := [name for name in reference.measured if name not in test.returned]:
        raise InputError(f"{path}: {test.with_article} returns {', '.join(test.returned)}, and the reference holds {missing[0]}.")
    return reference


def driven_as(path: Path, test: StressPathTest) -> StressPathTest:
    """The test, driven as that of a calibration file (.toml) was: in extension too, or along its cycle of stresses; as it is for a laboratory file."""
    if path.suffix != ".toml":
        return test
    entry, reference = _in_calibration(path, Compared(test.kind, test.title, test.control, test.returned, test.confining_pressure, ()))
    control = reference.control_name
    if control not in test.controls:
        raise InputError(f"{path}: the reference's control is {control}, and {test.name_with_article} is compared over {' or '.join(test.controls)}.")
    changes: dict[str, Any] = {"control": control} if control in STRAINS else {"control": control, "rest_every": None}
    if isinstance(test, CompressionTest):
        changes["turns"] = tuple(getattr(entry.model, "turns", ())) if control == POSITION else ()
    return replace(test, **changes)


def say_how_it_was_read(path: Path, reference: Reference) -> None:
    """What was taken for granted of a reference, beside a command's results."""
    for note in reference.notes:
        say(f"{path}: {note}", err=True)


def calibrated_against(result: Result, reference: Reference) -> str | None:
    """The experiment of a campaign whose test this is, and which it therefore cannot be said to predict; None where it is another test."""

    def the_same(known: Reference) -> bool:
        # By what was measured: the same file may have been read by another convention of strain, and one of the two only to some strain.
        rows = min(len(known.control), len(reference.control))
        shared = [(known.observables[name][:rows], reference.observables[name][:rows]) for name in set(known.names) & set(reference.names)]
        return any(np.ptp(values) > 0 and np.array_equal(values, others) for values, others in shared)

    return next((experiment.name for experiment in result.experiments if the_same(experiment.reference)), None)


def _of_laboratory(path: Path, test: Compared, measured_like: Experiment | None, asked: Mapping[str, Any], before: Before | None) -> Reference:
    own = [name for name in asked.get("columns", ()) if name in test.returned and name not in (test.control, "axial_strain", *STRESS_FORMS)]
    observables = tuple(dict.fromkeys((*test.observables, *(name for name in own if name not in test.recorded))))
    _refuse_other_pressure(path, test, asked)
    reference = Reference.of(read_another(path, test.control, observables, asked=asked, before=before, recorded=test.recorded, **test.reading))
    if measured_like is None:
        return reference
    other = measured_like.reference
    errors = {name: error for name, error in other.measurement_errors.items() if name in reference.names}
    step = other.control_step if other.control_name == reference.control_name else 0.0
    if not (errors or step):
        return reference
    taken = f'measurement errors are taken to be those of "{measured_like.name}".'
    return replace(reference, measurement_errors=errors, control_step=step, notes=(*reference.notes, taken))


def _refuse_other_pressure(path: Path, test: Compared, asked: Mapping[str, Any]) -> None:
    """Refuse a shear test whose file says in words that it was made at another effective confining pressure."""
    said = [value for value, effective in confining_pressures(read_table(path, encoding=asked.get("encoding"), sheet=asked.get("sheet")).remarks) if effective]
    if test.control in STRAINS and test.confining_pressure and len(said) == 1 and not np.isclose(said[0], test.confining_pressure, rtol=OTHER_PRESSURE):
        raise InputError(
            f"{path}: a line above the table says an effective confining pressure of {said[0]:g} Pa, and the test is predicted at {test.confining_pressure:g} Pa: --confining-pressure gives that of the file."
        )


def settings_of(path: Path, test: Compared) -> dict[str, Any]:
    """The settings of the model whose reference `read_comparison` takes from a calibration file; none for a laboratory file."""
    return _in_calibration(path, test)[0].model.given() if path.suffix == ".toml" else {}


def _of_calibration(path: Path, test: Compared) -> Reference:
    return _in_calibration(path, test)[1]


def _in_calibration(path: Path, test: Compared) -> tuple[ExperimentEntry, Reference]:
    found = read_references(path)
    # A model of one's own may stand for any test; of the built-in ones, a test is compared with those of its kind.
    found = [(entry, reference) for entry, reference in found if entry.model.kind == test.kind or entry.model.kind not in TESTS]
    pressures = [getattr(entry.model, "confining_pressure", None) for entry, _ in found]
    wanted = test.confining_pressure
    fitting = [pair for pressure, pair in zip(pressures, found) if pressure is None or wanted is None or np.isclose(pressure, wanted)]
    if len(fitting) == 1:
        return fitting[0]
    there = ", ".join(f'"{entry.name}"' + (f" at {pressure:g} Pa" if pressure else "") for pressure, (entry, _) in zip(pressures, found))
    if not found:
        article = "an" if test.kind[0] in "aeiou" else "a"
        raise InputError(f"{path}: {article} {test.kind} experiment was expected, to compare {article} {test.kind} test with, and there is none.")
    at = "" if test.confining_pressure is None else f" at the confining pressure of {test.confining_pressure:g} Pa"
    raise InputError(f"{path}: one experiment{at} was expected, and there {'are' if len(found) > 1 else 'is'} {there}.")
