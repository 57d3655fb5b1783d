"""Keys of a calibration file that are read and change nothing, and conventions that do not reach what they are meant for."""

from __future__ import annotations

from graincal.campaign.asked.calibration import POSTERIOR
from graincal.campaign.asked.doubt import Doubt
from graincal.campaign.file.config import CalibrationFile
from graincal.campaign.file.experiments import ExperimentEntry, ReferenceFile
from graincal.campaign.file.models import StressPathModel
from graincal.data import Reference
from graincal.laboratory.quantities import COMPRESSED, SIGNED, STRAINS
from graincal.models import stress_path
from graincal.positions import POSITION

_UNUSED = "key-without-effect"


def unused_in_file(file: CalibrationFile) -> list[Doubt]:
    """Of the keys that are of the whole calibration."""
    said, method, built_in = [], file.filter.method, any(isinstance(entry.model, StressPathModel) for entry in file.experiment)
    if alone := [name for name, each in file.parameters.items() if each.per_experiment and len(file.experiment) == 1]:
        said.append(f"per_experiment = true of {', '.join(alone)} changes nothing with a single experiment.")
    if not built_in and file.filter.given().get("packing_scatter"):
        said.append("packing_scatter = true changes nothing: there are no packings to differ, for no model is a built-in test.")
    if not built_in and file.filter.early_stop:
        said.append("early_stop = true changes nothing: runs of a built-in test alone can be stopped on their way.")
    if method != POSTERIOR:
        errors = [
            key
            for key in ("measurement_error", "relative_error", "step", "noise")
            if any(key in each.given() for entry in file.experiment for each in entry.observables.values())
        ]
        errors += [key for key in ("control_step", "simulated") if any(entry.reference and key in entry.reference.given() for entry in file.experiment)]
        if errors:
            said.append(
                f'{", ".join(errors)} change{"s" * (len(errors) == 1)} nothing of what method = "{method}" finds, which takes no errors of a measurement into account.'
            )
    return [Doubt(_UNUSED, sentence) for sentence in said]


def unused_in_experiment(entry: ExperimentEntry, reference: Reference) -> list[Doubt]:
    """Of the keys of one experiment, by the reference that they led to."""
    table = entry.reference
    if table is None:
        return []
    found = (*_strain(entry, table, reference), *_compression(table, reference), *_pressure(entry, table, reference))
    return [Doubt(doubt.code, doubt.sentence, entry.name) for doubt in found]


def _strain(entry: ExperimentEntry, table: ReferenceFile, reference: Reference) -> list[Doubt]:
    said = table.strain
    if said is None:
        return []
    read = set(reference.read_as)
    engineering = said == "engineering" or (isinstance(said, dict) and said.get(entry.control) == "engineering")
    if engineering and entry.control in read and entry.control in stress_path.STRAINS and entry.control not in STRAINS:
        text = f'strain = "engineering" does not reach {entry.control}, which is taken as logarithmic: give it as -ln(1 + e), of the engineering extension e.'
        return [Doubt("strain-not-converted", text)]
    if not read & {*STRAINS, *COMPRESSED, *stress_path.STRAINS}:
        return [Doubt(_UNUSED, f"strain changes nothing: no strain is read, only {', '.join(sorted(read))}.")]
    return []


def _compression(table: ReferenceFile, reference: Reference) -> list[Doubt]:
    said, read = table.compression, set(reference.read_as)
    if said != "negative" or read & set(SIGNED):
        return []
    return [
        Doubt(
            _UNUSED,
            f'compression = "negative" changes nothing: of {", ".join(sorted(read))} none has a sign that one word for all turns; name those that it is meant for.',
        )
    ]


def _pressure(entry: ExperimentEntry, table: ReferenceFile, reference: Reference) -> list[Doubt]:
    said = table.confining_pressure
    if said is None:
        return []
    model = entry.pressure
    if model is not None and entry.is_triaxial and abs(said / model - 1) > 0.01:
        text = f"reference.confining_pressure is {said:g} Pa and model.confining_pressure {model:g} Pa: the test would be simulated at another pressure than it was made at."
        return [Doubt("other-pressure", text)]
    # A position along a path counts from it.
    if not reference.at_pressure and entry.control != POSITION:
        return [Doubt(_UNUSED, "reference.confining_pressure changes nothing: no stress is made with it.")]
    return []
