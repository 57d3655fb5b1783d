"""Parameters whose prior is uniform in the logarithm, those that are fixed, and constraints: in files, models, stores, reports, predictions, libraries."""

import csv
import json
import os

import numpy as np
import pytest

import graincal as gc
from graincal.campaign import Calibration
from graincal.campaign.asked.description import describe, restore
from graincal.campaign.file.config import read_calibration
from graincal.campaign.file.expectation import expect
from graincal.campaign.found.export import export_csv, export_json
from graincal.campaign.found.runs import known_runs
from graincal.campaign.found.status import status
from graincal.campaign.stored.store import Store
from graincal.inference.sampling.samples import middle_of
from graincal.models.contact_laws import check_ranges, check_units

from .hyperbola import STRAIN, write_calibration
from .test_campaign import assert_same

pytestmark = pytest.mark.usefixtures("fewer_draws")

SPACE = gc.ParameterSpace({"E": (1e6, 1e9), "shape": 0.02, "v0": (0, 1), "v1": (0, 1)}, {"E": "Pa"}, scale={"E": "log"}, constraints=["v0 < v1"])
TRUTH = np.array([3e7, 0.3, 0.6])
ERRORS = {"stress_ratio": 0.05, "volumetric_strain": 2e-4}
ITERATIVE = {"method": "iterative-bayesian", "stop": gc.Stop(s=False, gl_error_increment=False, error=False, error_increment=False, max_iterations=3)}
POSTERIOR = {"method": "posterior", "stop": gc.Stop(max_iterations=3)}


def respond(theta):
    """A hyperbola whose shape is fixed, of a strength that grows with the modulus from decade to decade."""
    E, shape, v0, v1 = theta
    assert shape == 0.02 and v0 < v1 and 1e6 <= E <= 1e9
    return {"stress_ratio": 1 + np.log10(E / 1e6) * STRAIN / (shape + STRAIN), "volumetric_strain": v0 * 0.1 * STRAIN - v1 * STRAIN**2}


def measured(theta=TRUTH):
    curves = respond([theta[0], 0.02, *theta[1:]])
    return gc.Reference(STRAIN, curves, measurement_errors=ERRORS)


def calibrate(function=respond, space=SPACE, **options):
    return gc.calibrate(gc.PythonModel(function), measured(), space, **{"seed": 4, "workers": 1} | options)


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """A campaign by each method."""
    made = {name: tmp_path_factory.mktemp(name) / "campaign" for name in ("iterative", "posterior")}
    calibrate(folder=made["iterative"], truth={"E": 3e7}, **ITERATIVE)
    calibrate(folder=made["posterior"], truth={"E": 3e7}, **POSTERIOR)
    return made


@pytest.fixture(scope="module")
def results(folders):
    return {name: gc.Result.read(folder) for name, folder in folders.items()}


def test_samples_are_of_the_prior_and_nothing_failed(results):
    for result in results.values():
        assert result.failures == 0 and result.space.contains(result.samples).all()
        # A third of the first samples in each of the three decades.
        first = result.samples[result.iteration == 0, 0]
        assert np.ptp(np.histogram(np.log10(first), bins=3, range=(6, 9))[0]) <= max(2, 0.2 * len(first))
    posterior = results["posterior"].posterior
    assert np.all(np.abs(posterior.mean() - TRUTH) < 3 * posterior.std())
    np.testing.assert_allclose(results["posterior"].answer.theta, TRUTH, rtol=0.1)


def test_what_was_learnt_is_told_in_the_logarithm_and_against_the_prior_that_is_left(results):
    result = results["posterior"]
    logs = np.log10(result.posterior.samples[:, 0])
    spread = np.sqrt(result.posterior.weights @ (logs - result.posterior.weights @ logs) ** 2)
    assert result.shrinkage[0] == pytest.approx(spread / (3 / np.sqrt(12)), rel=1e-6)
    # Of a triangle the standard deviation is 1/sqrt(18) along its sides.
    assert result.shrinkage[1] == pytest.approx(result.posterior.std()[1] * np.sqrt(18), rel=0.01)


