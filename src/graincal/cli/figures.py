"""Figures that commands draw on request."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure
from numpy.typing import NDArray

from graincal.campaign import Experiment
from graincal.data import InputError, Reference, Response
from graincal.files import unwritable

_UNITS = {"strain": ("%", 100.0), "extension": ("%", 100.0), "stress": ("kPa", 1e-3), "pressure": ("kPa", 1e-3)}
"""What quantities are drawn in, by the last word of their names, and the factor to that from fractions and Pa."""


def draw_references(experiments: Sequence[Experiment], path: Path) -> None:
    """The references, a row for each experiment and a panel for each observable."""
    columns = max(len(experiment.reference.observables) for experiment in experiments)
    figure = Figure(figsize=(4 * columns, 3 * len(experiments)), layout="constrained")
    for row, experiment in enumerate(experiments):
        for column, (name, values) in enumerate(experiment.reference.observables.items()):
            axes = figure.add_subplot(len(experiments), columns, 1 + row * columns + column)
            axes.plot(_to_print(experiment.reference.control_name, experiment.reference.control), _to_print(name, values), "k.-", markersize=3, linewidth=0.8)
            axes.set(title=experiment.name, xlabel=_label(experiment.reference.control_name), ylabel=_label(name))
    _save(figure, path)


def draw_response(response: Response, path: Path, control: str, shown: Sequence[str], reference: Reference | None = None) -> None:
    """The named columns of a response, or the observables of a reference beside it."""
    # What is loaded to stresses is seen by the strain that they make.
    shown = tuple(reference.observables) if reference else tuple("axial_strain" if name == control else name for name in shown)
    figure = Figure(figsize=(4 * len(shown), 3), layout="constrained")
    for column, name in enumerate(shown):
        axes = figure.add_subplot(1, len(shown), 1 + column)
        axes.plot(_to_print(control, response.control), _to_print(name, response.values[name]), "-", color="tab:blue", label="simulated")
        if reference:
            axes.plot(_to_print(control, reference.control), _to_print(name, reference.observables[name]), "k.", markersize=3, label="reference")
            axes.legend(frameon=False)
        axes.set(xlabel=_label(control), ylabel=_label(name))
    _save(figure, path)


def _to_print(name: str, values: NDArray) -> NDArray:
    _, factor = _UNITS.get(name.split("_")[-1], ("", 1.0))
    return factor * values


def _label(name: str) -> str:
    unit, _ = _UNITS.get(name.split("_")[-1], ("", 1.0))
    return name.replace("_", " ") + (f" ({unit})" if unit else "")


def _save(figure: Figure, path: Path) -> None:
    try:
        figure.savefig(path, dpi=150)
    except OSError as error:
        raise InputError(unwritable(path, error)) from None
