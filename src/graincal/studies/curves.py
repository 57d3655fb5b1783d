"""Figures of curves over axial strain, in the paper's axes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from graincal.data import Reference, Response
from graincal.notation.quantities import quantity
from graincal.report.drawing import Axis, Figure, Line, Mark, Panel, Points, counting_axis
from graincal.report.palette import REFERENCE, Style, distinct
from graincal.studies.settings import OBSERVABLES


def over_strain(name: str, title: str, caption: str, curves: Mapping[str, Response], reference: Reference | None = None, columns: Sequence[str] = OBSERVABLES, styles: Mapping[str, Style] | None = None, dots: str = "reference") -> Figure:
    """A panel for each quantity, with a curve of each response by its name and the reference's points."""
    styles = styles or {each: distinct(number) for number, each in enumerate(curves)}
    panels = tuple(Panel(quantity(column).title, _strain_axis(), Axis(quantity(column).axis), tuple(_marks(column, curves, reference, styles, dots))) for column in columns)
    return Figure(name, title, caption, panels, columns=2)


def _marks(column: str, curves: Mapping[str, Response], reference: Reference | None, styles: Mapping[str, Style], dots: str) -> list[Mark]:
    scale = quantity(column).scale
    marks: list[Mark] = []
    measured = {} if reference is None else reference.measured
    if column in measured:
        marks.append(Points(100 * reference.control, scale * measured[column], REFERENCE, dots))
    return marks + [Line(100 * run.control, scale * run.values[column], styles[name], name) for name, run in curves.items()]


def difference(title: str, curves: Mapping[str, NDArray[np.float64]], strain: NDArray[np.float64], column: str) -> Panel:
    """A panel of what curves (S,) of a quantity differ from another by, over axial strain (S,)."""
    lines = tuple(Line(100 * strain, quantity(column).scale * curve, distinct(number), label) for number, (label, curve) in enumerate(curves.items()))
    return Panel(title, _strain_axis(), Axis(f"Δ {quantity(column).axis}"), lines)


def over_iterations(name: str, title: str, caption: str, series: Mapping[str, Sequence[float]], label: str, limits: tuple[float, float] | None = None, log: bool = False) -> Figure:
    """Lines over the number of the iteration, from 0."""
    lines = tuple(Line(np.arange(len(values), dtype=float), np.asarray(values, dtype=float), distinct(number), each) for number, (each, values) in enumerate(series.items()))
    return Figure(name, title, caption, (Panel("", iterations(series.values()), Axis(label, limits, log), lines),), columns=1)


def iterations(series: Iterable[Sequence[float]]) -> Axis:
    """The axis of the longest of some series, from iteration 0."""
    return counting_axis("iteration", 0, max(1, *(len(values) - 1 for values in series)))


def _strain_axis() -> Axis:
    return Axis("axial strain [%]")
