"""What the laboratory file of an experiment proves of what its calibration file says, and what it proposes where that asks."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from graincal.campaign.asked.doubt import Doubt
from graincal.campaign.file.experiments import ExperimentEntry, ReferenceFile
from graincal.campaign.file.models import StressPathModel
from graincal.data import InputError
from graincal.laboratory import Decision, Known, Understanding, understand
from graincal.laboratory.decisions import UNANSWERED
from graincal.laboratory.quantities import DIMENSIONS
from graincal.models import ConstantMeanStressTest, IsotropicTest, OedometricTest, TriaxialTest

_CODES = {"proof": "contradicts-file", "words": "contradicts-words"}
PRESSURES_APART = 0.03
"""A confining pressure is that of the file within this part of it."""


def evidence(entry: ExperimentEntry, folder: Path) -> tuple[Sequence[Decision], Sequence[Doubt], Sequence[Doubt]]:
    """What the file decides by itself, told nothing but its columns and units: decisions, problems where what it proves contradicts the entry, and notes where its words do."""
    if entry.reference is None or not isinstance(entry.model, StressPathModel):
        return (), (), ()
    found = _understood(folder / entry.reference.file, _known(entry.reference.model_dump()))
    if found is None:
        return (), (), ()
    stated = {decision.what: decision for decision in found.decided if decision.by != "person"}
    against: dict[str, list[Doubt]] = {"proof": [], "words": []}
    for said, decision in _contradicted(entry.reference, entry.model, stated, found.lateral_is_known):
        against[decision.by].append(
            Doubt(_CODES[decision.by], f"the calibration file says {said}, and the laboratory file {decision.value}, because {decision.because}.")
        )
    return tuple(stated.values()), against["proof"], against["words"]


def propose(folder: Path) -> Callable[[dict[str, Any], tuple[str | int, ...]], Any]:
    """Proposals for the questions of a calibration file in a folder, from the laboratory files that it names."""
    seen: dict[int, Understanding | None] = {}

    def proposed(entry: dict[str, Any], path: tuple[str | int, ...]) -> Any:
        if id(entry) not in seen:
            seen[id(entry)] = _of_content(entry, folder)
        found = seen[id(entry)]
        return None if found is None else _proposal(found, [str(part) for part in path])

    return proposed


def _proposal(found: Understanding, path: list[str]) -> Any:
    """The proposal for a key, that the file is likely to mean; None without one."""
    table, key, rest = path[0], path[1] if len(path) > 1 else "", path[2:]
    if table == "model" and key == "kind":
        return found.proposed("kind") or (None if found.kind == UNANSWERED else found.kind)
    if table == "model" and key in ("confining_pressure", "void_ratio"):
        value = found.proposed(key) or (found.confining_pressure if key == "confining_pressure" else found.void_ratio)
        return float(value) if value else None
    if table != "reference":
        return None
    names = [f"{key}.{rest[0]}"] if rest else []
    if key == "strain":
        names += ["strain", *(question.key for question in found.questions if question.key.startswith("strain."))]
    if key == "units" and rest and DIMENSIONS.get(rest[0]) == "pressure":
        names += ["units.stresses", "units"]
    decided = {decision.what: decision.value for decision in found.decided}
    return next((value for name in names or [key] if (value := found.proposed(name) or decided.get(name))), None)


def _of_content(entry: Mapping[str, Any], folder: Path) -> Understanding | None:
    reference = entry.get("reference")
    reference = {"file": reference} if isinstance(reference, str) else reference
    if not isinstance(reference, dict) or not isinstance(reference.get("file"), str):
        return None
    try:
        known = _known(ReferenceFile.model_validate(_answered(reference)).model_dump())
    except ValidationError:
        # Whatever else it holds: what is wrong with it is said where the file is read.
        return None
    said = entry.get("model")
    model = said if isinstance(said, dict) else {}
    pressure, kind = model.get("confining_pressure"), model.get("kind")
    if isinstance(pressure, (int, float)) and not isinstance(pressure, bool):
        known = replace(known, confining_pressure=float(pressure))
    if isinstance(kind, str) and kind != UNANSWERED:
        known = replace(known, kind=kind)
    return _understood(folder / reference["file"], known)


def _answered(reference: Mapping[str, Any]) -> dict[str, Any]:
    """The keys of a table that are no questions."""
    plain = {key: {name: each for name, each in value.items() if each != UNANSWERED} if isinstance(value, dict) else value for key, value in reference.items()}
    return {key: value for key, value in plain.items() if value != UNANSWERED}


def _known(reference: Mapping[str, Any]) -> Known:
    """What a table [experiment.reference] says, but for what the laboratory file is to prove: the measure and the signs of strains."""
    units = {name: unit for name, unit in (reference.get("units") or {}).items() if unit != UNANSWERED}
    columns = {name: place for name, place in (reference.get("columns") or {}).items() if place != UNANSWERED and not isinstance(place, list)}
    rows = reference.get("rows")
    return Known(
        columns={name: (place, units.get(name)) for name, place in columns.items()},
        stage=reference.get("stage"),
        rows=tuple(rows) if rows else None,
        sheet=reference.get("sheet"),
        encoding=None if reference.get("encoding") == UNANSWERED else reference.get("encoding"),
        sample_height=reference.get("sample_height"),
        sample_volume=reference.get("sample_volume"),
    )


def _understood(path: Path, known: Known) -> Understanding | None:
    """None where the file proves nothing: it is read by what is said of it, or what is wrong with it is said where it is read."""
    try:
        return understand(path, known)
    except InputError:
        return None


def _contradicted(reference: ReferenceFile, model: StressPathModel, stated: Mapping[str, Decision], lateral_is_known: bool) -> list[tuple[str, Decision]]:
    """What an entry says, with the decision that it contradicts."""
    found = []
    # A change of volume alone tells a drained test, and not what its lateral stress does.
    drained = not lateral_is_known and {model.kind, stated["kind"].value if "kind" in stated else ""} <= {TriaxialTest.kind, ConstantMeanStressTest.kind}
    if (decision := stated.get("kind")) and decision.value != model.kind and model.kind not in ("", "table") and not drained:
        found.append((f"kind = {model.kind}", decision))
    pressure = model.confining_pressure
    # A compression may begin at any stress of its path.
    same_kind = "kind" in stated and stated["kind"].value == model.kind and model.kind not in (OedometricTest.kind, IsotropicTest.kind)
    if (decision := stated.get("confining_pressure")) and pressure and same_kind and not math.isclose(pressure, float(decision.value), rel_tol=PRESSURES_APART):
        found.append((f"confining_pressure = {pressure:g}", decision))
    for what, decision in stated.items():
        key, _, quantity = what.partition(".")
        if key == "strain" and (said := _measure(reference, quantity)) and said != decision.value:
            found.append((f"{quantity} is {said} strain", decision))
        if key == "compression" and quantity in _read(reference) and (said := _sign(reference, quantity)) != decision.value:
            found.append((f"compression of {quantity} is {said}", decision))
    return found


def _read(reference: ReferenceFile) -> Mapping[str, Any]:
    return reference.columns or {"axial_strain": "", "volumetric_strain": ""}


def _measure(reference: ReferenceFile, quantity: str) -> str | None:
    if quantity not in _read(reference):
        return None
    return (reference.strain or "logarithmic") if not isinstance(reference.strain, dict) else reference.strain.get(quantity, "logarithmic")


def _sign(reference: ReferenceFile, quantity: str) -> str:
    return reference.compression if isinstance(reference.compression, str) else reference.compression.get(quantity, "positive")
