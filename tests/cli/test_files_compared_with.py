"""Files that a prediction or a simulation is compared with: by the campaign's columns, by --column, by their own names."""

import shutil
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from campaign import frictional
from campaign.as_tasks import as_tasks
from campaign.frictional import STRAIN

import graincal as gc
from graincal import demo
from graincal.campaign import begin
from graincal.campaign.file.config import read_calibration
from graincal.campaign.file.reading import read_before
from graincal.campaign.stored.store import Store
from graincal.cli.columns import Strain, said_of_file
from graincal.cli.comparison import Compared, read_comparison
from graincal.cli.predict import predicted_test
from graincal.laboratory.another_file import Before
from graincal.models import StressPathTest

pytestmark = pytest.mark.usefixtures("fewer_draws")

PACKING = Path(demo.__file__).with_name("packing_500.csv")
PRESSURE = 0.5e6
CALIBRATION = f"""
[parameters]
phi   = {{ range = [10, 50], unit = "deg" }}
eta_m = {{ range = [0, 1] }}
[[experiment]]
name        = "drained"
observables = {{ stress_ratio = {{ measurement_error = 0.01 }}, volumetric_strain = {{ measurement_error = 3e-4 }} }}
reference   = REFERENCE
model       = {{ kind = "triaxial", packing = "{PACKING}", confining_pressure = 0.5e6, fixed = {{ log_E = 8, nu = 0.2, beta_m = 0.1 }} }}
[filter]
first_batch = 8
packing_scatter = false
discrepancy = false
[stop]
max_iterations = 1
posterior_shift = 0
[run]
workers = 1
"""
BY_HEADER = """{ file = "lab.csv", columns = { axial_strain = "Ea", deviator_stress = "q", volumetric_strain = "Ev" },
units = { axial_strain = "%", deviator_stress = "kPa", volumetric_strain = "%" }, strain = "engineering", compression = { volumetric_strain = "negative" }, until = 0.12 }""".replace(
    "\n", " "
)
BY_NUMBER = BY_HEADER.replace('"Ea"', "1").replace('"q"', "2").replace('"Ev"', "3")


def measured(seed):
    """A test of the soil, with errors."""
    curves, rng = frictional.curves(32.0, 0.3), np.random.default_rng(seed)
    return {name: values + error * rng.standard_normal(len(STRAIN)) * (STRAIN > 0) for (name, values), error in zip(curves.items(), (0.01, 3e-4))}


def printed(seed, names=("Ea", "q", "Ev"), pressure=PRESSURE):
    """It as a laboratory prints it: engineering strains in percent, dilation positive, q in kPa."""
    curves = measured(seed)
    return write(names, [100 * -np.expm1(-STRAIN), (curves["stress_ratio"] - 1) * pressure / 1e3, 100 * np.expm1(-curves["volumetric_strain"])])


def write(names, columns):
    return "\n".join([",".join(names), *(",".join(f"{value:.12g}" for value in row) for row in zip(*columns))]) + "\n"


def campaign(folder, reference, calibration=CALIBRATION):
    folder.mkdir()
    (folder / "lab.csv").write_text(printed(1))
    (folder / "calibration.toml").write_text(calibration.replace("REFERENCE", reference))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(StressPathTest, "tasks", frictional.tasks)
        begin(read_calibration(folder / "calibration.toml"), folder / "campaign")
    return folder / "campaign"


@pytest.fixture(scope="module")
def by_header(tmp_path_factory):
    return campaign(tmp_path_factory.mktemp("columns") / "header", BY_HEADER)


@pytest.fixture(scope="module")
def by_number(tmp_path_factory, by_header):
    """The same, by a calibration file that names columns by their numbers."""
    folder = shutil.copytree(by_header, tmp_path_factory.mktemp("columns") / "number")
    with closing(Store.open(folder)) as store:
        store.database.rows("UPDATE meta SET value = ? WHERE key = 'source'", CALIBRATION.replace("REFERENCE", BY_NUMBER))
    return folder


@pytest.fixture(autouse=True)
def closed_form(monkeypatch):
    monkeypatch.setattr(StressPathTest, "tasks", frictional.tasks)


def counted(*given):
    """The soil in closed form, with what `simulate` says of a run."""
    response = frictional.respond(*given)
    return replace(response, details={**response.details, "states": 20, "flagged": 0})


def said(called):
    return " ".join(called.err.split())


