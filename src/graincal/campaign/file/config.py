"""calibration.toml: its keys, and how a calibration is made of them. Paths are relative to the file."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field, ValidationError, field_validator, model_validator

from graincal.campaign.asked.calibration import Calibration, check_observables, refuse_criteria
from graincal.campaign.asked.experiment import Experiment, no_reference
from graincal.campaign.file.names import FileName, Shown, with_printable_names
from graincal.campaign.file.questions import open_questions
from graincal.campaign.file.section import Section, mistake, sentences
from graincal.campaign.file.toml import NotTOML, read_toml
from graincal.campaign.found.first_look import read_first_look
from graincal.campaign.found.runs import known_runs
from graincal.data import InputError, MeasurementError, ParameterSpace, Reference
from graincal.dem.packing import Packing
from graincal.dem.stress_path_table import StressPathTable
from graincal.execution.cores import MOST_WORKERS
from graincal.files import check_name, is_unicode, unreadable
from graincal.inference import DEFAULT_METHOD, METHODS, Stop
from graincal.inference.posterior.posterior_filter import MOST_AHEAD
from graincal.inference.sampling.samples import MOST_SAMPLES
from graincal.models import TESTS, PythonModel, StressPathTest, TriaxialTest
from graincal.models.compression import CompressionTest
from graincal.models.economy import INERTIAL_NUMBERS, Economy
from graincal.models.python import LONGEST_TIMEOUT
from graincal.models.rests import RESTS_EVERY
from graincal.positions import POSITION
from graincal.suggestion import did_you_mean

MOST_ROUNDS = 1_000_000
"""Of limits on evaluations and iterations: what is longer is none."""

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Count = Annotated[int, Field(ge=1)]
def _only_false(value: Any) -> Any:
    # Zero equals false, and would switch a limit off that was meant to be nothing.
    if value is not False:
        raise ValueError("not false")
    return value


Off = Annotated[Literal[False], BeforeValidator(_only_false)]
Texts = dict[str, str]


class Parameter(Section):
    range: list[float] = Field(min_length=2, max_length=2, description="[low, high] with low < high")
    unit: Shown = Field("", description='text such as "deg"')
    per_experiment: bool = Field(False, description="true or false")

    @field_validator("range")
    @classmethod
    def _upwards(cls, limits: list[float]) -> list[float]:
        if not limits[0] < limits[1]:
            raise cls.unexpected("range", limits)
        return limits


class Observable(Section):
    fitted: bool = Field(True, description="true or false")
    variance_share: Positive | None = Field(None, description="a number above 0, the smaller the more trusted")
    measurement_error: Positive | None = Field(None, description="a standard deviation above 0, a fraction for strains, in Pa for stresses")
    relative_error: Positive | None = Field(None, description="a standard deviation above 0 as a part of each value")
    step: Positive | None = Field(None, description="the step of a display or of a reading, above 0, a fraction for strains, in Pa for stresses")
    noise: Positive | None = Field(None, description="a standard deviation above 0 of what differs from row to row, a fraction for strains, in Pa for stresses")

    @model_validator(mode="after")
    def _nothing_beside(self) -> Observable:
        if not self.fitted and (beside := self.given("fitted")):
            raise mistake(f" is not fitted, as fitted = false says, so that {' and '.join(beside)} cannot stand beside it")
        return self

    @property
    def error(self) -> MeasurementError | None:
        """What is said of the measurement's error; None for nothing."""
        said = {"absolute": self.measurement_error, "relative": self.relative_error, "step": self.step, "noise": self.noise}
        return MeasurementError(**{name: float(value) for name, value in said.items() if value}) if any(said.values()) else None


