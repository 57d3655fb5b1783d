"""YADE as a model: its curves against the engine's, and scripts of the user's with what they are told."""

import os
from pathlib import Path

import numpy as np
import pytest
from physics.curves import OBSERVABLES, error, mean_curve, replicate_floor, sample_error

from graincal import Failure, InputError, Packing, Response, Samples, TriaxialTest, demo
from graincal.models import YadeModel
from graincal.models.output import Column, Output
from graincal.models.rests import REST_EVERY, strains_at_rest
from graincal.models.yade.model import PARAMETERS, script, triaxial

from .pairs_elsewhere import needs_yade

PACKING = Path(demo.__file__).with_name("packing_500.csv")
STRAINS = strains_at_rest(np.array([0.0, 0.02]), REST_EVERY)
SCALINGS = (999, 1000, 1001)
CASES = {"middle": (8.72, 0.227, 28.1, 0.079, 0.569), "stiff": (10.0, 0.3, 20.0, 0.02, 0.2), "soft": (7.6, 0.2, 45.0, 0.3, 0.6)}
OUTPUT = Output({"axial_strain": Column("eps"), "stress_ratio": Column("ratio")}, "curve.txt")

BATCH_SCRIPT = """
readParamsFromTable(E=1.0, phi=2.0, noTableOk=True)
from yade.params import table
with open("curve.txt", "w") as file:
    file.write("eps ratio\\n")
    for eps in (0.0, 0.1):
        file.write(f"{eps} {table.E + table.phi + 1000 * runningInBatch()!r}\\n")
"""
ARGUMENTS_SCRIPT = """
import sys
with open("curve.txt", "w") as file:
    file.write("eps ratio\\n")
    for eps in (0.0, 0.1):
        file.write(f"{eps} {float(sys.argv[-1])!r}\\n")
"""


def samples(*theta, names=PARAMETERS):
    return Samples(np.arange(len(theta)), np.array(theta), names)


def evaluated(model, samples, at, workers=1):
    """The outcomes in the samples' order."""
    found = dict(model.evaluate(samples, at, workers))
    return [found[row] for row in range(len(samples))]


@needs_yade
@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_curves_agree_with_the_engines_to_two_percent_of_strain(case):
    """Within twice what runs of YADE differ by whose densities are 0.1 % apart: means of three, of which the two programs' would differ by 0.6 of it if they drew from one population."""
    sample = samples(CASES[case])
    yades = [evaluated(triaxial(PACKING, 0.5e6, scaling), sample, STRAINS)[0] for scaling in SCALINGS]
    assert all(isinstance(each, Response) for each in yades), yades
    ours = [TriaxialTest(Packing.read(PACKING), 0.5e6, density_scaling=scaling).simulate([CASES[case]], at=STRAINS)[0] for scaling in SCALINGS]
    yades, ours = [each.values for each in yades], [each.values for each in ours]
    yade, our = mean_curve(yades), mean_curve(ours)
    found = {name: round(error(yade, our, name), 3) for name in OBSERVABLES}
    assert sample_error(yade, our) <= 2 * replicate_floor(yades), (found, replicate_floor(yades))


@needs_yade
def test_hertz_mindlin_runs_too():
    model = triaxial(PACKING, 0.5e6, 1000, law="hertz-mindlin")
    ((outcome),) = evaluated(model, samples((9.0, 0.2, 45.0), names=("log_E", "nu", "phi")), np.array([0.0, 0.003]))
    our = TriaxialTest(Packing.read(PACKING), 0.5e6, density_scaling=1000, law="hertz-mindlin", fixed={"beta_m": 0, "eta_m": 0}).simulate(
        [(9.0, 0.2, 45.0)], at=np.array([0.0, 0.003])
    )[0]
    assert outcome.values["stress_ratio"] == pytest.approx(our.values["stress_ratio"], rel=0.01)


