"""Where a campaign runs is no part of what was asked: another number of workers is taken, and is no other campaign."""

import json
import shutil

import numpy as np
import pytest

import graincal as gc
from graincal.campaign.file.examination import examine
from graincal.campaign.found.status import status
from graincal.cli import main

from .hyperbola import THE_PAPERS, write_calibration

POSTERIOR = 'method = "posterior"\nfirst_batch = 20\nbatch = 6\nahead = 1'
OF_POSTERIOR = "s = false\ngl_error_increment = false\nerror = false\nerror_increment = false\n"


@pytest.fixture(scope="module")
def begun(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    with pytest.raises(SystemExit):
        main(["calibrate", str(write_calibration(folder, ("= 3\ns", "= 1\ns"))), "-o", str(folder / "campaign"), "--quiet"])
    return folder


@pytest.fixture
def campaign(begun, tmp_path):
    return shutil.copytree(begun / "campaign", tmp_path / "campaign")


def edit(campaign, old, new):
    copy = campaign / "campaign.toml"
    assert old in copy.read_text()
    copy.write_text(copy.read_text().replace(old, new))


def test_workers_that_are_asked_for_are_taken_and_logged(call, campaign):
    called = call("resume", campaign, "--workers", "2", "--max-iterations", "2")
    log = (campaign / "log.txt").read_text()
    assert called.code == 0 and log.count("Goes on with workers = 2, where it was begun with 1.") == 1 and ", 2 workers." in log


def test_workers_that_are_edited_are_taken_and_logged_and_seeds_are_not(call, campaign, begun):
    edit(campaign, "workers = 1", "workers = 2\nexpected_seconds = 0.5")
    called = call("resume", campaign, "--max-iterations", "2")
    log = (campaign / "log.txt").read_text()
    assert called.code == 0 and "was changed" not in called.out
    assert "Goes on with workers = 2, where it was begun with 1." in log and "run.expected_seconds was changed: it says how a campaign begins" in log
    whole = shutil.copytree(begun / "campaign", campaign.parent / "whole")
    assert call("resume", whole, "--max-iterations", "2", "-q").code == 0
    np.testing.assert_array_equal(gc.Result.read(campaign).iterations[1].weights, gc.Result.read(whole).iterations[1].weights)
    # What was edited stays, and is taken again.
    assert "workers = 2" in (campaign / "campaign.toml").read_text() and "was changed" not in call("resume", campaign, "--max-iterations", "3").out
    assert (campaign / "log.txt").read_text().count("Goes on with workers = 2") == 2
    edit(whole, "seed = 3", "seed = 4")
    assert "was changed in run.seed; what the store holds is used" in " ".join(call("resume", whole).out.split())


def test_what_it_cannot_say_is_a_sentence(call, campaign):
    edit(campaign, "workers = 1", 'workers = "many"')
    called = call("resume", campaign, "--max-iterations", "2")
    assert called.code == 1 and called.err == f'{campaign / "campaign.toml"}: run.workers must be a whole number above 0, or "all", not "many".\n'


def test_the_same_calibration_elsewhere_is_the_same(call, begun, tmp_path):
    folder = shutil.copytree(begun, tmp_path / "copied")
    file = begun / "calibration.toml"
    kept = file.read_text()
    file.write_text(kept.replace("workers = 1", "workers = 2\nexpected_seconds = 3"))
    called = call("calibrate", file, "-o", folder / "campaign")
    file.write_text(kept)
    assert called.code == 1 and "this calibration was begun here before, go on with it by: graincal resume" in called.err


def test_how_many_runs_fill_the_ranges_is_decided_once(call, tmp_path):
    file = write_calibration(
        tmp_path,
        (THE_PAPERS, 'method = "posterior"'),
        (OF_POSTERIOR, "posterior_shift = false\nmax_evaluations = 30\n"),
        ("max_iterations = 3\n", ""),
        ("workers = 1", "workers = 1\nexpected_seconds = 60"),
    )
    assert call("calibrate", file, "-o", tmp_path / "campaign", "-q").code == 0
    for instead in ("expected_seconds = 100", ""):
        file.write_text(file.read_text().replace("expected_seconds = 60", instead))
        assert "this calibration was begun here before" in call("calibrate", file, "-o", tmp_path / "campaign").err
    file.write_text(file.read_text().replace("seed = 3", "seed = 4"))
    assert "this folder holds another campaign" in call("calibrate", file, "-o", tmp_path / "campaign").err


@pytest.mark.parametrize(
    ("replacements", "said"),
    [
        ([], "64 workers are more than the 20 samples of an iteration: 44 of them would have no work; a larger alpha under [filter] gives them some."),
        (
            [(THE_PAPERS, POSTERIOR), (OF_POSTERIOR, "")],
            "64 workers are more than the 12 runs that are under way at once after the first batch: 52 of them would have no work; a larger batch, or ahead, under [filter] gives them some.",
        ),
        ([(THE_PAPERS, POSTERIOR.replace("batch = 6", "batch = 32").replace("first_batch = 20", "first_batch = 40")), (OF_POSTERIOR, "")], None),
    ],
)
def test_check_says_how_many_workers_would_idle(call, tmp_path, replacements, said):
    file = write_calibration(tmp_path, ("workers = 1", "workers = 64"), *replacements)
    notes = {note.code: note.sentence for note in examine(file).notes}
    assert notes.get("more-workers-than-runs") == said
    assert (said or "Expect") in " ".join(call("check", file).out.split())


def test_failures_are_counted_by_kind(call, tmp_path):
    file = write_calibration(tmp_path, ("= 3\ns", "= 1\ns"), ('"soil:respond"', '"soil:fails", timeout = 0.5'))
    (tmp_path / "soil.py").write_text(
        (tmp_path / "soil.py").read_text()
        + "\nimport time\nfrom graincal import Failure\n\ndef fails(theta):\n    if theta[0] > 0.9:\n        time.sleep(60)\n    if theta[0] > 0.7:\n        return Failure('infeasible', 'no such soil.')\n    return respond(theta)\n"
    )
    assert call("calibrate", file, "-o", tmp_path / "campaign", "-q", "--workers", "2").code == 0
    found = json.loads(call("status", tmp_path / "campaign", "--json").out)
    assert set(found["failure_kinds"]) <= {"infeasible", "timed_out", "error"} and found["failure_kinds"]["timed_out"] >= 1
    assert sum(found["failure_kinds"].values()) == found["failures"] == status(tmp_path / "campaign")["failures"] > 0