def test_another_file_of_the_laboratory_is_read_by_the_columns_of_the_campaign(call, by_header, tmp_path):
    # Not to the strain of the other test, and by the pressure of this one.
    (tmp_path / "other.csv").write_text(printed(2, pressure=1e6))
    called = call("predict", by_header, "--confining-pressure", "1e6", "--against", tmp_path / "other.csv", "-o", tmp_path / "band.csv")
    assert called.code == 0 and "Against the test:" in called.out
    assert (
        "read by the columns of \"drained\": axial_strain in 'Ea', deviator_stress in 'q', volumetric_strain in 'Ev'; "
        'with strain = { axial_strain = "engineering", volumetric_strain = "engineering" }, compression = { volumetric_strain = "negative" }.'
    ) in said(called)
    band = np.genfromtxt(tmp_path / "band.csv", delimiter=",", names=True)
    np.testing.assert_allclose(band["axial_strain"], STRAIN, atol=1e-8)


def test_what_is_read_is_what_was_measured(by_header, tmp_path):
    (tmp_path / "other.csv").write_text(printed(2, pressure=1e6))
    reference = read(by_header, tmp_path / "other.csv", confining_pressure=1e6)
    for name, values in measured(2).items():
        np.testing.assert_allclose(reference.observables[name], values, atol=1e-9)
    assert set(reference.measurement_errors) == {"stress_ratio", "volumetric_strain"} and reference.read_as == (
        "axial_strain",
        "deviator_stress",
        "volumetric_strain",
    )


def read(folder, path, kind=None, confining_pressure=None, **asked):
    """The reference as `predict` reads it."""
    result = gc.Result.read(folder)
    chosen = result.experiments[0]
    test = predicted_test(chosen, kind, confining_pressure)
    return read_comparison(path, Compared.of(test, chosen), chosen, asked=asked, before=read_before(result.calibration, chosen.name))


def test_a_file_of_other_columns_is_read_by_its_own_names(call, by_header, by_number, tmp_path):
    columns = {"axial_strain": STRAIN, **frictional.curves(32.0, 0.3)}
    (tmp_path / "own.csv").write_text(write(columns, columns.values()))
    for folder, words in ((by_header, "; those of \"drained\" are not all in it: 'Ea' for axial_strain is not."), (by_number, ".")):
        # A number is a column of any file, and so the names come first.
        called = call("predict", folder, "--against", tmp_path / "own.csv", "--samples", "20")
        assert called.code == 0 and f"read by the columns with the quantities' own names{words}" in said(called)
        reference = read(folder, tmp_path / "own.csv")
        np.testing.assert_allclose(reference.observables["volumetric_strain"], columns["volumetric_strain"], atol=1e-9)


def test_numbers_of_columns_serve_a_file_without_the_names(by_number, tmp_path):
    (tmp_path / "other.csv").write_text(printed(2))
    reference = read(by_number, tmp_path / "other.csv")
    assert reference.notes[0].startswith("read by the columns of \"drained\": axial_strain in 'Ea', deviator_stress in 'q'")
    np.testing.assert_allclose(reference.control, STRAIN, atol=1e-9)


def test_columns_of_the_command_alone_are_read_by_the_conventions_of_the_campaign(call, by_header, tmp_path):
    (tmp_path / "other.csv").write_text(printed(2, ("shortening", "deviator", "swelling")))
    columns = ["--column", "axial_strain=1:%", "--column", "deviator_stress=deviator:kPa", "--column", "volumetric_strain=C:%"]
    given = ["predict", by_header, "--against", tmp_path / "other.csv"]
    called = call(*given, *columns)
    assert called.code == 0
    assert "read by --column: axial_strain in 'shortening', deviator_stress in 'deviator', volumetric_strain in 'swelling'." in said(called)
    assert 'of "drained" was taken strain = {' in said(called)
    other = read(
        by_header,
        tmp_path / "other.csv",
        **said_of_file("--against", Path("other.csv"), columns[1::2], Strain.logarithmic, ["volumetric_strain=positive"], None, None, None),
    )
    assert other.control[-1] == pytest.approx(-np.expm1(-STRAIN[-1])) and other.observables["volumetric_strain"][-1] > 0
    missing = call(*given)
    assert missing.code == 1 and missing.out == ""
    assert said(missing) == (
        f"{tmp_path}/other.csv: there is no column of axial_strain, nor is 'Ea' for axial_strain of \"drained\", and --column axial_strain=COLUMN:UNIT, for each quantity, "
        "was expected to say which of these it is: 1 'shortening', 2 'deviator', 3 'swelling'."
    )
    wrong = call(*given, "--column", "axial_strain=Ea:%")
    assert wrong.code == 1 and "there is no column 'Ea' for axial_strain" in said(wrong)


def test_what_the_file_holds_is_compared(call, by_header, tmp_path):
    (tmp_path / "stress.csv").write_text(write(("axial_strain", "stress_ratio"), (STRAIN, frictional.curves(32.0, 0.3)["stress_ratio"])))
    called = call("predict", by_header, "--against", tmp_path / "stress.csv")
    assert called.code == 0 and "of stress_ratio; log score" in called.out
    assert "it holds no volumetric_strain, so that stress_ratio alone is compared." in said(called)