class ReferenceFile(Section):
    called: ClassVar[str] = "[experiment.reference]"

    file: FileName = Field(description="the name of a laboratory file")
    columns: dict[str, str | int | list[str | int]] = Field({}, description='a table of quantities and columns, by header, number or letter, such as { axial_strain = "Ea(%)", deviator_stress = 3 }')
    units: Texts = Field({}, description='a table of quantities and units, such as { axial_strain = "%" }')
    strain: str | Texts | None = Field(None, description='"logarithmic" or "engineering", or a table of quantities and these')
    compression: str | Texts = Field("positive", description='"positive" or "negative", or a table of quantities and these')
    unloading: Literal["drop"] | None = Field(None, description='"drop"')
    until: Positive | None = Field(None, description="the last value of the control that is compared, above 0, a fraction for strains, in Pa for stresses")
    confining_pressure: Positive | None = Field(None, description="a number above 0, in Pa")
    control_step: Positive | None = Field(None, description="the step to which the control was read, above 0, a fraction for strains, in Pa for stresses")
    simulated: bool = Field(False, description="true or false")
    stage: str | int | None = Field(None, description='the number or the word of a stage of the file, such as 3 or "shear"')
    rows: list[int] | None = Field(None, min_length=2, max_length=2, description="the first and the last line of the file to be read, such as [38, 53]")
    zero: list[str] = Field([], description='a list of quantities that count from the first row that is read, such as ["axial_strain"]')
    sample_volume: Positive | None = Field(None, description="the sample's volume when its change is 0, above 0, in m3")
    sample_height: Positive | None = Field(None, description="the sample's height when its change is 0, above 0, in m")
    sheet: str | int | None = Field(None, description="the name or the number of a sheet, or the group of AGS4 data")
    encoding: str | None = Field(None, description='how the file\'s text is encoded, such as "cp1251"')


class StressPathModel(Section):
    called: ClassVar[str] = "[experiment.model]"

    kind: str = Field(description=f"one of {', '.join(TESTS)}")
    confining_pressure: Positive = Field(description="a number above 0, in Pa")
    density_scaling: Positive | None = Field(None, description="a number above 0")
    fixed: dict[str, float] = Field({}, description="a table of parameters and numbers, such as { nu = 0.2 }")
    largest_flagged_share: float = Field(StressPathTest.largest_flagged_share, ge=0, le=1, description="a number from 0 to 1")
    step_limit: int = Field(StressPathTest.step_limit, ge=1, description="a whole number above 0")
    inertial_number: float | None = Field(None, ge=INERTIAL_NUMBERS[0], le=INERTIAL_NUMBERS[1], description="a number from {:g} to {:g}".format(*INERTIAL_NUMBERS))
    rest_every: float | None = Field(None, ge=RESTS_EVERY[0], le=RESTS_EVERY[1], description="a strain from {:g} to {:g}, as a fraction".format(*RESTS_EVERY))
    accuracy: Literal["standard", "reference"] = Field(Economy.accuracy, description='"standard" or "reference"')
    time_step_bound: Literal["grain", "contact"] | None = Field(None, description='"grain" or "contact"')
    mass_exponent: float | None = Field(None, ge=0, le=3, description="a number from 0 to 3")
    precision: Literal["float64", "float32"] | None = Field(None, description='"float64" or "float32"')
    inertia_factor: Positive = Field(Economy.inertia_factor, description="a number above 0")
    settling_damping: float = Field(Economy.settling_damping, gt=0, lt=1, description="a number between 0 and 1")
    strain_ramp: float = Field(Economy.strain_ramp, ge=0, le=0.5, description="a number from 0 to 0.5")
    law: Literal["linear", "hertz-mindlin"] = Field(StressPathTest.law, description='"linear" or "hertz-mindlin"')
    packing: FileName | list[FileName] | None = Field(None, description="the name of a packing file, or a list of them")
    particles: int | None = Field(None, ge=1, description="a whole number above 0")
    void_ratio: Positive | None = Field(None, description="a number above 0")
    grading: FileName = Field("toyoura", description='"toyoura", or the name of a file with the columns size [mm],passing [%]')
    seed: int = Field(1, ge=0, description="a whole number, not negative")

    PREPARATION: ClassVar[tuple[str, ...]] = ("particles", "void_ratio", "grading", "seed")
    MOST: ClassVar[dict[str, float]] = {"particles": 1_000_000, "void_ratio": 100, "step_limit": 10**15, "confining_pressure": 1e15, "packing": 100}

    @model_validator(mode="after")
    def _one_packing(self) -> StressPathModel:
        prepared = self.model_fields_set & set(self.PREPARATION)
        if self.packing is not None and prepared:
            raise mistake(f" has both packing and {', '.join(sorted(prepared))}, and one of them was expected")
        if self.packing is None and not {"particles", "void_ratio"} <= self.model_fields_set:
            raise mistake(" needs either packing, the name of a file, or particles and void_ratio of one to prepare")
        return self

    @model_validator(mode="after")
    def _one_density(self) -> StressPathModel:
        if {"density_scaling", "inertial_number"} <= self.model_fields_set:
            raise mistake(" has both density_scaling and inertial_number, and one of them was expected")
        return self

    def build(self, folder: Path, control: str) -> StressPathTest:
        """The test that is described, driven by `control`."""
        return TESTS[self.kind](self.grains(folder), control=control, **self._options(folder))

    def _options(self, folder: Path) -> dict[str, Any]:
        return self.given("kind", "packing", *self.PREPARATION)

    def grains(self, folder: Path) -> Packing | list[Packing]:
        """The packing, or the packings, read or prepared. Raises OutOfReach for a void ratio that the grading does not pack to."""
        if self.packing is not None:
            names = [self.packing] if isinstance(self.packing, str) else self.packing
            return [Packing.read(_from_root(folder / name)) for name in names]
        from graincal.dem.preparation import prepare

        file = folder / self.grading
        return prepare(self.particles, self.void_ratio, file if os.path.exists(file) else self.grading, self.seed)


