"""What is seen of a calibration file before anything is simulated: what it holds, what is decided and asked, and what speaks against it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.asked.calibration import POSTERIOR, Calibration
from graincal.campaign.asked.doubt import Doubt
from graincal.campaign.asked.limits import Limits
from graincal.campaign.asked.tested import OTHER, Tested
from graincal.campaign.file import laboratory_evidence
from graincal.campaign.file.check_marks import check_marks
from graincal.campaign.file.config import CalibrationFile, build_calibration, parse, validated
from graincal.campaign.file.doubts import doubts, doubts_of_reference, thinning_notes
from graincal.campaign.file.experiments import ExperimentEntry
from graincal.campaign.file.models import CompressionModel, StressPathModel
from graincal.campaign.file.questions import OpenQuestion, Proposed, open_questions, without_questions
from graincal.campaign.file.unused_keys import unused_in_experiment, unused_in_file
from graincal.data import InputError, Reference
from graincal.dem.preparation import OutOfReach
from graincal.inference.likelihood.thinning import Thinning
from graincal.laboratory.decisions import Decision
from graincal.models import IsotropicTest, OedometricTest, UndrainedTest
from graincal.models.stress_path import Abscissa
from graincal.positions import POSITION, stresses_at

Evidence = Callable[[ExperimentEntry, Path], tuple[Sequence[Decision], Sequence[Doubt], Sequence[Doubt]]]
"""What a laboratory file proves of an experiment's entry, whose names of files are relative to a folder: decisions, problems and notes."""


PROPOSE: Callable[[Path], Proposed] = laboratory_evidence.propose
EVIDENCE: Evidence = laboratory_evidence.evidence


_STAND_INS = {"kind": "oedometric", "packing": "?", "particles": 1000, "void_ratio": 0.7, "confining_pressure": 1e5}
"""What a model is validated with where these keys are open: nothing is computed of it. Of all kinds this one takes the most keys."""


@dataclass(frozen=True)
class Decided(Decision):
    """A decision, of an experiment by its name."""

    experiment: str | None = None


@dataclass(frozen=True, eq=False)
class Examined:
    """An experiment as it was read. kept_states: as many as the likelihood sees of its reference. questions: the keys that are open and were answered by a proposal, or left out."""

    entry: ExperimentEntry
    reference: Reference
    kept_states: int
    questions: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        return self.entry.name

    @property
    def tested(self) -> Tested:
        """By what the entry says of the test; its packing is not read for that."""
        model = self.entry.model
        if not isinstance(model, StressPathModel):
            return Tested(self.reference, OTHER)
        return Tested(self.reference, model.kind, model.confining_pressure, model.void_ratio)

    def abscissa(self, at: NDArray[np.float64]) -> Abscissa:
        """What its curve is drawn over at control values (T,): the logarithm of the stress for positions."""
        model, control = self.entry.model, self.reference.control_name
        if control != POSITION or not isinstance(model, CompressionModel):
            return Abscissa(control, at)
        stress = OedometricTest.stress if model.kind == OedometricTest.kind else IsotropicTest.stress
        return Abscissa(stress, stresses_at(at, model.confining_pressure, model.turns), logarithmic=True)

    def _beside(self) -> dict[str, dict[str, Any]]:
        """What is not fitted, and what follows from the others."""
        recorded = {name: {**_ends(values), "fitted": False} for name, values in self.reference.recorded.items()}
        return self._shown() | recorded

    def _shown(self) -> dict[str, dict[str, Any]]:
        """What follows from the observables and is not compared: the stress ratio of an undrained test, row by row."""
        observables, model = self.reference.measured, self.entry.model
        if (
            not isinstance(model, StressPathModel)
            or model.kind != UndrainedTest.kind
            or not {"deviatoric_stress", "excess_pore_pressure"} <= observables.keys()
        ):
            return {}
        q, pore, pressure = observables["deviatoric_stress"], observables["excess_pore_pressure"], model.confining_pressure
        if pressure is None or np.any(pore >= pressure):
            return {}
        return {"stress_ratio": {**_ends(1 + q / (pressure - pore)), "compared": False}}

    def as_json(self) -> dict[str, Any]:
        """The experiment as `graincal check --json` has it: fractions and Pa."""
        return {
            "name": self.name,
            "kind": self.entry.model.kind or None,
            "confining_pressure": getattr(self.entry.model, "confining_pressure", None),
            "states": len(self.reference.control),
            "kept_states": self.kept_states,
            "control": self.reference.control_name,
            "control_range": _ends(self.reference.control),
            "observables": {name: _ends(values) for name, values in self.reference.observables.items()} | self._beside(),
            "open": list(self.questions),
        }


