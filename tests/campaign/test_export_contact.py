"""The answer of a campaign as the contact law of another DEM program."""

from pathlib import Path

import numpy as np
import pytest

import graincal as gc
from graincal import demo
from graincal.models.contact_lines.lammps import FILE_NAME

from .hyperbola import write_calibration
from .test_command_line import TWO_ITERATIONS

FIXED = {"nu": 0.2, "beta_m": 0.1, "eta_m": 0.3}
STRAIN = np.array([0.0, 0.004])


@pytest.fixture(scope="module")
def campaigns(tmp_path_factory):
    """One and two triaxial tests of a few evaluations; the second of the two has another law."""
    folder, space = tmp_path_factory.mktemp("campaigns"), gc.ParameterSpace({"log_E": (8, 9), "phi": (20, 40)})
    reference = gc.Reference(control=STRAIN, observables={"stress_ratio": np.array([1.0, 1.4])})
    tests = [gc.TriaxialTest(demo.packing(), 0.5e6, fixed=FIXED), gc.TriaxialTest(demo.packing(), 0.5e6, fixed=FIXED, law="hertz-mindlin")]
    stop = gc.Stop(max_iterations=1)
    experiments = [gc.Experiment("one", tests[0], reference), gc.Experiment("two", tests[1], reference)]
    for count in (1, 2):
        gc.calibrate(
            experiments[:count], space=space, method="iterative-bayesian", alpha=4, effective_sample_size=0.5, stop=stop, folder=folder / str(count), workers=2
        )
    return folder


def test_the_lines_have_the_answers_values_and_the_fixed_ones(campaigns, call):
    result = gc.Result.read(campaigns / "1")
    log_E, phi = result.most_probable.theta.tolist()
    for program, file in (("yade", "contact.py"), ("lammps", "contact.lammps"), ("pfc", "contact.dat")):
        called = call("export", campaigns / "1", "--to", program)
        assert called.code == 0 and called.out == f"{campaigns / '1' / 'export' / file}\n"
        text = Path(called.out.strip()).read_text()
        assert f"log_E = {log_E!r}, nu = 0.2, phi = {phi!r}, beta_m = 0.1, eta_m = 0.3" in text and "most probable sample of" in text
    assert "10 classes" in (campaigns / "1" / "export" / FILE_NAME).read_text()


def test_each_experiment_has_its_own_lines_where_they_differ(campaigns, call, tmp_path):
    called = call("export", campaigns / "2", "--to", "lammps", "-o", tmp_path)
    assert called.out.split() == [str(tmp_path / f"contact_{name}.lammps") for name in ("one", "two")]
    assert "hooke" in (tmp_path / "contact_one.lammps").read_text() and "hertz/material" in (tmp_path / "contact_two.lammps").read_text()


def test_a_model_without_a_law_is_said(call, tmp_path):
    call("calibrate", write_calibration(tmp_path, TWO_ITERATIONS), "-o", tmp_path / "campaign", "--quiet")
    called = call("export", tmp_path / "campaign", "--to", "yade")
    assert called.code == 1 and called.err == (
        'export: contact lines are of models whose contact law graincal knows, and that of the experiment "drained" is no test of its own engine: export its samples with --to csv.\n'
    )
