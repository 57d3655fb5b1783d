"""The tables [[experiment]] of a calibration file, with their references and observables."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar, Literal

from pydantic import Field, field_validator, model_validator

from graincal.campaign.asked.calibration import check_observables
from graincal.campaign.asked.experiment import Experiment, no_reference
from graincal.campaign.file.model_section import ModelSection
from graincal.campaign.file.models import MODELS, CompressionModel, StressPathModel
from graincal.campaign.file.names import FileName, Shown, with_printable_names
from graincal.campaign.file.section import Section, mistake
from graincal.campaign.file.values import Positive, Texts
from graincal.campaign.file.yade import YadeSection
from graincal.data import InputError, MeasurementError, Reference
from graincal.models import TriaxialTest
from graincal.positions import POSITION
from graincal.suggestion import did_you_mean


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
    columns: dict[str, str | int | list[str | int]] = Field(
        {}, description='a table of quantities and columns, by header, number or letter, such as { axial_strain = "Ea(%)", deviator_stress = 3 }'
    )
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


class ExperimentEntry(Section):
    MOST: ClassVar[dict[str, float]] = {"observables": 1_000}

    name: Shown = Field(min_length=1, description="text")
    reference: ReferenceFile | None = Field(None, description="the name of a laboratory file, or a table [experiment.reference]")
    control: Shown = Field("axial_strain", description="the name of the control variable")
    observables: dict[str, Observable] = Field(min_length=1, description="a table such as { stress_ratio = { variance_share = 0.5 } }")
    model: ModelSection = Field(description=f"a table whose kind is one of {', '.join(MODELS)}")

    @field_validator("model", mode="plain")
    @classmethod
    def _by_kind(cls, table: Any) -> ModelSection:
        kind = table.get("kind") if isinstance(table, dict) else None
        if not isinstance(kind, str):
            raise cls.unexpected("model", table)
        if kind not in MODELS:
            raise mistake(f'.kind must be one of {", ".join(MODELS)}, not "{kind}"{did_you_mean(kind, MODELS)}')
        return MODELS[kind].model_validate(table)

    @field_validator("control", mode="before")
    @classmethod
    def _is_a_name(cls, value: Any) -> Any:
        if isinstance(value, list):
            raise mistake(
                " must be the name of the control variable, not a list; the values that a function of your own returns others at are control under [experiment.model]"
            )
        return value

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
            reference = self.read_reference(folder) if to is None else no_reference(model, to, self.fitted, self.control, self.recorded)
            return Experiment(self.name, model, reference)
        except InputError as error:
            raise InputError(f'experiment "{self.name}": {error}') from error

    @property
    def pressure(self) -> float | None:
        """The confining pressure, Pa, of a built-in test, or of graincal's own script of a triaxial test for YADE; None for others, and where it is not said."""
        return self.model.confining_pressure if isinstance(self.model, (StressPathModel, YadeSection)) else None

    @property
    def is_triaxial(self) -> bool:
        """Whether it is a drained triaxial test, the built-in one or graincal's own script for YADE."""
        return self.model.kind == TriaxialTest.kind or (isinstance(self.model, YadeSection) and self.pressure is not None)

    def read_reference(self, folder: Path) -> Reference:
        """The reference that is described."""
        if self.reference is None:
            raise InputError("it has no reference, and the name of a laboratory file, or a table [experiment.reference], was expected.")
        options = self.reference.given("file")
        # A path along positions starts from it, and a triaxial test keeps it; on other paths the lateral stress changes.
        if self.is_triaxial or (self.control == POSITION and isinstance(self.model, CompressionModel)):
            options.setdefault("confining_pressure", self.pressure)
        if self.control == POSITION and isinstance(self.model, CompressionModel):
            options["turns"] = self.model.turns
        errors = {name: entry.error for name, entry in self.observables.items() if entry.error}
        shares = {name: share for name in self.fitted if (share := self.observables[name].variance_share) is not None}
        observables = shares if len(shares) == len(self.fitted) else tuple(self.fitted)
        return Reference.read(folder / self.reference.file, self.control, observables, recorded=self.recorded, measurement_errors=errors, **options)