@dataclass(frozen=True, eq=False)
class Examination:
    """calibration: None where the file cannot be calibrated as it is."""

    experiments: tuple[Examined, ...] = ()
    decided: tuple[Decided, ...] = ()
    questions: tuple[OpenQuestion, ...] = ()
    problems: tuple[Doubt, ...] = ()
    notes: tuple[Doubt, ...] = ()
    calibration: Calibration | None = None

    @property
    def is_clear(self) -> bool:
        """Whether nothing has to be answered before it is calibrated."""
        return not (self.questions or self.problems)

    @property
    def limits(self) -> Limits | None:
        """What its limits come to."""
        return Limits.of(self.calibration, self.calibration.blank_filter()) if self.calibration else None

    def as_json(self) -> dict[str, Any]:
        """What `graincal check --json` prints: a contract for programs."""
        return {
            "experiments": [each.as_json() for each in self.experiments],
            "decided": [
                {"experiment": each.experiment, "what": each.what, "value": each.value, "because": each.because, "by": each.by} for each in self.decided
            ],
            "questions": [_question_as_json(each) for each in self.questions],
            "problems": [each.as_json() for each in self.problems],
            "notes": [each.as_json() for each in self.notes],
            "limits": limits.as_json() if (limits := self.limits) else None,
        }


def examine(path: str | Path, more_runs: Sequence[Path] = (), *, proposed: Proposed | None = None, evidence: Evidence | None = None) -> Examination:
    """Look at a calibration file and all that it names. Nothing is simulated but a packing that is to be prepared, and that neither while questions are open.

    more_runs: as in `read_calibration`. proposed: what is said to open questions, by default PROPOSE of the file's folder; a key without a proposal is left out, and where the file
    cannot be read without it, there are the questions and why. What is open of the kind, the grains and the confining pressure is not known then, and all else is examined. evidence: what laboratory files say, by default EVIDENCE.
    Raises InputError for a file that cannot be read, as `read_calibration`.
    """
    path = Path(path)
    folder, evidence = path.parent, evidence or EVIDENCE
    content, source = parse(path)
    questions, marks = open_questions(source, content), check_marks(source)
    if not questions:
        return _of_file(path, validated(path, content), source, more_runs, marks, evidence)
    content, questions = without_questions(content, questions, proposed or PROPOSE(folder))
    try:
        file = _with_unknowns(path, content, questions)
    except InputError as error:
        unread = [
            Doubt("unread-so-far", f"the file cannot be read before its questions are answered: {each.removeprefix(f'{path}: ')}")
            for each in str(error).splitlines()
            if not _is_asked(each.removeprefix(f"{path}: "), questions)
        ]
        left, said = _by_level([*unread, *marks])
        return Examination(questions=questions, problems=left, notes=said)
    experiments, unread = _read_so_far(file, folder, questions)
    decided, problems, notes = _evidence(file, folder, evidence)
    found = [doubt for each in experiments for doubt in (*doubts_of_reference(each.tested, each.name), *unused_in_experiment(each.entry, each.reference))]
    found += [*unread, *unused_in_file(file), *marks, *_readings(experiments)]
    return _examination(experiments, decided, questions, found, problems, notes)


def _with_unknowns(path: Path, content: dict[str, Any], questions: Sequence[OpenQuestion]) -> CalibrationFile:
    """What the content of a file says whose questions were answered or left out. Keys of a model that a reference can do without are None where they were left out, and the kind is OTHER. Raises InputError, as `validated`."""
    unknown: list[set[str]] = [set() for _ in content.get("experiment", ())]
    for question in questions:
        table, *keys = question.path[2:] if question.experiment is not None else ("",)
        if table == "model" and keys and keys[0] in _STAND_INS and not question.proposed:
            number = int(question.path[1])
            unknown[number].add(keys[0])
            content["experiment"][number]["model"].setdefault(keys[0], _STAND_INS[keys[0]])
    file = validated(path, content)
    entries = [
        entry.model_copy(update={"model": entry.model.model_copy(update={key: OTHER if key == "kind" else None for key in keys})})
        for entry, keys in zip(file.experiment, unknown)
    ]
    return file.model_copy(update={"experiment": entries})


def _of_file(path: Path, file: CalibrationFile, source: str, more_runs: Sequence[Path], marks: list[Doubt], evidence: Evidence) -> Examination:
    """Of a file without questions."""
    folder = path.parent
    try:
        experiments = [_examined(entry, folder, file) for entry in file.experiment]
    except InputError as error:
        # What is wrong with the models is said first, as ever: it may be why the file cannot be read.
        build_calibration(path, file, source, more_runs)
        raise InputError(f"{path}: {error}") from error
    out_of_reach = _out_of_reach(file, folder)
    calibration = None if out_of_reach else build_calibration(path, file, source, more_runs)
    decided, problems, notes = _evidence(file, folder, evidence)
    if calibration:
        found = [*thinning_notes(calibration), *doubts(calibration)]
    else:
        found = [*out_of_reach, *(doubt for each in experiments for doubt in doubts_of_reference(each.tested, each.name))]
    found += [doubt for each in experiments for doubt in unused_in_experiment(each.entry, each.reference)]
    found += [*unused_in_file(file), *marks, *_readings(experiments)]
    return replace(_examination(experiments, decided, (), found, problems, notes), calibration=calibration)


