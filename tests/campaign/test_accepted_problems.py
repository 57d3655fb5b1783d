"""A calibration that is begun in spite of problems says so for ever after."""

import json

import pytest

import graincal as gc
from graincal.campaign.stored.store import Store

from .hyperbola import THE_PAPERS, write_calibration

POSTERIOR = (
    (THE_PAPERS, 'method = "posterior"\nfirst_batch = 8'),
    ("max_iterations = 3\ns = false\ngl_error_increment = false\nerror = false\nerror_increment = false", "max_iterations = 1"),
)


@pytest.mark.parametrize("replacements", [[("max_iterations = 3", "max_iterations = 1")], POSTERIOR], ids=["the paper's method", "posterior"])
def test_problems_that_were_accepted_are_kept_and_reported(call, tmp_path, replacements):
    file, folder = write_calibration(tmp_path, *replacements), tmp_path / "campaign"
    rows = [line.split(",") for line in (tmp_path / "reference.csv").read_text().splitlines()]
    # q over σ3, and not σ1/σ3.
    (tmp_path / "reference.csv").write_text("\n".join(",".join(row) for row in [rows[0], *([e, str(float(r) - 1), v] for e, r, v in rows[1:])]) + "\n")
    refused = call("calibrate", file, "-o", folder)
    assert refused.code == 1 and "for there is 1 problem; correct the file, or go on in spite of it by --accept:" in refused.err and not folder.exists()
    assert call("calibrate", file, "-o", folder, "--accept", "--quiet").code == 0
    assert call("resume", folder, "--max-iterations", "2", "--quiet").code == 0
    (doubt,) = Store.open(folder).accepted
    assert doubt.code == "stress-ratio-low" and doubt.experiment == "drained"
    (said,) = [each for each in json.loads(call("status", folder, "--json").out)["remarks"] if each["code"] == "accepted-problems"]
    assert said["level"] == "condition" and said["numbers"]["problems"] == [doubt.as_json()]
    assert said["text"] in call("status", folder).out and "begun in spite of 1 problem" in (folder / "report.html").read_text()
    assert "accepted-problems" in {each.code for each in gc.Result.read(folder).remarks}


def test_what_has_no_problems_says_nothing_of_them(call, tmp_path):
    file, folder = write_calibration(tmp_path, ("max_iterations = 3", "max_iterations = 1")), tmp_path / "campaign"
    assert call("calibrate", file, "-o", folder, "--accept", "--quiet").code == 0
    assert Store.open(folder).accepted == () and json.loads(call("status", folder, "--json").out)["remarks"] == []
