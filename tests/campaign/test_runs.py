"""Runs that were made before: libraries, what calibrations learn from them, and what they refuse."""

from __future__ import annotations

import shutil

import numpy as np
import pytest

import graincal as gc
from graincal.campaign import Calibration
from graincal.campaign.asked.points import read_points
from graincal.campaign.file.config import read_calibration
from graincal.campaign.found.run_library import Library
from graincal.campaign.found.runs import known_runs
from graincal.campaign.found.status import status
from graincal.campaign.run.exploring import fill, go_on_filling
from graincal.campaign.stored.store import Store
from graincal.inference import PosteriorFilter
from graincal.inference.driving.known_runs import KnownRuns, uncovered

from . import frictional
from .as_tasks import broken_off
from .hyperbola import SPACE, STRAIN, THE_PAPERS, TRUTH, reference, respond, write_calibration
from .test_posterior_campaign import infeasible

pytestmark = pytest.mark.usefixtures("fewer_draws")

ERRORS = {"stress_ratio": 0.05, "volumetric_strain": 2e-4}
STOP = gc.Stop(max_iterations=2)


def measured(theta=TRUTH):
    return gc.Reference(STRAIN, reference(theta).observables, measurement_errors=ERRORS)


def library(folder, space=SPACE, runs=40, **options):
    return gc.explore(gc.PythonModel(infeasible), space, to=STRAIN, folder=folder, runs=runs, workers=1, **options)


def calibrate(folders, space=SPACE, theta=TRUTH, **options):
    return gc.calibrate(gc.PythonModel(infeasible), measured(theta), space, runs=folders, **{"seed": 6, "stop": STOP, "workers": 1} | options)


def test_a_library_fills_the_ranges_and_has_no_result(tmp_path):
    folder = library(tmp_path / "library")
    said = status(folder)
    assert said["evaluations"] == 40 and said["state"] == "finished" and said["answer"] is None and said["failures"] > 0
    with pytest.raises(gc.InputError, match="this is a library of runs for no reference, which has no result"):
        gc.Result.read(folder)
    with pytest.raises(gc.InputError, match="holds a library of runs, and a campaign needs a folder of its own"):
        calibrate([], folder=folder)
    with pytest.raises(gc.InputError, match="holds another library"):
        library(folder, runs=41)
    with pytest.raises(gc.InputError, match="a library needs a folder of its own"):
        library(tmp_path)


def test_a_library_that_was_broken_off_goes_on(tmp_path):
    whole = library(tmp_path / "whole")
    arguments = {"to": STRAIN, "folder": tmp_path / "library", "runs": 40, "workers": 1}
    with broken_off(after=9):
        gc.explore(gc.PythonModel(infeasible), SPACE, **arguments)
    assert status(tmp_path / "library")["state"] == "interrupted"
    gc.explore(gc.PythonModel(infeasible), SPACE, **arguments)
    one, other = (Store.open(folder) for folder in (whole, tmp_path / "library"))
    np.testing.assert_array_equal(one.all_samples().theta, other.all_samples().theta)
    assert all(
        np.array_equal(one.outcome(id, 0).values["stress_ratio"], other.outcome(id, 0).values["stress_ratio"])
        for id in range(40)
        if isinstance(one.outcome(id, 0), gc.Response)
    )


def test_a_calibration_learns_from_runs_that_are_there(tmp_path):
    folder = library(tmp_path / "library")
    result = calibrate([folder], folder=tmp_path / "campaign")
    # Two samples a parameter look where no run is near; all is known then, which fresh runs confirm; and the runs at the answer.
    assert list(np.bincount(result.iteration)) == [4, 20, 3]
    assert np.all(np.abs(result.posterior.mean() - TRUTH) < 3 * result.posterior.std()) and np.all(result.posterior.std() < 0.05)
    np.testing.assert_allclose(result.answer.theta, TRUTH, atol=0.02)
    assert "Learns from 40 runs of" in (tmp_path / "campaign" / "log.txt").read_text()
    # All is in the new folder, and another curve is as good.
    (folder / "campaign.db").unlink()
    again = gc.Result.read(tmp_path / "campaign")
    np.testing.assert_array_equal(again.posterior.samples, result.posterior.samples)
    assert again.emulation.log_likelihood(SPACE.to_unit(TRUTH[None]))[0] == result.emulation.log_likelihood(SPACE.to_unit(TRUTH[None]))[0]
    other = calibrate([tmp_path / "campaign"], theta=np.array([0.3, 0.7]))
    np.testing.assert_allclose(other.answer.theta, [0.3, 0.7], atol=0.05)


