"""Scores of predictions, against distributions whose scores are known."""

from __future__ import annotations

import numpy as np
import pytest

from graincal import Reference
from graincal.inference.scoring import score

CONTROL = np.linspace(0, 1, 400)


def test_a_band_of_the_right_spread_holds_what_it_says():
    # Responses that do not vary, and a test with errors of 0.1 that vary fast along the curve: 90 % of its states lie within the central 90 %.
    # 400 nearly independent states: four standard errors are 0.06.
    values = 1 + 0.1 * np.random.default_rng(2).standard_normal(len(CONTROL))
    reference = Reference(CONTROL, {"y": values}, measurement_errors={"y": 0.1})
    found = score(np.ones((40, len(CONTROL), 1)), reference)
    assert found.coverage["y"] == pytest.approx(0.9, abs=0.06)


def test_the_true_prediction_has_the_better_log_score():
    reference = Reference(CONTROL, {"y": 1 + CONTROL}, measurement_errors={"y": 0.05})
    scores = []
    for offset in (0.0, 0.05, 0.5):
        responses = (1 + CONTROL + offset)[None, :, None] + 0.02 * np.linspace(-1, 1, 21)[:, None, None]
        scores.append(score(responses, reference).log_score)
    assert scores[0] > scores[1] > scores[2]


def test_the_error_of_the_mean_is_that_of_the_paper():
    reference = Reference(CONTROL, {"y": np.full(len(CONTROL), 2.0)})
    assert score(np.full((3, len(CONTROL), 1), 2.1), reference).error == pytest.approx(5.0)
