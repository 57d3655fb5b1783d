"""Two tests of a soil whose dilatancy is one and whose strength differs: a campaign finds both strengths, keeps them, and says which is whose."""

import csv
import json
import os
import re

import numpy as np
import pytest

import graincal as gc
from graincal.campaign import Calibration
from graincal.campaign.asked.description import describe
from graincal.campaign.file.config import read_calibration
from graincal.campaign.found.export import export_csv, export_json
from graincal.campaign.found.status import status
from graincal.campaign.stored.store import Store
from graincal.models import StressPathTest

from . import frictional
from .hyperbola import SPACE as SHARED
from .hyperbola import STRAIN, respond, write_calibration
from .test_campaign import assert_same

pytestmark = pytest.mark.usefixtures("fewer_draws")

SPACE = gc.ParameterSpace({"strength": (0, 1), "dilatancy": (0, 1)}, per_experiment=["strength"])
NAMES = ("strength (0.5 MPa)", "strength (1 MPa)", "dilatancy")
TRUTH = np.array([0.6, 0.35, 0.4])
LIMITS = {"stress_ratio": 0.05, "volumetric_strain": 2e-4}
ITERATIVE = {"method": "iterative-bayesian", "stop": gc.Stop(s=False, gl_error_increment=False, error=False, error_increment=False, max_iterations=3)}
POSTERIOR = {"method": "posterior", "stop": gc.Stop(max_iterations=2)}


def reference(strength):
    curves = respond([strength, TRUTH[2]])
    return gc.Reference(STRAIN, {name: curves[name] for name in LIMITS}, measurement_errors=LIMITS)


def experiments(function=respond):
    return [gc.Experiment(name, gc.PythonModel(function), reference(strength)) for name, strength in (("0.5 MPa", TRUTH[0]), ("1 MPa", TRUTH[1]))]


def calibrate(function=respond, space=SPACE, **options):
    return gc.calibrate(experiments(function), space=space, **{"seed": 4, "workers": 1} | options)


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """A campaign by each method."""
    made = {name: tmp_path_factory.mktemp(name) / "campaign" for name in ("iterative", "posterior")}
    calibrate(folder=made["iterative"], truth={"strength": 0.6, "strength (1 MPa)": 0.35}, **ITERATIVE)
    calibrate(folder=made["posterior"], truth={"strength": 0.6, "strength (1 MPa)": 0.35}, **POSTERIOR)
    return made


@pytest.fixture(scope="module")
def results(folders):
    return {name: gc.Result.read(folder) for name, folder in folders.items()}


def test_both_values_are_found(results):
    assert all(result.space.names == NAMES and result.samples.shape[1] == 3 for result in results.values())
    posterior = results["posterior"].posterior
    assert np.all(np.abs(posterior.mean() - TRUTH) < 3 * posterior.std()) and np.all(posterior.std() < 0.05)
    # The references are without error: the maximum is the truth, but for the emulator.
    np.testing.assert_allclose(results["posterior"].answer.theta, TRUTH, atol=0.02)
    np.testing.assert_allclose(results["iterative"].posterior.mean(), TRUTH, atol=0.15)


def test_overlapping_batches_give_each_model_its_own_values():
    result = calibrate(ahead=1, workers=2, **POSTERIOR)
    for number in range(2):
        sample = int(np.flatnonzero(~result.failed)[0])
        expected = respond([result.samples[sample, number], result.samples[sample, 2]])
        np.testing.assert_array_equal(result.response(int(result.ids[sample]), number).values["stress_ratio"], expected["stress_ratio"])


def test_what_is_shared_is_known_better_than_from_either_alone(results):
    together = results["posterior"].posterior.std()
    for k, experiment in enumerate(experiments()):
        alone = gc.calibrate(experiment.model, experiment.reference, SPACE, seed=4, workers=1, **POSTERIOR).posterior
        # Two references of the same errors: 1 / sqrt(2) of either, and the emulators and draws are known to a tenth or so. Its own value is known as before.
        assert together[2] < 0.85 * alone.std()[1]
        assert together[k] == pytest.approx(alone.std()[0], rel=0.25)


def test_a_model_sees_its_own_values(results):
    result = results["iterative"]
    for id, theta in zip(result.ids, result.samples):
        for number, strength in enumerate(theta[:2]):
            outcome = result.response(int(id), number)
            if isinstance(outcome, gc.Response):
                np.testing.assert_array_equal(outcome.values["stress_ratio"], 1 + 3 * strength * STRAIN / (0.02 + STRAIN))


