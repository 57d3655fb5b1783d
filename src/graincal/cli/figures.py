"""Figures that commands draw on request."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter, StrMethodFormatter
from numpy.typing import NDArray

from graincal.campaign.found.prediction import Prediction
from graincal.data import InputError, Reference, Response
from graincal.drawing import with_matplotlib
from graincal.files import unwritable
from graincal.models.stress_path import Abscissa, Panel
from graincal.notation.glyphs import missing_glyphs_unsaid
from graincal.notation.markup import to_mathtext
from graincal.report.predicted import draw_predicted

_UNITS = {"strain": ("%", 100.0), "extension": ("%", 100.0), "stress": ("kPa", 1e-3), "pressure": ("kPa", 1e-3)}
"""What quantities are drawn in, by the last word of their names, and the factor to that from fractions and Pa."""

SMALLEST_SPAN = 1e-4
"""An axis spans at least so much of a fraction, or so large a part of the largest stress: as closely as a test meets its targets, and its figure is read."""


class Drawn(Protocol):
    """What a reference is drawn of: an experiment, or one whose model cannot be made yet."""

    @property
    def name(self) -> str: ...

    @property
    def reference(self) -> Reference: ...

    def abscissa(self, at: NDArray[np.float64]) -> Abscissa: ...


def draw_references(experiments: Sequence[Drawn], path: Path, responses: Mapping[int, Response] | None = None) -> None:
    """The references, a row for each experiment and a panel for each observable and what was recorded beside them. responses: to be drawn beside the reference of the experiment of that number, on its rows."""
    columns = max(len(experiment.reference.measured) for experiment in experiments)
    figure = Figure(figsize=(4 * columns, 3 * len(experiments)), layout="constrained")
    for row, experiment in enumerate(experiments):
        for column, (name, values) in enumerate(experiment.reference.measured.items()):
            axes = figure.add_subplot(len(experiments), columns, 1 + row * columns + column)
            over, x, logarithmic = experiment.abscissa(experiment.reference.control)
            axes.plot(_to_print(over, x), _to_print(name, values), "k.-", markersize=3, linewidth=0.8, label="reference")
            if response := (responses or {}).get(row):
                axes.plot(_to_print(over, x), _to_print(name, response.values[name]), "-", color="tab:blue", label="the first sample")
                axes.legend(frameon=False)
            if logarithmic:
                _scale_logarithmically(axes, x)
            axes.set(title=to_mathtext(f"{experiment.name}{_not_fitted(name, experiment.reference)}"), xlabel=_label(over), ylabel=_label(name))
    _save(figure, path)


def draw_response(response: Response, path: Path, control: str, shown: Sequence[Panel], reference: Reference | None = None) -> None:
    """Write the figure of a response (`response_figure`)."""
    _save(response_figure(response, control, shown, reference), path)


def response_figure(response: Response, control: str, shown: Sequence[Panel], reference: Reference | None = None) -> Figure:
    """The panels of a test's figure, with the rows of its curve; or the observables of a reference beside it."""
    panels = [Panel(name) for name in reference.measured] if reference else shown
    columns = {**response.values, control: response.control}
    figure = Figure(figsize=(4 * len(panels), 3), layout="constrained")
    for number, (name, over, logarithmic) in enumerate(panels):
        axes = figure.add_subplot(1, len(panels), 1 + number)
        over = over or control
        style = {"color": "tab:blue", "label": "simulated"} | ({} if reference else {"marker": ".", "linewidth": 1.0})
        axes.plot(_to_print(over, columns[over]), _to_print(name, columns[name]), "-", **style)
        if reference:
            axes.plot(
                _to_print(control, reference.control),
                _to_print(name, reference.measured[name]),
                "k.",
                markersize=3,
                label=f"reference{_not_fitted(name, reference)}",
            )
            axes.legend(frameon=False)
        if logarithmic:
            _scale_logarithmically(axes, columns[over])
        elif over == "stage":
            axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        elif over.endswith("stress"):
            # A stress path is seen from the origin.
            axes.set_xlim(left=0)
        least = SMALLEST_SPAN * max(1.0, float(np.max(np.abs(columns[name]))))
        _widen(axes, float(_to_print(name, np.asarray(least))))
        axes.set(xlabel=_label(over), ylabel=_label(name))
    return figure


def draw_prediction(prediction: Prediction, shown: Sequence[str], reference: Reference | None, path: Path, abscissa: Abscissa | None = None) -> None:
    """Write the figure of a prediction (`draw_predicted`), with the test that it is compared with if there is one; over the control if nothing else is given."""
    try:
        with_matplotlib.save(draw_predicted(prediction, reference, shown, abscissa), path)
    except OSError as error:
        raise InputError(unwritable(path, error)) from None


def _scale_logarithmically(axes: Axes, values: NDArray) -> None:
    """A logarithmic axis, labelled 1, 2, 5, 10, ... or, where it spans less than a few of these, evenly."""
    axes.set_xscale("log")
    wide = np.max(values) > 5 * np.min(values)
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)) if wide else MaxNLocator(5))
    axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())


def _widen(axes: Axes, span: float) -> None:
    """Let the vertical axis span as much at the least: what is constant to rounding is drawn constant."""
    low, high = axes.get_ylim()
    if high - low < span:
        middle = 0.5 * (low + high)
        axes.set_ylim(middle - 0.5 * span, middle + 0.5 * span)


def _to_print(name: str, values: NDArray) -> NDArray:
    _, factor = _UNITS.get(name.split("_")[-1], ("", 1.0))
    return factor * values


def _label(name: str) -> str:
    unit, _ = _UNITS.get(name.split("_")[-1], ("", 1.0))
    return to_mathtext(name.replace("_", " ")) + (f" ({unit})" if unit else "")


def _not_fitted(name: str, reference: Reference) -> str:
    return ", not fitted" if name in reference.recorded else ""


def _save(figure: Figure, path: Path) -> None:
    try:
        with missing_glyphs_unsaid():
            figure.savefig(path, dpi=150)
    except OSError as error:
        raise InputError(unwritable(path, error)) from None
