"""Campaigns that the version before began, and that were broken off, go on to the answers that they would have had."""

import importlib.util
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

import graincal as gc
from graincal.campaign.stored.provenance import provenance

BEGUN = Path(__file__).parents[1] / "data" / "begun"


@pytest.fixture(scope="module")
def make():
    spec = importlib.util.spec_from_file_location("begun", BEGUN / "make.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("name", ["engine", "function"])
def test_a_campaign_begun_by_the_version_before_goes_on_to_the_same_answer(name, make, tmp_path):
    shutil.copytree(BEGUN / name, tmp_path / name)
    expected = np.load(BEGUN / f"{name}.npz")
    before = gc.Result.read(tmp_path / name)
    assert 0 < before.evaluations < len(expected["ids"]) and not before.stopped_by
    models = {"engine": None, "function": gc.PythonModel(make.respond)}
    found = make.answer(gc.resume(tmp_path / name, models[name]))
    made_with = json.loads((BEGUN / "made-with.json").read_text())
    # By other libraries or another instruction set the last digits are others, and so are draws that follow from them.
    if all(value == made_with[key] for key, value in provenance().items() if key not in ("graincal", "commit", "compiler")):
        for key, values in expected.items():
            np.testing.assert_array_equal(found[key], values, err_msg=key)
    else:
        np.testing.assert_array_equal(found["ids"][: before.evaluations], expected["ids"][: before.evaluations])
