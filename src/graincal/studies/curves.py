"""Figures of curves over axial strain, in the paper's axes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence, Sized

import numpy as np
from numpy.typing import NDArray

from graincal.data import Reference, Response
from graincal.drawing.figure import Axis, Figure, Line, Mark, Panel, Points, counting_axis
from graincal.drawing.palette import REFERENCE, distinct
from graincal.notation.quantities import quantity
from graincal.studies.settings import OBSERVABLES


def over_strain(name: str, title: str, caption: str, curves: Mapping[str, Response], references: Mapping[str, Reference] | None = None) -> Figure:
    """A panel for each observable, with a curve of each response and points of each reference, by their names."""
    panels = tuple(
        Panel(quantity(column).title, _strain_axis(), Axis(quantity(column).axis), tuple(_marks(column, curves, references or {}))) for column in OBSERVABLES
    )
    return Figure(name, title, caption, panels, columns=2)


def _marks(column: str, curves: Mapping[str, Response], references: Mapping[str, Reference]) -> list[Mark]:
    scale = quantity(column).scale
    points = [Points(100 * each.control, scale * each.measured[column], REFERENCE, name) for name, each in references.items() if column in each.measured]
    lines = [Line(100 * run.control, scale * run.values[column], distinct(number), name) for number, (name, run) in enumerate(curves.items())]
    return [*points, *lines]


def difference(title: str, curves: Mapping[str, NDArray[np.float64]], strain: NDArray[np.float64], column: str) -> Panel:
    """A panel of what curves (S,) of a quantity differ from another by, over axial strain (S,)."""
    scale = quantity(column).scale
    lines = tuple(Line(100 * strain, scale * curve, distinct(number), label) for number, (label, curve) in enumerate(curves.items()))
    return Panel(title, _strain_axis(), Axis(f"Δ {quantity(column).axis}"), lines)


def over_iterations(name: str, title: str, caption: str, series: Mapping[str, Sequence[float]], label: str) -> Figure:
    """Lines over the number of the iteration, from 0."""
    numbered = ((number, each, np.asarray(values, dtype=float)) for number, (each, values) in enumerate(series.items()))
    lines = tuple(Line(np.arange(len(values), dtype=float), values, distinct(number), each) for number, each, values in numbered)
    return Figure(name, title, caption, (Panel("", iterations(series.values()), Axis(label), lines),), columns=1)


def iterations(series: Iterable[Sized]) -> Axis:
    """The axis of the longest of some series, from iteration 0."""
    return counting_axis("iteration", 0, max(1, *(len(values) - 1 for values in series)))


def _strain_axis() -> Axis:
    return Axis("axial strain [%]")