@pytest.mark.parametrize("method", ["iterative", "posterior"])
def test_a_killed_campaign_ends_as_if_it_never_was(results, method, tmp_path):
    calls, options = tmp_path / "calls", {"iterative": ITERATIVE, "posterior": POSTERIOR}[method]

    def deadly(theta):
        """The fifth and the thirtieth call kill the process: in the first experiment of the first iteration, and in a later one."""
        count = calls.stat().st_size if calls.exists() else 0
        calls.open("a").write(".")
        if count + 1 in (5, 30):
            os._exit(9)
        return respond(theta)

    models = [experiment.model for experiment in experiments(deadly)]
    for _ in range(2):
        child = os.fork()
        if child == 0:
            if (tmp_path / "campaign").exists():
                gc.resume(tmp_path / "campaign", models)
            else:
                calibrate(deadly, folder=tmp_path / "campaign", **options)
            os._exit(0)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 9
    killed = gc.resume(tmp_path / "campaign", models)
    assert_same(results[method], killed)
    np.testing.assert_array_equal(killed.posterior.samples, results[method].posterior.samples)
    np.testing.assert_array_equal(killed.posterior.weights, results[method].posterior.weights)


def test_tables_and_programs_are_told_whose_value_it_is(folders, results, tmp_path):
    assert status(folders["posterior"])["parameters"] == list(NAMES) and tuple(status(folders["posterior"])["answer"]["theta"]) == NAMES
    for name, result in results.items():
        tables = {path.name: next(csv.reader(path.open())) for path in export_csv(result, tmp_path / name)}
        assert tuple(tables["samples.csv"][2:5]) == NAMES
        assert tuple(tables.get("posterior.csv", [None, *NAMES])[1:]) == NAMES
        (path,) = export_json(result, tmp_path / name)
        parameters = json.loads(path.read_text())["parameters"]
        assert parameters["strength (1 MPa)"] == {"range": [0, 1], "unit": "", "parameter": "strength", "experiment": "1 MPa"}
        assert parameters["dilatancy"] == {"range": [0, 1], "unit": ""}
        report = result.report(tmp_path / f"{name}.html").read_text()
        assert all(label in report for label in NAMES)


def test_a_truth_is_of_one_value_or_of_all(results):
    assert results["posterior"].truth == {"strength (0.5 MPa)": 0.6, "strength (1 MPa)": 0.35}
    assert Calibration(SPACE, experiments(), truth={"strength": 0.5, "dilatancy": 0.4}).check().truth == dict(zip(NAMES, (0.5, 0.5, 0.4)))
    with pytest.raises(
        gc.InputError, match=r"truth.strength \(2 MPa\) is not a parameter .*; expected some of strength, dilatancy, strength \(0.5 MPa\), strength \(1 MPa\)"
    ):
        calibrate(truth={"strength (2 MPa)": 0.5})


def test_a_prediction_takes_the_values_of_one_experiment(results):
    result = results["posterior"]
    for experiment, number in (("1 MPa", 1), (0, 0)):
        prediction = gc.predict(result, gc.PythonModel(respond), STRAIN, samples=10, workers=1, experiment=experiment)
        expected = respond([TRUTH[number], TRUTH[2]])["stress_ratio"]
        # A standard deviation of strength is about 0.01, of which the ratio is at most three times as much.
        assert np.abs(prediction.mean("stress_ratio") - expected).max() < 0.1
        assert prediction.theta.shape == (10, 3)
    with pytest.raises(gc.InputError, match='whose value of strength is meant: experiment = one of "0.5 MPa", "1 MPa" was expected'):
        gc.predict(result, gc.PythonModel(respond), STRAIN, samples=10)
    with pytest.raises(gc.InputError, match='there is no experiment "2 MPa"; there are 0.5 MPa, 1 MPa'):
        gc.predict(result, gc.PythonModel(respond), STRAIN, samples=10, experiment="2 MPa")


def test_the_store_keeps_what_was_asked(folders):
    store = Store.open(folders["iterative"])
    assert store.description["parameters"] == [
        {"name": "strength", "range": [0, 1], "unit": "", "per_experiment": True},
        {"name": "dilatancy", "range": [0, 1], "unit": ""},
    ]
    assert store.keeps(Calibration(SPACE, experiments(), seed=4, **ITERATIVE)) and not store.keeps(Calibration(SHARED, experiments(), seed=4, **ITERATIVE))