def test_a_calibration_with_known_runs_goes_on_bit_for_bit(tmp_path):
    folder = library(tmp_path / "library")
    whole = calibrate([folder])
    with broken_off(after=5):
        gc.calibrate(gc.PythonModel(infeasible), measured(), SPACE, runs=[folder], seed=6, stop=STOP, workers=1, folder=tmp_path / "campaign")
    resumed = gc.resume(tmp_path / "campaign", gc.PythonModel(infeasible))
    np.testing.assert_array_equal(resumed.samples, whole.samples)
    np.testing.assert_array_equal(resumed.posterior.weights, whole.posterior.weights)


def test_of_other_ranges_the_part_that_no_run_covers_is_filled_first(tmp_path):
    folder = library(tmp_path / "library", gc.ParameterSpace({"strength": (0, 0.5), "dilatancy": (0, 1)}))
    result = calibrate([folder], first_batch=40)
    first = result.samples[result.iteration == 0]
    assert np.mean(first[:, 0] > 0.5) > 0.9 and 12 <= len(first) <= 28
    # And runs outside of narrower ranges are left out.
    narrow = Calibration(
        gc.ParameterSpace({"strength": (0.25, 1), "dilatancy": (0, 1)}), [gc.Experiment("drained", gc.PythonModel(infeasible), measured())], "posterior"
    )
    runs = known_runs([folder], narrow)
    assert len(runs) < 40 and runs.theta[:, 0].min() >= 0.25 and "at strength outside 0.25 to 1" in runs.sources[0]


def test_where_runs_lie_far_apart_is_open():
    points = np.random.default_rng(0).random((50, 2))
    np.testing.assert_array_equal(uncovered(points, np.empty((0, 2)), 4), np.arange(50))
    assert len(uncovered(points, points + 1e-3, 4)) == 4
    left = points[points[:, 0] < 0.5]
    assert np.mean(points[uncovered(points, left, 4), 0] > 0.5) > 0.9


def test_runs_of_other_models_and_parameters_are_refused_by_name(tmp_path):
    folder = library(tmp_path / "library")
    with pytest.raises(
        gc.InputError, match=r"they differ in the function; runs of the same settings were expected. Runs of other settings can serve as a first look"
    ):
        gc.calibrate(gc.PythonModel(respond), measured(), SPACE, runs=[folder])
    with pytest.raises(gc.InputError, match="its runs have no cohesion"):
        calibrate([folder], gc.ParameterSpace({"strength": (0, 1), "cohesion": (0, 1)}))
    with pytest.raises(gc.InputError, match="none of its runs can be learnt from, 40 at strength outside 2 to 3"):
        calibrate([folder], gc.ParameterSpace({"strength": (2, 3), "dilatancy": (0, 1)}))
    with pytest.raises(gc.InputError, match='filter.runs is an option of method = "posterior"'):
        calibrate([folder], method="iterative-bayesian")
    # A library has no method.
    paper = Calibration(SPACE, [gc.Experiment("drained", gc.PythonModel(infeasible), measured())], "iterative-bayesian", {"alpha": 5})
    assert status(fill(paper, tmp_path / "of-the-paper"))["evaluations"] == 8


def test_what_is_named_twice_and_what_has_no_name_is_refused(tmp_path):
    folder = library(tmp_path / "library")
    with pytest.raises(gc.InputError, match="this folder is named twice"):
        calibrate([folder, tmp_path / "." / "library"])
    nameless = gc.explore(gc.PythonModel(lambda theta: respond(theta)), SPACE, to=STRAIN, folder=tmp_path / "nameless", runs=4, workers=1)
    with pytest.raises(gc.InputError, match="which has no name by which it could be known to be the same"):
        gc.calibrate(gc.PythonModel(lambda theta: respond(theta)), measured(), SPACE, runs=[nameless])
    (source,) = calibrate([folder]).calibration.known.sources
    assert "That its model is the same is known by its name alone" in source
    # A copy of a folder tells nothing more.
    shutil.copytree(folder, tmp_path / "copy")
    with pytest.raises(gc.InputError, match="40 known from another folder"):
        calibrate([folder, tmp_path / "copy"])


