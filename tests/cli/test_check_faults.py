"""One line a fault: what is changed in a good file, and the code that check says then."""

import numpy as np
import pytest

from graincal import Reference
from graincal.campaign.asked.description import _describe_reference, _restore_reference
from graincal.campaign.asked.doubt import LEVELS
from graincal.campaign.file.examination import examine

from .tested import CONSTANT_MEAN, DRAINED, EXTENSION, OEDOMETRIC, STRAIN, UNDRAINED, VOID_RATIO, write

HARMLESS = {"reading"}
RATIO_OF = (", void_ratio = {}", ""), ("stress_ratio = {}, volumetric_strain = {}", "deviatoric_stress = {}")
VOLUME = ("excess_pore_pressure = {}", "volumetric_strain = {}")


@pytest.mark.parametrize(
    "case", [DRAINED, EXTENSION, UNDRAINED, CONSTANT_MEAN, OEDOMETRIC], ids=["drained", "extension", "undrained", "constant mean", "oedometric"]
)
def test_nothing_is_said_of_a_good_file(tmp_path, case):
    found = examine(write(tmp_path, case))
    assert found.is_clear and {note.code for note in found.notes} <= HARMLESS and found.calibration is not None


@pytest.mark.parametrize(
    ("case", "columns", "replacements", "code"),
    [
        (DRAINED, {"stress_ratio": lambda r: -r}, (), "stress-ratio-low"),
        (DRAINED, {"stress_ratio": lambda r: r - 1}, (), "stress-ratio-low"),
        (DRAINED, {"stress_ratio": lambda r: r - 0.03 * (r > 3) - 2.4 * (r > 3.35)}, (), "stress-ratio-low"),
        (DRAINED, {"stress_ratio": lambda r: 1 / r}, (), "stress-ratio-low"),
        (DRAINED, {"stress_ratio": lambda r: 1 + 4 * (r - 1)}, (), "stress-ratio-high"),
        (DRAINED, {"stress_ratio": lambda r: 1 + 6 * (r - 1)}, (("200e3", "20e3"),), "stress-ratio-high"),
        (DRAINED, {"stress_ratio": lambda r: r + 1}, (), "begins-sheared"),
        (DRAINED, {"stress_ratio": lambda r: 1 + (r - 1) / 1000}, (), "unsheared"),
        (DRAINED, {"stress_ratio": lambda r: np.where(STRAIN < 0.005, 0.97, r)}, (), "below-one"),
        (DRAINED, {"deviatoric_stress": lambda q: q * 1000}, RATIO_OF, "stress-ratio-high"),
        (DRAINED, {"deviatoric_stress": lambda q: q / 1000}, RATIO_OF, "unsheared"),
        (DRAINED, {"deviatoric_stress": lambda q: -q / 3}, RATIO_OF, "stress-ratio-low"),
        (DRAINED, {"axial_strain": lambda e: e / 100}, (), "strain-too-small"),
        (DRAINED, {"axial_strain": lambda e: 9 * e}, ((', strain =', ', units = { axial_strain = "-" }, strain ='),), "strain-too-large"),
        (DRAINED, {"axial_strain": lambda e: e - 0.02}, (), "negative-strain"),
        (DRAINED, {"axial_strain": lambda e: e - 1e-4}, (), "starts-below-zero"),
        (DRAINED, {"volumetric_strain": lambda v: 100 * v}, ((', strain =', ', units = { volumetric_strain = "-" }, strain ='),), "strain-too-large"),
        (DRAINED, {"volumetric_strain": lambda v: v / 100}, (), "strain-too-small"),
        (DRAINED, {"volumetric_strain": lambda v: 0 * v}, (), "strain-too-small"),
        (DRAINED, {"volumetric_strain": lambda v: 0 * v}, (), "constant-observable"),
        (DRAINED, {"volumetric_strain": lambda v: 8 * v}, (), "volumetric-beyond-axial"),
        (DRAINED, {"volumetric_strain": lambda v: -v}, (), "dilates-first"),
        (DRAINED, {"void_ratio": lambda e: e + 0.05}, (), "void-ratio-off"),
        (DRAINED, {"void_ratio": lambda e: e + 0.01}, (), "void-ratio-near"),
        (DRAINED, {"void_ratio": lambda e: e / (1 + e)}, (), "porosity-as-void-ratio"),
        (DRAINED, {"void_ratio": lambda e: 1 + e}, (), "specific-volume-as-void-ratio"),
        (DRAINED, {"void_ratio": lambda e: 100 * e}, (), "void-ratio-percent"),
        (DRAINED, {"void_ratio": lambda e: 100 * e / (1 + e)}, (), "void-ratio-percent"),
        (DRAINED, {"void_ratio": lambda e: 7 * e}, (), "void-ratio-impossible"),
        (EXTENSION, {"stress_ratio": lambda r: 1 / r}, (), "stress-ratio-low"),
        (EXTENSION, {"stress_ratio": lambda r: r**4}, (), "stress-ratio-high"),
        (EXTENSION, {"axial_extension": lambda e: e / 100}, (), "strain-too-small"),
        (EXTENSION, {}, (('"lab.csv"', '"lab.csv", strain = "engineering"'),), "strain-not-converted"),
        (UNDRAINED, {"excess_pore_pressure": lambda u: 2 * u}, (), "pore-pressure-beyond"),
        (UNDRAINED, {"excess_pore_pressure": lambda u: u + 100e3}, (), "pore-pressure-not-excess"),
        (UNDRAINED, {"excess_pore_pressure": lambda u: u / 1000}, (), "pore-pressure-small"),
        (UNDRAINED, {"deviatoric_stress": lambda q: 10 * q}, (), "stress-ratio-high"),
        (UNDRAINED, {"deviatoric_stress": lambda q: -q}, (), "stress-ratio-low"),
        (UNDRAINED, {"deviatoric_stress": lambda q: 1000 * q}, (VOLUME,), "stress-ratio-high"),
        (UNDRAINED, {"deviatoric_stress": lambda q: q / 1000}, (VOLUME,), "unsheared"),
        (UNDRAINED, {"deviatoric_stress": lambda q: -q}, (VOLUME,), "stress-ratio-low"),
        (UNDRAINED, {"volumetric_strain": lambda _: 0.5 * STRAIN}, (VOLUME,), "volume-changes"),
        (CONSTANT_MEAN, {"mean_stress": lambda p: -p}, (), "negative-stress"),
        (CONSTANT_MEAN, {"mean_stress": lambda p: p / 1000}, (), "mean-stress-not-confining"),
        (CONSTANT_MEAN, {"deviatoric_stress": lambda q: 1000 * q}, (), "negative-stress"),
        (OEDOMETRIC, {"lateral_stress": lambda s: -s}, (), "negative-stress"),
        (OEDOMETRIC, {"axial_stress": lambda s: s / 1000}, (), "stresses-elsewhere"),
        (OEDOMETRIC, {"void_ratio": lambda e: e + 0.1}, (), "void-ratio-off"),
        (OEDOMETRIC, {}, (('"lab.csv"', '"lab.csv", strain = "engineering"'),), "key-without-effect"),
        (DRAINED, {}, (("stress_ratio = {}", "stress_ratio = { relative_error = 1 }"),), "large-error"),
        (DRAINED, {}, (("volumetric_strain = {}", "volumetric_strain = { measurement_error = 0.05 }"),), "large-error"),
        (DRAINED, {}, ((', strain =', ', until = 0.3, strain ='),), "key-without-effect"),
        (DRAINED, {}, ((', strain =', ', confining_pressure = 300e3, strain ='),), "other-pressure"),
        (DRAINED, {}, ((', strain =', ', confining_pressure = 200e3, strain ='),), "key-without-effect"),
        (DRAINED, {}, (("range = [10, 50]", "per_experiment = true, range = [10, 50]"),), "key-without-effect"),
        (DRAINED, {}, (("[run]", '[filter]\nmethod = "iterative-bayesian"\n[run]'), ("volumetric_strain = {}", "volumetric_strain = { step = 1e-5 }")), "key-without-effect"),
        (DRAINED, {}, (("200e3", "1e5"), ("model  ", "# The confining pressure in Pa: CHECK.\nmodel  ")), "placeholder-pressure"),
        (DRAINED, {}, (("eta_m = 0.3 } }", "eta_m = 0.3 } }   # CHECK"), ("200e3", "100e3")), "placeholder-pressure"),
        (DRAINED, {}, (("eta_m = 0.3 } }", "eta_m = 0.3 } }   # CHECK"),), "check-marks"),
        (DRAINED, {}, (("200e3", "1e5"), ("model  ", "# The void ratio: CHECK, that of Toyoura sand.\nmodel  ")), "check-marks"),
        (DRAINED, {}, (("[run]", "[stop]\nmax_iterations = 3\nmax_evaluations = 600\n[run]"),), "limit-never-reached"),
        (DRAINED, {}, (("[run]", "[stop]\nmax_iterations = 300\nmax_evaluations = 100\n[run]"),), "limit-never-reached"),
        (DRAINED, {}, (("[run]", "[filter]\nfirst_batch = 20\nbatch = 10\n[stop]\nmax_evaluations = 30\n[run]"),), "limit-not-used"),
        (DRAINED, {}, (("[run]", '[filter]\nmethod = "iterative-bayesian"\n[stop]\nmax_evaluations = 600\n[run]'),), "limit-never-reached"),
        (DRAINED, {}, (("[run]", '[filter]\nmethod = "iterative-bayesian"\n[stop]\nmax_evaluations = 39\n[run]'),), "limit-not-used"),
        (DRAINED, {}, (("workers = 1", "workers = 4096"),), "more-workers-than-cores"),
        (DRAINED, {}, (("[7, 9]", "[5, 9]"),), "unusual-parameter"),
        (DRAINED, {}, (("fixed =", "inertial_number = 0.09, fixed ="),), "far-from-quasi-static"),
    ],
)  # fmt: skip
def test_a_fault_is_said(tmp_path, case, columns, replacements, code):
    found = examine(write(tmp_path, case, columns, replacements))
    problems, notes = {each.code for each in found.problems}, {each.code for each in found.notes}
    assert code in (problems if LEVELS[code] == "problem" else notes), (problems, notes)
    assert found.is_clear is (LEVELS[code] == "note")
    assert problems | notes <= set(LEVELS)