def test_a_simulation_is_compared_with_what_a_file_holds(call, tmp_path, monkeypatch):
    monkeypatch.setattr(StressPathTest, "tasks", as_tasks(counted))
    (tmp_path / "lab.csv").write_text(printed(1).replace("Ev", "sensor"))
    given = [
        "simulate",
        "triaxial",
        "--packing",
        PACKING,
        "--confining-pressure",
        PRESSURE,
        "-p",
        "log_E=8",
        "-p",
        "nu=0.2",
        "-p",
        "phi=32",
        "-p",
        "beta_m=0.1",
        "-p",
        "eta_m=0.3",
    ]
    columns = ["--column", "axial_strain=Ea:%", "--column", "deviator_stress=q:kPa", "--strain", "engineering"]
    called = call(*given, "--at", tmp_path / "lab.csv", *columns, "-o", tmp_path / "curve.csv", "--plot", tmp_path / "curve.png")
    assert called.code == 0 and "Error against the reference: stress_ratio" in called.err and "volumetric_strain alone" not in called.err
    assert "The reference: read by --column: axial_strain in 'Ea', deviator_stress in 'q'." in called.err
    assert "The reference: it holds no volumetric_strain, so that stress_ratio alone is compared." in called.err
    refused = call(*given, "--at", tmp_path / "lab.csv")
    assert refused.code == 1 and "there is no column of axial_strain, and --column axial_strain=COLUMN:UNIT" in refused.err
    for option, value in (("--column", "axial_strain=Ea"), ("--strain", "engineering"), ("--sheet", "2")):
        assert call(*given, option, value).err == f"{option} says how the file of --at is read, and that is missing.\n"


def test_what_is_not_fitted_is_read_and_drawn_and_told_apart(call, tmp_path, monkeypatch):
    not_fitted = CALIBRATION.replace("{ measurement_error = 3e-4 }", "{ fitted = false }")
    folder = campaign(tmp_path / "recorded", BY_HEADER, not_fitted)
    (tmp_path / "other.csv").write_text(printed(2))
    called = call("predict", folder, "--against", tmp_path / "other.csv", "--plot", tmp_path / "prediction.png")
    assert called.code == 0 and "of stress_ratio; log score" in called.out and "of volumetric_strain" not in called.out
    assert "Not fitted: the mean's error in volumetric_strain is " in called.out and "volumetric_strain in 'Ev'" in said(called)
    reference = read(folder, tmp_path / "other.csv")
    assert reference.names == ("stress_ratio",)
    np.testing.assert_allclose(reference.recorded["volumetric_strain"], measured(2)["volumetric_strain"], atol=1e-9)
    # Where the other file does not hold it.
    (tmp_path / "stress.csv").write_text(write(("axial_strain", "stress_ratio"), (STRAIN, measured(2)["stress_ratio"])))
    assert "Not fitted" not in call("predict", folder, "--against", tmp_path / "stress.csv", "--samples", "20").out
    monkeypatch.setattr(StressPathTest, "tasks", as_tasks(counted))
    given = [
        "simulate",
        "triaxial",
        "--packing",
        PACKING,
        "--confining-pressure",
        PRESSURE,
        "-p",
        "log_E=8",
        "-p",
        "nu=0.2",
        "-p",
        "phi=32",
        "-p",
        "beta_m=0.1",
        "-p",
        "eta_m=0.3",
    ]
    called = call(*given, "--at", folder.parent / "calibration.toml", "-o", tmp_path / "curve.csv", "--plot", tmp_path / "curve.png")
    assert called.code == 0 and "Error of what is not fitted: volumetric_strain" in called.err


def test_an_undrained_test_is_compared_by_its_stress_and_pore_pressure(by_header, tmp_path):
    pressure = 80 * np.tanh(STRAIN / 0.05)
    (tmp_path / "undrained.csv").write_text(write(("Ea", "q", "excess_pore_pressure [kPa]"), (100 * -np.expm1(-STRAIN), 1e3 * STRAIN, pressure)))
    reference = read(by_header, tmp_path / "undrained.csv", "undrained")
    assert reference.names == ("deviatoric_stress", "excess_pore_pressure")
    np.testing.assert_allclose(reference.control, STRAIN, atol=1e-9)
    np.testing.assert_allclose(reference.observables["deviatoric_stress"], 1e6 * STRAIN, atol=1e-3)
    np.testing.assert_allclose(reference.observables["excess_pore_pressure"], 1e3 * pressure, atol=1e-3)


