"""Figure: what a posterior predicts of a test, with the band of what the test would measure."""

from __future__ import annotations

from collections.abc import Sequence

from graincal.campaign.found.prediction import Prediction
from graincal.data import Reference
from graincal.drawing.figure import Array, Axis, Figure, Line, Mark, Panel, Points, log_axis
from graincal.drawing.palette import BAND, MEASURED, PREDICTED, REFERENCE
from graincal.inference.sampling.posterior import PROBABILITY
from graincal.models.stress_path import Abscissa
from graincal.notation.numbers import count
from graincal.notation.quantities import quantity
from graincal.report.responses import NOT_FITTED, bands

SHOWN = ("stress_ratio", "volumetric_strain", "deviatoric_stress", "excess_pore_pressure", "axial_stress")
"""What of a prediction is drawn where nobody says it, as far as it is there."""


def draw_predicted(prediction: Prediction, against: Reference | None = None, names: Sequence[str] = (), abscissa: Abscissa | None = None) -> Figure:
    """The mean and the band of a prediction, beside a test whose measurement errors it then has.

    names: what is drawn, by default what the test measured. abscissa: what it is drawn over, by default the control. Raises InputError for a name that the prediction does not hold.
    """
    if against:
        prediction = prediction.measured_as(against)
    names = tuple(names) or tuple(against.measured if against else (name for name in SHOWN if name in prediction.values)) or tuple(prediction.values)[:3]
    over, values, logarithmic = abscissa or Abscissa(prediction.control_name, prediction.control)
    across = quantity(over)
    x = values * across.scale
    axis = log_axis(across.axis, x) if logarithmic else Axis(across.axis)
    panels = []
    for name in names:
        shown = quantity(name)
        marks = predicted_marks(prediction, name, x)
        if against and name in against.measured:
            marks.append(Points(x, against.measured[name] * shown.scale, REFERENCE, "measured"))
        title = f"{shown.title}{NOT_FITTED * bool(against and name in against.recorded)}"
        panels.append(Panel(title, axis, Axis(shown.axis), tuple(marks)))
    title = f"Predicted by {count(len(prediction.theta), 'run')}."
    return Figure("prediction", title, prediction.band_in_words(names, PROBABILITY), tuple(panels), columns=2 if len(panels) == 4 else min(3, len(panels)))


def predicted_marks(prediction: Prediction, name: str, x: Array, mean: str = "predicted mean") -> list[Mark]:
    """The band of a quantity and the mean response, over x (T,) of an axis; mean: what that is called."""
    shown = quantity(name)
    low, high = prediction.measured_interval(name, PROBABILITY) * shown.scale
    style, of = (MEASURED, "what a test would measure") if name in prediction.with_errors else (BAND, "responses")
    return [*bands(x, low, high, style, f"{100 * PROBABILITY:.0f} % of {of}"), Line(x, prediction.mean(name) * shown.scale, PREDICTED, mean)]
