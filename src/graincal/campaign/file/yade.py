"""The table [experiment.model] of YADE, kind = "yade": graincal's own triaxial test by it, or a script of the user's."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar, Literal

from pydantic import Field, model_validator

from graincal.campaign.file.command import CommandSection
from graincal.campaign.file.names import FileName, Shown
from graincal.campaign.file.output import OutputSection
from graincal.campaign.file.section import mistake
from graincal.campaign.file.values import Positive, from_root
from graincal.dem.packing import Packing
from graincal.models import YadeModel
from graincal.models.economy import INERTIAL_NUMBER, INERTIAL_NUMBERS, density_scaling_of
from graincal.models.rests import REST_EVERY, RESTS_EVERY
from graincal.models.yade.model import script, triaxial

_TRIAXIAL = ("packing", "confining_pressure", "density_scaling", "inertial_number", "fixed", "law", "rest_every")
_SCRIPT = ("script", "arguments", "table", "output", "derived", "link", "templates", "delimiters", "environment", "parameters_file")


class YadeSection(CommandSection):
    MOST: ClassVar[dict[str, float]] = CommandSection.MOST | {"arguments": 10_000, "table": 1_000, "confining_pressure": 1e15}

    kind: Literal["yade"] = Field(description='"yade"')  # type: ignore[assignment]  # what a command has, but for its kind
    program: Shown = Field("yade", min_length=1, description='the name or path of the program, such as "yade" or "/opt/yade/bin/yade-2024"')
    command: list[str] = Field([], description="no list: this kind has program, and script, in its place")
    packing: FileName | None = Field(None, description="the name of a packing file")
    confining_pressure: Positive | None = Field(None, description="a number above 0, in Pa")
    density_scaling: Positive | None = Field(None, description="a number above 0")
    inertial_number: float | None = Field(
        None, ge=INERTIAL_NUMBERS[0], le=INERTIAL_NUMBERS[1], description="a number from {:g} to {:g}".format(*INERTIAL_NUMBERS)
    )
    fixed: dict[str, float] = Field({}, description="a table of parameters and numbers, such as { nu = 0.2 }")
    law: Literal["linear", "hertz-mindlin"] = Field("linear", description='"linear" or "hertz-mindlin"')
    rest_every: float = Field(REST_EVERY, ge=RESTS_EVERY[0], le=RESTS_EVERY[1], description="a strain from {:g} to {:g}, as a fraction".format(*RESTS_EVERY))
    script: FileName | None = Field(None, description="the name of a script for YADE")
    arguments: list[str] = Field([], description='a list of the script\'s arguments, such as ["{{ E }}", "{{ phi }}"]')
    table: list[Shown] = Field([], description='a list of the names that the script\'s readParamsFromTable reads, such as ["E", "phi"]')
    output: OutputSection | None = Field(  # type: ignore[assignment]  # of a script alone
        None, description='a table such as { file = "curve.csv", columns = { axial_strain = "eps_a [%]", stress_ratio = "ratio" } }'
    )

    @model_validator(mode="after")
    def _one_of_two(self) -> YadeSection:
        given = self.model_fields_set
        if "command" in given:
            raise mistake(' has command, and with kind = "yade" either packing and confining_pressure, or script and output, were expected')
        own = [key for key in _TRIAXIAL if key in given]
        if self.script is not None:
            if own:
                raise mistake(f" has both script and {', '.join(own)}, and only one was expected: graincal's own triaxial test needs no script")
            if self.output is None:
                raise mistake(" has a script, and output, what the script writes, was expected too")
        elif self.packing is None or self.confining_pressure is None:
            raise mistake(" needs packing and confining_pressure, for graincal's own triaxial test by YADE, or script and output")
        elif theirs := [key for key in _SCRIPT if key in given]:
            raise mistake(f" has both packing and {', '.join(theirs)}, and only one was expected: these are of a script of your own")
        if {"density_scaling", "inertial_number"} <= given:
            raise mistake(" has both density_scaling and inertial_number, and one of them was expected")
        return self

    def build(self, folder: Path, control: str) -> YadeModel:
        options = self.options(folder, control) | {"program": self.program}
        if self.script is not None and self.output is not None:
            return script(self.script, self.output.build(), arguments=self.arguments, table=self.table, link=self.link, **options)
        assert self.packing is not None and self.confining_pressure is not None, "they are given where no script is"
        return triaxial(
            folder.resolve() / self.packing,
            self.confining_pressure,
            self._scaling(from_root(folder / self.packing), self.confining_pressure),
            fixed=self.fixed,
            law=self.law,
            rest_every=self.rest_every,
            **options,
        )

    def _scaling(self, file: Path, pressure: float) -> float:
        """The factor on the grains' density, of the packing that is read for it, and checked by it."""
        packing = Packing.read(file)
        if self.density_scaling is not None:
            return self.density_scaling
        return float(density_scaling_of(packing, pressure, INERTIAL_NUMBER if self.inertial_number is None else self.inertial_number))
