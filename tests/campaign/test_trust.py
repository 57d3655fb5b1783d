"""A campaign in a folder of another user: what it would run is shown, and run by a person's word alone."""

import os
import shutil

import pytest

import graincal as gc
from graincal.campaign.stored import code
from graincal.cli import main

from .hyperbola import model, write_calibration


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    begun = tmp_path_factory.mktemp("trust")
    with pytest.raises(SystemExit):
        main(["calibrate", str(write_calibration(begun, ("= 3\ns", "= 1\ns"))), "-o", str(begun / "campaign"), "--quiet"])
    return begun


@pytest.fixture
def strangers(folder, tmp_path, monkeypatch):
    """As its owner is seen by another user; who runs the tests may not be able to give it away."""
    monkeypatch.setattr(code.os, "getuid", lambda: os.stat(folder).st_uid + 1)
    return shutil.copytree(folder / "campaign", tmp_path / "campaign")


def test_what_it_would_run_is_shown_and_needs_a_word(call, folder, strangers):
    refused = call("resume", strangers, "--max-iterations", "2")
    assert refused.code == 1 and "this campaign belongs to another user (" in refused.err and refused.err.count("\n") == 1
    assert refused.err.endswith(f"to go on with it runs code: soil:respond of {folder}. Where you trust that, go on by --trust, or trust=True in Python.\n")
    with pytest.raises(gc.InputError, match="belongs to another user"):
        gc.resume(strangers, max_iterations=2)
    assert gc.Result.read(strangers).evaluations == 20
    assert call("resume", strangers, "--max-iterations", "2", "--trust", "-q").code == 0 and gc.Result.read(strangers).evaluations == 40
    assert gc.resume(strangers, trust=True, max_iterations=3).evaluations == 60


def test_what_runs_no_code_of_it_needs_none(call, strangers):
    for arguments in (["status"], ["report", "-o", strangers.parent / "report.html"], ["export", "--to", "csv"]):
        assert call(arguments[0], strangers, *arguments[1:]).code == 0
    assert gc.resume(strangers, model(), max_iterations=2).evaluations == 40


def test_one_s_own_needs_none(call, folder, tmp_path):
    campaign = shutil.copytree(folder / "campaign", tmp_path / "campaign")
    assert call("resume", campaign, "--max-iterations", "2", "-q").code == 0
