"""Calibration files with kind = "yade": what they build, what is refused, and a first look by the engine; and the examples of YADE and LAMMPS, calibrated where the programs are."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from models.pairs_elsewhere import needs_lammps, needs_yade

import graincal as gc
from graincal import demo
from graincal.campaign.asked.description import describe_model
from graincal.campaign.file.config import read_calibration
from graincal.models import TriaxialTest, YadeModel

EXAMPLES = Path(__file__).parents[2] / "examples"

FILE = """
[parameters]
log_E = { range = [8, 9], unit = "log10 Pa" }
phi   = { range = [20, 40], unit = "deg" }

[[experiment]]
name        = "drained"
reference   = { file = "reference.csv", strain = "logarithmic" }
observables = { stress_ratio = { relative_error = 0.01 } }
model       = { MODEL }
"""
TRIAXIAL = 'kind = "yade", packing = "packing.csv", confining_pressure = 0.5e6, fixed = { nu = 0.2, beta_m = 0.1, eta_m = 0.3 }'
SCRIPT = 'kind = "yade", script = "test.py", table = ["phi"], output = { file = "curve.txt", columns = { axial_strain = "eps", stress_ratio = "ratio" } }'


@pytest.fixture
def written(tmp_path):
    """Writes a calibration file with a model, and what may follow."""
    shutil.copyfile(Path(demo.__file__).with_name("packing_500.csv"), tmp_path / "packing.csv")
    (tmp_path / "reference.csv").write_text("axial_strain,stress_ratio\n0,1\n0.004,1.8\n0.01,2.6\n")
    (tmp_path / "test.py").write_text("")

    def write(model, *, rest=""):
        (tmp_path / "calibration.toml").write_text(FILE.replace("MODEL", model) + rest)
        return tmp_path / "calibration.toml"

    return write


def test_the_papers_test_is_built_and_stored(written):
    model = read_calibration(written(TRIAXIAL + ", inertial_number = 1e-3, time_limit = 50, cores = 2")).experiments[0].model
    assert isinstance(model, YadeModel) and model.cores == 2 and model.limits.time_limit == 50 and "-j2" in model.command
    scaling = float(model.command[model.command.index("--density-scaling") + 1])
    packing = gc.Packing.read(model.folder / "packing.csv")
    assert scaling == pytest.approx(gc.TriaxialTest(packing, 0.5e6, inertial_number=1e-3).scaling)
    described = describe_model(model)
    assert described["kind"] == "yade" and YadeModel.restored(described).command == model.command


def test_a_script_is_led_to_its_table(written):
    model = read_calibration(written(SCRIPT)).experiments[0].model
    (given,) = model.given(gc.Samples(np.arange(1), np.array([[8.0, 30.0]]), ("log_E", "phi")), [0.0, 0.01])
    assert given.environment == {"YADE_BATCH": "parameters.table:2"} and given.files == {"parameters.table": "phi\n30.0\n"}
    assert given.command == ("yade", "-n", "-x", "-j1", "test.py") and set(given.links) == {"test.py"}


@pytest.mark.parametrize(
    ("model", "said"),
    [
        ('kind = "yade"', "needs packing and confining_pressure, for graincal's own triaxial test by YADE, or script and output"),
        (TRIAXIAL + ', script = "test.py"', "has both script and packing, confining_pressure, fixed, and only one was expected"),
        (TRIAXIAL + ', arguments = ["1"]', "has both packing and arguments, and only one was expected"),
        (TRIAXIAL + ', command = ["yade"]', 'has command, and with kind = "yade" either packing and confining_pressure, or script and output, were expected'),
        (TRIAXIAL + ", inertial_number = 1e-3, density_scaling = 1e3", "has both density_scaling and inertial_number"),
        (TRIAXIAL.replace("eta_m = 0.3", "eta_m = -1"), "fixed.eta_m must be a number at least 0"),
        ('kind = "yade", script = "test.py", table = ["phi"]', "has a script, and output, what the script writes, was expected too"),
        (SCRIPT.replace('"phi"', '"Phi"'), 'table names Phi (did you mean "phi"?), which is no parameter and not derived'),
        (SCRIPT + ', link = ["parameters.table"]', "parameters.table is the name of two files"),
        (SCRIPT.replace('table = ["phi"], ', ""), "test.py is told no parameters"),
    ],
)
def test_what_cannot_be_is_one_sentence(written, call, model, said):
    called = call("check", written(model))
    assert called.code == 1 and said in called.err + called.out and "Traceback" not in called.err


def test_a_range_without_meaning_is_said_before_anything_runs(written, call):
    path = written(TRIAXIAL)
    path.write_text(path.read_text().replace("[20, 40]", "[20, 95]"))
    called = call("check", path)
    assert called.code == 1 and "parameters.phi.range must hold numbers at least 0 and below 90" in called.err


def test_the_engine_may_look_first(written):
    look = read_calibration(written(TRIAXIAL + ", time_limit = 50", rest='\n[first_look]\nmodel = { kind = "triaxial" }\n')).look
    test = look.experiments[0].model
    # What both kinds know is the same.
    assert (
        isinstance(test, TriaxialTest)
        and test.confining_pressure == 0.5e6
        and dict(test.fixed) == {"nu": 0.2, "beta_m": 0.1, "eta_m": 0.3}
        and test.packing.count == 500
    )


def test_a_look_of_no_kind_is_said(written, call):
    called = call("check", written(TRIAXIAL, rest='\n[first_look]\nmodel = { kind = "triaxal" }\n'))
    assert called.code == 1 and 'first_look.model.kind is "triaxal", and one of ' in called.err


@pytest.mark.slow
@pytest.mark.parametrize("name", [pytest.param("yade_script", marks=needs_yade), pytest.param("lammps", marks=needs_lammps)])
def test_the_example_is_calibrated(name, call, tmp_path):
    folder = shutil.copytree(EXAMPLES / name, tmp_path / name)
    called = call("calibrate", folder / "calibration.toml", "-o", tmp_path / "campaign", "--workers", "2", "--quiet")
    assert called.code == 0, called.err
    result = gc.Result.read(tmp_path / "campaign")
    # The reference is the program's own at known parameters: 200 spheres scatter, so that 15 evaluations come near and no nearer.
    assert result.evaluations == 15 and result.failures == 0 and result.best.error < 20
