"""The commands, as a user or another program calls them."""

import csv
import json
import resource
import shutil
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import numpy as np
import pytest

import graincal as gc
from graincal import demo
from graincal.campaign.file.config import read_calibration
from graincal.campaign.found.status import status
from graincal.campaign.stored.store import Store, holds_campaign
from graincal.cli import app, main
from graincal.cli.outputs import check_file
from graincal.cli.status import _lines
from graincal.execution import available_cores
from graincal.models import TESTS

from .hyperbola import STRAIN, reference, respond, write_calibration

PACKING = Path(demo.__file__).with_name("packing_500.csv")
TWO_ITERATIONS = ("max_iterations = 3", "max_iterations = 2")


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    """A folder with a calibration file and its finished campaign."""
    folder = tmp_path_factory.mktemp("calibration")
    file = write_calibration(folder, TWO_ITERATIONS)
    with pytest.raises(SystemExit) as ended:
        main(["calibrate", str(file), "-o", str(folder / "campaign"), "--quiet"])
    assert ended.value.code in (None, 0)
    return folder / "campaign"


@pytest.mark.parametrize("command", [*(command.callback.__name__ for command in app.registered_commands), *(f"simulate {kind}" for kind in TESTS)])
def test_every_command_has_help_with_an_example(call, command):
    called = call(*command.split(), "--help")
    assert called.code == 0 and f"Example:  graincal {command}" in called.out


def test_the_version_names_the_build(call):
    called = call("--version")
    assert called.code == 0 and gc.__version__ in called.out and "commit" in called.out


def test_a_calibration_says_what_it_found(call, tmp_path):
    called = call("calibrate", write_calibration(tmp_path, TWO_ITERATIONS), "-o", tmp_path / "campaign", "--workers", "2", "--seed", "4")
    assert called.code == 0 and called.err == ""
    report = tmp_path / "campaign" / "report.html"
    assert called.out.endswith(f"Report: {report}\nGo on with:\n  graincal resume {tmp_path / 'campaign'} --max-iterations 4\n") and report.exists()
    for said in ("iteration 0 (of at most 2), drained: 20 of 20 samples to evaluate", "Stopped by max_iterations", "40 evaluations", "Grade:", "dilatancy"):
        assert said in called.out
    kept = (tmp_path / "campaign" / "campaign.toml").read_text()
    assert kept.startswith("# Begun with --seed 4, instead of the seed below.\n") and kept.endswith((tmp_path / "calibration.toml").read_text())
    # What runs in processes from a file is what runs on threads from Python.
    stop = gc.Stop(s=False, gl_error_increment=False, error=False, error_increment=False, max_iterations=2)
    space = gc.ParameterSpace({"strength": (0, 1), "dilatancy": (0, 1)})
    expected = gc.calibrate(gc.PythonModel(respond), reference(), space, method="iterative-bayesian", seed=4, stop=stop)
    np.testing.assert_array_equal(gc.Result.read(tmp_path / "campaign").iterations[1].weights, expected.iterations[1].weights)


def test_quiet_is_silent(campaign, call):
    called = call("resume", campaign, "--quiet")
    assert (called.code, called.out, called.err) == (0, "", "")


def test_resume_goes_on_by_another_limit_and_says_what_was_edited(campaign, call, tmp_path):
    folder = shutil.copytree(campaign, tmp_path / "campaign")
    copy = folder / "campaign.toml"
    copy.write_text("# a remark\n" + copy.read_text())
    assert "was changed" not in call("resume", folder).out
    copy.write_text(copy.read_text().replace("max_iterations = 2", "max_iterations = 4").replace("alpha = 10", "alpha = 11"))
    edited = call("resume", folder)
    assert edited.code == 0 and "campaign.toml was changed in filter.alpha, stop.max_iterations; what the store holds is used" in " ".join(edited.out.split())

    folder = shutil.copytree(campaign, tmp_path / "unedited")
    longer = call("resume", folder, "--max-iterations", "4", "--error", "false")
    assert longer.code == 0 and "was changed" not in longer.out and "iteration 3 (of at most 4)" in longer.out and "limit of 4 iterations" in longer.out
    assert (folder / "campaign.toml").read_text().startswith("# Continued with max_iterations = 4, instead of what stands below.\n")
    assert "was changed" not in call("resume", folder).out
    assert call("resume", folder, "--max-iterations", "four").err == "--max-iterations must be a whole number or false, not four.\n"
    fewer = call("resume", folder, "--max-iterations", "3")
    assert fewer.code == 1 and "it would have ended after 3 of the 4 iterations that are begun" in fewer.err

    original = campaign.parent / "calibration.toml"
    kept = original.read_text()
    original.write_text(kept.replace("alpha = 10", "alpha = 12"))
    later = call("resume", folder)
    original.write_text(kept)
    assert "was changed in filter.alpha since this campaign was begun by it" in " ".join(later.out.split())

    whole = write_calibration(tmp_path, ("max_iterations = 3", "max_iterations = 4"))
    assert call("calibrate", whole, "-o", tmp_path / "whole", "--quiet").code == 0
    expected, found = gc.Result.read(tmp_path / "whole"), gc.Result.read(folder)
    np.testing.assert_array_equal(found.samples, expected.samples)
    np.testing.assert_array_equal(found.iterations[3].weights, expected.iterations[3].weights)


