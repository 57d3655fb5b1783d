"""What is recorded in a test and not fitted: nothing that is found depends on it, and how far the answer is from it is said."""

import json

import numpy as np
import pytest

import graincal as gc
from graincal.campaign import Calibration, Experiment
from graincal.campaign.asked import tested
from graincal.campaign.asked.description import describe
from graincal.campaign.file.config import read_calibration
from graincal.campaign.file.doubts import doubts_of_reference
from graincal.campaign.found.comparison import compare
from graincal.campaign.found.export import export_csv, export_json
from graincal.campaign.found.prediction import predict
from graincal.campaign.found.runs import known_runs
from graincal.campaign.found.status import status
from graincal.campaign.stored.store import Store
from graincal.data import InputError, Response
from graincal.inference.likelihood.thinning import Thinning
from graincal.models import StressPathTest

from . import frictional
from .hyperbola import SPACE, STRAIN, TRUTH, respond, write_calibration

pytestmark = pytest.mark.usefixtures("fewer_draws")

METHODS = {
    "iterative-bayesian": {"alpha": 10, "stop": gc.Stop(s=False, gl_error_increment=False, error=False, error_increment=False, max_iterations=2)},
    "posterior": {"stop": gc.Stop(max_iterations=1)},
}
ERRORS = {"stress_ratio": 0.05}
SHARES = "{ stress_ratio = { variance_share = 0.5 }, volumetric_strain = { variance_share = 0.5 } }"


def measured(recorded=("volumetric_strain",), factor=1.0):
    """The stress ratio at the truth, and others beside it, as many times too large."""
    curves = respond(TRUTH)
    return gc.Reference(
        STRAIN, {"stress_ratio": curves["stress_ratio"]}, measurement_errors=ERRORS, recorded={name: factor * curves[name] for name in recorded}
    )


def sometimes_without(theta):
    """As `respond`, but that its volumetric strain is no number at a state where the soil dilates much."""
    curves = respond(theta)
    return curves | {"volumetric_strain": np.where((STRAIN == STRAIN[4]) & (theta[1] > 0.7), np.nan, curves["volumetric_strain"])}


def stress_alone(theta):
    return {"stress_ratio": respond(theta)["stress_ratio"]}


def calibrate(method, reference, function=sometimes_without, **options):
    return gc.calibrate(gc.PythonModel(function), reference, SPACE, method=method, seed=3, workers=1, **METHODS[method], **options)


