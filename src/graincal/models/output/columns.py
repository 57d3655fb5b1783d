"""A column that is declared for a quantity: where it is found, in which unit, with which sign."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graincal.data import InputError
from graincal.laboratory.quantities import DIMENSIONS
from graincal.laboratory.units import Unit, find_unit, known_units, split_header
from graincal.models.output.tables import Columns, Unreadable
from graincal.notation.expression import Expression, NotAnExpression


@dataclass(frozen=True)
class Column:
    """column: the name of a column with its unit or without, its number from 1, or an expression of columns' names, such as `s33 / s11`. unit: where the name has none or a wrong one. sign: 1, or -1 where the file counts the other way.

    A column without a unit is a fraction, or in SI units. Raises InputError for a unit that is not known.
    """

    column: str | int
    unit: str | None = None
    sign: int = 1

    def __post_init__(self) -> None:
        if self.unit is not None and find_unit(self.unit) is None:
            raise InputError(f"the unit '{self.unit}' is not known, and one of {known_units(None)} was expected.")

    def read(self, quantity: str, columns: Columns) -> NDArray[np.float64]:
        """Its values (T,) as fractions or in SI units, by the sign that is declared. Raises Unreadable."""
        if (found := self._named(quantity, columns)) is not None:
            return self.sign * found
        if (expression := as_expression(self.column)) is None:
            # The column's own words on what there is instead.
            columns.find(self.column)
            raise Unreadable(f"there is no column {self.column!r}.")
        values = evaluate(expression, columns)
        unit = find_unit(self.unit) if self.unit else None
        return self.sign * values * (unit.factor if unit else 1.0)

    def _named(self, quantity: str, columns: Columns) -> NDArray[np.float64] | None:
        """The values of the column of that name, by its unit; None where there is none."""
        name, unit = split_header(self.column) if isinstance(self.column, str) else (self.column, None)
        said = self.column if columns.has(self.column) else name
        if not columns.has(said):
            return None
        values, printed = columns.find(said)
        # A unit in the name that is declared is one that is said, where the file's own name has none.
        text = self.unit or printed or unit
        if not self.unit and printed and unit and find_unit(printed) != find_unit(unit):
            raise Unreadable(f"the unit of {quantity} is '{printed}' in the file and '{unit}' in columns.")
        return values * (_unit(text, quantity).factor if text else 1.0)


def _unit(text: str, quantity: str) -> Unit:
    unit, dimension = find_unit(text), DIMENSIONS.get(quantity)
    if unit is None or dimension not in (None, unit.dimension):
        raise Unreadable(f"the unit of {quantity} is '{text}', and one of {known_units(dimension)} was expected.")
    return unit


def as_expression(text: str | int) -> Expression | None:
    """A text as an expression of columns; None where it is none, or a name alone."""
    if isinstance(text, int):
        return None
    try:
        found = Expression(text)
    except NotAnExpression:
        return None
    return found if found.names and found.names != (text.strip(),) else None


def evaluate(expression: Expression, columns: Columns) -> NDArray:
    """An expression of columns, each of which is a fraction or in SI units. Raises Unreadable."""
    values = {}
    for name in expression.names:
        found, text = columns.find(name)
        unit = find_unit(text) if text else None
        if text and unit is None:
            raise Unreadable(f"the unit of {name} is '{text}', and one of {known_units(None)} was expected.")
        values[name] = found * (unit.factor if unit else 1.0)
    if len({len(each) for each in values.values()}) > 1:
        raise Unreadable(
            f"the columns of {expression.text} have {', '.join(str(len(each)) for each in values.values())} rows, and as many in each were expected."
        )
    return expression(values)