@pytest.mark.parametrize("method", ["iterative", "posterior"])
def test_a_killed_campaign_ends_as_if_it_never_was(results, method, tmp_path):
    calls, options = tmp_path / "calls", {"iterative": ITERATIVE, "posterior": POSTERIOR}[method]

    def deadly(theta):
        """The fifth and the twentieth call kill the process."""
        count = calls.stat().st_size if calls.exists() else 0
        calls.open("a").write(".")
        if count + 1 in (5, 20):
            os._exit(9)
        return respond(theta)

    for _ in range(2):
        child = os.fork()
        if child == 0:
            if (tmp_path / "campaign").exists():
                gc.resume(tmp_path / "campaign", gc.PythonModel(deadly))
            else:
                calibrate(deadly, folder=tmp_path / "campaign", **options)
            os._exit(0)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 9
    killed = gc.resume(tmp_path / "campaign", gc.PythonModel(deadly))
    assert_same(results[method], killed)
    np.testing.assert_array_equal(killed.posterior.samples, results[method].posterior.samples)


def test_a_store_keeps_the_prior(folders):
    store = Store.open(folders["posterior"])
    assert store.description["constraints"] == ["v0 < v1"]
    assert store.description["parameters"][:2] == [
        {"name": "E", "range": [1e6, 1e9], "unit": "Pa", "scale": "log"},
        {"name": "shape", "fixed": 0.02, "unit": ""},
    ]
    experiments = [gc.Experiment("experiment", gc.PythonModel(respond), measured())]
    assert store.keeps(Calibration(SPACE, experiments, seed=4, **POSTERIOR))
    plain = {"E": (1e6, 1e9), "shape": 0.02, "v0": (0, 1), "v1": (0, 1)}
    for other in (gc.ParameterSpace(plain, {"E": "Pa"}, scale={"E": "log"}), gc.ParameterSpace(plain, {"E": "Pa"}, constraints=["v0 < v1"])):
        assert not store.keeps(Calibration(other, experiments, seed=4, **POSTERIOR))


def test_tables_reports_and_programs_see_plain_values_and_what_the_prior_is(folders, results, tmp_path, call):
    assert status(folders["posterior"])["answer"]["theta"]["E"] == pytest.approx(3e7, rel=0.1)
    for name, result in results.items():
        tables = {path.name: list(csv.reader(path.open())) for path in export_csv(result, tmp_path / name)}
        assert tables["samples.csv"][0][2:5] == ["E", "v0", "v1"] and 1e6 <= float(tables["samples.csv"][1][2]) <= 1e9
        (path,) = export_json(result, tmp_path / name)
        document = json.loads(path.read_text())
        assert document["parameters"]["E"] == {"range": [1e6, 1e9], "unit": "Pa", "scale": "log"} and document["parameters"]["v0"] == {
            "range": [0, 1],
            "unit": "",
        }
        assert document["fixed"] == {"shape": {"value": 0.02, "unit": ""}} and document["constraints"] == ["v0 < v1"]
        report = result.report(tmp_path / f"{name}.html").read_text()
        for sentence in (
            "Fixed: shape = 0.02.",
            "The prior of E is uniform in the logarithm.",
            "The prior is uniform where v0 &lt; v1, which is 50 % of the ranges.",
        ):
            assert sentence in report
    shown = call("report", folders["posterior"])
    assert shown.code == 0


def test_a_prediction_is_made_with_what_is_fixed(results):
    for result in results.values():
        prediction = gc.predict(result, gc.PythonModel(respond), STRAIN, samples=10, workers=1)
        assert not prediction.failures and prediction.theta.shape == (10, 3)


