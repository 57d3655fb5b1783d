"""A calibration file that asks for a first look by a cheaper model: taken first, kept in the campaign's folder, and gone on with."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

import graincal as gc
from graincal.campaign import begin
from graincal.campaign.file.config import read_calibration
from graincal.campaign.found.status import status
from graincal.campaign.stored.store import LOOK
from graincal.cli import app

from .as_tasks import broken_off
from .hyperbola import write_calibration
from .test_campaign import assert_same

pytestmark = pytest.mark.usefixtures("fewer_draws")

ASKED = (
    '[filter]\nmethod = "iterative-bayesian"\nalpha = 10\n\n[stop]\nmax_iterations = 3\ns = false\ngl_error_increment = false\nerror = false\nerror_increment = false',
    '[filter]\nmethod = "posterior"\ncorrelation_length = 0.1\n\n[first_look]\nmodel = { function = "soil:weaker" }\nmax_evaluations = 20\n\n[stop]\nmax_iterations = 1',
)  # fmt: skip
CHEAPER = """

def weaker(theta):
    found = respond(theta)
    return found | {"stress_ratio": 0.9 * found["stress_ratio"]}
"""


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    folder = tmp_path_factory.mktemp("calibration")
    path = write_calibration(folder, ASKED)
    (folder / "soil.py").write_text((folder / "soil.py").read_text() + CHEAPER)
    return path


@pytest.fixture(scope="module")
def whole(file, fewer_draws):
    """The campaign, run at one go in a folder."""
    return begin(read_calibration(file), file.parent / "campaign")


def test_the_look_is_taken_first_and_its_evaluations_are_begun_with(file, whole):
    calibration = read_calibration(file)
    assert [experiment.model.function for experiment in calibration.look.experiments] == ["soil:weaker"]
    look = gc.Result.read(file.parent / "campaign" / LOOK)
    assert look.evaluations <= 20 and not look.stopped.any()
    np.testing.assert_array_equal(whole.calibration.first_look.theta, look.samples[look.complete])
    said = CliRunner().invoke(app, ["status", str(file.parent / "campaign")]).output
    assert f"began with a first look: {file.parent / 'campaign' / LOOK}, {look.evaluations} evaluations" in said
    # By two calls it is the same.
    named = gc.calibrate(
        list(calibration.experiments), space=calibration.space, method="posterior", seed=3, stop=calibration.stop, first_look=look, correlation_length=0.1
    )
    assert_same(named, whole)
    assert_same(gc.Result.read(file.parent / "campaign"), whole)


@pytest.mark.parametrize("breaks_at", [5, 23])
def test_it_is_gone_on_with_wherever_it_was_broken_off(file, whole, tmp_path, breaks_at):
    calibration = read_calibration(file)
    with broken_off(after=breaks_at - 1):
        begin(calibration, tmp_path / "campaign")
    found = status(tmp_path / "campaign")
    assert found["first_look"]["state"] == ("interrupted" if breaks_at == 5 else "finished")
    json.dumps(found)
    lines = CliRunner().invoke(app, ["status", str(tmp_path / "campaign")]).output
    assert ("first look, before it:" in lines) == (breaks_at == 5) and f"graincal resume {tmp_path / 'campaign'}" in lines
    with pytest.raises(gc.InputError, match="this calibration was begun here before"):
        begin(calibration, tmp_path / "campaign")
    assert_same(gc.resume(tmp_path / "campaign"), whole)


def test_check_and_the_terminal_tell_of_both(file, tmp_path):
    said = CliRunner().invoke(app, ["check", str(file)]).output
    assert "first look, by cheaper models:" in said and "model: soil:weaker" in said and "First look:" in said
    ran = CliRunner().invoke(app, ["calibrate", str(file), "-o", str(tmp_path / "campaign"), "--seed", "7"])
    assert ran.exit_code == 0, ran.output
    assert ran.output.index("Takes a first look") < ran.output.index("Begins with") < ran.output.index("Stopped after")
    assert gc.Result.read(tmp_path / "campaign" / LOOK).calibration.seed == 7


def test_a_smaller_packing_takes_the_place_of_another(tmp_path):
    lattice = np.stack(np.meshgrid(*[np.arange(6) / 6] * 3), axis=-1).reshape(-1, 3)
    packing = gc.Packing(lattice, np.full(216, 0.08), np.eye(3), "cube")
    packing.write(tmp_path / "packing.csv")
    text = (
        '[parameters]\nlog_E = { range = [7, 8] }\n[[experiment]]\nname = "drained"\nreference = "test.csv"\nobservables = { stress_ratio = {} }\n'
        '[experiment.model]\nkind = "triaxial"\npacking = "packing.csv"\nconfining_pressure = 1e5\nfixed = { nu = 0.2, phi = 30, beta_m = 0, eta_m = 0 }\n'
        '[filter]\nmethod = "posterior"\ndiscrepancy = true\n[first_look]\nmodel = { packing = "small.csv", density_scaling = 1e4 }\n'
    )
    (tmp_path / "test.csv").write_text("axial_strain,stress_ratio\n0,1\n0.01,2\n0.02,2.2\n")
    gc.Packing(lattice[:100], packing.radii[:100], packing.edges, "small").write(tmp_path / "small.csv")
    (tmp_path / "calibration.toml").write_text(text)
    calibration = read_calibration(tmp_path / "calibration.toml")
    (experiment,), (cheap,) = calibration.experiments, calibration.look.experiments
    assert (experiment.model.packing.count, experiment.model.density_scaling) == (216, None)
    assert (cheap.model.packing.count, cheap.model.density_scaling) == (100, 1e4) and cheap.reference is experiment.reference
    assert calibration.look.filter_options["discrepancy"]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('function = "soil:weaker"', 'functoin = "soil:weaker"', 'first_look.model, with experiment "drained": functoin is not a key'),
        ('method = "posterior"', 'method = "sequential-monte-carlo"', 'first_look is an option of method = "posterior"'),
        ('method = "posterior"', 'method = "posterior"\nfirst_look = "look"', "one of them was expected"),
        ("max_evaluations = 20", "max_evaluations = 4", "first_look.max_evaluations must be a whole number, at least 10, not 4"),
        ('"soil:weaker"', '"soil:nothing"', "nothing"),
    ],
)
def test_what_cannot_be_a_first_look_is_refused(file, old, new, words):
    wrong = file.with_name("wrong.toml")
    wrong.write_text(file.read_text().replace(old, new))
    with pytest.raises(gc.InputError, match=words):
        read_calibration(wrong)
