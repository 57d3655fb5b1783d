"""The tables [experiment.model] of a calibration file, by their kinds."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from pydantic import Field, model_validator

from graincal.campaign.file.by_hand import ByHandSection
from graincal.campaign.file.command import CommandSection
from graincal.campaign.file.model_section import ModelSection
from graincal.campaign.file.names import FileName, Shown
from graincal.campaign.file.section import mistake
from graincal.campaign.file.values import Positive, from_root
from graincal.campaign.file.yade import YadeSection
from graincal.dem.packing import Packing
from graincal.dem.stress_path_table import StressPathTable
from graincal.models import TESTS, PythonModel, StressPathTest
from graincal.models.compression import CompressionTest
from graincal.models.contact_laws import LAWS
from graincal.models.economy import INERTIAL_NUMBERS, Economy
from graincal.models.python import LONGEST_TIMEOUT
from graincal.models.rests import RESTS_EVERY

if TYPE_CHECKING:
    Law = str
else:
    # One of them, which a type checker cannot know.
    Law = Literal[tuple(LAWS)]


class StressPathModel(ModelSection):
    INSTEAD: ClassVar[dict[str, str]] = {
        "relative_density": "graincal init and graincal pack take --relative-density, and say which void_ratio that is",
    }

    kind: str = Field(description=f"one of {', '.join(TESTS)}")
    confining_pressure: Positive = Field(description="a number above 0, in Pa")
    density_scaling: Positive | None = Field(None, description="a number above 0")
    fixed: dict[str, float] = Field({}, description="a table of parameters and numbers, such as { nu = 0.2 }")
    largest_flagged_share: float = Field(StressPathTest.largest_flagged_share, ge=0, le=1, description="a number from 0 to 1")
    step_limit: int = Field(StressPathTest.step_limit, ge=1, description="a whole number above 0")
    inertial_number: float | None = Field(
        None, ge=INERTIAL_NUMBERS[0], le=INERTIAL_NUMBERS[1], description="a number from {:g} to {:g}".format(*INERTIAL_NUMBERS)
    )
    rest_every: float | None = Field(None, ge=RESTS_EVERY[0], le=RESTS_EVERY[1], description="a strain from {:g} to {:g}, as a fraction".format(*RESTS_EVERY))
    accuracy: Literal["standard", "reference"] = Field(Economy.accuracy, description='"standard" or "reference"')
    time_step_bound: Literal["grain", "contact"] | None = Field(None, description='"grain" or "contact"')
    mass_exponent: float | None = Field(None, ge=0, le=3, description="a number from 0 to 3")
    precision: Literal["float64", "float32"] | None = Field(None, description='"float64" or "float32"')
    inertia_factor: Positive = Field(Economy.inertia_factor, description="a number above 0")
    settling_damping: float = Field(Economy.settling_damping, gt=0, lt=1, description="a number between 0 and 1")
    strain_ramp: float = Field(Economy.strain_ramp, ge=0, le=0.5, description="a number from 0 to 0.5")
    law: Law = Field(StressPathTest.law, description=" or ".join(f'"{law}"' for law in LAWS))
    packing: FileName | list[FileName] | None = Field(None, description="the name of a packing file, or a list of them")
    particles: int | None = Field(None, ge=1, description="a whole number above 0")
    void_ratio: Positive | None = Field(None, description="a number above 0")
    grading: FileName = Field(
        "toyoura",
        description='"toyoura", a median size in mm and d60/d10 such as "d50=0.14,Cu=1.5", or the name of a file with the columns size [mm],passing [%]',
    )
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
        return TESTS[self.kind](self.grains(folder), control=control, **self._options(folder))

    def _options(self, folder: Path) -> dict[str, Any]:
        return self.given("kind", "packing", *self.PREPARATION)

    def grains(self, folder: Path) -> Packing | list[Packing]:
        """The packing, or the packings, read or prepared. Raises OutOfReach for a void ratio that the grading does not pack to."""
        if self.packing is not None:
            names = [self.packing] if isinstance(self.packing, str) else self.packing
            return [Packing.read(from_root(folder / name)) for name in names]
        from graincal.dem.preparation import prepare

        file = folder / self.grading
        assert self.particles is not None and self.void_ratio is not None, "they are given where no packing is"
        return prepare(self.particles, self.void_ratio, file if os.path.exists(file) else self.grading, self.seed)


class CompressionModel(StressPathModel):
    MOST: ClassVar[dict[str, float]] = StressPathModel.MOST | {"turns": 1_000}

    turns: list[Positive] = Field([], description="a list of numbers above 0, in Pa, such as [320e3, 20e3]")


class TableModel(StressPathModel):
    confining_pressure: Positive | None = Field(  # type: ignore[assignment]  # the one test that may have none
        None, description="a number above 0, in Pa"
    )
    table: FileName = Field(description="the name of a file with the stages of the path")

    def _options(self, folder: Path) -> dict[str, Any]:
        return super()._options(folder) | {"table": StressPathTable.read(from_root(folder / self.table))}


class FunctionModel(ModelSection):
    MOST: ClassVar[dict[str, float]] = {"control": 100_000, "timeout": LONGEST_TIMEOUT}

    kind: Literal["python"] = Field(description='"python"')
    function: Shown = Field(description='the name of a function as "module:name"')
    control: list[float] | None = Field(None, description="a list of the control values that the function returns values at")
    timeout: Positive | None = Field(None, description="a number of seconds above 0")

    def build(self, folder: Path, control: str) -> PythonModel:
        return PythonModel(self.function, self.control, folder=folder.resolve(), timeout=self.timeout)


_PATHS: dict[str, type[ModelSection]] = {kind: CompressionModel if issubclass(test, CompressionTest) else StressPathModel for kind, test in TESTS.items()}

MODELS: dict[str, type[ModelSection]] = _PATHS | {
    "table": TableModel,
    "python": FunctionModel,
    "command": CommandSection,
    "yade": YadeSection,
    "by-hand": ByHandSection,
}
"""The kinds of models, by the word that `kind` has."""