class CompressionModel(StressPathModel):
    MOST: ClassVar[dict[str, float]] = StressPathModel.MOST | {"turns": 1_000}

    turns: list[Positive] = Field([], description="a list of numbers above 0, in Pa, such as [320e3, 20e3]")


class TableModel(StressPathModel):
    confining_pressure: Positive | None = Field(None, description="a number above 0, in Pa")
    table: FileName = Field(description="the name of a file with the stages of the path")

    def _options(self, folder: Path) -> dict[str, Any]:
        return super()._options(folder) | {"table": StressPathTable.read(_from_root(folder / self.table))}


class FunctionModel(Section):
    MOST: ClassVar[dict[str, float]] = {"control": 100_000, "timeout": LONGEST_TIMEOUT}

    kind: Literal["python"] = Field(description='"python"')
    function: Shown = Field(description='the name of a function as "module:name"')
    control: list[float] | None = Field(None, description="a list of the control values that the function returns values at")
    timeout: Positive | None = Field(None, description="a number of seconds above 0")

    def build(self, folder: Path, control: str) -> PythonModel:
        """The model that is described, which is not told what its control values are of."""
        return PythonModel(self.function, self.control, folder=folder.resolve(), timeout=self.timeout)


MODELS: dict[str, type[Section]] = {kind: CompressionModel if issubclass(test, CompressionTest) else StressPathModel for kind, test in TESTS.items()} | {"table": TableModel, "python": FunctionModel}


class ExperimentEntry(Section):
    MOST: ClassVar[dict[str, float]] = {"observables": 1_000}

    name: Shown = Field(min_length=1, description="text")
    reference: ReferenceFile | None = Field(None, description="the name of a laboratory file, or a table [experiment.reference]")
    control: Shown = Field("axial_strain", description="the name of the control variable")
    observables: dict[str, Observable] = Field(min_length=1, description="a table such as { stress_ratio = { variance_share = 0.5 } }")
    model: StressPathModel | FunctionModel = Field(description=f"a table whose kind is one of {', '.join(MODELS)}")

    @field_validator("model", mode="plain")
    @classmethod
    def _by_kind(cls, table: Any) -> Section:
        kind = table.get("kind") if isinstance(table, dict) else None
        if not isinstance(kind, str):
            raise cls.unexpected("model", table)
        if kind not in MODELS:
            raise mistake(f'.kind must be one of {", ".join(MODELS)}, not "{kind}"{did_you_mean(kind, MODELS)}')
        return MODELS[kind].model_validate(table)

    @field_validator("reference", mode="before")
    @classmethod
    def _name_alone(cls, value: Any) -> Any:
        return {"file": value} if isinstance(value, str) else value

    @field_validator("observables")
    @classmethod
    def _printable_names(cls, observables: dict[str, Observable]) -> dict[str, Observable]:
        return with_printable_names(observables)

    @field_validator("observables")
    @classmethod
    def _all_shares_or_none(cls, observables: dict[str, Observable]) -> dict[str, Observable]:
        fitted = {name: observable for name, observable in observables.items() if observable.fitted}
        if not fitted:
            raise mistake(" are all fitted = false, and at least one that is fitted was expected")
        without = [name for name, observable in fitted.items() if observable.variance_share is None]
        if without and len(without) < len(fitted):
            raise mistake(f" have a variance_share for some, and one for {', '.join(without)} too was expected")
        return observables

    @property
    def fitted(self) -> tuple[str, ...]:
        """The names of the observables that are fitted."""
        return tuple(name for name, observable in self.observables.items() if observable.fitted)

    @property
    def recorded(self) -> tuple[str, ...]:
        """The names of the others."""
        return tuple(name for name, observable in self.observables.items() if not observable.fitted)

    def build(self, folder: Path, to: float | None = None) -> Experiment:
        """The experiment that is described, with its reference and packing read; or for no reference, to the control value `to`."""
        try:
            model = self.model.build(folder, self.control)
            # Before the file is read, whose columns would be blamed for what is no observable.
            check_observables(model, tuple(self.observables))
            reference = self.read_reference(folder) if to is None else no_reference(to, self.fitted, self.control, self.recorded)
            return Experiment(self.name, model, reference)
        except InputError as error:
            raise InputError(f'experiment "{self.name}": {error}') from error

    def read_reference(self, folder: Path) -> Reference:
        """The reference that is described."""
        if self.reference is None:
            raise InputError("it has no reference, and the name of a laboratory file, or a table [experiment.reference], was expected.")
        options = self.reference.given("file")
        # A path along positions starts from it, and a triaxial test keeps it; on other paths the lateral stress changes.
        if self.model.kind == TriaxialTest.kind or (self.control == POSITION and isinstance(self.model, CompressionModel)):
            options.setdefault("confining_pressure", self.model.confining_pressure)
        if self.control == POSITION and isinstance(self.model, CompressionModel):
            options["turns"] = self.model.turns
        errors = {name: entry.error for name, entry in self.observables.items() if entry.error}
        shares = {name: self.observables[name].variance_share for name in self.fitted}
        observables = tuple(shares) if None in shares.values() else shares
        return Reference.read(folder / self.reference.file, self.control, observables, recorded=self.recorded, measurement_errors=errors, **options)


