"""The report's figures from Python, each as Matplotlib's axes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from graincal.campaign.found.prediction import Prediction
from graincal.data import InputError, Reference
from graincal.drawing.figure import Figure
from graincal.drawing.with_matplotlib import show
from graincal.report.emulated_figures import draw_bands, draw_emulated_pairs
from graincal.report.pairs import draw_pairs
from graincal.report.predicted import draw_predicted
from graincal.report.prediction import draw_other_pressure, predict_response
from graincal.report.responses import draw_responses
from graincal.report.sampling import draw_samples
from graincal.report.write import PREDICTED as TIMES

if TYPE_CHECKING:
    from graincal.result import Result


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
        """A prediction (`graincal.predict`) with its 90 % bands, measurement errors included, and a test that it is compared with; names: what is drawn, by default what the test measured.

        `prediction.band_in_words(names)` says what the bands hold. Without a prediction it is the report's, at twice the confining pressure: by the method "posterior" 20 runs where they take half a
        minute at most, else one run of the answer.
        """
        if prediction is None:
            return _shown(draw_other_pressure(predict_response(self._result, TIMES)), "predict")
        return _shown(draw_predicted(prediction, against, names), "predict")


def _shown(figure: Figure | None, name: str) -> np.ndarray:
    if figure is None:
        raise InputError(f"plot.{name}: there is nothing to draw yet, for the campaign has too few evaluations with a response.")
    return show(figure)
