"""A parameter of a calibration file, a line under [parameters]; and a table [[constraint]] between them."""

from __future__ import annotations

from typing import Any, ClassVar, Literal

from pydantic import Field, field_validator, model_validator

from graincal.campaign.file.names import Shown
from graincal.campaign.file.section import Section, mistake
from graincal.parameter_space import LINEAR


class Parameter(Section):
    range: list[float] | None = Field(None, min_length=2, max_length=2, description="[low, high] with low < high")
    fixed: float | None = Field(None, description="a number")
    unit: Shown = Field("", description='text such as "deg"')
    scale: Literal["linear", "log"] = Field(LINEAR, description='"linear" or "log"')
    per_experiment: bool = Field(False, description="true or false")

    @property
    def given_as(self) -> tuple[float, float] | float:
        """Its range, or its value where it is fixed, as a `ParameterSpace` takes it."""
        if self.fixed is not None:
            return self.fixed
        assert self.range is not None, "one of them is given"
        low, high = self.range
        return low, high

    @model_validator(mode="before")
    @classmethod
    def _range_or_value(cls, table: Any) -> Any:
        if isinstance(table, (int, float)) and not isinstance(table, bool):
            raise mistake(f" must be a table, {{ fixed = {table} }} for a value that is known or {{ range = [low, high] }}, not {table}")
        if isinstance(table, dict) and "fixed" not in table and "range" not in table and set(table) <= set(cls.model_fields):
            raise mistake(".range is missing, and [low, high] with low < high was expected, or fixed = a number in its place")
        if isinstance(table, dict) and "fixed" in table and (others := [key for key in ("range", "scale", "per_experiment") if key in table]):
            raise mistake(f".{others[0]} says nothing of a parameter that is fixed, and fixed without {others[0]}, or range without fixed, was expected")
        return table

    @field_validator("range")
    @classmethod
    def _upwards(cls, limits: list[float] | None) -> list[float] | None:
        if limits is None or not limits[0] < limits[1]:
            raise cls.unexpected("range", limits)
        return limits


class ConstraintEntry(Section):
    called: ClassVar[str] = "[[constraint]]"

    require: str = Field(min_length=1, description='a condition on the parameters, such as "v0 < v1"')
