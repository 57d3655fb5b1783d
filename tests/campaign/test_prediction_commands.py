"""Predicting and comparing from the command line: a soil of two parameters, and the same with a friction that is wrong."""

import re
from copy import copy

import numpy as np
import pytest

import graincal as gc
from graincal.campaign.found.comparison import Contender, compare
from graincal.campaign.stored.learnt import Learnt
from graincal.cli.compare import _doubts
from graincal.cli.comparison import calibrated_against
from graincal.cli.predict import _named
from graincal.models import StressPathTest
from graincal.result import Result

from . import frictional
from .frictional import STRAIN

pytestmark = pytest.mark.usefixtures("fewer_draws")

TRUTH = (32.0, 0.3)
ERRORS = {"stress_ratio": 0.01, "volumetric_strain": 3e-4}
FIXED = {"log_E": 8, "nu": 0.2, "beta_m": 0.1}


def measured(seed):
    """A test of that soil, with errors."""
    rng = np.random.default_rng(seed)
    return {name: values + ERRORS[name] * rng.standard_normal(len(STRAIN)) for name, values in frictional.curves(*TRUTH).items()}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two campaigns, "soil" and "wrong", the test that both are calibrated against, fitted.csv, and another, held_out.csv."""
    folder = tmp_path_factory.mktemp("comparison")
    models = {"soil": {}, "wrong": {"phi": 40.0}}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(StressPathTest, "tasks", frictional.tasks)
        for name, wrong in models.items():
            space = gc.ParameterSpace(
                {key: limits for key, limits in {"phi": (10, 50), "eta_m": (0, 1)}.items() if key not in wrong}, units={} if wrong else {"phi": "deg"}
            )
            test = gc.TriaxialTest(frictional.packing(), 0.5e6, fixed=FIXED | wrong)
            reference = gc.Reference(STRAIN, measured(1), measurement_errors=ERRORS)
            gc.calibrate(
                test,
                reference,
                space,
                folder=folder / name,
                workers=1,
                stop=gc.Stop(max_iterations=3, posterior_shift=0),
                seed=1,
                first_batch=8,
                packing_scatter=False,
                discrepancy=False,
            )
    for number, file in ((1, "fitted.csv"), (2, "held_out.csv")):
        columns = {"axial_strain": STRAIN, **measured(number)}
        # As many digits as it takes to read the same numbers again.
        np.savetxt(folder / file, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="", fmt="%.17g")
    return folder


@pytest.fixture(autouse=True)
def closed_form(monkeypatch):
    monkeypatch.setattr(StressPathTest, "tasks", frictional.tasks)


def test_another_pressure_is_predicted_and_scored(call, folder, tmp_path):
    called = call(
        "predict",
        folder / "soil",
        "--confining-pressure",
        "1e6",
        "--against",
        folder / "held_out.csv",
        "-o",
        tmp_path / "band.csv",
        "--plot",
        tmp_path / "band.png",
    )
    assert called.code == 0 and "Predicted a triaxial test at 1000 kPa from 30 samples of the posterior" in called.out
    assert "calibrated against" not in called.out
    # The file says nothing of its errors, and the campaign's were stated: of twenty states of either column, eighteen are to be expected in the band.
    assert f'{folder}/held_out.csv: measurement errors are taken to be those of "experiment".' in " ".join(called.err.split())
    *shares, value = re.search(r"holds (\d+) % of stress_ratio, (\d+) % of volumetric_strain; log score (\S+) a value", called.out).groups()
    assert min(map(int, shares)) >= 70
    # Not far from that of independent errors of these deviations, which the test has and the calibration does not know to be independent.
    deviations = np.array(list(ERRORS.values()))
    assert float(value) == pytest.approx(-0.5 - np.mean(np.log(deviations * np.sqrt(2 * np.pi))), abs=0.6)
    assert (tmp_path / "band.png").stat().st_size > 0
    band = np.genfromtxt(tmp_path / "band.csv", delimiter=",", names=True)
    np.testing.assert_array_equal(band["axial_strain"], np.float64([f"{strain:.9g}" for strain in STRAIN]))
    for name, values in frictional.curves(*TRUTH).items():
        assert np.abs(band[f"{name}_mean"] - values).max() < 3 * ERRORS[name]


def test_a_path_without_a_consolidation_is_named_without_its_pressure(tmp_path):
    (tmp_path / "path.csv").write_text("stress_x,stress_y,stress_z,record\n1e5,1e5,1e5,yes\n")
    table = gc.TableTest(frictional.packing(), table=gc.StressPathTable.read(tmp_path / "path.csv"))
    assert _named(table) == table.name_with_article and _named(gc.TriaxialTest(frictional.packing(), 0.5e6)) == "a triaxial test at 500 kPa"


def test_a_test_that_was_fitted_is_not_called_predicted(call, folder):
    called = call("predict", folder / "soil", "--against", folder / "fitted.csv")
    assert called.code == 0
    assert 'The campaign was calibrated against this test ("experiment"): what follows says how it fits, not how it predicts.' in called.out


def test_a_test_that_was_fitted_is_known_by_its_beginning(folder):
    result = gc.Result.read(folder / "soil")
    for until in (0.05, 0.1):
        beginning = gc.Reference.read(folder / "fitted.csv", until=until)
        assert len(beginning.control) < len(STRAIN) and calibrated_against(result, beginning) == "experiment"
        assert calibrated_against(result, gc.Reference.read(folder / "held_out.csv", until=until)) is None


@pytest.mark.parametrize(("option", "name"), [("-o", "campaign.db"), ("-o", "lab.csv"), ("--plot", "figure.png")])
def test_a_prediction_overwrites_nothing(call, folder, tmp_path, option, name):
    target = folder / "soil" / name if name == "campaign.db" else tmp_path / name
    if not target.exists():
        target.write_text("measured")
    before = target.read_bytes()
    called = call("predict", folder / "soil", "--samples", "2", "-q", option, target)
    assert (called.code, called.err) == (1, f"{target}: this file is there already and is not overwritten; delete it, or name another by {option}.\n")
    assert target.read_bytes() == before


def test_campaigns_are_ranked_by_a_test_that_was_held_out(call, folder):
    called = call("compare", folder / "wrong", folder / "soil", "--against", folder / "held_out.csv")
    assert called.code == 0
    header, first, second, rule, unsettled = called.out.splitlines()
    assert "log score" in header and first.startswith(str(folder / "soil")) and second.startswith(str(folder / "wrong")) and "log score" in rule
    assert unsettled.startswith("Not settled yet") and unsettled.endswith(f": {folder}/soil, {folder}/wrong.")


def test_campaigns_are_not_ranked_by_a_test_that_was_fitted(call, folder):
    called = call("compare", folder / "wrong", folder / "soil", "--against", folder / "fitted.csv")
    assert called.code == 1 and called.out == ""
    said = " ".join(called.err.split())
    assert f'{folder}/fitted.csv: a test that was held out was expected, and {folder}/wrong was calibrated against this one ("experiment").' in said


def test_without_another_test_they_are_ranked_by_evidence(call, folder):
    called = call("compare", folder / "wrong", folder / "soil")
    assert called.code == 0
    _, first, second, rule, _ = called.out.splitlines()
    assert first.startswith(str(folder / "soil")) and second.startswith(str(folder / "wrong")) and rule.startswith("Ranked by log evidence")
    # The best is below nothing.
    assert len(first.split()) + 1 == len(second.split())


def test_a_prediction_by_few_simulations_says_so_in_a_comparison_too(call, folder):
    called = call("compare", folder / "wrong", folder / "soil", "--against", folder / "held_out.csv", "--samples", "5")
    assert "Of 5 simulations the interval is little more than the range" in called.out


def test_evidences_that_do_not_differ_are_said_not_to():
    # The second may be above the first; the third, of which the emulator knows little, is far below it nearly for certain, however large its deviation.
    ranked = [Contender(name, evidence, deviation, True, None) for name, evidence, deviation in (("a", 10.0, 2.0), ("b", 4.0, 1.0), ("c", -10.0, 500.0))]
    assert _doubts(ranked) == ["By evidence a is not better than b for all that is known: the difference is within what they may be off by."]


def test_an_evidence_that_is_not_known_is_not_compared(folder):
    soil = Result.read(folder / "soil")
    blind = copy(soil)
    blind.learnt = [Learnt()]
    with pytest.raises(gc.InputError, match="blind: its evidence is not known"):
        compare({"soil": soil, "blind": blind})


@pytest.mark.parametrize("command", ["predict", "compare"])
def test_workers_are_at_least_one(call, folder, command):
    given = [folder / "soil"] if command == "predict" else [folder / "soil", folder / "wrong"]
    called = call(command, *given, "--workers", "0")
    assert (called.code, called.err) == (1, '--workers must be a whole number above 0 or "all", not 0.\n')


@pytest.mark.parametrize("workers", [0, True, None, "two"])
def test_workers_of_a_prediction_are_a_number_or_all(folder, workers):
    result = Result.read(folder / "soil")
    with pytest.raises(gc.InputError, match='workers must be a whole number above 0 or "all", not '):
        gc.predict(result, result.experiments[0].model, STRAIN, workers=workers)
