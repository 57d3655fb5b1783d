"""calibration.toml: its keys, and how a calibration is made of them. Paths are relative to the file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

from pydantic import Field, ValidationError, field_validator

from graincal.campaign.asked.calibration import Calibration, refuse_criteria
from graincal.campaign.file.experiments import ExperimentEntry
from graincal.campaign.file.look import LookSection
from graincal.campaign.file.names import with_printable_names
from graincal.campaign.file.options import FilterSection, RunSection, StopSection
from graincal.campaign.file.parameters import ConstraintEntry, Parameter
from graincal.campaign.file.questions import open_questions
from graincal.campaign.file.section import Section, sentences
from graincal.campaign.file.values import from_root
from graincal.campaign.found.first_look import read_first_look
from graincal.campaign.found.runs import known_runs
from graincal.data import InputError, ParameterSpace, Reference
from graincal.files import check_name, is_unicode, unreadable
from graincal.inference import METHODS, Stop
from graincal.notation.toml import NotTOML, read_toml


class CalibrationFile(Section):
    MOST: ClassVar[dict[str, float]] = {"parameters": 200, "constraint": 200, "experiment": 1_000}

    parameters: dict[str, Parameter] = Field(min_length=1, description="a table such as phi = { range = [0, 60] }")
    constraint: list[ConstraintEntry] = Field([], description='tables [[constraint]] with require = "v0 < v1"')
    experiment: list[ExperimentEntry] = Field(min_length=1, description="at least one table [[experiment]]")
    filter: FilterSection = Field(FilterSection(), description="a table [filter]")
    first_look: LookSection | None = Field(None, description="a table [first_look] with model = { particles = 250 }")
    stop: StopSection = Field(StopSection(), description="a table [stop]")
    run: RunSection = Field(RunSection(), description="a table [run]")

    @field_validator("parameters")
    @classmethod
    def _printable_names(cls, parameters: dict[str, Parameter]) -> dict[str, Parameter]:
        return with_printable_names(parameters)


def read_calibration(path: str | Path, more_runs: Sequence[Path] = (), *, exploring: bool = False, to: float | None = None) -> Calibration:
    """Read a calibration file and all that it names, and check that it can be calibrated.

    more_runs: folders beside those under `runs`. exploring: for a library, without what was run before; to: then without references, up to this control value (`experiment.no_reference`).

    Raises InputError for what cannot: a sentence for each mistake, with the file, the key and what was expected; and one for each open question, a value "?".
    """
    path = Path(path)
    file, source = _read(path)
    return build_calibration(path, file, source, more_runs, exploring=exploring, to=to)


def build_calibration(
    path: Path, file: CalibrationFile, source: str, more_runs: Sequence[Path] = (), *, exploring: bool = False, to: float | None = None
) -> Calibration:
    """The calibration that a file describes, whose text is `source`, as `read_calibration`."""
    # A store keeps text, which a name in the encoding of an old system is none of.
    name = str(from_root(path)) if is_unicode(from_root(path)) else ""
    try:
        return replace(_build(file, path.parent, source, more_runs, exploring, to), file=name).check()
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def read_entries(path: str | Path) -> list[ExperimentEntry]:
    """The experiments of a calibration file as they are written; nothing that they name is read."""
    return _read(Path(path))[0].experiment


def read_references(path: str | Path) -> list[tuple[ExperimentEntry, Reference]]:
    """The experiments of a calibration file, each with its reference, read as a calibration would; no packing is read or prepared for that."""
    path = Path(path)
    file, _ = _read(path)
    found = []
    for entry in file.experiment:
        try:
            found.append((entry, entry.read_reference(path.parent)))
        except InputError as error:
            raise InputError(f'{path}: experiment "{entry.name}": {error}') from error
    return found


def _read(path: Path) -> tuple[CalibrationFile, str]:
    """What a file says, and its text. Raises InputError for open questions too."""
    content, source = parse(path)
    if questions := open_questions(source, content):
        raise InputError("\n".join(f"{path}: {question.sentence}" for question in questions))
    return validated(path, content), source


def parse(path: Path) -> tuple[dict[str, Any], str]:
    """The content of a file as TOML has it, and its text."""
    try:
        check_name(path, "a calibration file")
        source = path.read_text(encoding="utf-8-sig")
        return read_toml(source), source
    except OSError as error:
        raise InputError(unreadable(path, error, "a calibration file")) from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: a text file in UTF-8 was expected.") from None
    except NotTOML as error:
        raise InputError(f"{path}: this is not TOML, {error}.") from None


def validated(path: Path, content: dict[str, Any]) -> CalibrationFile:
    """What the content of a file says. Raises InputError with a sentence for each mistake."""
    try:
        return CalibrationFile.model_validate(content)
    except ValidationError as error:
        raise InputError("\n".join(f"{path}: {sentence}" for sentence in sentences(error, content))) from None


def _build(file: CalibrationFile, folder: Path, source: str, more_runs: Sequence[Path] = (), exploring: bool = False, to: float | None = None) -> Calibration:
    parameters = file.parameters.items()
    space = ParameterSpace(
        {name: entry.given_as for name, entry in parameters},
        {name: entry.unit for name, entry in parameters},
        [name for name, entry in parameters if entry.per_experiment],
        scale={name: entry.scale for name, entry in parameters if entry.fixed is None},
        constraints=[entry.require for entry in file.constraint],
    )
    if file.filter.method in METHODS:
        # What is set in a file counts as asked for even where it is the default.
        refuse_criteria(file.filter.method, file.stop.given())
    calibration = Calibration(
        space,
        [entry.build(folder, to) for entry in file.experiment],
        file.filter.method,
        file.filter.given("method", "first_look", "runs"),
        Stop(**file.stop.given()),
        file.run.seed,
        file.run.workers,
        source,
        expected_seconds=file.run.expected_seconds,
        place=file.run.place(folder),
    )
    if exploring:
        return calibration
    if runs := (*(from_root(folder / each) for each in file.filter.runs or ()), *more_runs):
        try:
            calibration = replace(calibration, known=known_runs(runs, calibration.check()))
        except InputError as error:
            raise InputError(f"filter.runs: {error}") from error
    if file.filter.first_look and file.first_look:
        raise InputError("filter.first_look names a first look that was taken, and first_look asks for one; one of them was expected.")
    if look := file.filter.first_look:
        return replace(calibration, first_look=read_first_look(from_root(folder / look), calibration))
    return replace(calibration, look=file.first_look.build(calibration, file.experiment, folder)) if file.first_look else calibration
