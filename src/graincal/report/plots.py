"""The report's figures from Python, each as Matplotlib's axes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from graincal.campaign.found.prediction import Prediction
from graincal.data import InputError, Reference
from graincal.drawing.figure import Axis, Figure, Line, Mark, Panel, Points
from graincal.drawing.palette import BAND, PREDICTED, REFERENCE
from graincal.drawing.with_matplotlib import show
from graincal.inference.sampling.posterior import PROBABILITY
from graincal.notation.numbers import count
from graincal.notation.quantities import quantity
from graincal.report.emulated_figures import draw_bands, draw_emulated_pairs
from graincal.report.pairs import draw_pairs
from graincal.report.prediction import draw_prediction, predict_response
from graincal.report.responses import bands, draw_responses
from graincal.report.sampling import draw_samples
from graincal.report.write import PREDICTED as TIMES

if TYPE_CHECKING:
    from graincal.result import Result

SHOWN = ("stress_ratio", "volumetric_strain", "deviatoric_stress", "excess_pore_pressure", "axial_stress")
"""What of a prediction is drawn where nobody says it, as far as it is there."""


class Plots:
    """Draws what a result found: each method returns the axes (rows, columns) of a figure of pyplot's. Raises InputError where there is nothing to draw yet."""

    def __init__(self, result: Result) -> None:
        self._result = result

    def curves(self) -> np.ndarray:
        """The reference and the answer's responses, with the bands of what is known: a panel for each observable of each experiment."""
        emulated = self._result.emulated
        return _shown(draw_bands(emulated) if emulated else None if self._result.has_posterior else draw_responses(self._result), "curves")

    def pairs(self) -> np.ndarray:
        """The posterior in pairs of parameters, (n, n)."""
        emulated = self._result.emulated
        return _shown(draw_emulated_pairs(emulated) if emulated else None if self._result.has_posterior else draw_pairs(self._result), "pairs")

    def trace(self) -> np.ndarray:
        """Where the runs went: the error of each over each parameter, later ones darker."""
        return _shown(draw_samples(self._result), "trace")

    def predict(self, prediction: Prediction | None = None, against: Reference | None = None, names: Sequence[str] = ()) -> np.ndarray:
        """A prediction (`graincal.predict`) with its 90 % bands of the responses, and a test that it is compared with; names: what is drawn, by default what the test measured.

        Without a prediction, one run of the answer at twice the confining pressure, as in the report: it takes as long as one evaluation.
        """
        if prediction is None:
            return _shown(draw_prediction(predict_response(self._result, TIMES)), "predict")
        return _shown(figure_of(prediction, against, names), "predict")


def figure_of(prediction: Prediction, against: Reference | None = None, names: Sequence[str] = ()) -> Figure:
    """The bands of a prediction. Raises InputError for a name that it does not hold."""
    names = tuple(names) or tuple(against.measured if against else (name for name in SHOWN if name in prediction.values)) or tuple(prediction.values)[:3]
    across = quantity(prediction.control_name)
    x, panels = prediction.control * across.scale, []
    for name in names:
        shown = quantity(name)
        low, high = prediction.interval(name, PROBABILITY) * shown.scale
        marks: list[Mark] = [
            *bands(x, low, high, BAND, f"{100 * PROBABILITY:.0f} % of responses"),
            Line(x, prediction.mean(name) * shown.scale, PREDICTED, "predicted mean"),
        ]
        if against and name in against.measured:
            marks.append(Points(against.control * across.scale, against.measured[name] * shown.scale, REFERENCE, "measured"))
        panels.append(Panel(shown.title, Axis(across.axis), Axis(shown.axis), tuple(marks)))
    caption = "The band holds the responses of the parameters drawn from the posterior, state by state; errors of measurement are not in it."
    return Figure("prediction", f"Predicted by {count(len(prediction.theta), 'run')}.", caption, tuple(panels), columns=min(3, len(panels)))


def _shown(figure: Figure | None, name: str) -> np.ndarray:
    if figure is None:
        raise InputError(f"plot.{name}: there is nothing to draw yet, for the campaign has too few evaluations with a response.")
    return show(figure)