@pytest.mark.parametrize("command", ["predict", "compare"])
def test_what_says_nothing_of_a_file_is_refused(call, by_header, by_number, command):
    folders = [by_header] if command == "predict" else [by_header, by_number]
    alone = call(command, *folders, "--column", "axial_strain=2")
    assert alone.code == 1 and said(alone) == "--column says how the file of --against is read, and that is missing."
    beside = call(command, *folders, "--against", by_header.parent / "calibration.toml", "--column", "axial_strain=2")
    assert beside.code == 1 and "a calibration file says itself how its laboratory files are read, so --column cannot stand beside it." in said(beside)
    twice = call(command, *folders, "--against", by_header.parent / "lab.csv", "--column", "axial_strain=2", "--column", "axial_strain=3")
    assert twice.code == 1 and said(twice) == "--column names axial_strain twice, and each quantity once was expected."


def test_campaigns_are_ranked_by_one_reading_of_a_file(call, by_header, by_number, tmp_path):
    (tmp_path / "other.csv").write_text(printed(2))
    called = call("compare", by_header, by_number, "--against", tmp_path / "other.csv")
    assert called.code == 0, called.err
    assert "log score a value" in called.out and said(called).count("read by the columns of \"drained\": axial_strain in 'Ea'") == 1


def test_a_campaign_from_python_has_no_columns(by_header):
    calibration = gc.Result.read(by_header).calibration
    assert read_before(calibration, "drained").carried["strain"] == "engineering" and "until" not in read_before(calibration, "drained").carried
    assert read_before(calibration, "other") is None
    assert read_before(replace(calibration, source=""), "drained") is None


def test_a_cycle_is_read_by_its_positions_and_an_extension_by_its_own_strain(tmp_path):
    stress = [2e4, 8e4, 1.6e5, 4e4, 2.5e5]
    (tmp_path / "cycle.csv").write_text(write(("sv", "void_ratio"), (stress, [0.72, 0.71, 0.70, 0.703, 0.69])))
    cycle = Compared("oedometric", "oedometric test", "position", ("void_ratio",), 2e4, ("void_ratio",), (1.6e5, 4e4))
    asked = {"columns": {"axial_stress": "sv", "void_ratio": 2}, "units": {"axial_stress": "Pa"}}
    reference = read_comparison(tmp_path / "cycle.csv", cycle, asked=asked)
    np.testing.assert_allclose(reference.control, np.abs(np.diff(np.log(stress), prepend=np.log(2e4))).cumsum())
    with pytest.raises(gc.InputError, match="--column axial_stress=COLUMN:UNIT"):
        read_comparison(tmp_path / "cycle.csv", cycle)
    with pytest.raises(gc.InputError, match="the stress turns around at 160000, 40000 Pa, and turns of the model says 120000"):
        read_comparison(tmp_path / "cycle.csv", replace(cycle, turns=(1.2e5,)), asked=asked)
    (tmp_path / "extension.csv").write_text(write(("eps", "stress_ratio"), (-STRAIN, 1 / (1 + STRAIN))))
    extension = replace(Compared.drained(PRESSURE), control="axial_extension")
    reference = read_comparison(tmp_path / "extension.csv", extension, asked={"columns": {"axial_strain": "eps"}, "strain": "logarithmic"})
    assert reference.control_name == "axial_extension" and reference.names == ("stress_ratio",)
    np.testing.assert_allclose(reference.control, STRAIN, atol=1e-9)


def test_a_part_of_a_file_is_compared(call, by_header, tmp_path):
    # The test stands below another one, by the same headers.
    other = write(("Ea", "q", "Ev"), (100 * STRAIN[:5], 10 * STRAIN[:5], STRAIN[:5]))
    (tmp_path / "two.csv").write_text(other + printed(2).partition("\n")[2])
    called = call("predict", by_header, "--against", tmp_path / "two.csv", "--rows", "7-26")
    assert called.code == 0 and "20 rows of lines 7 to 26 were read, and 5 others left out." in said(called)
    np.testing.assert_allclose(read(by_header, tmp_path / "two.csv", rows=(7, 26)).control, STRAIN, atol=1e-9)


def test_a_stage_of_the_campaigns_file_is_not_one_of_another(tmp_path):
    (tmp_path / "other.csv").write_text(printed(2))
    columns = {"axial_strain": "Ea", "deviator_stress": "q"}
    before = Before(
        '"drained"', {"columns": columns, "units": {"axial_strain": "%", "deviator_stress": "kPa"}, "stage": "shear", "zero": ["axial_strain"], "until": 0.01}
    )
    reference = read_comparison(tmp_path / "other.csv", Compared.drained(PRESSURE), before=before)
    assert reference.notes[0].endswith('; with zero = ["axial_strain"].') and len(reference.control) == len(STRAIN)
    assert 'all of it was read: stage = "shear" of "drained" is of another file.' in reference.notes