def test_a_library_fills_the_prior_and_serves_another_as_far_as_its_runs_are_possible_there(tmp_path):
    model = gc.PythonModel(respond)
    folder = gc.explore(model, SPACE, to=STRAIN, folder=tmp_path / "library", runs=40, workers=1)
    samples = Store.open(folder).all_samples()
    assert len(samples) == 40 and SPACE.contains(samples.theta).all()
    narrower = gc.ParameterSpace({"E": (1e7, 1e9), "shape": 0.02, "v0": (0, 1), "v1": (0, 1)}, scale={"E": "log"}, constraints=["v0 + 0.3 < v1"])
    runs = known_runs([folder], Calibration(narrower, [gc.Experiment("drained", model, measured())]))
    assert 0 < len(runs) < 40 and narrower.contains(runs.theta).all()
    assert "where v0 + 0.3 < v1 does not hold" in runs.sources[0] and "at E outside 1e+07 to 1e+09" in runs.sources[0]
    result = calibrate(runs=[folder], space=narrower, **POSTERIOR)
    assert result.failures == 0 and narrower.contains(result.samples).all()
    other = gc.ParameterSpace({"E": (1e7, 1e9), "shape": 0.03, "v0": (0, 1), "v1": (0, 1)})
    with pytest.raises(gc.InputError, match="none of its runs can be learnt from, .* at another shape than 0.03"):
        known_runs([folder], Calibration(other, [gc.Experiment("drained", model, measured())]))
    with pytest.raises(gc.InputError, match='point 2 lies where "v0 < v1" does not hold.'):
        gc.explore(model, SPACE, to=STRAIN, folder=tmp_path / "chosen", points=[[1e7, 0.1, 0.2], [1e7, 0.2, 0.1]])


def test_a_constraint_on_a_value_of_each_experiment_holds_in_each():
    space = gc.ParameterSpace({"E": (1e6, 1e9), "shape": 0.02, "v0": (0, 1), "v1": (0, 1)}, scale={"E": "log"}, per_experiment=["v0"], constraints=["v0 < v1"])
    experiments = [gc.Experiment(name, gc.PythonModel(respond), measured(theta)) for name, theta in (("loose", TRUTH), ("dense", [3e7, 0.1, 0.6]))]
    result = gc.calibrate(experiments, space=space, seed=4, workers=1, **POSTERIOR)
    assert result.space.names == ("E", "v0 (loose)", "v0 (dense)", "v1") and result.failures == 0
    np.testing.assert_allclose(result.answer.theta, [3e7, 0.3, 0.1, 0.6], rtol=0.3)
    described = describe(result.calibration)
    again = describe(restore(described))
    assert described["constraints"] == ["v0 < v1"] and all(again[key] == described[key] for key in ("parameters", "constraints"))


CONSTRAINT = '[[constraint]]\nrequire = "strength > dilatancy"\n\n[[constraint]]\nrequire = "offset + strength < 1.25"\n\n'
EDITS = (
    ("strength  = { range = [0, 1] }", 'strength  = { range = [0.01, 1], scale = "log" }\noffset = { fixed = 0.5, unit = "kPa" }'),
    ("[[experiment]]", CONSTRAINT + "[[experiment]]"),
)


def write(folder, *replacements):
    path = write_calibration(folder, *EDITS, *replacements)
    soil = folder / "soil.py"
    soil.write_text(
        soil.read_text().replace("strength, dilatancy = theta", "strength, offset, dilatancy = theta\n    assert offset == 0.5 and strength > dilatancy")
    )
    return path


