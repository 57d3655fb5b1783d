"""Figure: undrained tests as they are read, the stress path in q over p′ and the excess pore pressure."""

from __future__ import annotations

import numpy as np

from graincal.campaign import Experiment
from graincal.campaign.found.record import Record
from graincal.data import Response
from graincal.drawing.figure import Axis, Figure, Line, Mark, Panel, Points
from graincal.drawing.palette import ANSWER, REFERENCE
from graincal.drawing.sight import in_sight
from graincal.notation.quantities import quantity
from graincal.report.responses import control_axis, on_axis, prefix

PORE, SHEAR, MEAN = "excess_pore_pressure", "deviatoric_stress", "mean_stress"


def draw_stress_paths(result: Record) -> Figure | None:
    """The undrained tests of a result, by the runs at the answer or else the best run; None where there is none."""
    panels = [panel for number in range(len(result.experiments)) for panel in _panels(result, number)]
    if not panels:
        return None
    shown, cut = in_sight(panels)
    caption = "p′ is the mean effective stress, q the deviatoric stress, Δu the excess pore pressure where the total lateral stress is held. Points were measured, where the test has them."
    return Figure("stress_paths", "The undrained tests: stress path and excess pore pressure.", f"{caption} {cut}".strip(), shown, columns=2)


def _panels(result: Record, number: int) -> list[Panel]:
    experiment = result.experiments[number]
    runs = [run for id in _samples(result) if isinstance(run := result.response(int(id), number), Response) and PORE in run.values]
    if not runs:
        return []
    name = "runs at the answer" if result.answer and len(result.answer.samples) else "best response"
    mean, shear, pore = (quantity(each) for each in (MEAN, SHEAR, PORE))
    path = [Line(run.values[MEAN] * mean.scale, run.values[SHEAR] * shear.scale, ANSWER, name) for run in runs if {MEAN, SHEAR} <= run.values.keys()]
    risen = [Line(on_axis(experiment, run.control), run.values[PORE] * pore.scale, ANSWER, name) for run in runs]
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


def _samples(result: Record) -> np.ndarray:
    if result.answer and len(result.answer.samples):
        return result.answer.samples
    return np.array([result.best.sample]) if result.best else np.empty(0, dtype=np.int64)
