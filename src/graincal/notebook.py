"""How references, responses, packings and parameter spaces show themselves: in a few lines at a prompt, and as a table with curves in a notebook."""

from __future__ import annotations

import html
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from graincal.notation.markup import to_html
from graincal.notation.numbers import count
from graincal.notation.printable import printable
from graincal.notation.quantities import Quantity, parameter, quantity

if TYPE_CHECKING:
    from graincal.data import MeasurementError, Reference, Response
    from graincal.dem.packing import Packing
    from graincal.parameter_space import ParameterSpace

FEW = 60
"""Rows up to which each is drawn as a point."""

DRAWN = 3
"""Values of a response whose curves are drawn: the first, which are what tests are compared by."""

NOT_FITTED = "recorded, not fitted"
"""What stands in the place of a measurement error."""


def as_text(reference: Reference) -> str:
    """The number of states, and the range of each quantity in the unit that it is shown in, with its measurement error: a line each."""
    shown = quantity(reference.control_name)
    states = f"{len(reference.control)} state{'s' * (len(reference.control) > 1)}"
    over = f"{reference.control_name} {' to '.join(_range(reference.control, shown))}{shown.behind}"
    lines = [f"Reference: {states} over {over}{_said_of_all(reference, shown)}"]
    width = max(map(len, reference.measured))
    for name, values in reference.measured.items():
        of = quantity(name)
        error = NOT_FITTED if name in reference.recorded else f"measurement error: {error_in_words(reference.measurement_errors.get(name), of)}"
        lines.append(f"  {name:{width}}  {' to '.join(_range(values, of))}{of.behind}, {error}")
    if reference.notes:
        lines.append(f"  {len(reference.notes)} note{'s' * (len(reference.notes) > 1)} on how it was read, in .notes")
    return "\n".join(lines)


def as_html(reference: Reference) -> str:
    """The same as a table, with the notes and the curves (SVG); whatever is text is escaped."""
    shown = quantity(reference.control_name)
    rows = [(shown, reference.control, f"control{_said_of_all(reference, shown)}")]
    rows += [(quantity(name), values, error_in_words(reference.measurement_errors.get(name), quantity(name))) for name, values in reference.observables.items()]
    rows += [(quantity(name), values, NOT_FITTED) for name, values in reference.recorded.items()]
    body = "".join(
        f"<tr><th style='text-align:left'>{to_html(of.title)}</th><td>{'</td><td>'.join(_range(values, of))}</td>"
        f"<td>{html.escape(of.behind.strip())}</td><td style='text-align:left'>{html.escape(words)}</td></tr>"
        for of, values, words in rows
    )
    head = "".join(f"<th>{word}</th>" for word in (f"{len(reference.control)} states", "least", "largest", "unit", "measurement error"))
    notes = "".join(f"<li>{html.escape(note)}</li>" for note in reference.notes)
    listed = f"<ul>{notes}</ul>" if notes else ""
    return f"<div><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{listed}{_curves(reference)}</div>"


def response_as_html(response: Response) -> str:
    """Of each value of a response the first, the last, the least and the largest, as a table, with the curves of the first of them (SVG)."""
    control = quantity(response.control_name or "control")
    rows = "".join(
        f"<tr><th style='text-align:left'>{to_html(of.title)}</th>{''.join(f'<td>{of.scale * value + 0.0:.4g}</td>' for value in (column[0], column[-1], *_ends(column)))}<td>{html.escape(of.behind.strip())}</td></tr>"
        for of, column in ((control, response.control), *((quantity(name), values) for name, values in response.values.items()))
    )
    head = "".join(f"<th>{word}</th>" for word in (f"{len(response.control)} states", "first", "last", "least", "largest", "unit"))
    drawn = dict(list(response.values.items())[:DRAWN])
    return (
        f"<div><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>{_panels(response.control_name or 'control', response.control, drawn)}</div>"
    )


def packing_as_html(packing: Packing) -> str:
    """The particles, the void ratio, the cell and the diameters of a packing, as a table."""
    lengths = " × ".join(f"{1e3 * length:.4g}" for length in np.diag(packing.edges))
    least, middle, largest = (f"{2e3 * radius:.4g}" for radius in np.quantile(packing.radii, [0, 0.5, 1]))
    said = {
        "Particles": f"{packing.count}",
        "Void ratio": f"{packing.void_ratio:.3f}",
        "Cell": f"{lengths} mm",
        "Diameters": f"{least} to {largest} mm, half of them up to {middle} mm",
        "Name": packing.name,
    }
    rows = "".join(f"<tr><th style='text-align:left'>{key}</th><td>{html.escape(printable(text))}</td></tr>" for key, text in said.items())
    return f"<table>{rows}</table>"


