"""A parameter of a calibration file: a line under [parameters]."""

from __future__ import annotations

from pydantic import Field, field_validator

from graincal.campaign.file.names import Shown
from graincal.campaign.file.section import Section


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
