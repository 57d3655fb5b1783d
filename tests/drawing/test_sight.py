"""What of a panel is in sight."""

import numpy as np
import pytest

from graincal.drawing.figure import Axis, Line, Panel, Points
from graincal.drawing.palette import ANSWER, REFERENCE
from graincal.drawing.sight import in_sight

X = np.linspace(0, 1, 11)


def panel(curve, measured=1 + X):
    return Panel("Stress", Axis(), Axis("stress [kPa]"), (Line(X, curve, ANSWER), Points(X, measured, REFERENCE)))


def test_an_axis_is_cut_where_a_curve_goes_far_beyond_what_was_measured_and_that_is_said():
    (cut,), said = in_sight([panel(1 + 100 * X)])
    # The measured points are from 1 to 2; as much again is in sight above them, and nothing of what is not there below.
    assert cut.y.limits == pytest.approx((0.95, 3.05)) and said == "Axes are cut in Stress (curves go from 1.00 to 101)."
    near = panel(1 + 2 * X)
    assert in_sight([near]) == ((near,), "")


def test_noise_of_rounding_is_drawn_as_zero():
    (shown,), said = in_sight([panel(1e-14 * X, 0 * X)])
    assert not shown.marks[0].y.any() and shown.y.limits == (-1, 1) and said == ""