@pytest.mark.parametrize("instant", ["before", "after"])
def test_a_kill_while_other_limits_are_stored_blames_nobody(campaign, call, tmp_path, monkeypatch, instant):
    folder = shutil.copytree(campaign, tmp_path / "campaign")
    go_on = Store.go_on

    def killed(store, *arguments):
        if instant == "after":
            go_on(store, *arguments)
        raise SystemExit(137)

    with monkeypatch.context() as patched:
        patched.setattr(Store, "go_on", killed)
        assert call("resume", folder, "--max-iterations", "3").code == 137
    again = call("resume", folder, "--max-iterations", "3")
    assert again.code == 0 and "was changed" not in again.out and "limit of 3 iterations" in again.out
    assert (folder / "campaign.toml").read_text().startswith("# Continued with max_iterations = 3, instead of what stands below.\n")


def test_status_is_a_contract(campaign, call):
    found = json.loads(call("status", campaign, "--json").out)
    assert list(found) == [
        "folder", "state", "graincal", "started", "updated", "method", "seed", "parameters", "units", "experiments", "evaluations", "failures", "failure_kinds", "stopped",
        "first_look", "iteration", "iterations", "best", "most_probable", "answer", "settled", "posterior", "fits_about_as_well", "remarks", "stopped_by", "stopped_because", "next_command", "seconds", "seconds_left", "seconds_to_end",
    ]  # fmt: skip
    assert (found["state"], found["evaluations"], found["stopped_by"], found["seconds_left"]) == ("finished", 40, "max_iterations", 0.0)
    assert found["settled"] is False and found["posterior"] is None and found["fits_about_as_well"] is None and found["remarks"] == []
    assert found["iteration"] == {"index": 1, "samples": 20, "evaluated": 20, "failed": 0, "stopped": 0}
    figures = ["index", "samples", "failed", "stopped", "s", "s_per_state", "effective_sample_size", "gl_error", "error", "smallest_error", "best_error"]
    assert list(found["iterations"][0]) == figures
    # The best is that of all iterations so far, here as on the terminal and in a report.
    smallest = [iteration["smallest_error"] for iteration in found["iterations"]]
    assert [iteration["best_error"] for iteration in found["iterations"]] == [min(smallest[: k + 1]) for k in range(len(smallest))]
    assert found["iterations"][-1]["best_error"] == found["best"]["error"]
    assert list(found["best"]) == ["sample", "iteration", "error", "theta"] and list(found["best"]["theta"]) == ["strength", "dilatancy"]
    words = call("status", campaign)
    assert words.code == 0 and "finished" in words.out and "stopped by max_iterations" in words.out


def test_a_batch_that_is_evaluated_has_no_time_left(campaign):
    found = status(campaign) | {"state": "interrupted", "seconds_left": 0.0}
    assert any(line.endswith(": 20 of 20 evaluated, 0 failed") for line in _lines(found))
    assert any(line.endswith(", about 30 s left in it") for line in _lines(found | {"seconds_left": 30.0}))


def test_export_gives_every_figure(campaign, call, tmp_path):
    paths = call("export", campaign, "--to", "csv", "-o", tmp_path).out.split()
    assert [Path(path).name for path in paths] == ["samples.csv", "iterations.csv", "responses_drained.csv"]
    result = gc.Result.read(campaign)
    with open(tmp_path / "samples.csv") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["strength"]) for row in rows] == result.samples[:, 0].tolist()
    assert sum(float(row["weight"]) for row in rows) == pytest.approx(2)
    assert {row["failure"] for row in rows if row["error"] == "nan"} <= {"error: ArithmeticError: no equilibrium (soil.py, line 18)."}

    again = call("export", campaign, "--to", "csv", "-o", tmp_path)
    assert (again.code, again.err) == (1, f"{tmp_path / 'samples.csv'}: this file is there already and is not overwritten; name another folder.\n")
    own = shutil.copytree(campaign, tmp_path / "copy")
    assert [call("export", own, "--to", "csv").err for _ in range(2)] == ["", "3 of these replaced the files of an earlier export.\n"]

    blocked = call("export", campaign, "--to", "csv", "-o", tmp_path / "samples.csv" / "below")
    assert (blocked.code, blocked.err) == (1, f"{tmp_path / 'samples.csv'}: this is a file, and a folder to write to was expected.\n")
    call("export", campaign, "--to", "json", "-o", tmp_path)
    document = json.loads((tmp_path / "campaign.json").read_text())
    assert np.array(document["iterations"][1]["weights"]).shape == (11, 20)
    best = document["samples"][result.best.sample]
    assert best["theta"] == result.best.theta.tolist() and best["error"] == result.best.error
    assert best["responses"]["drained"]["void_ratio"] == result.response(result.best.sample).values["void_ratio"].tolist()


