"""What is drawn: the figures' data against the result, and that both renderers take every figure."""

import re
from copy import copy
from dataclasses import replace

import numpy as np
import plotly.graph_objects as go
import pytest

import graincal as gc
from graincal.campaign.found.findings import telling_correlation
from graincal.data import InputError
from graincal.drawing import with_matplotlib, with_plotly
from graincal.drawing.figure import Band, Bars, Level, Line, Points, log_axis
from graincal.report import find, summarise, tables, write_figures
from graincal.report.contents import figures
from graincal.report.sampling import draw_samples
from graincal.report.stress_paths import MOST_LIKELY

from . import soil

RESULTS = ("result", "two_experiments", "without_weights", "all_failed", "running", "strange_names")


def drawn(result):
    return {figure.name: figure for figure in figures(result)}


def marks(panel, kind):
    return [mark for mark in panel.marks if isinstance(mark, kind)]


def named(panel, name):
    return next(mark for mark in panel.marks if mark.name == name)


def test_responses_stand_beside_the_reference_in_percent(result):
    stress, volume = drawn(result)["responses"].panels
    assert (stress.y.label, volume.y.label, volume.x.label) == ("stress ratio σ_{1}/σ_{3} [-]", "volumetric strain [%]", "axial strain [%]")
    assert named(volume, "reference").x == pytest.approx(100 * soil.STRAIN)
    assert named(volume, "reference").y == pytest.approx(100 * soil.reference().observables["volumetric_strain"])
    best = next(line for line in marks(stress, Line) if "best" in line.name)
    assert best.y == pytest.approx(soil.respond(result.best.theta)["stress_ratio"])


def test_the_band_holds_nine_tenths_of_the_weight(result):
    [band] = marks(drawn(result)["responses"].panels[0], Band)
    last = result.iterations[-1]
    curves = result.responses(last.index)["stress_ratio"]
    below = np.nansum(last.final_weights[:, None] * (curves < band.low), axis=0)
    above = np.nansum(last.final_weights[:, None] * (curves > band.high), axis=0)
    assert np.all(below < 0.05) and np.all(above <= 0.05 + 1e-12)


def test_several_experiments_have_their_own_panels(two_experiments):
    titles = [panel.title for panel in drawn(two_experiments)["responses"].panels]
    assert [title.split(":")[0] for title in titles] == ["stiff", "stiff", "soft", "soft"]
    assert named(drawn(two_experiments)["responses"].panels[2], "reference").y == pytest.approx(soil.reference(0.03).observables["stress_ratio"])


def test_every_sample_is_drawn_once_over_the_whole_range(result):
    panels = drawn(result)["samples"].panels
    assert len(panels) == result.space.size
    for k, panel in enumerate(panels):
        assert sorted(level.at for level in marks(panel, Level) if level.upright) == [result.space.low[k], result.space.high[k]]
        [limit] = [level.at for level in marks(panel, Level) if not level.upright]
        # The points below the line are those that the table's range of close fits is of.
        below = result.samples[result.errors <= limit, k]
        assert find(result.space, result.iterations)[k].close == (below.min(), below.max())
        shown = [points for points in marks(panel, Points) if points.name.startswith(("iteration", "failed"))]
        assert sorted(np.concatenate([points.x for points in shown])) == pytest.approx(np.sort(result.samples[:, k]))
    assert len(named(panels[0], "failed, no error known").x) == result.failures > 0


@pytest.mark.parametrize("count", [1, 8, 12, 13, 40])
def test_every_iteration_stands_in_the_key(count, result):
    iterations = tuple(replace(result.iterations[0], index=index) for index in range(count))
    longer = copy(result)
    longer.iterations = iterations
    key = [mark.name for mark in draw_samples(longer).key if mark.name.startswith("iteration")]
    ranges = [[int(number) for number in re.findall(r"\d+", name)] for name in key]
    assert [index for ends in ranges for index in range(ends[0], ends[-1] + 1)] == list(range(count))
    assert count > 12 or key == [f"iteration {index}" for index in range(count)]


