"""The test at another pressure, and the line to simulate a sample again, on the built-in model."""

import html
import re
import shlex
import shutil
from copy import copy
from dataclasses import replace
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from campaign.as_tasks import as_tasks
from typer.testing import CliRunner

import graincal as gc
from graincal.campaign.found.export_contact import contact_texts
from graincal.cli import app
from graincal.data import Failure
from graincal.interpolation import interpolate
from graincal.report import prediction as predicting
from graincal.report import write_report
from graincal.report.answer import as_samples
from graincal.report.command import PLACEHOLDER, pack_command, simulate_command
from graincal.report.contents import figures
from graincal.report.prediction import predict_response

PACKING = files("graincal.demo") / "packing_500.csv"
STRAIN = np.array([0.0, 0.002, 0.004])
FIXED = {"log_E": 8.0, "nu": 0.2, "beta_m": 0.1, "eta_m": 0.5}


@pytest.fixture(scope="module")
def result():
    """Four simulations, dense and soft for speed, at two pressures."""
    packing = gc.Packing.read(PACKING)
    experiments = []
    for pressure in (1e5, 5e4):
        test = gc.TriaxialTest(packing, pressure, density_scaling=1e5, fixed=FIXED, largest_flagged_share=1.0)
        reference = gc.Reference(STRAIN, {"stress_ratio": [1.0, 1.3, 1.5], "volumetric_strain": [0.0, 0.001, 0.0015]})
        experiments.append(gc.Experiment(f"{pressure:g} Pa", test, reference))
    space = gc.ParameterSpace({"phi": (20, 40)}, units={"phi": "deg"})
    return gc.calibrate(experiments, space=space, method="sequential-monte-carlo", alpha=2, effective_sample_size=0.5, workers=1)


def test_it_is_the_most_probable_sample_at_twice_the_highest_pressure(result):
    found = predict_response(result, 2.0)
    assert found.experiment.name == "100000 Pa" and found.test.confining_pressure == 2e5
    [simulated] = found.test.simulate([result.most_probable.theta], at=STRAIN, threads=1)
    # The engine gives the same bits for the same run.
    assert np.array_equal(interpolate(found.response, STRAIN).values["stress_ratio"], simulated.values["stress_ratio"])
    figure = figures(result, found)[-1]
    assert figure.name == "prediction" and "No test at this pressure was compared with it" in figure.caption
    assert figure.caption.startswith("A prediction, not a confirmation:") and figure.title.startswith("Predicted, not confirmed, at 200 kPa")
    predicted = next(mark for mark in figure.panels[1].marks if mark.name == "predicted at 200 kPa")
    assert predicted.x == pytest.approx(100 * found.response.control) and predicted.y == pytest.approx(100 * found.response.values["volumetric_strain"])


def test_it_can_be_left_out(result, tmp_path):
    assert predict_response(result, None) is None
    assert "Prediction at" not in write_report(result, tmp_path / "report.html", predict=None).read_text(encoding="utf-8")


def test_it_is_left_out_where_it_would_take_long(result, tmp_path, monkeypatch):
    monkeypatch.setattr(predicting, "LONGEST", 0.0)
    text = write_report(result, tmp_path / "report.html").read_text(encoding="utf-8")
    assert "It was not simulated: the same sample took" in text
    assert "--confining-pressure 200000" in text


def test_a_prediction_that_fails_says_why(result, monkeypatch):
    monkeypatch.setattr(gc.TriaxialTest, "tasks", as_tasks(lambda *_: Failure("diverged", "a particle ran away.")))
    found = predict_response(result, 2.0)
    assert found.response is None and found.missing == "It could not be simulated: a particle ran away."


def test_the_line_simulates_the_sample_again(result, tmp_path, monkeypatch):
    experiment = result.experiments[0]
    line = simulate_command(experiment.model, as_samples(result, result.most_probable, experiment), experiment.reference)
    words = shlex.split(line)
    monkeypatch.chdir(tmp_path)
    run = CliRunner().invoke(app, words[1:])
    assert run.exit_code == 0, run.output
    table = np.genfromtxt(tmp_path / "curve.csv", delimiter=",", names=True)
    curve = interpolate(result.response(result.most_probable.sample, 0), STRAIN).values["stress_ratio"]
    # Eight digits of theta, and the chaos of grains over so short a path.
    assert np.interp(STRAIN, table["axial_strain"], table["stress_ratio"]) == pytest.approx(curve, rel=0.02)