class FilterSection(Section):
    called: ClassVar[str] = "[filter]"
    MOST: ClassVar[dict[str, float]] = {"first_batch": MOST_SAMPLES, "batch": MOST_SAMPLES, "ahead": MOST_AHEAD, "correlation_length": 1e6, "runs": 1_000}

    method: str = Field(DEFAULT_METHOD, description=" or ".join(f'"{method}"' for method in METHODS))
    alpha: Positive = Field(10, description="a number above 0")
    effective_sample_size: float = Field(0.3, gt=0, lt=1, description="a number between 0 and 1")
    scale: Literal["peak", "pointwise"] = Field("peak", description='"peak" or "pointwise"')
    covariance: Literal["tied", "full"] = Field("tied", description='"tied" or "full"')
    first_batch: int | None = Field(None, ge=2, description="a whole number above 1")
    batch: int | None = Field(None, ge=2, description="a whole number above 1")
    ahead: int = Field(0, ge=0, description="a whole number, not negative")
    early_stop: bool = Field(False, description="true or false")
    thin: bool | None = Field(None, description="true or false")
    correlation_length: Positive | None = Field(None, description="a number above 0, in lengths of the whole curve")
    discrepancy: bool | None = Field(None, description="true or false")
    packing_scatter: bool = Field(True, description="true or false")
    first_look: FileName | None = Field(None, min_length=1, description="the folder of a campaign of cheaper models on the same experiments")
    runs: list[FileName] | None = Field(None, min_length=1, description='a list of the folders of campaigns and libraries of the same models, such as ["library"]')


