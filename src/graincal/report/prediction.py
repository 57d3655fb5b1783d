"""What the calibrated triaxial test gives at another confining pressure: a prediction, which no test was compared with."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from graincal.campaign import Experiment
from graincal.campaign.found.answer import Candidate
from graincal.campaign.found.record import Record
from graincal.data import Failure, Response
from graincal.drawing.figure import Axis, Figure, Line, Panel, Points
from graincal.drawing.palette import BEST, PREDICTED, REFERENCE
from graincal.drawing.sight import in_sight
from graincal.models import TriaxialTest
from graincal.notation import numbers
from graincal.notation.quantities import quantity
from graincal.report.answer import answer_of, as_samples
from graincal.report.responses import NOT_FITTED, control_axis

LONGEST = 120.0
"""Seconds that the same sample's evaluation may have taken for a report to simulate it once more."""
CONTROL = "control of the prediction"
_MORE_STEPS = 3
"""How many times the steps of that evaluation the simulation may take."""


@dataclass(frozen=True, eq=False)
class Prediction:
    """A calibrated sample in `test`, the triaxial test of an experiment at another confining pressure.

    response: what the simulation gave; None where there is none, and `missing` then says why.
    """

    experiment: Experiment
    test: TriaxialTest
    candidate: Candidate
    calibrated: Response
    response: Response | None
    missing: str = ""


def predict_response(result: Record, factor: float | None) -> Prediction | None:
    """Simulate the most probable sample once, at `factor` times the confining pressure, in the triaxial experiment of the highest pressure.

    None without a factor or a triaxial experiment. It is one simulation, and none where the same sample took longer than LONGEST.
    """
    candidate = answer_of(result)
    tests = [experiment for experiment in result.experiments if isinstance(experiment.model, TriaxialTest)]
    if not (factor and tests and candidate):
        return None
    experiment = max(tests, key=lambda each: each.model.confining_pressure)
    calibrated = result.response(candidate.sample, experiment.name)
    test = replace(experiment.model, confining_pressure=factor * experiment.model.confining_pressure)
    seconds, steps = calibrated.details.get("seconds", 0.0), calibrated.details.get("steps", test.step_limit)
    if seconds > LONGEST:
        missing = f"It was not simulated: the same sample took {numbers.duration(seconds)} in the calibration, and a report waits {LONGEST:g} s at most."
        return Prediction(experiment, test, candidate, calibrated, None, missing)
    bounded = replace(test, step_limit=min(test.step_limit, int(_MORE_STEPS * steps)))
    outcome = _kept(result, f"prediction of {candidate.sample} at {bounded.confining_pressure!r}", lambda: _simulate(result, bounded, candidate, experiment))
    if isinstance(outcome, Response):
        return Prediction(experiment, test, candidate, calibrated, outcome)
    return Prediction(experiment, test, candidate, calibrated, None, f"It could not be simulated: {outcome.reason}")


def _simulate(result: Record, test: TriaxialTest, candidate: Candidate, experiment: Experiment) -> Response | Failure:
    [(_, outcome)] = test.evaluate(as_samples(result, candidate, experiment), experiment.reference.control, workers=1)
    return outcome


def _kept(result: Record, name: str, simulate: Callable[[], Response | Failure]) -> Response | Failure:
    """What is simulated, kept with what the last look found, so that another report does not run it again."""
    if not result.has_posterior or result.found is None:
        return simulate()
    failures = []

    def table() -> NDArray | None:
        """The response's control and values as columns."""
        outcome = simulate()
        if isinstance(outcome, Failure):
            failures.append(outcome)
            return None
        columns = {CONTROL: outcome.control, **outcome.values}
        return np.rec.fromarrays(list(columns.values()), names=list(columns)).view(np.ndarray)

    rows = result.derived(name, table)
    return failures[0] if rows is None else Response(rows[CONTROL], {name: rows[name] for name in rows.dtype.names if name != CONTROL})


def draw_prediction(prediction: Prediction | None) -> Figure | None:
    """The observables at the other pressure, beside those of the calibration."""
    if prediction is None or prediction.response is None:
        return None
    experiment = prediction.experiment
    predicted, calibrated = (numbers.pressure(pressure) for pressure in (prediction.test.confining_pressure, experiment.model.confining_pressure))
    axis, x = control_axis(experiment)
    scale = quantity(experiment.reference.control_name).scale
    panels = []
    for name, values in experiment.reference.measured.items():
        shown = quantity(name)
        title = f"{shown.title}{NOT_FITTED * (name in experiment.reference.recorded)}"
        marks = (
            Line(
                scale * prediction.calibrated.control,
                prediction.calibrated.values[name] * shown.scale,
                replace(BEST, dash="dash"),
                f"calibrated at {calibrated}",
            ),
            Points(x, values * shown.scale, REFERENCE, f"reference at {calibrated}"),
            Line(scale * prediction.response.control, prediction.response.values[name] * shown.scale, PREDICTED, f"predicted at {predicted}"),
        )
        panels.append(Panel(title, axis, Axis(shown.axis), marks))
    shown, cut = in_sight(panels)
    caption = (
        f"A prediction, not a confirmation: one simulation of sample {prediction.candidate.sample} at {predicted}, everything else as in {experiment.name}. "
        "No test at this pressure was compared with it, and another run of the same parameters would differ by the scatter of runs."
        f"{' ' * bool(cut)}{cut}"
    )
    return Figure(
        "prediction", f"Predicted, not confirmed, at {predicted} from the calibration at {calibrated}.", caption, shown, columns=min(3, max(2, len(panels)))
    )