def test_a_packing_that_is_no_file_leaves_a_place_for_one(result):
    experiment = result.experiments[0]
    packing = experiment.model.packing
    unnamed = gc.TriaxialTest(gc.Packing(packing.positions, packing.radii, packing.edges), 1e5, fixed=FIXED)
    line = simulate_command(unnamed, as_samples(result, result.most_probable, experiment), experiment.reference)
    assert f"--packing {PLACEHOLDER} --confining-pressure 100000 -p log_E=8 -p nu=0.2 -p phi=" in line
    assert line.endswith("--axial-strain 0.004 --increment 0.002 -o curve.csv")


def _as_copied(report):
    """The text of a report, with its commands as they are copied: without what breaks them between options."""
    return re.sub("</?span>", "", report.read_text(encoding="utf-8"))


def test_the_line_of_a_calibration_file_prints_the_error_from_anywhere(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(PACKING, "packing.csv")
    Path("lab.csv").write_text("axial_strain,stress_ratio\n0,1\n0.002,1.2\n0.004,1.3\n")
    Path("calibration.toml").write_text(
        '[parameters]\nphi = { range = [20, 40] }\n[[experiment]]\nname = "tiny"\nreference = "lab.csv"\nobservables = { stress_ratio = {} }\n'
        'model = { kind = "triaxial", packing = "packing.csv", confining_pressure = 1e5, fixed = { log_E = 7.5, nu = 0.2, beta_m = 0.1, eta_m = 0.1 } }\n'
        "[filter]\nmethod = 'iterative-bayesian'\nalpha = 5\n[stop]\nmax_iterations = 1\n"
    )
    assert CliRunner().invoke(app, ["calibrate", "calibration.toml", "-o", "campaign", "-q"]).exit_code == 0
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    [line] = re.findall(r"graincal simulate [^<]*--at [^<]*", _as_copied(tmp_path / "campaign" / "report.html"))
    run = CliRunner().invoke(app, shlex.split(html.unescape(line))[1:])
    assert run.exit_code == 0 and "Error against the reference: stress_ratio" in run.output, run.output


def test_a_precision_that_is_not_the_default_is_named(result):
    experiment = result.experiments[0]
    assert "--precision" not in simulate_command(experiment.model, as_samples(result, result.most_probable, experiment), experiment.reference)
    single = replace(experiment.model, precision="float64")
    assert " --density-scaling 100000 --precision float64 " in simulate_command(
        single, as_samples(result, result.most_probable, experiment), experiment.reference
    )


def test_lines_for_other_programs_stand_line_by_line(result, tmp_path):
    text = html.unescape(write_report(result, tmp_path / "report.html", predict=None).read_text(encoding="utf-8"))
    for program, title in (("yade", "YADE"), ("lammps", "LAMMPS"), ("pfc", "PFC")):
        assert f"Lines for {title}" in text
        for lines in contact_texts(result, result.most_probable.theta, "most probable sample", program).values():
            assert lines.count("\n") > 3 and lines in text


def test_a_packing_that_was_prepared_comes_with_the_line_that_makes_it(result, tmp_path):
    model = 'model = { kind = "triaxial", particles = 500, void_ratio = 0.68, confining_pressure = 1e5, seed = 3 }'
    source = "\n".join(f'[[experiment]]\nname = "{experiment.name}"\n{model}' for experiment in result.experiments)
    line = "graincal pack --particles 500 --void-ratio 0.68 --grading toyoura --seed 3 -o packing.csv"
    assert pack_command(result.experiments[0], source) == line
    assert pack_command(result.experiments[0], source.replace("particles = 500, void_ratio = 0.68", 'packing = "mine.csv"')) is None
    assert "graincal pack" not in write_report(result, tmp_path / "none.html", predict=None).read_text(encoding="utf-8")
    prepared = copy(result)
    prepared.calibration = replace(result.calibration, source=source)
    text = _as_copied(write_report(prepared, tmp_path / "report.html", predict=None))
    # Both experiments have the same packing.
    assert text.count(line) == 1 and "The packing of 100000 Pa, 50000 Pa was prepared." in text