def test_with_one_experiment_it_makes_no_difference():
    one, other = (gc.calibrate(gc.PythonModel(respond), reference(0.6), space, seed=4, workers=1, **ITERATIVE) for space in (SPACE, SHARED))
    assert_same(one, other)
    assert describe(one.calibration) == describe(other.calibration) and one.space.names == SHARED.names


SECOND = """[[experiment]]
name        = "loose"
reference   = "reference.csv"
observables = { stress_ratio = {} }
model       = { kind = "python", function = "soil:respond" }

[filter]"""


def test_a_calibration_file_says_it_by_a_key(tmp_path, call):
    own = ("strength  = { range = [0, 1] }", "strength  = { range = [0, 1], per_experiment = true }")
    path = write_calibration(tmp_path, own, ("[filter]", SECOND), ("= 3\ns", "= 1\ns"))
    assert read_calibration(path).space.names == ("strength (drained)", "strength (loose)", "dilatancy")
    for arguments in (["check", path], ["calibrate", path, "-o", tmp_path / "campaign"], ["status", tmp_path / "campaign"]):
        called = call(*arguments)
        assert called.code == 0 and "strength (loose)" in called.out
    path = write_calibration(tmp_path, (own[0], own[1].replace("true", '"yes"')))
    with pytest.raises(gc.InputError) as error:
        read_calibration(path)
    assert str(error.value) == f'{path}: parameters.strength.per_experiment must be true or false, not "yes".'
    path = write_calibration(tmp_path, own, ("[filter]", SECOND), ("dilatancy = {", '"strength (loose)" = {'))
    with pytest.raises(gc.InputError) as error:
        read_calibration(path)
    assert str(error.value) == f'{path}: parameters: two unknowns would be called "strength (loose)"; give the parameters, or the experiments, other names.'


def test_built_in_tests_are_predicted_with_the_values_of_one(tmp_path, monkeypatch, call):
    monkeypatch.setattr(StressPathTest, "tasks", frictional.tasks)
    space = gc.ParameterSpace({"phi": (10, 50), "eta_m": (0, 1)}, units={"phi": "deg"}, per_experiment=["phi"])

    def experiment(name, pressure, friction):
        test = gc.TriaxialTest(frictional.packing(), pressure, fixed={"log_E": 8, "nu": 0.2, "beta_m": 0.1})
        return gc.Experiment(name, test, gc.Reference(STRAIN, frictional.curves(friction, 0.3, STRAIN)))

    tests = [experiment("low", 1e5, 40.0), experiment("high", 5e5, 20.0)]
    result = gc.calibrate(tests, space=space, folder=tmp_path / "campaign", workers=1, **ITERATIVE)
    theta = result.most_probable.theta
    assert theta[0] > theta[1] + 10

    for number, name in enumerate(("low", "high")):
        called = call(
            "predict",
            tmp_path / "campaign",
            "--experiment",
            name,
            "--path",
            "undrained",
            "--axial-strain",
            0.1,
            "--samples",
            200,
            "-o",
            tmp_path / f"{name}.csv",
        )
        assert called.code == 0 and f'Predicts with the value of phi in "{name}".' in called.out
        predicted = np.genfromtxt(tmp_path / f"{name}.csv", delimiter=",", names=True)
        # Two hundred draws of sixty weighted samples, by their weights but for one draw each: a sixtieth of a spread of 40 degrees at most.
        assert predicted["stress_ratio_mean"][-1] == pytest.approx(1 + result.posterior.mean()[number] / 100, abs=0.01)
    few = ("predict", tmp_path / "campaign", "--path", "undrained", "--axial-strain", 0.1, "--samples", 5)
    assert "Of 5 simulations the interval is little more than the range" in call(*few).out
    quiet = call(*few, "--quiet")
    assert (quiet.code, quiet.out, quiet.err) == (0, "", "")
    report = result.report(tmp_path / "report.html").read_text()
    # The lines that simulate it again have the value of their experiment, and the prediction that of the highest pressure.
    low, high, predicted = (line for line in report.split("\n") if "graincal simulate triaxial" in line)
    np.testing.assert_allclose([float(re.search(r"phi=([\d.]+)", line)[1]) for line in (low, high, predicted)], theta[[0, 1, 1]], rtol=1e-6)
    wrong = gc.ParameterSpace({"phi": (10, 95), "eta_m": (0, 1)}, per_experiment=["phi"])
    with pytest.raises(gc.InputError, match="parameters.phi.range must hold numbers at least 0 and below 90"):
        gc.calibrate(tests, space=wrong)
