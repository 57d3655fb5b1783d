"""A reference of any number of rows is checked and calibrated in the memory of one of a hundred, and says what was done with it."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import graincal as gc
from graincal import InputError, ParameterSpace, PythonModel, Reference, Result
from graincal.campaign.file.config import read_calibration
from graincal.campaign.found.comparison import compare

SPACE = ParameterSpace({"strength": (1, 4), "half_strain": (0.005, 0.05)})
NAMES = ("stress_ratio", "volumetric_strain")

SOIL = """
import numpy as np
STRAIN = np.linspace(0, 0.2, 51)
def respond(theta):
    strength, half_strain = theta
    return {"stress_ratio": 1 + strength * STRAIN / (half_strain + STRAIN), "volumetric_strain": 0.1 * STRAIN - half_strain * STRAIN}
"""
CALIBRATION = """
[parameters]
strength    = { range = [1, 4] }
half_strain = { range = [0.005, 0.05] }
[[experiment]]
name        = "dense"
reference   = "rows.csv"
observables = { stress_ratio = { noise = 0.01, relative_error = 0.01 }, volumetric_strain = { noise = 1e-4, measurement_error = 1e-4 } }
model       = { kind = "python", function = "soil:respond", control = CONTROL }
[stop]
max_evaluations = 21
"""


def values(strain, strength=2.5, half_strain=0.02):
    return np.column_stack([1 + strength * strain / (half_strain + strain), 0.1 * strain - half_strain * strain])


def write(folder, rows, *replacements):
    strain = np.linspace(0, 0.2, rows)
    noise = np.random.default_rng(1).standard_normal((rows, 2)) * [0.01, 1e-4]
    table = np.column_stack([strain, values(strain) + noise])
    np.savetxt(folder / "rows.csv", table, delimiter=",", header="axial_strain,stress_ratio,volumetric_strain", comments="", fmt="%.8g")
    (folder / "soil.py").write_text(SOIL)
    text = CALIBRATION.replace("CONTROL", json.dumps(np.linspace(0, 0.2, 51).tolist()))
    for old, new in replacements:
        assert old in text
        text = text.replace(old, new)
    (folder / "calibration.toml").write_text(text)
    return folder / "calibration.toml"


def peak_memory(folder, *words):
    """Of a command as a process, in MB, and what it printed."""
    process = subprocess.Popen(
        [str(Path(sys.executable).with_name("graincal")), *words], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    said = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    assert os.waitstatus_to_exitcode(status) == 0, said
    return usage.ru_maxrss / 1024, said


@pytest.mark.slow
def test_forty_thousand_rows_are_checked_and_calibrated_in_little_memory(tmp_path):
    write(tmp_path, 40_000)
    memory, said = peak_memory(tmp_path, "check", "calibration.toml")
    # The libraries alone take 150 MB; covariances of all rows would take 250 GB.
    assert memory < 1000, memory
    assert "40000 rows, axial_strain 0 to 0.2" in said and "the likelihood sees the 40000 rows put together to" in said
    assert "thin = false under [filter] keeps every row" in said
    memory, _ = peak_memory(tmp_path, "calibrate", "calibration.toml", "-o", "campaign", "--quiet")
    assert memory < 1000, memory
    assert "put together to" in (tmp_path / "campaign" / "log.txt").read_text()
    result = Result.read(tmp_path / "campaign")
    # Responses are kept on the states of the model, and errors are of all rows.
    assert len(result.response(0).control) == 51
    reference = result.experiments[0].reference
    expected = 100 * np.abs(reference.values - values(reference.control, *result.samples[0])).sum(axis=0) / np.abs(reference.values).sum(axis=0)
    np.testing.assert_allclose(result.observable_errors[0], expected, rtol=5e-3)


def test_keeping_every_row_is_a_choice_and_refused_where_memory_ends(tmp_path):
    calibration = read_calibration(write(tmp_path, 300, ("[stop]", "[filter]\nthin = false\n[stop]")))
    assert len(calibration.blank_filter().kept[0].control) == 300
    with pytest.raises(
        InputError,
        match=r"calibration.toml: filter.thin = false keeps all 9000 rows of a reference with 2 observables, and the covariances of their errors would need about \d+ GB of memory",
    ):
        read_calibration(write(tmp_path, 9000, ("[stop]", "[filter]\nthin = false\n[stop]")))
    with pytest.raises(InputError, match="thin must be true or false"):
        read_calibration(write(tmp_path, 300, ("[stop]", "[filter]\nthin = 80\n[stop]")))


def test_the_papers_method_sees_every_row_unless_it_is_told_otherwise(tmp_path):
    for words, states in (("", 300), ("thin = true\n", 101)):
        text = f'[filter]\nmethod = "iterative-bayesian"\nalpha = 5\n{words}[stop]'
        kept = read_calibration(write(tmp_path, 300, ("[stop]", text))).blank_filter().kept[0]
        assert len(kept.control) == 300 if states == 300 else len(kept.control) < states


def test_references_that_were_thinned_differently_are_not_compared():
    strain = np.linspace(0, 0.2, 300)
    reference = Reference(strain, dict(zip(NAMES, values(strain).T)), measurement_errors=dict(zip(NAMES, (0.02, 2e-4))))
    model = PythonModel(lambda theta: dict(zip(NAMES, values(strain, *theta).T)))
    thinned, whole, again = (gc.calibrate(model, reference, SPACE, max_evaluations=21, **options) for options in ({}, {"thin": False}, {"seed": 2}))
    with pytest.raises(InputError, match=r"whole and thinned differ in which references are thinned \(filter.thin\), so that they cannot be compared"):
        compare({"thinned": thinned, "whole": whole})
    assert len(compare({"thinned": thinned, "again": again})) == 2
