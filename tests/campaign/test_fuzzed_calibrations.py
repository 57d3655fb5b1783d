"""Calibration files with mistakes in them: each is read, or refused in a sentence."""

import random

import pytest
from fuzzing import SEEDS, fuzzed, refused_in_words, with_other_values
from hypothesis import given

from graincal.campaign.file.examination import examine
from graincal.data import InputError
from graincal.models import PythonModel

from .hyperbola import write_calibration
from .test_calibration_file import write_triaxial

POSTERIOR = '[filter]\nmethod = "posterior"\nfirst_batch = 12\nbatch = 6\nahead = 1\nearly_stop = false\nthin = true\ncorrelation_length = 0.1\ndiscrepancy = true\npacking_scatter = false\n'
MODEL = 'kind = "triaxial", packing = "cubic.csv", confining_pressure = 2e5, law = "linear", step_limit = 100000, rest_every = 0.01, inertial_number = 1e-3, density_scaling = 1e3, largest_flagged_share = 0.1, mass_exponent = 1'
REFERENCE = 'reference   = { file = "reference.csv", until = 0.15, strain = "logarithmic", compression = "positive", units = { axial_strain = "-" }, rows = [2, 11], control_step = 1e-3, columns = { axial_strain = 1 } }'


PROGRAM = """kind = "command", command = ["python3", "soil.py", "{{ E }}"], derived = { E = "10**strength" }, link = ["soil.py"], templates = { "case.in" = "soil.py" }, delimiters = ["<<", ">>"], environment = { X = "{{ E }}" },
 parameters_file = "p.json", time_limit = 60, memory = 1e9, cores = 2, max_at_once = 3, success_exit_codes = [0, 1], retry_exit_codes = [75], infeasible_exit_codes = [3], keep = "all", scratch = "/tmp",
 output = { file = "curve.csv", zero = ["axial_strain"], first_row = 2, where = "stage == 2", strain = "engineering", columns = { axial_strain = { column = "e33", unit = "%", sign = -1 }, stress_ratio = "s33 / s11", volumetric_strain = 3 } }"""
"""All keys of a program, on one line for TOML."""


@pytest.fixture(scope="module")
def texts(tmp_path_factory):
    """Good files of each kind of model and method, and the folder that all of them are read in."""
    folder = tmp_path_factory.mktemp("fuzzed")
    python = write_calibration(folder, ('"soil:respond"', '"soil:respond", timeout = 90, control = [0, 0.1, 0.2]')).read_text()
    plain = write_calibration(folder).read_text()
    triaxial = write_triaxial(folder).read_text()
    posterior = (
        plain[: plain.index("[filter]")]
        + POSTERIOR
        + "[stop]\nposterior_shift = 0.2\nmax_evaluations = 100\nmax_iterations = 5\nhours = 2\n[run]\nworkers = 2\nseed = 1\nexpected_seconds = 1.5\n"
    )
    whole = triaxial.replace('kind = "triaxial", packing = "cubic.csv", confining_pressure = 2e5', MODEL).replace('reference   = "reference.csv"', REFERENCE)
    prepared = triaxial.replace('packing = "cubic.csv"', 'particles = 100, void_ratio = 0.7, grading = "toyoura", seed = 2')
    cycles = posterior.replace(
        'kind = "python", function = "soil:respond"', 'kind = "isotropic", packing = "cubic.csv", confining_pressure = 2e5, turns = [3e5, 1e5]'
    ).replace("[filter]", 'control = "position"\n[filter]')
    look = triaxial[: triaxial.index("[filter]")] + POSTERIOR + "[first_look]\nmodel = { particles = 250, inertial_number = 1e-3 }\nmax_evaluations = 30\n"
    program = plain.replace('kind = "python", function = "soil:respond"', PROGRAM.replace("\n", ""))
    return folder, [python, plain, posterior, whole, prepared, cycles, look, program]


@pytest.fixture(scope="module", autouse=True)
def nothing_runs():
    """No packing is prepared, and no function looked for, in each of hundreds of files."""

    def prepare(*arguments, **options):
        raise InputError("no packing is prepared here.")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("graincal.dem.preparation.prepare", prepare)
        patch.setattr(PythonModel, "check", lambda self, at, samples: self.tasks(samples, at))
        yield


@pytest.mark.slow
@fuzzed
@given(seed=SEEDS)
def test_a_file_with_mistakes_is_read_or_refused_in_a_sentence(texts, seed):
    folder, good = texts
    text = with_other_values(random.Random(seed).choice(good), seed)
    file = folder / "mutated.toml"
    file.write_text(text, encoding="utf-8")
    refused_in_words(lambda: examine(file).limits)