def test_places_where_runs_only_failed_are_open(tmp_path):
    def fails(theta):
        return gc.Failure("timeout", "too long.") if theta[0] > 0.5 else respond(theta)

    known = KnownRuns(*_runs(fails), infeasible=np.zeros(60, dtype=bool), missing=np.random.default_rng(0).random((60, 2))[:, 0] > 0.5)
    filter = PosteriorFilter(SPACE, measured(), known=known, first_batch=40)
    asked = filter.ask().theta
    assert np.mean(asked[:, 0] > 0.5) > 0.8 and len(asked) > 8


def _runs(function):
    theta = np.random.default_rng(0).random((60, 2))
    nothing = np.full((len(STRAIN), 2), np.nan)
    found = [function(each) for each in theta]
    return theta, (np.array([nothing if isinstance(each, gc.Failure) else np.column_stack([each[name] for name in ERRORS]) for each in found]),)


def test_what_explore_cannot_take_is_said(tmp_path):
    experiment = gc.Experiment("drained", gc.PythonModel(infeasible), measured())
    for model, to in (([experiment], 0.1), ([gc.PythonModel(infeasible)], None)):
        with pytest.raises(gc.InputError, match="explore takes one model with to"):
            gc.explore(model, SPACE, to, folder=tmp_path / "library")
    with pytest.raises(gc.InputError, match="how far runs go"):
        gc.explore(gc.PythonModel(infeasible), SPACE, folder=tmp_path / "library")
    # What a beginning that was cut short leaves is no hindrance.
    (tmp_path / "library").mkdir()
    (tmp_path / "library" / "log.txt").touch()
    assert status(library(tmp_path / "library", runs=4))["evaluations"] == 4


def test_points_of_somebodys_own_are_run_and_read_back(tmp_path):
    points = SPACE.from_unit(np.random.default_rng(2).random((5, SPACE.size)))
    arguments = {"to": STRAIN, "folder": tmp_path / "library", "workers": 1, "points": points}
    with broken_off(after=2):
        gc.explore(gc.PythonModel(infeasible), SPACE, **arguments)
    assert status(tmp_path / "library")["state"] == "interrupted"
    go_on_filling(tmp_path / "library", [gc.PythonModel(infeasible)])
    found = Library.read(gc.explore(gc.PythonModel(infeasible), SPACE, **arguments))
    np.testing.assert_array_equal(found.samples.theta, points)
    for theta, outcome in zip(points, found.outcomes[0]):
        expected = infeasible(theta)
        assert isinstance(outcome, gc.Failure) == isinstance(expected, gc.Failure)
        if isinstance(outcome, gc.Response):
            np.testing.assert_array_equal(outcome.values["stress_ratio"], expected["stress_ratio"])
    assert len(found.responses()) == sum(isinstance(outcome, gc.Response) for outcome in found.outcomes[0])
    with pytest.raises(gc.InputError, match="holds another library"):
        gc.explore(gc.PythonModel(infeasible), SPACE, **arguments | {"points": points[::-1]})
    with pytest.raises(gc.InputError, match="holds another library"):
        library(tmp_path / "library", runs=5)


def test_points_that_are_none_are_refused(tmp_path):
    points, model, to = SPACE.from_unit(np.full((2, SPACE.size), 0.5)), gc.PythonModel(infeasible), {"to": STRAIN, "folder": tmp_path / "library"}
    with pytest.raises(gc.InputError, match="runs and points are both given"):
        gc.explore(model, SPACE, **to, runs=2, points=points)
    for wrong in (points[:, 1:], "many", np.full_like(points, np.nan)):
        with pytest.raises(gc.InputError, match="points must be rows of"):
            gc.explore(model, SPACE, **to, points=wrong)
    with pytest.raises(gc.InputError, match="point 2 lies outside the ranges"):
        gc.explore(model, SPACE, **to, points=np.stack([points[0], SPACE.high + 1]))
    names = SPACE.names
    (tmp_path / "points.csv").write_text("\n".join(["# chosen", ",".join(("number", *names)), *(",".join(map(repr, (0.0, *row))) for row in points.tolist())]))
    np.testing.assert_array_equal(read_points(tmp_path / "points.csv", SPACE), points)
    (tmp_path / "points.csv").write_text(",".join(names[1:]))
    with pytest.raises(gc.InputError, match=f"points.csv: a column for {names[0]} is missing"):
        read_points(tmp_path / "points.csv", SPACE)
    (tmp_path / "points.csv").write_text(",".join(names) + "\n1,x")
    with pytest.raises(gc.InputError, match="points.csv: each row must hold a number for each of"):
        read_points(tmp_path / "points.csv", SPACE)
    with pytest.raises(gc.InputError, match="there is no such file"):
        read_points(tmp_path / "none.csv", SPACE)


