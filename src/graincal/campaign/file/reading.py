"""How the laboratory file of an experiment was read, as far as the campaign's calibration file says: other files may be read likewise."""

from __future__ import annotations

from pydantic import ValidationError

from graincal.campaign.asked.calibration import Calibration
from graincal.campaign.file.experiments import ReferenceFile
from graincal.laboratory.another_file import Before
from graincal.notation.toml import NotTOML, read_toml


def read_before(calibration: Calibration, experiment: str) -> Before | None:
    """What [experiment.reference] of the experiment of that name says; None where it says nothing but the file, and for a campaign from Python."""
    try:
        entries = read_toml(calibration.source).get("experiment", [])
    except NotTOML:
        return None
    table = next((entry.get("reference") for entry in entries if entry.get("name") == experiment), None)
    if not isinstance(table, dict):
        return None
    try:
        options = ReferenceFile.model_validate(table).given("file")
    except ValidationError:
        # Of another version, whose keys are not known any more.
        return None
    before = Before(f'"{experiment}"', options)
    return before if before.carried else None