def test_a_short_test_that_was_cut_on_purpose_is_no_fault(tmp_path):
    file = write(
        tmp_path,
        DRAINED,
        {"axial_strain": lambda e: e / 5, "volumetric_strain": lambda v: v / 5, "void_ratio": lambda e: 0 * e + VOID_RATIO + STRAIN / 100},
        ((", strain =", ", until = 0.0025, strain ="),),
    )
    assert examine(file).is_clear


def test_a_constant_lateral_stress_makes_no_stress_ratio_of_another_test(tmp_path):
    file = write(tmp_path, UNDRAINED, {}, [("deviatoric_stress = {}, excess_pore_pressure = {}", "stress_ratio = {}"),
                 (', strain =', ', columns = { deviator_stress = "deviatoric_stress [Pa]" }, confining_pressure = 200e3, strain =')])  # fmt: skip
    assert "lateral-stress-not-constant" in {each.code for each in examine(file).problems}


def test_dense_noisy_rows_tell_no_wrong_sign(tmp_path):
    rows = 3000
    strain, noise = np.linspace(0, 0.1, rows), 2e-4 * np.random.default_rng(1).standard_normal(rows)
    columns = {
        "axial_strain": strain,
        "stress_ratio": 1 + 2.5 * strain / (0.005 + strain),
        "volumetric_strain": 0.1 * strain - strain**2 / 10 + noise,
        "void_ratio": 0 * strain + VOID_RATIO + strain / 100,
    }
    assert examine(write(tmp_path, (columns, DRAINED[1]))).is_clear