def test_a_known_truth_is_drawn_and_tabled_where_it_is_known(result):
    known = copy(result)
    known.calibration = replace(result.calibration, truth={"phi": 30.0, "psi": 19.0})
    figures_of = drawn(known)
    assert [[level.at for level in marks(panel, Level) if level.name == "truth"] for panel in figures_of["samples"].panels] == [[30], [19], []]
    pairs = figures_of["posterior"]
    assert [level.at for level in marks(pairs.panels[0], Level) if level.name == "truth"] == [30]
    assert {(level.at, level.upright) for level in marks(pairs.panels[3], Level) if level.name == "truth"} == {(30, True), (19, False)}
    # It lies beyond the samples, and the axes reach it.
    assert pairs.panels[4].x.limits[1] > 19 > known.iterations[-1].samples.theta[:, 1].max()
    table = tables.of_parameters(known, find(known.space, known.iterations, known.truth))
    assert [row[table.head.index("truth")] for row in table.rows] == ["30", "19", "–"]
    assert "truth" not in tables.of_parameters(result, find(result.space, result.iterations)).head
    assert "The truth, 19 deg, lies outside the 90 % interval" in summarise(known) and "truth" not in summarise(result)
    for figure in figures_of.values():
        with_matplotlib.draw(figure)


def test_the_course_of_the_iterations(result):
    errors, s, sizes = drawn(result)["convergence"].panels
    assert named(errors, "GL error ε_{GL}").y == pytest.approx([iteration.gl_error for iteration in result.iterations])
    assert marks(s, Line)[0].y == pytest.approx([iteration.s for iteration in result.iterations])
    assert marks(sizes, Line)[0].y == pytest.approx([iteration.effective_sample_size for iteration in result.iterations])
    assert [level.at for level in marks(sizes, Level)] == [0.3]


def test_pairs_carry_weights_and_correlations(result):
    figure = drawn(result)["posterior"]
    n = result.space.size
    assert figure.square and len(figure.panels) == n * n
    correlation = result.posterior.correlation()
    assert float(figure.panels[1].cell[0].replace("−", "-")) == pytest.approx(correlation[0, 1], abs=0.005)
    for k in range(n):
        [bars] = marks(figure.panels[k * (n + 1)], Bars)
        assert bars.heights.sum() == pytest.approx(1)
    scatter = max(marks(figure.panels[n], Points), key=lambda points: len(points.x))
    assert len(scatter.x) == len(scatter.sizes) == (~result.iterations[-1].failed).sum()
    assert scatter.sizes[-1] == max(scatter.sizes)


def test_correlations_are_coloured_where_they_tell(result):
    coloured = [panel.cell for panel in drawn(result)["posterior"].panels if panel.cell and panel.cell[1] != "#ffffff"]
    telling = telling_correlation(result.posterior)
    correlations = result.posterior.correlation()[np.triu_indices(result.space.size, 1)]
    assert len(coloured) == np.sum(np.abs(correlations) >= telling) and f"coloured from {telling:.2f} on" in drawn(result)["posterior"].caption
    # 0.3 of 30 samples, nine, carry weight: none is.
    few = drawn(soil.calibrate(alpha=9, effective_sample_size=0.3))["posterior"]
    assert "none coloured: on so few samples with weight" in few.caption
    assert {panel.cell[1] for panel in few.panels if panel.cell} == {"#ffffff"}


def test_fabric_is_that_of_the_best(result):
    coordination, anisotropies = drawn(result)["fabric"].panels
    looks = [(line.style.colour, line.style.dash) for panel in (coordination, anisotropies) for line in marks(panel, Line)]
    assert len({colour for colour, _ in looks}) == len({dash for _, dash in looks}) == len(looks)
    best = soil.respond(result.best.theta)
    assert marks(coordination, Line)[0].y == pytest.approx(best["coordination_number"])
    assert [line.name for line in marks(anisotropies, Line)] == ["a_{c}"]


def test_an_undrained_test_has_its_stress_path_and_its_pore_pressure(result):
    def respond(theta):
        shear = 1e3 * theta[0] * soil.STRAIN
        return {"deviatoric_stress": shear, "mean_stress": 1e5 - shear / 3, "excess_pore_pressure": shear / 2}

    reference = gc.Reference(soil.STRAIN, {name: respond(soil.TRUTH)[name] for name in ("deviatoric_stress", "mean_stress")})
    found = gc.calibrate(gc.PythonModel(respond), reference, soil.SPACE, method="iterative-bayesian", seed=3, alpha=20, stop=soil.STOP, workers=1)
    path, pore = drawn(found)["stress_paths"].panels
    assert named(path, "measured").x == pytest.approx(1e-3 * reference.observables["mean_stress"])
    [line] = marks(pore, Line)
    assert line.y == pytest.approx(1e-3 * respond(found.best.theta)["excess_pore_pressure"]) and not marks(pore, Points)
    assert "stress_paths" not in drawn(result)


