"""What is possible and can be calibrated, and yet is seldom meant."""

from __future__ import annotations

from graincal.campaign.calibration import Calibration
from graincal.data import Reference
from graincal.execution import available_cores
from graincal.laboratory.backbone import first_movement


def doubts(calibration: Calibration) -> list[str]:
    """Each as a sentence for whoever asked for the calibration."""
    said = [
        f'Experiment "{experiment.name}": the first states dilate, and a drained sample normally contracts first; if the file counts contraction as '
        'negative, its reference needs compression = { volumetric_strain = "negative" }.'
        for experiment in calibration.experiments
        if _dilates_first(experiment.reference)
    ]
    if calibration.number_of_workers > (cores := available_cores()):
        said.append(f"{calibration.number_of_workers} workers are more than the {cores} core{'s' * (cores > 1)} that this process may use: evaluations that compute are no faster for it.")
    return said


def _dilates_first(reference: Reference) -> bool:
    volumetric_strain = reference.observables.get("volumetric_strain")
    return reference.control_name == "axial_strain" and volumetric_strain is not None and first_movement(volumetric_strain) < 0
