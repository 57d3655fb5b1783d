"""The table [experiment.model] of runs that somebody makes, kind = "by-hand"."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar, Literal

from pydantic import Field

from graincal.campaign.file.model_section import ModelSection
from graincal.campaign.file.output import OutputSection
from graincal.campaign.file.values import Texts
from graincal.models import ByHandModel


class ByHandSection(ModelSection):
    MOST: ClassVar[dict[str, float]] = {"derived": 1_000}

    kind: Literal["by-hand"] = Field(description='"by-hand"')
    output: OutputSection | None = Field(None, description='a table such as { columns = { axial_strain = "eps_a [%]", stress_ratio = "ratio" } }')
    derived: Texts = Field({}, description='a table of names and expressions of parameters, such as { E = "10**log_E" }')

    def build(self, folder: Path, control: str) -> ByHandModel:
        if self.output is None:
            return ByHandModel(None, self.derived)
        output = self.output.build()
        output.check(control)
        return ByHandModel(output, self.derived)
