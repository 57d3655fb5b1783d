"""The reference that a simulated triaxial test is compared with: that of a calibration file, or a laboratory file as it stands."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import typer

from graincal.campaign import Experiment, Result
from graincal.campaign.config import ExperimentEntry, read_references
from graincal.data import InputError, Reference
from graincal.models import TriaxialTest
from graincal.models.stress_path import RETURNED


def read_comparison(path: Path, confining_pressure: float, measured_like: Experiment | None = None) -> Reference:
    """The reference of a calibration file (.toml), of several the one at this confining pressure (Pa); or a laboratory file's, which says nothing of its
    errors: they are taken to be those of an experiment, where one is given.

    Raises InputError where none or several fit, or where a triaxial test does not return what the reference holds.
    """
    reference = _of_calibration(path, confining_pressure) if path.suffix == ".toml" else _of_laboratory(path, confining_pressure, measured_like)
    if reference.control_name != "axial_strain":
        raise InputError(f"{path}: the reference's control is {reference.control_name}, and a triaxial test is compared over axial_strain.")
    if missing := [name for name in reference.names if name not in RETURNED]:
        raise InputError(f"{path}: a triaxial test returns {', '.join(RETURNED)}, and the reference holds {missing[0]}.")
    return reference


def say_how_it_was_read(path: Path, reference: Reference) -> None:
    """What was taken for granted of a reference, beside a command's results."""
    for note in reference.notes:
        typer.echo(f"{path}: {note}", err=True)


def calibrated_against(result: Result, reference: Reference) -> str | None:
    """The experiment of a campaign whose test this is, and which it therefore cannot be said to predict; None where it is another test."""

    def the_same(known: Reference) -> bool:
        # By what was measured: the same file may have been read by another convention of strain, and one of the two only to some strain.
        rows = min(len(known.control), len(reference.control))
        shared = [(known.observables[name][:rows], reference.observables[name][:rows]) for name in set(known.names) & set(reference.names)]
        return any(np.ptp(values) > 0 and np.array_equal(values, others) for values, others in shared)

    return next((experiment.name for experiment in result.experiments if the_same(experiment.reference)), None)


def _of_laboratory(path: Path, confining_pressure: float, measured_like: Experiment | None) -> Reference:
    reference = Reference.read(path, confining_pressure=confining_pressure)
    other = measured_like.reference if measured_like else reference
    errors = {name: error for name, error in other.measurement_errors.items() if name in reference.names}
    step = other.control_step if other.control_name == reference.control_name else 0.0
    if not (errors or step):
        return reference
    taken = f'measurement errors are taken to be those of "{measured_like.name}".'
    return Reference(
        reference.control, reference.observables, measurement_errors=errors, control_name=reference.control_name, control_step=step, notes=(*reference.notes, taken)
    )


def settings_of(path: Path, confining_pressure: float) -> dict[str, Any]:
    """The settings of the model whose reference `read_comparison` takes from a calibration file; none for a laboratory file."""
    return _in_calibration(path, confining_pressure)[0].model.given() if path.suffix == ".toml" else {}


def _of_calibration(path: Path, confining_pressure: float) -> Reference:
    return _in_calibration(path, confining_pressure)[1]


def _in_calibration(path: Path, confining_pressure: float) -> tuple[ExperimentEntry, Reference]:
    found = read_references(path)
    # A model of one's own may stand for any test; of the built-in ones, a triaxial test is compared with triaxial ones.
    found = [(entry, reference) for entry, reference in found if entry.model.kind in (TriaxialTest.kind, "python")]
    pressures = [getattr(entry.model, "confining_pressure", None) for entry, _ in found]
    fitting = [pair for pressure, pair in zip(pressures, found) if pressure is None or np.isclose(pressure, confining_pressure)]
    if len(fitting) == 1:
        return fitting[0]
    there = ", ".join(f'"{entry.name}"' + (f" at {pressure:g} Pa" if pressure else "") for pressure, (entry, _) in zip(pressures, found))
    if not found:
        raise InputError(f"{path}: a triaxial experiment was expected, to compare a triaxial test with, and there is none.")
    raise InputError(f"{path}: one experiment at the confining pressure of {confining_pressure:g} Pa was expected, and there {'are' if len(found) > 1 else 'is'} {there}.")