def test_check_reads_draws_and_estimates(call, tmp_path):
    called = call("check", write_calibration(tmp_path), "--plot", tmp_path / "references.png")
    assert called.code == 0 and (tmp_path / "references.png").stat().st_size > 1000
    for said in (
        "are taken as logarithmic, since the key strain does not say. With strain =",
        "parameter strength: 0 to 1",
        "11 rows, axial_strain 0 to 0.2",
        "▁▂",
        "Expect 20 evaluations an iteration",
        "at most 60 evaluations in 3 iterations",
    ):
        assert said in called.out


def test_check_and_the_report_say_what_is_left_out_beyond_until(call, tmp_path):
    # The soil gives its values at all strains of the file.
    control = ('"soil:respond"', f'"soil:respond", control = {STRAIN.tolist()}')
    file = write_calibration(tmp_path, TWO_ITERATIONS, control, ('"reference.csv"', '{ file = "reference.csv", strain = "logarithmic", until = 0.1 }'))
    said = "5 rows left out beyond until = 0.1, where axial_strain goes on to 0.2: lines 8-12."
    checked = call("check", file).out
    assert "6 rows, axial_strain 0 to 0.1\n" in checked and f"  {said}\n" in checked
    assert call("calibrate", file, "-o", tmp_path / "campaign", "--quiet").code == 0
    assert said in (tmp_path / "campaign" / "report.html").read_text()


def test_check_and_calibrate_note_what_is_seldom_meant(call, tmp_path):
    file = write_calibration(tmp_path, ("workers = 1", "workers = 4096"), TWO_ITERATIONS)
    checked = call("check", file).out
    cores = available_cores()
    assert "4096 workers are more than the" in checked and f"with 4096 workers on {cores} core{'s' * (cores > 1)}; " in checked
    assert "Note:" not in call("calibrate", file, "-o", tmp_path / "one", "--workers", "1").out

    # The soil contracts first. With its signs turned, a sample dilates from the beginning.
    rows = [line.split(",") for line in (tmp_path / "reference.csv").read_text().splitlines()]
    turned = [rows[0], *([strain, ratio, str(-float(volume))] for strain, ratio, volume in rows[1:])]
    (tmp_path / "reference.csv").write_text("\n".join(map(",".join, turned)))
    said = 'Experiment "drained": the volumetric strain says that the sample dilates first'
    checked, refused = call("check", file), call("calibrate", file, "-o", tmp_path / "two", "--workers", "1")
    assert checked.code == 2 and f"Problems: {said}" in " ".join(checked.out.split())
    assert refused.code == 1 and "go on in spite of it by --accept" in refused.err and said in refused.err and not (tmp_path / "two").exists()
    accepted = call("calibrate", file, "-o", tmp_path / "two", "--workers", "1", "--accept")
    assert accepted.code == 0 and f"Problem: {said}" in " ".join(accepted.out.split())
    assert "the sample dilates first" in (tmp_path / "two" / "log.txt").read_text()
    file.write_text(file.read_text().replace('"reference.csv"', '{ file = "reference.csv", compression = { volumetric_strain = "negative" } }'))
    assert "dilates" not in call("check", file).out


def test_init_proposes_a_file_and_overwrites_nothing(call, tmp_path):
    write_calibration(tmp_path)
    proposed = tmp_path / "proposed.toml"
    called = call("init", tmp_path / "reference.csv", "--strain", "logarithmic", "--confining-pressure", "5e5", "-o", proposed)
    assert called.code == 0 and "axial_strain: column 'axial_strain'" in called.out and "CHECK" in proposed.read_text()
    again = call("init", tmp_path / "reference.csv", "-o", proposed)
    assert again.code == 1 and again.err == f"{proposed}: this file is there already and is not overwritten; delete it, or name another by -o.\n"