def test_a_calibration_file_says_it_by_keys(tmp_path, call):
    path = write(tmp_path)
    calibration = read_calibration(path)
    space = calibration.space
    assert space.names == ("strength", "dilatancy") and space.order == ("strength", "offset", "dilatancy") and space.fixed == {"offset": 0.5}
    assert space.scales == ("log", "linear") and [each.source for each in space.constraints] == ["strength > dilatancy", "offset + strength < 1.25"]
    # The integral of s < 0.75 over ln s, as a part of ln 100.
    assert space.part == pytest.approx((0.75 - 0.01) / np.log(100), rel=0.01)
    # The middle of the ranges is excluded, and a run near it tells what a calibration costs.
    assert space.contains(middle_of(space)[None]).all() and expect(calibration)[0].failure is None
    checked = call("check", path)
    assert checked.code == 0
    for sentence in (
        "parameter strength: 0.01 to 1",
        "Fixed: offset = 0.5 kPa.",
        "The prior of strength is uniform in the logarithm.",
        "The prior is uniform where strength > dilatancy and offset + strength < 1.25, which is",
    ):
        assert sentence in checked.out
    for arguments in (["calibrate", path, "-o", tmp_path / "campaign"], ["status", tmp_path / "campaign"], ["report", tmp_path / "campaign"]):
        assert call(*arguments).code == 0
    assert gc.Result.read(tmp_path / "campaign").failures == 0


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("range = [0.01, 1], ", "", "parameters.strength.range is missing, and [low, high] with low < high was expected, or fixed = a number in its place."),
        ('scale = "log"', 'scale = "lg"', 'parameters.strength.scale must be "linear" or "log", not "lg"'),
        ("[0.01, 1]", "[0, 1]", 'parameters.strength: scale = "log" needs a range of numbers above 0, not [0.0, 1.0].'),
        ("fixed = 0.5", "fixed = true", "parameters.offset.fixed must be a number, not true."),
        ("fixed = 0.5", "fixed = inf", "parameters.offset.fixed must be a number, not Infinity."),
        (
            "fixed = 0.5",
            "fixed = 0.5, range = [0, 1]",
            "parameters.offset.range says nothing of a parameter that is fixed, and fixed without range, or range without fixed, was expected.",
        ),
        (
            "strength > dilatancy",
            "strength > dilatency",
            'constraint.require = "strength > dilatency" names dilatency, which is no parameter (did you mean "dilatancy"?)',
        ),
        (
            'offset = { fixed = 0.5, unit = "kPa" }',
            "offset = 0.5",
            "parameters.offset must be a table, { fixed = 0.5 } for a value that is known or { range = [low, high] }, not 0.5.",
        ),
        (
            "strength > dilatancy",
            "strength > 2",
            'constraint.require = "strength > 2", "offset + strength < 1.25": of 1,048,576 points that fill the ranges none is left',
        ),
        ("strength > dilatancy", "strength > 0", 'constraint.require = "strength > 0" holds all over the ranges'),
        ("strength > dilatancy", "strength", 'constraint.require = "strength" is no condition'),
        ("strength > dilatancy", "open('x') > 1", "constraint.require = \"open('x') > 1\": there is no function open"),
        ('require = "strength > dilatancy"', "require = 3", 'constraint 1: require must be a condition on the parameters, such as "v0 < v1", not 3.'),
        (
            'require = "strength > dilatancy"',
            'requires = "strength > dilatancy"',
            'constraint 1: requires is not a key that is known here (did you mean "require"?)',
        ),
    ],
)
def test_each_mistake_is_one_sentence_with_the_file_and_the_key(tmp_path, old, new, said):
    path = write(tmp_path, (old, new))
    with pytest.raises(gc.InputError) as error:
        read_calibration(path)
    assert said in str(error.value) and str(error.value).startswith(f"{path}: ") and "\n" not in str(error.value)


def test_contact_parameters_that_are_fixed_are_checked_as_others_are():
    space = gc.ParameterSpace({"phi": (10, 50), "nu": 0.2, "log_E": 1e9}, units={"log_E": "Pa"})
    with pytest.raises(
        gc.InputError,
        match="parameters.log_E.fixed must be a number at least 0 and below 20, where the contact law means something, not 1e\\+09; for a modulus of 1e\\+09 Pa write 9",
    ):
        check_ranges(space, "linear")
    with pytest.raises(gc.InputError, match='parameters.log_E.unit must be "log10 Pa" or left out, .* so write the value in that unit'):
        check_units(space, "linear")
