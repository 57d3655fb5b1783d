"""The table output = { ... } of a model in a calibration file: what a program writes, and which of its columns is which quantity."""

from __future__ import annotations

from pathlib import PurePosixPath
from typing import Any, ClassVar, Literal

from pydantic import Field, field_validator

from graincal.campaign.file.names import FileName, Shown, with_printable_names
from graincal.campaign.file.section import Section, mistake, show
from graincal.campaign.file.values import Count, Texts
from graincal.laboratory.units import find_unit, known_units
from graincal.models.output import STANDARD_OUTPUT, Column, Output
from graincal.notation.expression import Expression, NotAnExpression


def inside(name: str, what: str = "a file within the folder of an evaluation") -> str:
    """A file's name in the folder of an evaluation. Raises the mistake of one that leads out of it."""
    path = PurePosixPath(name)
    if not name.strip() or path.is_absolute() or ".." in path.parts or not path.parts:
        raise mistake(f" is {show(name)}, and the name of {what} was expected")
    return name


class ColumnTable(Section):
    column: Shown | int = Field(description='the name or the number of a column, or an expression of columns such as "s33 / s11"')
    unit: Shown | None = Field(None, description='a unit such as "%" or "kPa"')
    sign: Literal[1, -1] = Field(1, description="1 or -1")

    @field_validator("unit")
    @classmethod
    def _known(cls, unit: str | None) -> str | None:
        if unit is not None and find_unit(unit) is None:
            raise mistake(f" is {show(unit)}, and one of {known_units(None)} was expected")
        return unit


class OutputSection(Section):
    INSTEAD: ClassVar[dict[str, str]] = {
        "units": 'a unit stands with its column, { column = "e33", unit = "%" }, or in brackets in its name',
        "compression": 'a sign stands with its column, { column = "e33", sign = -1 }',
    }
    MOST: ClassVar[dict[str, float]] = {"columns": 1_000, "zero": 1_000}

    file: FileName = Field(STANDARD_OUTPUT, description='the name of the file that is written, or "-" for what is printed')
    columns: dict[str, ColumnTable] = Field(
        min_length=1, description='a table of quantities and columns, such as { axial_strain = "eps_a [%]", stress_ratio = "s33 / s11" }'
    )
    zero: list[Shown] = Field([], description='a list of quantities that count from the first row that is read, such as ["axial_strain"]')
    first_row: Count | None = Field(None, description="the number of the first row of numbers that is read, a whole number above 0")
    where: Shown | None = Field(None, description='an expression of columns that holds for the rows that are read, such as "stage == 2"')
    strain: Literal["logarithmic", "engineering"] | Texts = Field(
        "logarithmic", description='"logarithmic" or "engineering", or a table of quantities and these'
    )

    @field_validator("columns", mode="before")
    @classmethod
    def _names_alone(cls, columns: Any) -> Any:
        if not isinstance(columns, dict):
            return columns
        return {
            name: {"column": value} if isinstance(value, (str, int)) and not isinstance(value, bool) else value
            for name, value in with_printable_names(columns).items()
        }

    @field_validator("file")
    @classmethod
    def _inside(cls, name: str) -> str:
        return name if name == STANDARD_OUTPUT else inside(name, 'a file within the folder of an evaluation, or "-" for what is printed,')

    @field_validator("where")
    @classmethod
    def _compares(cls, text: str | None) -> str | None:
        try:
            if text is not None and not Expression(text).compares:
                raise NotAnExpression("it compares nothing")
        except NotAnExpression as error:
            raise mistake(f' is {show(text)}, and an expression of columns such as "stage == 2" was expected: {error}') from None
        return text

    @field_validator("strain")
    @classmethod
    def _words(cls, strain: str | dict[str, str]) -> str | dict[str, str]:
        for word in strain.values() if isinstance(strain, dict) else ():
            if word not in ("logarithmic", "engineering"):
                raise mistake(f' has {show(word)}, and "logarithmic" or "engineering" was expected')
        return strain

    def build(self) -> Output:
        """The output that is described. Raises InputError for quantities that are no columns."""
        columns = {name: Column(each.column, each.unit, each.sign) for name, each in self.columns.items()}
        return Output(columns, self.file, tuple(self.zero), self.first_row, self.where, self.strain)
