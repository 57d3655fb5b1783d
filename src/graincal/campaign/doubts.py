"""What is possible and can be calibrated, and yet is seldom meant."""

from __future__ import annotations

import numpy as np

from graincal.campaign.calibration import POSTERIOR, Calibration
from graincal.data import Reference
from graincal.execution import available_cores
from graincal.laboratory.backbone import first_movement
from graincal.laboratory.quantities import unsheared
from graincal.models import StressPathTest
from graincal.laboratory.reading import sign_change
from graincal.models.contact_parameters import unusual_parameters
from graincal.models.stress_path import STRAINS, unusual


def doubts(calibration: Calibration) -> list[str]:
    """Each as a sentence for whoever asked for the calibration."""
    said = [
        f'Experiment "{experiment.name}": the volumetric strain says that the sample dilates first, and a drained sample normally contracts first; '
        + _turn(experiment.reference)
        for experiment in calibration.experiments
        if _dilates_first(experiment.reference)
    ]
    tests = [(experiment.name, experiment.model) for experiment in calibration.experiments if isinstance(experiment.model, StressPathTest)]
    for name, test in tests:
        said += [f'Experiment "{name}": {doubt}' for doubt in unusual(test)]
    said += [f'Experiment "{experiment.name}": {doubt}' for experiment in calibration.experiments if (doubt := _unsheared(experiment.reference))]
    said += [f'Experiment "{experiment.name}": {doubt}' for experiment in calibration.experiments for doubt in _large_errors(experiment.reference)]
    if calibration.method == POSTERIOR and calibration.filter_options.get("packing_scatter", True):
        said += [
            f'Experiment "{experiment.name}": its reference is a simulation, and is taken for one on another packing like this one; where it is of this one, packing_scatter = false under [filter] says so.'
            for experiment in calibration.experiments
            if experiment.reference.simulated and experiment.siblings
        ]
    if tests:
        space = calibration.space.of_experiment(0)
        said += unusual_parameters({f"parameters.{name}": (float(low), float(high)) for name, low, high in zip(space.names, space.low, space.high)})
    if calibration.number_of_workers > (cores := available_cores()):
        said.append(f"{calibration.number_of_workers} workers are more than the {cores} core{'s' * (cores > 1)} that this process may use: evaluations that compute are no faster for it.")
    return said


def thinning_notes(calibration: Calibration) -> list[str]:
    """What was done with dense references, a sentence for each."""
    return [
        f'Experiment "{experiment.name}": the likelihood sees the {len(thinning.whole.control)} rows put together to {len(thinning.kept.control)} states, and errors ε are of all rows; '
        "thin = false under [filter] keeps every row."
        for experiment, thinning in zip(calibration.experiments, calibration.blank_filter().thinnings)
        if thinning.thinned
    ]


def _large_errors(reference: Reference) -> list[str]:
    """Measurement errors as large as what was measured: most of them are percent that were meant to be fractions."""
    errors = {name: max(error.absolute, error.step, error.noise) for name, error in reference.measurement_errors.items()} | {reference.control_name: reference.control_step}
    measured = {name: np.ptp(values) for name, values in reference.observables.items()} | {reference.control_name: np.ptp(reference.control)}
    relative = [
        f"{name} is said to be measured to {error.relative:g} of each value, which is {100 * error.relative:g} %; errors are fractions here, not percent."
        for name, error in reference.measurement_errors.items()
        if error.relative > 0.3
    ]
    return relative + [
        f"{name} is said to be measured to {error:g}, and it varies by {measured[name]:.3g} in all; strains and their errors are fractions here, not percent."
        for name, error in errors.items()
        if error > 0.5 * measured[name] > 0
    ]


def _unsheared(reference: Reference) -> str | None:
    """What is to be said of a test by axial strain whose stress ratio stays at 1; None for others."""
    ratio = reference.observables.get("stress_ratio")
    if reference.control_name not in STRAINS or ratio is None:
        return None
    return unsheared(float(ratio.min()), float(ratio.max()))


def _turn(reference: Reference) -> str:
    """How the reference is read with the other sign."""
    if sign_change("volumetric_strain") in reference.notes:
        return 'if the file counts contraction as positive, its reference needs compression = { volumetric_strain = "positive" }.'
    return 'if the file counts contraction as negative, its reference needs compression = { volumetric_strain = "negative" }.'


def _dilates_first(reference: Reference) -> bool:
    """Whether the volumetric strain looks turned. A very dense sample may dilate from its first state on: then its stress ratio has a peak."""
    volumetric_strain = reference.observables.get("volumetric_strain")
    if reference.control_name != "axial_strain" or volumetric_strain is None or first_movement(volumetric_strain) >= 0:
        return False
    turns = volumetric_strain[-1] - volumetric_strain.min() > 0.1 * np.ptp(volumetric_strain)
    stress_ratio = reference.observables.get("stress_ratio")
    has_peak = stress_ratio is not None and stress_ratio.max() - stress_ratio[-1] > 0.05 * np.ptp(stress_ratio)
    return bool(turns or not has_peak)
