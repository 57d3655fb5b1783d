"""Figure: undrained tests as they are read, the stress path in q over p′ and the excess pore pressure."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from graincal.campaign import Experiment
from graincal.campaign.found.emulated import Emulated
from graincal.campaign.found.record import Record
from graincal.data import Response
from graincal.drawing.figure import Axis, Figure, Line, Mark, Panel, Points
from graincal.drawing.palette import ANSWER, LIKELY, REFERENCE
from graincal.drawing.sight import in_sight
from graincal.notation.numbers import count
from graincal.notation.quantities import quantity
from graincal.report.responses import control_axis, on_axis, prefix

PORE, SHEAR, MEAN = "excess_pore_pressure", "deviatoric_stress", "mean_stress"


MOST_LIKELY = 30
"""Runs that fit about as well, that are drawn: more would hide each other."""


def draw_stress_paths(result: Record, emulated: Emulated | None = None) -> Figure | None:
    """The undrained tests of a result, by the runs at the answer or else the best run, with runs that fit about as well where that is known; None where there is none."""
    likely = _evenly(emulated.likely) if emulated else np.empty(0, dtype=np.int64)
    panels = [panel for number in range(len(result.experiments)) for panel in _panels(result, number, likely)]
    if not panels:
        return None
    drawn, cut = in_sight(panels)
    spread = f": the thin lines, {count(len(likely), 'run')} that fit about as well, show how far it is known" if len(likely) else ""
    caption = (
        "p′ is the mean effective stress, q the deviatoric stress, Δu the excess pore pressure where the total lateral stress is held. Points were measured, where the test has them. "
        f"A stress path has no band, for it may come to one p′ more than once{spread}."
    )
    return Figure("stress_paths", "The undrained tests: stress path and excess pore pressure.", f"{caption} {cut}".strip(), drawn, columns=2)


def _panels(result: Record, number: int, likely: NDArray[np.int64]) -> list[Panel]:
    experiment = result.experiments[number]
    at_answer, beside = _runs(result, number, _samples(result)), _runs(result, number, likely)
    if not at_answer:
        return []
    name = "runs at the answer" if result.answer and len(result.answer.samples) else "best response"
    runs = [(run, LIKELY, "runs that fit about as well") for run in beside] + [(run, ANSWER, name) for run in at_answer]
    mean, shear, pore = (quantity(each) for each in (MEAN, SHEAR, PORE))
    path = [Line(run.values[MEAN] * mean.scale, run.values[SHEAR] * shear.scale, style, of) for run, style, of in runs if {MEAN, SHEAR} <= run.values.keys()]
    risen = [Line(on_axis(experiment, run.control), run.values[PORE] * pore.scale, style, of) for run, style, of in runs]
    axis, x = control_axis(experiment)
    before, panels = prefix(result, experiment), []
    if path:
        panels.append(Panel(f"{before}Stress path", Axis("mean effective stress p′ [kPa]"), Axis(shear.axis), (*path, *_measured(experiment, MEAN, SHEAR))))
    measured = experiment.reference.measured
    points: tuple[Mark, ...] = (Points(x, measured[PORE] * pore.scale, REFERENCE, "measured"),) if PORE in measured else ()
    return [*panels, Panel(f"{before}{pore.title}", axis, Axis(pore.axis), (*risen, *points))]


def _measured(experiment: Experiment, over: str, name: str) -> tuple[Points, ...]:
    measured = experiment.reference.measured
    return (
        (Points(measured[over] * quantity(over).scale, measured[name] * quantity(name).scale, REFERENCE, "measured"),)
        if {over, name} <= measured.keys()
        else ()
    )


def _runs(result: Record, number: int, ids: NDArray[np.int64]) -> list[Response]:
    """The responses of samples that have a pore pressure, in the experiment of a number."""
    return [run for id in ids if isinstance(run := result.response(int(id), number), Response) and PORE in run.values]


def _evenly(ids: NDArray[np.int64]) -> NDArray[np.int64]:
    """As many of them as are drawn, from the first to the last."""
    return ids[np.linspace(0, len(ids) - 1, min(len(ids), MOST_LIKELY)).astype(np.intp)]


def _samples(result: Record) -> NDArray[np.int64]:
    if result.answer and len(result.answer.samples):
        return result.answer.samples
    return np.array([result.best.sample]) if result.best else np.empty(0, dtype=np.int64)
