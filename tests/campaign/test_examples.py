"""The examples are what users copy: they are read and run as they stand."""

import runpy
import tomllib
from pathlib import Path

import pytest

from graincal.campaign.file.config import CalibrationFile, read_calibration

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*/calibration.toml")), ids=lambda path: path.parent.name)
def test_each_file_is_one_that_calibrate_takes(path):
    file = CalibrationFile.model_validate(tomllib.loads(path.read_text()))
    for entry in file.experiment:
        assert (path.parent / entry.reference.file).exists()


@pytest.mark.slow
def test_the_packing_of_the_triaxial_example_can_be_prepared(tmp_path, monkeypatch):
    monkeypatch.setenv("GRAINCAL_CACHE", str(tmp_path))
    first, second = read_calibration(EXAMPLES / "triaxial" / "calibration.toml").experiments
    assert first.model.packing.count == 500 and first.model.packing.void_ratio == pytest.approx(0.68, abs=0.002)
    assert len(list(tmp_path.glob("*.csv"))) == 1  # both tests are of the same packing


def test_the_function_of_one_s_own_is_found():
    calibration = read_calibration(EXAMPLES / "python_model" / "calibration.toml")
    assert calibration.space.names == ("strength", "reference_strain", "dilatancy")


def test_the_script_finds_what_made_its_references(capsys):
    found = runpy.run_path(str(EXAMPLES / "two_tests.py"))
    assert found["result"].answer.theta == pytest.approx([7.4, 34.0], rel=0.02)
    assert "friction_angle: 3" in capsys.readouterr().out