class LookSection(Section):
    called: ClassVar[str] = "[first_look]"
    MOST: ClassVar[dict[str, float]] = {"max_evaluations": MOST_ROUNDS}

    model: dict[str, Any] = Field(min_length=1, description="a table of keys that make every experiment's model cheaper, such as { particles = 250 }")
    max_evaluations: int | None = Field(None, ge=10, description="a whole number, at least 10")

    def build(self, calibration: Calibration, entries: list[ExperimentEntry], folder: Path) -> Calibration:
        """The calibration by cheaper models. Most of its evaluations fill the ranges: it is to say where to look, not where exactly the best is."""
        n, options = calibration.space.size, calibration.filter_options
        most = self.max_evaluations or 32 * n
        kept = {name: options[name] for name in ("thin", "correlation_length", "discrepancy") if name in options}
        return replace(
            calibration,
            experiments=[self._cheaper(experiment, entry, folder) for experiment, entry in zip(calibration.experiments, entries)],
            filter_options={"first_batch": min(12 * n, most // 2), "batch": min(4 * n, max(2, most // 6)), "packing_scatter": False} | kept,
            stop=Stop(posterior_shift=False, max_iterations=False, max_evaluations=most),
            source="",
            truth={},
            known=None,
        )

    def _cheaper(self, experiment: Experiment, entry: ExperimentEntry, folder: Path) -> Experiment:
        table = entry.model.given()
        if {"packing", *StressPathModel.PREPARATION} & self.model.keys():
            # One packing takes the place of another; without a void ratio, one of the same.
            instead = {"packing", *(StressPathModel.PREPARATION if "packing" in self.model else ())}
            table = {key: value for key, value in table.items() if key not in instead}
            if "particles" in self.model and isinstance(experiment.model, StressPathTest):
                table.setdefault("void_ratio", round(experiment.model.packing.void_ratio, 4))
        if {"density_scaling", "inertial_number"} & self.model.keys():
            table = {key: value for key, value in table.items() if key not in ("density_scaling", "inertial_number")}
        table |= self.model
        try:
            model = type(entry.model).model_validate(table)
        except ValidationError as error:
            raise InputError("\n".join(f'first_look.model, with experiment "{entry.name}": {sentence}' for sentence in sentences(error, table))) from None
        return replace(experiment, model=model.build(folder, entry.control))


class StopSection(Section):
    called: ClassVar[str] = "[stop]"
    MOST: ClassVar[dict[str, float]] = {"max_iterations": MOST_ROUNDS, "max_evaluations": MOST_ROUNDS}

    s: NotNegative | Off = Field(0.01, description="a number, not negative, or false")
    gl_error_increment: NotNegative | Off = Field(0.2, description="percentage points, not negative, or false")
    error: NotNegative | Off = Field(2.0, description="percent, not negative, or false")
    error_increment: NotNegative | Off = Field(0.2, description="percentage points, not negative, or false")
    max_iterations: Count | Off | None = Field(None, description="a whole number above 0, or false")
    max_evaluations: Count | Off = Field(False, description="a whole number above 0, or false")
    hours: Positive | Off = Field(False, description="hours of wall time, above 0, or false")
    posterior_shift: NotNegative | Off = Field(0.25, description="standard deviations, not negative, or false")


class RunSection(Section):
    called: ClassVar[str] = "[run]"
    MOST: ClassVar[dict[str, float]] = {"workers": MOST_WORKERS, "expected_seconds": LONGEST_TIMEOUT}

    workers: Count | Literal["all"] = Field("all", description='a whole number above 0, or "all"')
    seed: int = Field(1, ge=0, description="a whole number, not negative")
    expected_seconds: Positive | None = Field(None, description="seconds above 0 that one evaluation takes on one core")


class CalibrationFile(Section):
    MOST: ClassVar[dict[str, float]] = {"parameters": 200, "experiment": 1_000}

    parameters: dict[str, Parameter] = Field(min_length=1, description="a table such as phi = { range = [0, 60] }")
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


def build_calibration(path: Path, file: CalibrationFile, source: str, more_runs: Sequence[Path] = (), *, exploring: bool = False, to: float | None = None) -> Calibration:
    """The calibration that a file describes, whose text is `source`, as `read_calibration`."""
    # A store keeps text, which a name in the encoding of an old system is none of.
    name = str(_from_root(path)) if is_unicode(_from_root(path)) else ""
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


def _from_root(path: Path) -> Path:
    """The path from the root: what is made of the file is kept and named elsewhere too."""
    return Path(os.path.abspath(path))


def _build(file: CalibrationFile, folder: Path, source: str, more_runs: Sequence[Path] = (), exploring: bool = False, to: float | None = None) -> Calibration:
    parameters = file.parameters.items()
    space = ParameterSpace(
        {name: entry.range for name, entry in parameters},
        {name: entry.unit for name, entry in parameters},
        [name for name, entry in parameters if entry.per_experiment],
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
    )
    if exploring:
        return calibration
    if runs := (*(_from_root(folder / each) for each in file.filter.runs or ()), *more_runs):
        try:
            calibration = replace(calibration, known=known_runs(runs, calibration.check()))
        except InputError as error:
            raise InputError(f"filter.runs: {error}") from error
    if file.filter.first_look and file.first_look:
        raise InputError("filter.first_look names a first look that was taken, and first_look asks for one; one of them was expected.")
    if look := file.filter.first_look:
        return replace(calibration, first_look=read_first_look(_from_root(folder / look), calibration))
    return replace(calibration, look=file.first_look.build(calibration, file.experiment, folder)) if file.first_look else calibration