TO = 0.02
UNKNOWN = gc.ParameterSpace({"log_E": (8, 9), "phi": (20, 40)}, units={"phi": "deg"})
FIXED = {"nu": 0.2, "eta_m": 0.1, "beta_m": 0.1}


def test_runs_at_one_pressure_are_runs_at_another(tmp_path):
    test = gc.TriaxialTest(frictional.packing(), 0.5e6, fixed=FIXED)
    folder = gc.explore(test, UNKNOWN, to=TO, folder=tmp_path / "library", runs=6, workers=1)
    elsewhere = gc.TriaxialTest(frictional.packing(), 0.25e6, fixed=FIXED)
    curve = gc.Reference(np.array([0.005, 0.01, 0.015]), {"stress_ratio": [1.5, 2.0, 2.2], "volumetric_strain": [0.001, 0.0, -0.001]})
    space = gc.ParameterSpace({"log_E": (8 - np.log10(2), 9 - np.log10(2)), "phi": (20, 40)})
    runs = known_runs([folder], Calibration(space, [gc.Experiment("other", elsewhere, curve)]))
    assert len(runs) == 6
    assert "Runs are taken from 500 kPa to 250 kPa, where the same curve has a log_E that differs by the logarithm of the pressures' ratio." in runs.sources[0]
    # The same to within what a last digit of the modulus does to a run.
    own = elsewhere.simulate(runs.theta[:1], curve.control, threads=1)[0]
    np.testing.assert_allclose(runs.responses[0][0], own.observables(curve.names), rtol=0.02, atol=1e-4)
    for other, difference in (
        (gc.TriaxialTest(frictional.packing(), 0.5e6, fixed=FIXED, law="hertz-mindlin"), "law"),
        (gc.TriaxialTest(frictional.packing(), 0.5e6, fixed=FIXED, inertial_number=1e-3), "inertial_number"),
        (gc.UndrainedTest(frictional.packing(), 0.5e6, fixed=FIXED), "the kind of the model"),
    ):
        with pytest.raises(gc.InputError, match=f"they differ in {difference};"):
            known_runs([folder], Calibration(UNKNOWN, [gc.Experiment("other", other, curve)]))
    # One that is fixed now must have been run at that value.
    fixed = gc.TriaxialTest(frictional.packing(), 0.5e6, fixed=FIXED | {"phi": 30.0})
    with pytest.raises(gc.InputError, match="6 at another phi than 30"):
        known_runs([folder], Calibration(gc.ParameterSpace({"log_E": (8, 9)}), [gc.Experiment("other", fixed, curve)]))
    longer = gc.Reference(np.array([0.01, 0.05]), {"stress_ratio": [1.5, 2.0], "volumetric_strain": [0.001, 0.0]})
    with pytest.raises(gc.InputError, match="6 shorter than a reference"):
        known_runs([folder], Calibration(UNKNOWN, [gc.Experiment("other", test, longer)]))


def test_a_calibration_file_names_its_runs(tmp_path):
    # A function that knows no other states than the reference's.
    path = write_calibration(
        tmp_path,
        ('function = "soil:respond"', f'function = "soil:respond", control = {STRAIN.tolist()}'),
        (THE_PAPERS, 'runs = ["library"]'),
        ("s = false\ngl_error_increment = false\nerror = false\nerror_increment = false\n", ""),
    )
    with pytest.raises(gc.InputError, match=r"filter.runs: .*library: there is no campaign in this folder"):
        read_calibration(path)
    fill(read_calibration(path, exploring=True), tmp_path / "library", 20)
    found = read_calibration(path)
    assert len(found.known) == 20 and "Learns from 20 runs" in found.known.sources[0]
    without = write_calibration(tmp_path, ('reference   = "reference.csv"\n', ""))
    with pytest.raises(gc.InputError, match=r"it has no reference, and the name of a laboratory file, or a table \[experiment.reference\], was expected"):
        read_calibration(without)