def test_init_takes_a_packing_that_is_there(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_calibration(tmp_path)
    (tmp_path / "grains").mkdir()
    shutil.copy(PACKING, tmp_path / "grains" / "packing.csv")
    given = ["init", "reference.csv", "--packing", "grains/packing.csv", "-o", "grains/calibration.toml"]
    both = call(*given, "--void-ratio", "0.7")
    assert both.code == 1 and both.err == "--packing has a void ratio of its own, so --void-ratio cannot stand beside it.\n"
    missing = call(*given[:3], "grains/none.csv")
    assert missing.code == 1 and missing.err == "grains/none.csv: there is no such file, and a packing file was expected here.\n"
    called = call(*given, "--confining-pressure", "5e5", "--strain", "logarithmic")
    assert "find out which it is" not in called.out and "does not say the confining pressure" not in called.out
    assert called.code == 0 and "grains/packing.csv: 500 particles at a void ratio of 0.68" in called.out
    # What it wrote is what calibrate takes, wherever it stands.
    (experiment,) = read_calibration(Path("grains/calibration.toml")).experiments
    assert experiment.model.packing.count == 500 and experiment.model.confining_pressure == 5e5
    assert call("init", "reference.csv", "--void-ratio", "0.71", "--particles", "200", "-o", "other.toml").code == 0
    assert (
        tomllib.loads(Path("other.toml").read_text())["experiment"][0]["model"]["void_ratio"] == 0.71
        and "# Before shearing: as you gave it" in Path("other.toml").read_text()
    )


def test_a_triaxial_test_is_simulated_and_calibrated(call, tmp_path):
    given = ["simulate", "triaxial", "--packing", PACKING, "--confining-pressure", "0.5e6"]
    truth = [part for value in ("log_E=7.5", "nu=0.2", "phi=30", "beta_m=0.1", "eta_m=0.5") for part in ("-p", value)]
    called = call(*given, *truth, "--axial-strain", "0.01", "--increment", "0.004", "-o", tmp_path / "reference.csv", "--plot", tmp_path / "curve.png")
    assert called.code == 0 and called.out == "" and called.err.startswith("4 rows")
    curve = np.genfromtxt(tmp_path / "reference.csv", delimiter=",", names=True)
    assert curve.dtype.names[:4] == ("axial_strain", "volumetric_strain", "stress_ratio", "void_ratio")
    np.testing.assert_allclose(curve["axial_strain"], [0, 0.004, 0.008, 0.01], atol=1e-6)
    assert (tmp_path / "curve.png").exists()
    assert call(*given, *truth, "--precision", "float64", "--axial-strain", "0.01", "--increment", "0.004", "-o", tmp_path / "single.csv").code == 0
    single = np.genfromtxt(tmp_path / "single.csv", delimiter=",", names=True)
    # So short and soft a test is hardly chaotic: another rounding makes another curve, and much the same one.
    assert np.any(single["stress_ratio"] != curve["stress_ratio"])
    np.testing.assert_allclose(single["stress_ratio"], curve["stress_ratio"], rtol=0.01)
    beside = call(*given, *truth, "--at", tmp_path / "reference.csv", "--plot", tmp_path / "beside.png").err
    assert "together 0.00 %" in beside and "The reference: axial_strain and volumetric_strain are taken as logarithmic" in beside
    clash = call(*given, *truth, "--at", tmp_path / "reference.csv", "-o", tmp_path / "reference.csv")
    assert (
        clash.code == 1 and clash.err == f"{tmp_path / 'reference.csv'}: this file is there already and is not overwritten; delete it, or name another by -o.\n"
    )

    file = tmp_path / "triaxial.toml"
    model = f'{{ kind = "triaxial", packing = "{PACKING}", confining_pressure = 0.5e6, fixed = {{ nu = 0.2, beta_m = 0.1, eta_m = 0.5 }} }}'
    file.write_text(
        "[parameters]\nlog_E = { range = [7, 8] }\nphi = { range = [20, 40] }\n"
        '[[experiment]]\nname = "tiny"\nreference = "reference.csv"\nobservables = { stress_ratio = {}, volumetric_strain = {} }\n'
        f"model = {model}\n[filter]\nmethod = 'iterative-bayesian'\nalpha = 3\n[stop]\nmax_iterations = 1\n"
    )
    again = tmp_path / "again.csv"
    called = call(*given, *truth, "--at", file, "-o", again)
    assert "together 0.00 %" in called.err and called.err.endswith(f"\nWritten to {again}.\n")
    assert "only the rows" not in called.err
    set_there = tmp_path / "set.toml"
    set_there.write_text(file.read_text().replace('kind = "triaxial"', 'kind = "triaxial", rest_every = 0.01, accuracy = "reference"'))
    noted = call(*given, *truth, "--at", set_there, "--rest-every", "0.01", "-o", tmp_path / "noted.csv").err
    assert noted.startswith(f"Note: only the rows are taken from {set_there}. For the settings of its model add --accuracy reference.\n")
    other = call(*given[:-1], "2e5", *truth, "--at", file)
    assert other.code == 1 and other.err == f'{file}: one experiment at the confining pressure of 200000 Pa was expected, and there is "tiny" at 500000 Pa.\n'
    checked = call("check", file)
    assert checked.code == 0 and "500 particles" in checked.out and "Expect 6 evaluations an iteration" in checked.out
    assert "precision" not in checked.out
    single = tmp_path / "single.toml"
    single.write_text(file.read_text().replace('kind = "triaxial",', 'kind = "triaxial", precision = "float64",'))
    assert "  inertial number 0.00136, precision float64\n" in call("check", single).out
    assert call("calibrate", file, "-o", tmp_path / "campaign").code == 0
    result = gc.Result.read(tmp_path / "campaign")
    assert result.failures == 0 and result.best.error < 40
    assert result.experiments[0].model.packing.count == 500 and np.all(result.seconds > 0)
    assert "coordination_number" in result.response(0).values


SOFT = f"--packing {PACKING} -p log_E=7.5 -p nu=0.2 -p phi=30 -p beta_m=0.1 -p eta_m=0.5".split()


@pytest.mark.parametrize(
    ("path", "control", "values"),
    [
        ("triaxial --confining-pressure 2e5 --axial-strain -0.01 --increment 0.004", "axial_strain", [0, -0.004, -0.008, -0.01]),
        ("constant-mean-stress --confining-pressure 2e5 --axial-strain 0.01 --increment 0.005", "axial_strain", [0, 0.005, 0.01]),
        ("undrained --confining-pressure 2e5 --axial-strain -0.01 --increment 0.005", "axial_strain", [0, -0.005, -0.01]),
        ("oedometric --confining-pressure 2e4 --axial-strain 0.01 --increment 0.005", "axial_strain", [0, 0.005, 0.01]),
        ("oedometric --confining-pressure 2e4 --axial-stress 1e5 --axial-stress 2e5 --axial-stress 1e5", "axial_stress", [1e5, 2e5, 1e5]),
        ("isotropic --confining-pressure 1e5 --pressure 2e5 --pressure 1e5", "mean_stress", [2e5, 1e5]),
        ("table --confining-pressure 1e5 --table path.csv", "stage", [1, 3]),
    ],
)
def test_each_path_is_simulated(call, tmp_path, monkeypatch, path, control, values):
    monkeypatch.chdir(tmp_path)
    Path("path.csv").write_text("strain_x,stress_y,strain_z,record\n0,1e5,0.001,\n0,2e5,0.001,no\n0,1e5,0.002,yes\n")
    called = call("simulate", *path.split(), *SOFT, "-o", "curve.csv", "--plot", "curve.png")
    assert called.code == 0 and called.out == "" and called.err.startswith(f"{len(values)} rows from ") and Path("curve.png").exists()
    curve = np.genfromtxt("curve.csv", delimiter=",", names=True)
    assert curve.dtype.names[0] == control and {"stress_ratio", "void_ratio", "coordination_number"} < set(curve.dtype.names)
    # Strains to 1e-6 and stresses to a thousandth, as the servo's tolerances are.
    np.testing.assert_allclose(curve[control], values, rtol=1e-3 if control.endswith("stress") else 0, atol=1e-6)


def test_another_path_is_calibrated_resumed_and_reported(call, tmp_path):
    given = ["simulate", "oedometric", "--confining-pressure", "5e4", "--axial-stress", "1e5", "--axial-stress", "2e5"]
    assert call(*given, *SOFT, "-o", tmp_path / "reference.csv", "--quiet").code == 0
    text = (tmp_path / "reference.csv").read_text()
    (tmp_path / "reference.csv").write_text(text.replace("axial_stress", "axial_stress [Pa]", 1))
    file = tmp_path / "oedometric.toml"
    file.write_text(
        "[parameters]\nlog_E = { range = [7, 8] }\nphi = { range = [20, 40] }\n"
        '[[experiment]]\nname = "tiny"\nreference = "reference.csv"\ncontrol = "axial_stress"\nobservables = { void_ratio = {} }\n'
        f'model = {{ kind = "oedometric", packing = "{PACKING}", confining_pressure = 5e4, fixed = {{ nu = 0.2, beta_m = 0.1, eta_m = 0.5 }} }}\n'
        "[filter]\nmethod = 'iterative-bayesian'\nalpha = 3\n[stop]\nmax_iterations = 1\n"
    )
    checked = call("check", file)
    assert checked.code == 0 and "oedometric test at 50000 Pa, 500 particles" in checked.out and "Expect 6 evaluations an iteration" in checked.out
    assert call("calibrate", file, "-o", tmp_path / "campaign").code == 0
    assert call("resume", tmp_path / "campaign").code == 0
    result = gc.Result.read(tmp_path / "campaign")
    assert result.failures == 0 and result.experiments[0].model.control == "axial_stress"
    report = (tmp_path / "campaign" / "report.html").read_text()
    assert "graincal simulate oedometric" in report and report.count("--axial-stress ") == 2


def test_values_that_another_unit_was_probably_meant_for_are_noted(call, tmp_path):
    given = ["simulate", "oedometric", "--axial-stress", "2e3", *SOFT]
    low = call(*given, "--confining-pressure", "200")
    assert low.code == 0 and "Note: confining_pressure is 200 Pa, and tests are made at 1000 to 1e+08 Pa; if 200 kPa is meant, write 200000.\n" in low.err
    assert "Note:" not in call(*given, "--confining-pressure", "1.5e3").err and "Note:" not in call(*given, "--confining-pressure", "200", "-q").err
    assert "axial_stress is 500 Pa" in call(*given, "--axial-stress", "500", "--confining-pressure", "1e3").err
    assert "if 0.2 MPa is meant, write 200000" in call(*given, "--confining-pressure", "0.2").err
    modulus = [
        "simulate",
        "triaxial",
        "--packing",
        PACKING,
        "--confining-pressure",
        "2e5",
        *PARAMETERS.replace("log_E=9", "log_E=5e8").replace("phi=30", "phi=0.5").split(),
    ]
    wrong = call(*modulus)
    assert "Note: phi = 0.5 is in degrees; if 0.5 rad is meant, write 28.65.\n" in wrong.err
    assert wrong.code == 1 and wrong.err.endswith(
        "log_E = 5e+08 has no meaning, it must be a number at least 0 and below 20; for a modulus of 5e+08 Pa write 8.699.\n"
    )

    call(
        "simulate", "triaxial", "--confining-pressure", "2e3", "--axial-strain", "0.002", "--increment", "0.001", *SOFT, "-o", tmp_path / "reference.csv", "-q"
    )
    file = tmp_path / "soft.toml"
    file.write_text(
        "[parameters]\nlog_E = { range = [5, 7] }\n"
        '[[experiment]]\nname = "tiny"\nreference = "reference.csv"\nobservables = { stress_ratio = {} }\n'
        f'model = {{ kind = "triaxial", packing = "{PACKING}", confining_pressure = 200, fixed = {{ phi = 30, nu = 0.2, beta_m = 0.1, eta_m = 0.5 }} }}\n'
        "[filter]\nmethod = 'iterative-bayesian'\nalpha = 3\n[stop]\nmax_iterations = 1\n"
    )
    # The test goes to 0.2 % of axial strain alone, which is a problem.
    for called in (call("check", file), call("calibrate", file, "-o", tmp_path / "campaign", "--accept")):
        said = " ".join(called.out.split())
        assert 'Experiment "tiny": confining_pressure is 200 Pa' in said
        assert "parameters.log_E = 5 to 7 is a modulus of 1e+05 to 1e+07 Pa, and 1e+06 to 1e+12 Pa is usual (6 to 12)." in said


PARAMETERS = "-p log_E=9 -p nu=0.2 -p phi=30 -p beta_m=0.1 -p eta_m=0.5"
"""Of grains so stiff that a test would take its time: what is refused is refused before anything is computed."""


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (
            f"simulate triaxial --packing {PACKING} --confining-pressure 1e5 {PARAMETERS} -o none/curve.csv",
            "none/curve.csv: this cannot be written, for there is no folder none, and one that exists was expected.",
        ),
        (
            f"simulate triaxial --packing {PACKING} --confining-pressure 1e5 {PARAMETERS} --plot none/curve.png",
            "none/curve.png: this cannot be written, for there is no folder none, and one that exists was expected.",
        ),
        (
            f"simulate triaxial --packing {PACKING} --confining-pressure 1e5 {PARAMETERS} --plot curve.pgn",
            'curve.pgn: the suffix says what a figure is written as, and .png, .pdf, .svg or another that Matplotlib writes was expected (did you mean ".png"?).',
        ),
        (
            f"simulate triaxial --packing {PACKING} --confining-pressure 1e5 {PARAMETERS} -o curve.png",
            "curve.png: this is to be a table in CSV, and a name such as curve.csv was expected; a figure is drawn by --plot.",
        ),
        (
            f"simulate triaxial --packing {PACKING} --confining-pressure 1e5 {PARAMETERS} -o {PACKING}",
            f"{PACKING}: this file is there already and is not overwritten; delete it, or name another by -o.",
        ),
        (
            f"simulate triaxial --packing {PACKING} --confining-pressure 1e5 {PARAMETERS} -o .",
            ".: this is a folder, and the name of a file to write was expected.",
        ),
        (
            "check nowhere.toml --plot references",
            "references: the suffix says what a figure is written as, and .png, .pdf, .svg or another that Matplotlib writes was expected.",
        ),
        ("simulate oedometric --packing x --confining-pressure 1e5 -p phi=1", "either --axial-strain or --axial-stress was expected, and neither is given."),
        (
            "simulate oedometric --packing x --confining-pressure 1e5 -p phi=1 --axial-strain 0.1 --axial-stress 2e5",
            "either --axial-strain or --axial-stress was expected, and both are given.",
        ),
        ("simulate table --packing x -p phi=1 --table nowhere.csv", "nowhere.csv: there is no such file, and the table of a stress path was expected here."),
        (
            f"simulate triaxial --packing {PACKING} --confining-pressure 1e5 -p logE=8 -p nu=0.2 -p phi=30 -p beta_m=0.1 -p eta_m=0.1",
            'a triaxial test needs each of log_E, nu, phi, beta_m, eta_m once, as a parameter or fixed: logE is not one of them (did you mean "log_E"?); log_E is missing.',
        ),
        ("calibrate nowhere.toml -o out", "nowhere.toml: there is no such file, and a calibration file was expected here."),
        ("resume nowhere", "nowhere: there is no campaign in this folder (no campaign.db)."),
        ("status nowhere", "nowhere: there is no campaign in this folder (no campaign.db)."),
        ("export nowhere --to csv", "nowhere: there is no campaign in this folder (no campaign.db)."),
        ("check nowhere.toml", "nowhere.toml: there is no such file, and a calibration file was expected here."),
        ("init nowhere.csv", "nowhere.csv: there is no such file, and a laboratory file was expected here."),
        (
            "simulate triaxial --packing nowhere.csv --confining-pressure 1e5 -p phi=3",
            "nowhere.csv: there is no such file, and a packing file was expected here.",
        ),
        ("simulate triaxial --packing x --confining-pressure 1e5 -p phi", "-p phi: NAME=VALUE with a number was expected, such as -p phi=28.1."),
        ("simulate triaxial --packing x --confining-pressure 1e5 -p phi=1 -p phi=2", "-p phi=2: phi is given twice."),
        (
            "simulate triaxial --packing x --confining-pressure 1e5 -p phi=1 --axial-strain 20",
            "--axial-strain and --increment must be fractions with 0 < increment <= |strain| < 1, not 20 and 0.004.",
        ),
        (
            "simulate triaxial --packing x --confining-pressure 1e5 -p phi=1 --at y.csv --increment 0.004",
            "--at gives the axial strains, so --axial-strain and --increment cannot stand beside it.",
        ),
        (
            "simulate triaxial --packing x --confining-pressure 1e5 -p phi=1 --at y.toml",
            "y.toml: there is no such file, and a calibration file was expected here.",
        ),
    ],
)
def test_a_mistake_is_one_sentence_and_the_code_1(call, tmp_path, monkeypatch, arguments, said):
    monkeypatch.chdir(tmp_path)
    called = call(*arguments.split())
    assert (called.code, called.err, called.out) == (1, f"{said}\n", "")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_with_a_campaign_is_refused_with_the_way_on(call, campaign):
    file = campaign.parent / "calibration.toml"
    same = call("calibrate", file, "-o", campaign)
    assert same.code == 1 and same.err.endswith(f"go on with it by: graincal resume {campaign}\n")
    other = call("calibrate", file, "-o", campaign, "--seed", "77")
    assert other.code == 1 and other.err == f"{campaign}: this folder holds another campaign, and a new one needs a folder of its own.\n"


