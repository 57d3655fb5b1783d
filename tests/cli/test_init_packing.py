"""The packing that graincal init has prepared: of a void ratio, of a relative density, of a grading, of so many particles."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from graincal.dem import preparation
from graincal.dem.preparation import Reach, prepare, reach

FIELD = Path(__file__).parents[1] / "data" / "field"
OEDOMETER = FIELD / "consolidation.ags"
"""Its void ratio begins at 0.764, at 25 kPa with 0.757."""
FEW = ("--particles", "180")
GRADING = "size [mm],passing [%]\n1.0,0\n1.5,60\n2.0,100\n"


@pytest.fixture(scope="module", autouse=True)
def cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("GRAINCAL_CACHE", str(tmp_path_factory.mktemp("packings")))
        yield


def experiment(file: Path) -> dict:
    return tomllib.loads(file.read_text(encoding="utf-8"))["experiment"][0]


def test_a_relative_density_becomes_the_void_ratio_of_the_packing(call, tmp_path):
    file, found = tmp_path / "c.toml", reach(180)
    called = call("init", OEDOMETER, "--relative-density", "0.7", *FEW, "-o", file)
    assert called.code == 0, called.err
    model = experiment(file)["model"]
    assert model["void_ratio"] == pytest.approx(found.loosest - 0.7 * (found.loosest - found.densest), abs=1e-4) and model["particles"] == 180
    said = f"They pack between {found.densest:.3f} (densest) and {found.loosest:.3f} (loosest): found by packing 180 of them with the friction angle of 45° and without friction."
    assert said in called.out and f"# {said}" in file.read_text(encoding="utf-8") and "relative density 0.7 that you gave" in called.out
    # The sand has another void ratio than the packing: what is compared is by how much it changes.
    assert experiment(file)["observables"] == {"volumetric_strain": {"measurement_error": 0.0004}}
    checked = call("check", file)
    assert checked.code == 0 and "volumetric_strain was computed from void_ratio, column 'CONS_INCE'" in checked.out, checked.out


def test_the_ends_of_the_range_can_be_prepared():
    found = reach(180)
    for relative_density, end in ((0.0, found.loosest), (1.0, found.densest)):
        void_ratio = round(found.void_ratio(relative_density), 4)
        assert void_ratio == pytest.approx(end, abs=1e-4) and prepare(180, void_ratio).void_ratio == pytest.approx(end, abs=1e-3)


def test_a_reach_is_kept_and_that_of_many_grains_is_that_of_fewer(monkeypatch):
    found = reach(180)
    monkeypatch.setattr(preparation, "_loosest", lambda *request: pytest.fail("packed again"))
    assert reach(180) == found and found.particles == 180
    monkeypatch.setattr(preparation, "REACH_OF", 180)
    assert reach(5000) == found


@pytest.mark.parametrize(("void_ratio", "way"), [("1.05", "looser"), ("0.4", "denser")])
def test_a_void_ratio_out_of_reach_is_said_with_the_range(call, tmp_path, void_ratio, way):
    called = call("init", OEDOMETER, "--void-ratio", void_ratio, *FEW, "-o", tmp_path / "c.toml")
    assert called.code == 0 and f"Note: the void ratio of {void_ratio} is {way} than spheres of grading toyoura pack. They pack between" in called.out
    assert "a packing of the same relative density, (e_max - e)/(e_max - e_min): --relative-density VALUE" in called.out
    assert ("real grains" in called.out.lower()) == (way == "looser")


def test_the_void_ratio_of_the_file_is_looked_at_too(call, tmp_path, monkeypatch):
    for loosest, said in ((0.74, True), (0.8, False)):
        monkeypatch.setattr(preparation, "reach", lambda *request: Reach(0.56, loosest, 1000))
        called = call("init", OEDOMETER, "-o", tmp_path / f"{loosest}.toml")
        assert called.code == 0 and ("is looser than spheres of grading toyoura pack" in called.out) == said


def test_a_packing_of_ones_own_or_a_void_ratio_stands_alone(call, tmp_path):
    beside = {"--void-ratio": "0.7", "--relative-density": "0.7", "--grading": "toyoura", "--particles": "200"}
    for option, value in beside.items():
        called = call("init", OEDOMETER, "--packing", "packing.csv", option, value, "-o", tmp_path / "c.toml")
        assert called.code == 1 and re.search(rf"--packing has (a void ratio|grains) of its own, so {option} cannot stand beside it", called.err)
    both = call("init", OEDOMETER, "--void-ratio", "0.7", "--relative-density", "0.7", "-o", tmp_path / "c.toml")
    assert both.code == 1 and both.err == "--relative-density gives the void ratio, so --void-ratio cannot stand beside it.\n"
    beyond = call("init", OEDOMETER, "--relative-density", "80", "-o", tmp_path / "c.toml")
    assert (
        beyond.code == 1 and beyond.err == "--relative-density must be from 0, the loosest packing, to 1, the densest, not 80; if 80 % is meant, write 0.8.\n"
    )


def test_a_grading_is_that_of_a_file_wherever_the_calibration_file_stands(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("grading.csv").write_text(GRADING)
    Path("calibrations").mkdir()
    called = call("init", OEDOMETER, "--relative-density", "0.5", "--grading", "grading.csv", *FEW, "-o", "calibrations/c.toml")
    assert called.code == 0, called.err
    model = experiment(Path("calibrations/c.toml"))["model"]
    assert model["grading"] == "../grading.csv" and "# The grading: as you gave it." in Path("calibrations/c.toml").read_text(encoding="utf-8")
    assert call("check", "calibrations/c.toml").code == 0
    missing = call("init", OEDOMETER, "--grading", "none.csv", "-o", "other.toml")
    assert missing.code == 1 and missing.err.startswith("none.csv: there is no such file, and a grading, 'toyoura', d50=SIZE,Cu=NUMBER or a CSV file")
    few = call("init", OEDOMETER, "--relative-density", "0.5", "--particles", "20", "-o", "few.toml")
    assert few.code == 1 and "of grading toyoura fill a cell only" in few.err
    # Where nothing rests on it, the file is written, and it is said.
    assert "Note: particles: 20 of grading toyoura fill a cell only" in call("init", OEDOMETER, "--particles", "20", "-o", "few.toml").out


def test_the_change_of_volume_follows_from_a_column_that_is_named_for_a_void_ratio(tmp_path):
    from graincal import Reference

    (tmp_path / "lab.csv").write_text("strain,n [%]\n0,42\n0.01,41.5\n0.02,42.5\n")
    read = Reference.read(
        tmp_path / "lab.csv", "axial_strain", ("volumetric_strain",), columns={"axial_strain": "strain", "porosity": "n"}, strain="logarithmic"
    )
    # Of a constant volume of solids, V = Vs / (1 - n).
    np.testing.assert_allclose(read.observables["volumetric_strain"], np.log((1 - np.array([0.42, 0.415, 0.425])) / (1 - 0.42)), atol=1e-12)
    assert read.observables["volumetric_strain"][1] > 0 > read.observables["volumetric_strain"][2]


def test_pack_takes_a_relative_density(call, tmp_path):
    found, file = reach(180), tmp_path / "packing.csv"
    called = call("pack", "--relative-density", "0.7", *FEW, "-o", file)
    assert called.code == 0 and "of the relative density 0.7: such spheres pack between" in called.out, called.err
    assert f"(asked for {found.void_ratio(0.7):.4g}" in called.out
    beyond = call("pack", "--void-ratio", "2", *FEW, "-o", tmp_path / "beyond.csv")
    assert beyond.code == 1 and "is out of reach for grading toyoura" in beyond.err and "--relative-density asks for a packing as dense" in beyond.err
    quiet = call("pack", "--relative-density", "0.7", "--quiet", *FEW, "-o", tmp_path / "quiet.csv")
    assert (quiet.code, quiet.out, quiet.err) == (0, "", "")
    for options in ((), ("--void-ratio", "0.6", "--relative-density", "0.7")):
        refused = call("pack", *options, *FEW, "-o", tmp_path / "other.csv")
        assert refused.code == 1 and "one of --void-ratio and --relative-density was expected" in refused.err
    assert "write 0.7" in call("pack", "--relative-density", "70", *FEW, "-o", tmp_path / "other.csv").err