def test_how_a_reference_was_read_is_kept_for_programs(tmp_path):
    folder = tmp_path
    (folder / "q.csv").write_text("axial_strain,q [kPa],ev\n0,0,0\n0.01,100,-0.001\n0.02,200,-0.0005\n0.03,210,0.001\n")
    columns = {"deviator_stress": "q [kPa]", "volumetric_strain": "ev"}
    read = Reference.read(
        folder / "q.csv", columns=columns, strain="logarithmic", confining_pressure=100e3, until=0.02, compression={"volumetric_strain": "negative"}
    )
    assert (read.cut, read.at_pressure, read.turned, read.idle) == (True, ("stress_ratio",), ("volumetric_strain",), ())
    whole = Reference.read(folder / "q.csv", columns=columns, strain="logarithmic", confining_pressure=100e3, until=0.2)
    assert (whole.cut, whole.turned) == (False, ()) and len(whole.idle) == 1 and set(whole.idle) < set(whole.notes)
    # A stress that is made with the pressure is an effect of it.
    mean = Reference.read(
        folder / "q.csv", "axial_strain", ["mean_stress"], columns={"deviator_stress": "q [kPa]"}, strain="logarithmic", confining_pressure=100e3
    )
    assert mean.at_pressure == ("mean_stress",)
    kept = _restore_reference(_describe_reference(read))
    assert (kept.cut, kept.at_pressure, kept.turned) == (read.cut, read.at_pressure, read.turned)