@needs_yade
def test_a_script_reads_its_table_as_in_a_batch(tmp_path):
    (tmp_path / "test.py").write_text(BATCH_SCRIPT)
    model = script("test.py", OUTPUT, table=["E", "phi"], derived={"E": "10**log_E"}, folder=tmp_path)
    found = evaluated(model, samples((2.0, 0.1 + 0.2), (3.0, 5.0), names=("log_E", "phi")), np.array([0.0, 0.05]))
    # Every digit arrives.
    assert [each.values["stress_ratio"][0] for each in found] == [100 + (0.1 + 0.2) + 1000, 1000 + 5.0 + 1000]


@needs_yade
def test_a_script_takes_arguments(tmp_path):
    (tmp_path / "test.py").write_text(ARGUMENTS_SCRIPT)
    model = script("test.py", OUTPUT, arguments=["{{ a }}"], folder=tmp_path)
    assert evaluated(model, samples((0.1 + 0.2,), names=("a",)), np.array([0.0, 0.05]))[0].values["stress_ratio"][0] == 0.1 + 0.2


@needs_yade
def test_a_script_that_ends_badly_is_a_failure(tmp_path):
    (tmp_path / "test.py").write_text("raise RuntimeError('no equilibrium')")
    model = script("test.py", OUTPUT, arguments=["{{ a }}"], folder=tmp_path)
    ((outcome),) = evaluated(model, samples((1.0,), names=("a",)), np.array([0.0, 0.05]))
    assert isinstance(outcome, Failure) and outcome.kind == "exit_code"


@needs_yade
def test_a_test_that_comes_to_no_end_is_a_failure():
    model = triaxial(PACKING, 0.5e6, 1000)
    model = YadeModel(**vars(model) | {"command": (*model.command, "--step-limit", "1500")})
    ((outcome),) = evaluated(model, samples(CASES["middle"]), STRAINS)
    assert isinstance(outcome, Failure) and outcome.kind == "exit_code" and "The test is not at its end after 2000 steps" in outcome.reason


def test_it_is_described_and_restored():
    model = triaxial(PACKING, 0.5e6, 1000, fixed={"nu": 0.2})
    again = YadeModel.restored(model.described())
    assert {key: value for key, value in vars(again).items() if key != "folder"} == {
        key: value for key, value in vars(model).items() if key != "folder"
    } and again.folder == Path(os.getcwd())
    given = [each.given(samples((8.0, 20.0, 0.1, 0.2), names=("log_E", "phi", "beta_m", "eta_m")), [0.0, 0.01])[0].command for each in (model, again)]
    assert given[0] == given[1] and "-p=nu=0.2" in given[0] and "-p=log_E=8.0" in given[0]
    # It rests where the engine's test rests, as far as the reference goes.
    assert given[0][-2:] == ("--strains", "0.0,0.0005,0.001,0.002,0.003,0.004,0.008,0.012")


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (lambda: triaxial(PACKING, 1e5, 1, fixed={"young": 1.0}), "fixed: young is not among the test's parameters"),
        (lambda: triaxial(PACKING, 1e5, 1, fixed={"phi": 95.0}), "fixed.phi must be a number at least 0 and below 90, not 95.0"),
        (lambda: triaxial(PACKING, 1e5, 1, law="hertz-mindlin", fixed={"eta_m": 0.5}), "fixed.eta_m must be 0 or left out"),
        (lambda: triaxial(PACKING, 1e5, 1).tasks(samples((1.0,), names=("log_E",)), STRAINS), "nu, which is no parameter"),
        (lambda: triaxial(PACKING, 1e5, 1).tasks(samples((1.0,) * 6, names=(*PARAMETERS, "friction")), STRAINS), "and friction is not one of them"),
        (lambda: script("test.py", OUTPUT), "test.py is told no parameters"),
        (lambda: script("nowhere.py", OUTPUT, table=["E"]).tasks(samples((1.0,), names=("E",)), STRAINS), "script names nowhere.py, and there is no "),
        (lambda: script("test.py", OUTPUT, table=["E"], folder=PACKING.parent), None),
    ],
)
def test_what_cannot_be_is_said(made, said):
    if said is None:
        assert made().environment == {}
        return
    with pytest.raises(InputError) as raised:
        made()
    assert said in str(raised.value)