@pytest.fixture(scope="module", params=METHODS)
def folder(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("recorded") / request.param
    calibrate(request.param, measured(), folder=folder)
    return folder


@pytest.fixture(scope="module")
def result(folder):
    return gc.Result.read(folder)


def test_nothing_that_is_found_depends_on_it(result):
    method = result.calibration.method
    for other in (calibrate(method, measured(())), calibrate(method, measured(("volumetric_strain", "void_ratio"), 7.0))):
        for name in ("samples", "errors", "observable_errors", "failed"):
            np.testing.assert_array_equal(getattr(result, name), getattr(other, name))
        np.testing.assert_array_equal(result.posterior.samples, other.posterior.samples)
        np.testing.assert_array_equal(result.posterior.weights, other.posterior.weights)
        assert [iteration.gl_error for iteration in result.iterations] == pytest.approx(
            [iteration.gl_error for iteration in other.iterations], rel=0, abs=0, nan_ok=True
        )


def test_its_errors_are_those_of_the_curves(result):
    assert result.recorded_names == (("experiment", "volumetric_strain"),) and result.recorded_errors.shape == (result.evaluations, 1)
    truth, failed = respond(TRUTH)["volumetric_strain"], 0
    for theta, error in zip(result.samples, result.recorded_errors[:, 0]):
        strength, dilatancy = theta
        if strength + dilatancy > 1.5 or dilatancy > 0.7:
            assert np.isnan(error)
            failed += strength + dilatancy > 1.5
        else:
            assert error == pytest.approx(100 * np.abs(truth - respond(theta)["volumetric_strain"]).sum() / np.abs(truth).sum(), rel=1e-12)
    # A value that is not finite is no failure.
    assert failed == result.failures and np.isnan(result.recorded_errors).sum() > failed


def test_it_is_stored_and_restored(result, folder):
    stored = Store.open(folder).calibration.experiments[0].reference
    np.testing.assert_array_equal(stored.recorded["volumetric_strain"], respond(TRUTH)["volumetric_strain"])
    assert stored.names == ("stress_ratio",)
    others = describe(calibrate(result.calibration.method, measured(())).calibration)
    assert describe(result.calibration)["experiments"][0]["reference"].keys() - others["experiments"][0]["reference"].keys() == {"recorded"}


def test_the_status_says_the_error_of_the_answer(result, folder, call):
    (said,) = status(folder)["recorded"]
    rows = np.isin(result.ids, result.answer.samples) if result.has_posterior else result.ids == result.most_probable.sample
    errors = result.recorded_errors[rows, 0]
    assert said["experiment"] == "experiment" and said["observable"] == "volumetric_strain"
    assert said["of"] == ("answer" if result.has_posterior else "most probable sample")
    assert said["errors"] == [None if np.isnan(error) else error for error in errors]
    assert said["mean"] == (None if np.isnan(errors).all() else pytest.approx(np.nanmean(errors)))
    assert "not fitted: volumetric_strain in experiment, error" in call("status", folder).out
    assert json.loads(call("status", folder, "--json").out)["recorded"] == [said]


def test_a_status_without_it_is_as_it_was(tmp_path):
    calibrate("iterative-bayesian", measured(()), folder=tmp_path / "campaign")
    assert "recorded" not in status(tmp_path / "campaign")


def test_it_is_exported(result, tmp_path):
    export_csv(result, tmp_path)
    export_json(result, tmp_path)
    head = (tmp_path / "samples.csv").read_text().splitlines()[0].split(",")
    assert head[head.index("weight") - 1] == "error of what is not fitted: experiment: volumetric_strain"
    (experiment,) = json.loads((tmp_path / "campaign.json").read_text())["experiments"]
    assert experiment["recorded"] == {"volumetric_strain": respond(TRUTH)["volumetric_strain"].tolist()} and "volumetric_strain" not in experiment["reference"]


def test_a_run_that_was_stopped_has_the_error_of_the_states_that_it_came_to():
    experiment, curves = Experiment("drained", gc.PythonModel(respond), measured()), respond(TRUTH)
    doubled = {"stress_ratio": curves["stress_ratio"], "volumetric_strain": 2 * curves["volumetric_strain"]}
    stopped = Response(STRAIN[:6], {name: values[:6] for name, values in doubled.items()}, {"stopped": 1})
    unfinished = Response(STRAIN[:6], {name: np.where(STRAIN[:6] == STRAIN[2], np.nan, values[:6]) for name, values in doubled.items()}, {"stopped": 1})
    found = experiment.recorded_errors([stopped, Response(STRAIN, doubled), unfinished])
    np.testing.assert_allclose(found[:2, 0], [100, 100], rtol=1e-12)
    assert np.isnan(found[2, 0])


def test_a_model_must_return_it():
    found = calibrate("iterative-bayesian", measured(), function=stress_alone)
    assert found.stopped_by == "failures" and "the reference needs volumetric_strain too" in found.failure_kinds()[0][1]
    test = gc.TriaxialTest(frictional.packing(), 0.5e6)
    reference = gc.Reference(STRAIN, {"stress_ratio": 1 + STRAIN}, recorded={"porosity": 1 + STRAIN})
    with pytest.raises(InputError, match="porosity is not an observable of a triaxial test"):
        gc.calibrate(test, reference, gc.ParameterSpace.paper())


def test_an_observable_that_is_not_finite_is_still_a_failure():
    infinite = calibrate("iterative-bayesian", measured(), function=lambda theta: respond(TRUTH) | {"stress_ratio": np.full(len(STRAIN), np.nan)})
    assert infinite.failures == infinite.evaluations and infinite.failure_kinds()[0][:2] == ("output", "stress_ratio is not finite at axial_strain 0.")
    assert np.isnan(infinite.recorded_errors).all()


def test_a_reference_checks_it_as_observables():
    curves = respond(TRUTH)
    stress = {"stress_ratio": curves["stress_ratio"]}
    assert dict(gc.Reference(STRAIN, stress).recorded) == {}
    for recorded, said in (
        ({"stress_ratio": curves["stress_ratio"]}, "stress_ratio is an observable, which is fitted, and cannot be recorded"),
        ({"volumetric_strain": STRAIN[1:]}, "volumetric_strain has 10 values and axial_strain 11"),
        ({"volumetric_strain": np.full(len(STRAIN), np.nan)}, "volumetric_strain is not a finite number in row 1"),
    ):
        with pytest.raises(InputError, match=said):
            gc.Reference(STRAIN, stress, recorded=recorded)
    reference = measured()
    with pytest.raises(TypeError):
        reference.recorded["void_ratio"] = STRAIN
    assert list(reference.measured) == ["stress_ratio", "volumetric_strain"]
    assert "volumetric_strain" in repr(reference) and "recorded, not fitted" in repr(reference) and "recorded, not fitted" in reference._repr_html_()


def test_a_dense_reference_is_thinned_by_its_observables_alone():
    control = np.linspace(0, 0.2, 400)
    stress = {"stress_ratio": 1 + control / (0.01 + control)}
    beside, alone = (Thinning.of(gc.Reference(control, stress, recorded=recorded)) for recorded in ({"volumetric_strain": np.sin(100 * control)}, {}))
    np.testing.assert_array_equal(beside.first, alone.first)
    assert beside.kept.names == ("stress_ratio",) and len(beside.kept.recorded["volumetric_strain"]) == len(beside.first)


def test_a_calibration_file_says_what_is_not_fitted(tmp_path):
    path = write_calibration(tmp_path, (SHARES, "{ stress_ratio = { variance_share = 0.4 }, volumetric_strain = { fitted = false } }"))
    given = read_calibration(path)
    for calibration in (given, Store.create(given).calibration):
        reference = calibration.experiments[0].reference
        assert reference.names == ("stress_ratio",) and reference.variance_shares == {"stress_ratio": 0.4}
        np.testing.assert_array_equal(reference.recorded["volumetric_strain"], respond(TRUTH)["volumetric_strain"])


@pytest.mark.parametrize(
    ("observables", "said"),
    [
        (
            "{ stress_ratio = {}, volumetric_strain = { fitted = false, variance_share = 0.5 } }",
            "volumetric_strain is not fitted, as fitted = false says, so that variance_share cannot stand beside it.",
        ),
        (
            "{ stress_ratio = {}, volumetric_strain = { fitted = false, step = 1e-4, noise = 1e-4 } }",
            "volumetric_strain is not fitted, as fitted = false says, so that step and noise cannot stand beside it.",
        ),
        (
            "{ stress_ratio = { fitted = false }, volumetric_strain = { fitted = false } }",
            "observables are all fitted = false, and at least one that is fitted was expected.",
        ),
        ("{ stress_ratio = {}, volumetric_strain = { fitted = 0 } }", "volumetric_strain.fitted must be true or false, not 0."),
    ],
)
def test_what_cannot_be_meant_of_it_is_one_sentence(tmp_path, observables, said):
    with pytest.raises(InputError) as refused:
        read_calibration(write_calibration(tmp_path, (SHARES, observables)))
    assert str(refused.value).endswith(said) and "\n" not in str(refused.value)


def test_a_file_is_calibrated_explored_and_checked_with_it(tmp_path, call):
    path = write_calibration(tmp_path, (SHARES, "{ stress_ratio = {}, volumetric_strain = { fitted = false } }"), ("max_iterations = 3", "max_iterations = 1"))
    checked = call("check", path, "--plot", tmp_path / "references.png")
    assert checked.code == 0 and (tmp_path / "references.png").exists()
    assert any("volumetric_strain" in line and line.endswith(", not fitted") for line in checked.out.splitlines())
    found = json.loads(call("check", path, "--json").out)["experiments"][0]["observables"]
    assert found["volumetric_strain"]["fitted"] is False and "fitted" not in found["stress_ratio"]
    ended = call("calibrate", path, "-o", tmp_path / "campaign")
    assert ended.code == 0 and "Recorded and not fitted, with the error of the most probable sample (Eq. 5): volumetric strain" in ended.out
    assert call("explore", path, "-o", tmp_path / "library", "--runs", 4, "--quiet").code == 0


def test_runs_of_a_library_serve_without_it(tmp_path):
    """A likelihood is of the observables alone."""
    model = gc.PythonModel(stress_alone)
    gc.explore(model, SPACE, STRAIN, folder=tmp_path / "library", observables=("stress_ratio",), runs=12, workers=1)
    known = known_runs([tmp_path / "library"], Calibration(SPACE, [Experiment("experiment", model, measured())]))
    assert len(known) == 12


def test_campaigns_with_and_without_it_are_compared(tmp_path):
    results = {name: calibrate("posterior", reference) for name, reference in {"with": measured(), "without": measured(())}.items()}
    first, second = compare(results)
    assert first.log_evidence == second.log_evidence


def test_a_prediction_is_scored_without_it(result):
    score = predict(result, gc.PythonModel(respond), STRAIN, samples=4, workers=1).against(measured())
    assert set(score.coverage) == {"stress_ratio"}


def test_a_built_in_test_is_calibrated_with_it(tmp_path, monkeypatch):
    monkeypatch.setattr(StressPathTest, "tasks", frictional.tasks)
    curves, space = frictional.curves(32.0, 0.3), gc.ParameterSpace({"phi": (10, 50), "eta_m": (0, 1)})
    test = gc.TriaxialTest(frictional.packing(), 0.5e6, fixed={"log_E": 8, "nu": 0.2, "beta_m": 0.1})
    reference = gc.Reference(frictional.STRAIN, {"stress_ratio": curves["stress_ratio"]}, recorded={"volumetric_strain": curves["volumetric_strain"]})
    options = {"seed": 1, "workers": 1, "first_batch": 8, "packing_scatter": False, "stop": gc.Stop(max_iterations=1)}
    result = gc.calibrate(test, reference, space, **options)
    assert result.recorded_errors.shape == (result.evaluations, 1) and np.isfinite(result.recorded_errors[result.complete]).all()
    assert result.knowledge.kept[0].names == ("stress_ratio",)


def test_a_wrong_sign_of_it_is_a_problem_too(tmp_path):
    contracts_first = 0.3 * STRAIN * np.exp(-STRAIN / 0.02) - 0.1 * STRAIN**2 / (0.05 + STRAIN)
    stress_ratio = {"stress_ratio": respond(TRUTH)["stress_ratio"]}
    assert (
        doubts_of_reference(tested.Tested(gc.Reference(STRAIN, stress_ratio, recorded={"volumetric_strain": contracts_first}), "triaxial", 1e5, 0.7), "drained")
        == []
    )
    reference = gc.Reference(STRAIN, stress_ratio, recorded={"volumetric_strain": -contracts_first})
    found = doubts_of_reference(tested.Tested(reference, "triaxial", 1e5, 0.7), "drained")
    assert [doubt.code for doubt in found] == ["dilates-first"]
