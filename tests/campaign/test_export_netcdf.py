"""graincal export --to netcdf: ArviZ opens what it writes."""

import sys

import numpy as np
import pytest
from report import soil

import graincal as gc


@pytest.fixture(scope="module")
def by_iterations(tmp_path_factory):
    folder = tmp_path_factory.mktemp("netcdf") / "campaign"
    soil.calibrate(folder=folder)
    return folder


@pytest.fixture(scope="module")
def of_posterior(tmp_path_factory, fewer_draws):
    """Two experiments, by the method "posterior"."""
    folder = tmp_path_factory.mktemp("netcdf") / "campaign"
    space = gc.ParameterSpace({"phi": (20, 40), "psi": (0, 20)}, units={"phi": "deg", "psi": "deg"})
    experiments = [
        gc.Experiment(name, gc.PythonModel(model), soil.reference(stiffness))
        for name, model, stiffness in (("stiff", _stiff, 0.01), ("soft / loose", _soft, 0.03))
    ]
    gc.calibrate(experiments, space=space, method="posterior", seed=3, max_evaluations=60, workers=1, folder=folder)
    return folder


def _stiff(theta):
    return soil.respond([*theta, 0.5])


def _soft(theta):
    return soil.respond([*theta, 0.5], stiffness=0.03)


def test_arviz_opens_the_posterior_of_two_experiments(of_posterior, call):
    arviz = pytest.importorskip("arviz", reason="ArviZ is not installed")
    told = call("export", of_posterior, "--to", "netcdf")
    path = of_posterior / "export" / "posterior.nc"
    assert told.code == 0 and told.out.split() == [str(path)]
    tree, result = arviz.from_netcdf(path), gc.Result.read(of_posterior)
    posterior = tree["posterior"]
    assert posterior["phi"].dims == ("chain", "draw")
    assert posterior["phi"].attrs["unit"] == "deg" and list(posterior["phi"].attrs["range"]) == [20.0, 40.0]
    assert abs(float(posterior["phi"].mean()) - result.posterior.mean()[0]) < 0.3 * result.posterior.std()[0]
    assert tree["sample_stats"]["lp"].shape == posterior["phi"].shape
    for name in ("stiff: stress_ratio", "soft _ loose: stress_ratio"):
        predicted, observed = tree["posterior_predictive"][name], tree["observed_data"][name]
        assert predicted.dims == ("chain", "draw", *observed.dims)
        np.testing.assert_array_equal(predicted[observed.dims[0]], observed[observed.dims[0]])
    assert len(arviz.summary(tree, var_names=["phi", "psi"], kind="stats")) == 2


def test_xarray_opens_that_of_the_papers_method(by_iterations, call, tmp_path):
    xarray = pytest.importorskip("xarray", reason="xarray is not installed")
    assert call("export", by_iterations, "--to", "netcdf", "-o", tmp_path / "out").code == 0
    with xarray.open_datatree(tmp_path / "out" / "posterior.nc", engine="h5netcdf") as tree:
        assert set(tree.children) == {"posterior", "prior", "sample_stats", "posterior_predictive", "observed_data"}
        np.testing.assert_allclose(tree["observed_data"]["stress_ratio"], soil.reference().observables["stress_ratio"])
        np.testing.assert_allclose(tree["observed_data"]["axial_strain"], soil.STRAIN)
        assert tree.attrs["inference_library"] == "graincal"


def test_no_file_is_overwritten_but_an_export_of_its_own(by_iterations, call, tmp_path):
    pytest.importorskip("h5netcdf", reason="h5netcdf is not installed")
    (tmp_path / "posterior.nc").write_text("mine")
    told = call("export", by_iterations, "--to", "netcdf", "-o", tmp_path)
    assert told.code == 1 and "not overwritten" in told.err
    assert (tmp_path / "posterior.nc").read_text() == "mine"


def test_what_is_not_installed_is_said(by_iterations, call, monkeypatch):
    monkeypatch.setitem(sys.modules, "h5netcdf", None)
    told = call("export", by_iterations, "--to", "netcdf")
    assert told.code == 1 and "pip install '.[netcdf]'" in told.err