SLOW = """
import time
from soil import respond as soil

def respond(theta):
    time.sleep({seconds})
    return soil(theta)
"""


def start(folder, seconds, *arguments, **options):
    """A process that calibrates with a function that takes its time."""
    file = write_calibration(folder, ("soil:respond", "slow:respond"), TWO_ITERATIONS)
    (folder / "slow.py").write_text(SLOW.format(seconds=seconds))
    command = [sys.executable, "-c", "from graincal.cli import main; main()", "calibrate", file, "-o", folder / "campaign", *arguments]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)


def test_ctrl_c_stores_and_says_how_to_go_on(campaign, call, tmp_path):
    process = start(tmp_path, 0.3)
    folder = tmp_path / "campaign"
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline and not (holds_campaign(folder) and (found := status(folder))["seconds_to_end"]):
        time.sleep(0.1)
    # By this method nothing is known of how most campaigns go.
    assert found["state"] == "running" and found["evaluations"] and found["seconds_to_end"]["as_most_go"] is None
    assert found["seconds_to_end"]["at_most"] > 0 and any(", to the end at most about " in line for line in _lines(found))
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=30)
    assert process.returncode == 130 and "Stopped by" not in out
    assert err == f"Stopped. All that was finished is stored; go on with:\n  graincal resume {folder}\n"
    found = status(folder)
    assert found["state"] == "interrupted" and 0 < found["evaluations"] < 20 and found["seconds_left"] > 0 and found["seconds_to_end"] is None
    assert "go on with: graincal resume" in call("status", folder).out

    (tmp_path / "slow.py").write_text("from soil import respond\n")
    assert call("resume", folder, "--workers", "2").code == 0
    whole, resumed = gc.Result.read(campaign), gc.Result.read(folder)
    np.testing.assert_array_equal(resumed.samples, whole.samples)
    np.testing.assert_array_equal(resumed.iterations[1].weights, whole.iterations[1].weights)