def _examination(
    experiments: Sequence[Examined],
    decided: Sequence[Decided],
    questions: Sequence[OpenQuestion],
    found: Sequence[Doubt],
    problems: Sequence[Doubt],
    notes: Sequence[Doubt],
) -> Examination:
    of_file, said_of_file = _by_level(found)
    return Examination(tuple(experiments), tuple(decided), tuple(questions), (*of_file, *problems), (*said_of_file, *notes))


def _by_level(found: Sequence[Doubt]) -> tuple[tuple[Doubt, ...], tuple[Doubt, ...]]:
    """The problems, and the notes."""
    problems, notes = (tuple(doubt for doubt in found if doubt.level == level) for level in ("problem", "note"))
    return problems, notes


def _examined(entry: ExperimentEntry, folder: Path, file: CalibrationFile, questions: tuple[str, ...] = ()) -> Examined:
    """An experiment with its reference read. Raises InputError with its name."""
    try:
        reference = entry.read_reference(folder)
    except InputError as error:
        raise InputError(f'experiment "{entry.name}": {error}') from error
    thin = file.filter.method == POSTERIOR if file.filter.thin is None else file.filter.thin
    return Examined(entry, reference, len(Thinning.of(reference, thin).kept.control), questions)


def _is_asked(mistake: str, questions: Sequence[OpenQuestion]) -> bool:
    """Whether a mistake is that of a key that has no answer yet, or of a table that holds nothing else."""
    key, found, _ = mistake.partition(" is missing")
    if not found:
        key, found, _ = mistake.partition(" must be ")
    return bool(found) and any(question.place == key or question.place.startswith(f"{key}.") for question in questions)


def _read_so_far(file: CalibrationFile, folder: Path, questions: Sequence[OpenQuestion]) -> tuple[list[Examined], list[Doubt]]:
    """The experiments that can be read with questions open, and what is to be said of the others."""
    experiments, unread = [], []
    for entry in file.experiment:
        asked = tuple(question.key for question in questions if question.experiment == entry.name)
        try:
            experiments.append(_examined(entry, folder, file, asked))
        except InputError as error:
            if not asked:
                raise
            sentence = str(error).removeprefix(f'experiment "{entry.name}": ')
            unread.append(Doubt("unread-so-far", f"it cannot be read before its questions are answered: {sentence}", entry.name))
    return experiments, unread


def _out_of_reach(file: CalibrationFile, folder: Path) -> list[Doubt]:
    """Void ratios that gradings do not pack to. What is prepared for that is kept for the calibration."""
    said = []
    for entry in file.experiment:
        try:
            if isinstance(entry.model, StressPathModel) and entry.model.packing is None:
                entry.model.grains(folder)
        except OutOfReach as error:
            text = (
                f"{str(error).rstrip('.')}: real grains are no spheres, and pack looser. What people compare then is a packing of the same relative density, (e_max - e)/(e_max - e_min): "
                f"graincal init --relative-density gives its void ratio."
            )
            said.append(Doubt("void-ratio-out-of-reach", text, entry.name))
        except InputError:
            # What else is wrong is said where the calibration is made.
            continue
    return said


def _evidence(file: CalibrationFile, folder: Path, evidence: Evidence) -> tuple[list[Decided], list[Doubt], list[Doubt]]:
    """What laboratory files say of all experiments, by their names."""
    decided, problems, notes = [], [], []
    for entry in file.experiment:
        found, against, noted = evidence(entry, folder)
        decided += [Decided(each.what, each.value, each.because, each.by, entry.name) for each in found]
        problems += [replace(doubt, experiment=entry.name) for doubt in against]
        notes += [replace(doubt, experiment=entry.name) for doubt in noted]
    return decided, problems, notes


def _readings(experiments: Sequence[Examined]) -> list[Doubt]:
    """What was done with the files as they were read."""
    return [Doubt("key-without-effect" if note in each.reference.idle else "reading", note, each.name) for each in experiments for note in each.reference.notes]


def _question_as_json(question: OpenQuestion) -> dict[str, Any]:
    return {
        "experiment": question.experiment,
        "key": question.key,
        "line": question.line,
        "question": question.asked,
        "answers": list(question.answers),
        "proposed": question.proposed or None,
    }


def _ends(values: NDArray[np.float64]) -> dict[str, float]:
    return {"first": float(values[0]), "last": float(values[-1]), "min": float(values.min()), "max": float(values.max())}
