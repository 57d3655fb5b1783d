"""A result as people look at it from Python: summary, table, ArviZ, figures, and what a notebook shows."""

import sys
from xml.etree import ElementTree

import matplotlib
import numpy as np
import pytest

import graincal as gc
from graincal.demo import packing

matplotlib.use("agg")

STRAIN = np.linspace(0, 0.2, 11)
SPACE = gc.ParameterSpace({"phi": (0, 60), "psi": (0, 20)}, units={"phi": "deg", "psi": "deg"})
ERRORS = {"stress_ratio": 0.02, "volumetric_strain": 1e-4}


def respond(theta):
    """A soil in two formulas; the friction moves the stress alone, and the dilatancy the volume alone."""
    phi, psi = theta
    return {"stress_ratio": 1 + 0.05 * phi * STRAIN / (0.02 + STRAIN), "volumetric_strain": 0.1 * STRAIN - 0.03 * psi * STRAIN}


MODEL = gc.PythonModel(respond)
REFERENCE = gc.Reference(STRAIN, respond([30.0, 8.0]), measurement_errors=ERRORS)


@pytest.fixture(scope="module")
def result():
    return gc.calibrate(MODEL, REFERENCE, SPACE, seed=1, workers=1, max_evaluations=40, expected_seconds=60.0)


@pytest.fixture(scope="module")
def by_iterations():
    stop = gc.Stop(s=False, gl_error_increment=False, error=False, error_increment=False, max_iterations=2)
    return gc.calibrate(MODEL, REFERENCE, SPACE, method="iterative-bayesian", seed=3, workers=1, stop=stop)


def test_the_summary_says_what_each_parameter_is_and_what_informs_it(result):
    summary = result.summary()
    phi = summary["phi"]
    assert (phi.unit, phi.range, phi.answer) == ("deg", (0.0, 60.0), result.answer.theta[0])
    assert phi.interval == tuple(result.posterior.interval(0.9)[:, 0]) and phi.interval[0] < 30 < phi.interval[1]
    assert [each.informed_by for each in summary] == ["stress ratio σ_1/σ_3", "volumetric strain"]
    head, *rows = repr(summary).splitlines()[1:]
    assert head.split("  ")[0] == "parameter" and [row.split()[0] for row in rows] == ["φ", "ψ"]
    with pytest.raises(KeyError):
        summary["other"]


def test_the_papers_method_has_a_summary_too(by_iterations):
    summary = by_iterations.summary()
    assert summary["phi"].answer == by_iterations.most_probable.theta[0] and summary["phi"].informed_by is None
    assert summary.error == by_iterations.most_probable.error


def test_a_notebook_shows_results_packings_and_responses(result):
    for each in (result, packing(), result.response(int(result.best.sample))):
        ElementTree.fromstring(each._repr_html_())
    assert "500" in packing()._repr_html_() and " mm" in packing()._repr_html_()
    assert "<svg" in result.response(int(result.best.sample))._repr_html_()


def test_no_repr_is_a_dump_of_arrays(result):
    prediction = gc.predict(result, MODEL, STRAIN, samples=3, workers=1)
    for each in (result, result.posterior, result.answer, result.best, prediction):
        assert "array(" not in repr(each) and len(repr(each)) < 200


def test_a_table_of_pandas_has_every_evaluation(result, by_iterations):
    pytest.importorskip("pandas", reason="pandas is not installed")
    table = result.to_dataframe()
    assert list(table.index) == list(result.ids) and table["phi"].tolist() == result.samples[:, 0].tolist()
    np.testing.assert_array_equal(table["error"], result.errors)
    weighted = by_iterations.to_dataframe()
    np.testing.assert_allclose(weighted.groupby("iteration")["weight"].sum(), 1)


@pytest.mark.parametrize("name", ["pandas", "arviz"])
def test_what_is_not_installed_is_said(result, monkeypatch, name):
    monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(gc.InputError, match=r"not installed: .* -m pip install '\.\[notebook\]'"):
        result.to_dataframe() if name == "pandas" else result.to_arviz()


@pytest.mark.parametrize("method", ["result", "by_iterations"])
def test_arviz_reads_it(method, request):
    arviz = pytest.importorskip("arviz", reason="ArviZ is not installed")
    found = request.getfixturevalue(method)
    tree = found.to_arviz()
    posterior = tree["posterior"]
    # Draws of equal weight have the moments of the weighted samples.
    assert abs(float(posterior["phi"].mean()) - found.posterior.mean()[0]) < 0.3 * found.posterior.std()[0]
    assert posterior["phi"].attrs["range"] == [0.0, 60.0] and posterior["phi"].attrs["unit"] == "deg"
    assert tree["posterior_predictive"]["stress_ratio"].shape[2:] == tree["observed_data"]["stress_ratio"].shape
    assert set(tree["observed_data"]["stress_ratio"].coords) == {"axial_strain"}
    assert len(arviz.summary(tree, var_names=["phi", "psi"], kind="stats")) == 2


def test_figures_are_axes_of_matplotlib(result, by_iterations):
    from matplotlib import pyplot

    for found in (result, by_iterations):
        assert (found.plot.curves().shape, found.plot.pairs().shape, found.plot.trace().shape) == ((1, 2), (2, 2), (1, 2))
    prediction = gc.predict(result, MODEL, STRAIN, samples=3, workers=1)
    first = result.plot.predict(prediction, against=REFERENCE)[0, 0]
    assert isinstance(first, matplotlib.axes.Axes) and first.get_ylabel() == r"stress ratio σ$_{\mathrm{1}}$/σ$_{\mathrm{3}}$ [-]"
    with pytest.raises(gc.InputError, match="plot.predict: there is nothing to draw"):
        result.plot.predict()
    pyplot.close("all")


def test_any_model_is_simulated_at_parameters_by_name():
    one = gc.simulate(gc.PythonModel(respond, control=STRAIN), {"phi": 30.0, "psi": 8.0}, at=STRAIN[2:5])
    np.testing.assert_allclose(one.values["stress_ratio"], respond([30.0, 8.0])["stress_ratio"][2:5])
    assert len(gc.simulate(MODEL, {"phi": [30.0, 31.0], "psi": [8.0, 9.0]}, at=STRAIN, workers=1)) == 2
    with pytest.raises(gc.InputError, match="as many values of each"):
        gc.simulate(MODEL, {"phi": [30.0, 31.0], "psi": 8.0}, at=STRAIN)


def test_results_are_compared_by_name(result):
    ranked = gc.compare({"one": result, "the same": result})
    assert {each.name for each in ranked} == {"one", "the same"}