@pytest.mark.parametrize("size", [1_000, 40_000])
def test_a_full_disk_is_one_sentence_and_loses_nothing(campaign, call, tmp_path, size):
    # A limit on the size of files stands for a disk that is full at once, or fills up while the campaign runs.
    process = start(tmp_path, 0, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)))
    out, err = process.communicate(timeout=60)
    folder = tmp_path / "campaign"
    assert process.returncode == 1 and err.startswith(f"{folder / 'campaign.db'}: ") and err.count("\n") == 1
    if holds_campaign(folder):
        assert 0 < status(folder)["evaluations"] < 40
        again = call("resume", folder, "-q")
    else:
        again = call("calibrate", tmp_path / "calibration.toml", "-o", folder, "-q")
    assert (again.code, again.err) == (0, "")
    np.testing.assert_array_equal(gc.Result.read(folder).iterations[1].weights, gc.Result.read(campaign).iterations[1].weights)


def test_a_campaign_may_be_moved(campaign, call, tmp_path):
    moved = shutil.copytree(campaign, tmp_path / "moved")
    assert json.loads(call("status", moved, "--json").out)["best"] == json.loads(call("status", campaign, "--json").out)["best"]


def test_report_writes_its_figures_on_request(call, campaign, tmp_path):
    folder = shutil.copytree(campaign, tmp_path / "campaign")
    called = call("report", folder, "--figures", "png", "--no-prediction")
    assert called.code == 0
    written = [Path(line) for line in called.out.splitlines()]
    assert written[0] == folder / "report.html" and {path.suffix for path in written[1:]} == {".png"}
    assert all(path.stat().st_size > 0 for path in written)
    refused = call("report", folder, "--figures", "doc")
    assert refused.code == 1 and "doc" in refused.err