@pytest.mark.usefixtures("fewer_draws")
def test_a_stress_path_of_the_posterior_has_the_runs_that_fit_about_as_well():
    def respond(theta):
        shear = 1e3 * theta[0] * soil.STRAIN
        return {"deviatoric_stress": shear, "mean_stress": 1e5 + shear / 3 - shear / 2, "excess_pore_pressure": shear / 2}

    names = ("deviatoric_stress", "excess_pore_pressure")
    reference = gc.Reference(soil.STRAIN, {name: respond(soil.TRUTH)[name] for name in names}, measurement_errors=dict.fromkeys(names, 100.0), simulated=True)
    found = gc.calibrate(gc.PythonModel(respond), reference, soil.SPACE, seed=3, workers=1, stop=gc.Stop(max_iterations=2))
    figure = drawn(found)["stress_paths"]
    for panel, name in zip(figure.panels, names):
        lines = [line for line in marks(panel, Line) if line.name == "runs that fit about as well"]
        assert 0 < len(lines) <= MOST_LIKELY and f"the thin lines, {len(lines)} run" in figure.caption
        # Two standard deviations are 4 % of the last value at most, and the runs at the answer are among them.
        assert all(1e3 * line.y[-1] == pytest.approx(reference.observables[name][-1], rel=0.2) for line in lines)


def test_failures_are_counted_by_iteration(result):
    panel = drawn(result)["run_times"].panels[1]
    assert named(panel, "failed").heights == pytest.approx([iteration.failed.sum() for iteration in result.iterations])


def test_what_does_not_exist_is_left_out(without_weights, all_failed, strange_names):
    assert "posterior" not in drawn(without_weights) and not marks(drawn(without_weights)["responses"].panels[0], Band)
    assert set(drawn(all_failed)) == {"run_times"}
    assert "fabric" not in drawn(strange_names)


@pytest.mark.parametrize("name", RESULTS)
def test_both_renderers_take_every_figure(name, request):
    for figure in figures(request.getfixturevalue(name)):
        descriptions = [with_plotly.describe_square(figure)] if figure.square else [with_plotly.describe(panel) for panel in figure.panels]
        for description in descriptions:
            # Plotly's own schema: an unknown property or value raises.
            go.Figure(description)
        with_matplotlib.draw(figure)


def test_figures_are_written_in_the_formats_asked_for(without_weights, tmp_path):
    paths = write_figures(without_weights, tmp_path / "figures")
    assert [path.name for path in paths] == [f"{name}.{suffix}" for name in ("responses", "samples", "fabric", "run_times") for suffix in ("png", "pdf")]
    for path in paths:
        assert path.read_bytes().startswith({".png": b"\x89PNG", ".pdf": b"%PDF"}[path.suffix])


def test_another_format_is_refused(result, tmp_path):
    with pytest.raises(InputError, match='"docx" cannot be written'):
        write_figures(result, tmp_path, formats=["png", "docx"])
    assert not list(tmp_path.iterdir())


def test_a_logarithmic_axis_has_ticks_to_read():
    axis = log_axis("error", np.array([1.1, 130.0, np.nan, 0.0]))
    assert axis.log and [text for _, text in axis.ticks] == ["1", "2", "5", "10", "20", "50", "100"]
    assert not log_axis("error", np.array([3.0, 4.0])).log
    # Within a decade there are enough of them to see that it is logarithmic, and each says its own number.
    assert [text for _, text in log_axis("error", np.array([2.9, 14.0])).ticks] == ["3", "4", "5", "7", "10"]
    texts = [text for _, text in log_axis("stress", np.array([1e5, 9e5])).ticks]
    assert len(texts) == len(set(texts)) == 7
    assert not log_axis("error", np.array([0.0, np.nan])).log
    assert [text for _, text in log_axis("s", np.array([1e-9, 10.0])).ticks][:2] == ["10^{−8}", "10^{−6}"]
