"""What was recorded and not fitted stands in the report: drawn, marked, and with its error."""

import numpy as np
import pytest

import graincal as gc
from graincal.campaign.found.emulated import Emulated
from graincal.drawing import with_matplotlib, with_plotly
from graincal.drawing.figure import Band, Line
from graincal.report import summarise, tables, write_report
from graincal.report.contents import figures

from . import soil
from .test_report import read

pytestmark = pytest.mark.usefixtures("fewer_draws")

METHODS = {"iterative-bayesian": {"stop": soil.STOP, "alpha": 20}, "posterior": {"stop": gc.Stop(max_iterations=1), "discrepancy": False}}


def respond(theta):
    """As the soil does, but that one in ten has a volumetric strain that is no number at a state."""
    curves = soil.respond(theta)
    return curves | {"volumetric_strain": np.where((soil.STRAIN == soil.STRAIN[5]) & (theta[2] > 0.9), np.nan, curves["volumetric_strain"])}


@pytest.fixture(scope="module", params=METHODS)
def result(request):
    curves = soil.respond(soil.TRUTH)
    reference = gc.Reference(
        soil.STRAIN,
        {"stress_ratio": curves["stress_ratio"]},
        measurement_errors={"stress_ratio": 0.03},
        recorded={"volumetric_strain": curves["volumetric_strain"]},
    )
    return gc.calibrate(gc.PythonModel(respond), reference, soil.SPACE, method=request.param, seed=3, workers=1, **METHODS[request.param])


@pytest.fixture(scope="module")
def responses(result):
    return next(figure for figure in figures(result) if figure.name == "responses")


def test_its_panel_is_marked_and_says_the_error(result, responses):
    fitted, recorded = responses.panels
    assert "not fitted" not in fitted.title and recorded.title.startswith("Volumetric strain, not fitted, error ") and recorded.title.endswith(" %")
    assert "recorded, not fitted" in [mark.name for mark in responses.key] and "the calibration did not see it" in responses.caption
    (points,) = (mark for mark in recorded.marks if mark.name == "recorded, not fitted")
    assert points.y == pytest.approx(100 * soil.respond(soil.TRUTH)["volumetric_strain"])
    answer = result.answer.theta if result.has_posterior else result.most_probable.theta
    lines = [mark.y for mark in recorded.marks if isinstance(mark, Line) and ("answer" in mark.name or "most probable" in mark.name)]
    expected = 100 * respond(answer)["volumetric_strain"]
    assert len(lines) == (3 if result.has_posterior else 1)
    for y in lines:
        # Runs at the answer are some millionths of the ranges apart.
        np.testing.assert_allclose(y, expected, atol=1e-3)


def test_its_band_is_of_runs(result, responses):
    (band,) = (mark for mark in responses.panels[1].marks if isinstance(mark, Band))
    assert np.isfinite(band.low).all() and np.all(band.low <= band.high)
    if not result.has_posterior:
        assert band.name == "90 % of the weight"
        return
    assert band.name == "range of the runs that fit about as well"
    likely = Emulated.of(result).likely
    assert len(likely) == result.fits_about_as_well.count and set(result.answer.samples) <= set(likely)
    curves = np.array([result.response(int(id)).values["volumetric_strain"] for id in likely])
    whole = 100 * curves[np.isfinite(curves).all(axis=1)]
    np.testing.assert_allclose([band.low, band.high], [whole.min(axis=0), whole.max(axis=0)])


def test_both_renderers_draw_it(responses):
    drawn = with_matplotlib.draw(responses)
    assert "recorded, not fitted" in [text.get_text() for text in drawn.legends[0].get_texts()]
    assert "recorded, not fitted" in [trace["name"] for trace in with_plotly.describe(responses.panels[1])["data"]]


def test_the_page_and_the_terminal_say_it_in_a_line(result, tmp_path):
    of = "runs at the answer" if result.has_posterior else "most probable sample"
    said = f"Recorded and not fitted, with the error of the {of} (Eq. 5): volumetric strain"
    (line,) = (line for line in summarise(result).splitlines() if "not fitted" in line)
    assert line.startswith(said)
    page = read(write_report(result, tmp_path / "report.html"))
    text = " ".join(page.text)
    assert said in text and "Not fitted" in text and "not fitted: volumetric strain" in tables.of_experiments(result).rows[0][2]