def test_a_calibration_in_which_everything_fails_ends_with_a_sentence(call, tmp_path):
    file = write_calibration(tmp_path, ("strength  = { range = [0, 1] }", "strength  = { range = [2, 3] }"))
    called = call("calibrate", file, "-o", tmp_path / "campaign", "--quiet")
    assert called.code == 1 and "every evaluation failed" in called.err and called.err.endswith("graincal calibrate CALIBRATION.toml -o NEW_FOLDER\n")


def test_what_is_there_is_left_as_it_is(tmp_path):
    held, empty, link = tmp_path / "held", tmp_path / "empty", tmp_path / "link"
    held.write_text("measured")
    empty.touch()
    link.symlink_to(tmp_path / "nowhere")
    before = sorted(tmp_path.iterdir())
    for path, said in (
        (held, "is not overwritten"),
        (link, "this is a link to nowhere"),
        (tmp_path, "this is a folder"),
        (tmp_path / ("long" * 100), "cannot be written"),
    ):
        with pytest.raises(gc.InputError, match=said):
            check_file(path)
    for path in (empty, tmp_path / "new", Path("/dev/null")):
        check_file(path)
    assert sorted(tmp_path.iterdir()) == before and held.read_text() == "measured" and link.is_symlink()


def test_a_report_overwrites_no_other_file(call, campaign, tmp_path):
    (tmp_path / "lab.csv").write_text("measured")
    called = call("report", campaign, "-o", tmp_path / "lab.csv")
    assert called.code == 1 and "not overwritten" in called.err and (tmp_path / "lab.csv").read_text() == "measured"


def test_an_observable_that_the_test_does_not_return_is_refused_before_anything_runs():
    porosity = gc.Reference([0.0, 0.01], {"porosity": [0.4, 0.4]})
    with pytest.raises(gc.InputError, match="porosity is not an observable of a triaxial test, which gives axial_strain, "):
        gc.calibrate(gc.TriaxialTest(gc.Packing.read(PACKING), 1e5), porosity, gc.ParameterSpace.paper())
