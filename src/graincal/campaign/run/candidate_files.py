"""Tests that may be made next, from a calibration file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.file.config import read_entries
from graincal.campaign.file.experiments import ExperimentEntry
from graincal.campaign.run.candidate_tests import CONTROLS, LAST_STRAIN, LAST_STRESS, CandidateTest, rows_to
from graincal.data import InputError
from graincal.models import Model, StressPathTest
from graincal.models.stress_path import STRAINS


def candidate_tests(path: str | Path) -> list[CandidateTest]:
    """The experiments of a calibration file as tests, with their models, observables and measurement errors.

    A test is measured at the rows of its reference, where it has one; else at its states at rest, up to an axial strain of 0.2 or to twenty times its confining pressure.
    Raises InputError for a file that says something else, and for a test that would not know how far it goes.
    """
    path = Path(path)
    return [_candidate(entry, path) for entry in read_entries(path)]


def _candidate(entry: ExperimentEntry, path: Path) -> CandidateTest:
    errors = {name: observable.error for name, observable in entry.observables.items() if observable.error}
    try:
        model = entry.model.build(path.parent, entry.control)
        return CandidateTest(entry.name, model, _rows(entry, model, path.parent), tuple(entry.observables), errors)
    except InputError as error:
        raise InputError(f'{path}: experiment "{entry.name}": {error}') from error


def _rows(entry: ExperimentEntry, model: Model, folder: Path) -> NDArray[np.float64]:
    if entry.reference is not None:
        return entry.read_reference(folder).control
    if isinstance(model, StressPathTest) and model.control in STRAINS:
        return rows_to(model, LAST_STRAIN)
    if isinstance(model, StressPathTest) and model.control in CONTROLS.values():
        return rows_to(model, LAST_STRESS * model.confining_pressure)
    raise InputError(f"a reference was expected, whose {entry.control} says how far the test goes.")
