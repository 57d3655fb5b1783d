"""What the report predicts by the method "posterior": draws, their band, and why there is none."""

import numpy as np
import pytest
from campaign import frictional
from campaign.as_tasks import as_tasks
from campaign.frictional import STRAIN

import graincal as gc
from graincal.data import Failure
from graincal.drawing.figure import Band
from graincal.models import StressPathTest
from graincal.report import prediction as predicting
from graincal.report import write_report
from graincal.report.contents import figures
from graincal.report.prediction import DRAWS, predict_response

pytestmark = pytest.mark.usefixtures("fewer_draws")

ERRORS = {"stress_ratio": 0.02, "volumetric_strain": 5e-4}
KNOWN = {"log_E": 8, "nu": 0.2, "beta_m": 0.1}


@pytest.fixture
def result(tmp_path, monkeypatch):
    """A campaign of its own for each test, for what is simulated is kept in it."""
    monkeypatch.setattr(StressPathTest, "tasks", frictional.tasks)
    test = gc.TriaxialTest(frictional.packing(), 5e5, fixed=KNOWN)
    reference = gc.Reference(STRAIN, frictional.curves(32.0, 0.3), measurement_errors=ERRORS, simulated=True)
    space = gc.ParameterSpace({"phi": (10, 50), "eta_m": (0, 1)}, units={"phi": "deg"})
    options = {"seed": 3, "workers": 1, "stop": gc.Stop(max_iterations=1), "first_batch": 8, "packing_scatter": False}
    return gc.calibrate(test, reference, space, folder=tmp_path / "campaign", **options)


def test_it_is_by_draws_with_the_band_of_what_would_be_measured(result):
    found = predict_response(result, 2.0)
    assert found.response is None and found.test.confining_pressure == 1e6 and len(found.drawn.theta) == DRAWS
    figure = figures(result, found)[-1]
    assert figure.name == "prediction" and figure.title.startswith("Predicted, not confirmed, at 1 MPa")
    assert "No test at this pressure was compared with it" in figure.caption
    assert (
        "90 % of what a test would measure, state by state: the responses of 20 parameter sets drawn from the posterior, with the measurement errors"
        in figure.caption
    )
    for panel, name in zip(figure.panels, ERRORS):
        band = next(mark for mark in panel.marks if isinstance(mark, Band))
        low, high = found.drawn.measured_interval(name) * (100 if name == "volumetric_strain" else 1)
        np.testing.assert_array_equal([band.low, band.high], [low, high])
        assert band.name == "90 % of what a test would measure"


def test_a_second_report_runs_nothing(result, tmp_path, monkeypatch):
    first = predict_response(result, 2.0).drawn
    monkeypatch.setattr(StressPathTest, "tasks", as_tasks(lambda *_: pytest.fail("a run")))
    again = predict_response(gc.Result.read(tmp_path / "campaign"), 2.0).drawn
    for name, values in first.values.items():
        np.testing.assert_array_equal(again.values[name], values)
    np.testing.assert_array_equal(again.theta, first.theta)
    assert "20 simulations by the posterior" in write_report(result, tmp_path / "report.html").read_text(encoding="utf-8")


def test_where_draws_would_take_long_it_is_one_run_and_says_so(result, monkeypatch):
    monkeypatch.setattr(predicting, "LONGEST_DRAWS", 0.0)
    found = predict_response(result, 2.0)
    assert found.drawn is None and found.response is not None
    caption = figures(result, found)[-1].caption
    assert (
        "one simulation of sample" in caption
        and "It is one run and has no band: 20 runs would take about" in caption
        and "on 1 core, and a report waits 0 s at most" in caption
    )


def test_draws_that_fail_are_counted_and_where_all_do_it_is_said(result, monkeypatch):
    half = as_tasks(lambda test, samples, at: Failure("diverged", "It blew up.") if samples.ids[0] % 2 else frictional.respond(test, samples, at))
    monkeypatch.setattr(StressPathTest, "tasks", half)
    assert figures(result, predict_response(result, 2.0))[-1].caption.endswith("10 more runs failed.")
    monkeypatch.setattr(StressPathTest, "tasks", as_tasks(lambda *_: Failure("diverged", "It blew up.")))
    found = predict_response(result, 3.0)
    assert found.drawn is None and "It blew up" in found.missing


def test_the_command_says_and_writes_the_band_with_errors(result, call, tmp_path):
    called = call("predict", tmp_path / "campaign", "-o", tmp_path / "band.csv", "--plot", tmp_path / "band.png")
    assert called.code == 0 and "The band holds 90 % of what a test would measure, state by state: the responses of 30 parameter sets" in called.out
    assert "No error is stated of coordination number Z and a_c: the band there holds 90 % of the responses alone." in called.out
    band = np.genfromtxt(tmp_path / "band.csv", delimiter=",", names=True, deletechars="")
    assert {"stress_ratio_mean", "stress_ratio_5%", "stress_ratio_measured_5%", "stress_ratio_measured_95%", "void_ratio_95%"} <= set(band.dtype.names)
    assert "void_ratio_measured_95%" not in band.dtype.names
    # The responses do not differ at the start: the band is that of the error.
    assert np.ptp([band["stress_ratio_measured_5%"][0], band["stress_ratio_measured_95%"][0]]) == pytest.approx(2 * 1.645 * 0.02, rel=1e-3)
    assert np.all(band["stress_ratio_measured_95%"] > band["stress_ratio_95%"]) and (tmp_path / "band.png").stat().st_size > 0