def space_as_text(space: ParameterSpace) -> str:
    """The range of each parameter with its unit, or the value of one that is fixed: a line each; and the constraints."""
    told = _told_of_parameters(space)
    width = max(map(len, told))
    lines = [f"  {name:{width}}  {words}" for name, words in told.items()] + [f"  where {source}" for source in _conditions(space)]
    return "\n".join([f"ParameterSpace: {count(space.size, 'unknown parameter')}", *lines])


def space_as_html(space: ParameterSpace) -> str:
    """The same as a table."""
    rows = "".join(
        f"<tr><th style='text-align:left'>{to_html(parameter(name, '').label)}</th><td style='text-align:left'>{html.escape(told)}</td></tr>"
        for name, told in _told_of_parameters(space).items()
    )
    where = "".join(f"<tr><th style='text-align:left'>where</th><td style='text-align:left'>{html.escape(source)}</td></tr>" for source in _conditions(space))
    return f"<table>{rows}{where}</table>"


def _conditions(space: ParameterSpace) -> list[str]:
    """What constraints say; one on the values of each experiment is said once."""
    return list(dict.fromkeys(each.source for each in space.constraints))


def _told_of_parameters(space: ParameterSpace) -> dict[str, str]:
    """By name, in the order in which models are given them; a parameter with a value in each experiment may be there once for each."""
    told = {}
    for name, low, high, unit, scale in zip(space.names, space.low, space.high, space.units, space.scales):
        even = ", even in the logarithm" if scale == "log" else ""
        own = ", a value in each experiment" if name in space.per_experiment else ""
        told[name] = f"{low:g} to {high:g}{f' {unit}' * bool(unit)}{even}{own}"
    for name, value in space.fixed.items():
        unit = space.units_of_fixed[name]
        told[name] = f"{value:g}{f' {unit}' * bool(unit)}, fixed"
    return {name: told[name] for name in (*(name for name in space.order if name in told), *(name for name in told if name not in space.order))}


def error_in_words(error: MeasurementError | None, shown: Quantity) -> str:
    """A measurement error in the unit that its observable is shown in."""
    if error is None:
        return "none stated"
    parts = [f"sd {shown.scale * error.absolute:.3g}{shown.behind}"] if error.absolute else []
    parts += [f"{100 * error.relative:.3g} % of each value"] if error.relative else []
    parts += [f"steps of {shown.scale * error.step:.3g}{shown.behind}"] if error.step else []
    parts += [f"noise of sd {shown.scale * error.noise:.3g}{shown.behind}"] if error.noise else []
    return ", ".join(parts)


def _said_of_all(reference: Reference, shown: Quantity) -> str:
    """What holds for all of the reference: how its control was read, and whether it is a simulation's."""
    steps = f", in steps of {shown.scale * reference.control_step:.3g}{shown.behind}" if reference.control_step else ""
    return steps + (", of a simulation" if reference.simulated else "")


def _range(values: NDArray[np.float64], shown: Quantity) -> tuple[str, str]:
    """The least and the largest value, in the unit that they are shown in."""
    # Without a sign before 0.
    least, largest = (f"{shown.scale * end(values) + 0.0:.4g}" for end in (np.min, np.max))
    return least, largest


def _ends(values: NDArray[np.float64]) -> tuple[float, float]:
    """The least and the largest of the finite values; NaN without any."""
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if finite.size else (np.nan, np.nan)


def _curves(reference: Reference) -> str:
    """The observables over the control, a panel each, as an SVG element."""
    return _panels(reference.control_name, reference.control, reference.measured)


def _panels(control_name: str, control: NDArray[np.float64], values: Mapping[str, NDArray[np.float64]]) -> str:
    """Values over their control, a panel each, as an SVG element."""
    from graincal.drawing.figure import Axis, Figure, Panel, log_axis
    from graincal.drawing.with_matplotlib import to_svg

    shown = quantity(control_name)
    x = shown.scale * control
    across = log_axis(shown.axis, x) if control_name.endswith("stress") and x[0] > 0 else Axis(shown.axis)
    panels = tuple(Panel("", across, Axis(quantity(name).axis), tuple(_marks(x, quantity(name).scale * column))) for name, column in values.items())
    return to_svg(Figure("curves", "", "", panels)) if panels else ""


def _marks(x: NDArray[np.float64], y: NDArray[np.float64]) -> Iterator:
    from graincal.drawing.figure import Line, Points
    from graincal.drawing.palette import BLUE, REFERENCE, Style

    yield Line(x, y, Style(BLUE))
    if len(x) <= FEW:
        yield Points(x, y, REFERENCE)
