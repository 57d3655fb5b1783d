"""What ends a run says the command that goes on with it."""

import shlex

import pytest

from graincal.campaign.found.status import status

from .hyperbola import write_calibration


@pytest.mark.parametrize(
    ("change", "options", "ended_by", "then"),
    [
        (("max_iterations = 3", "max_iterations = 2"), (), "max_iterations", "--max-iterations 4"),
        (("", ""), ("--max-evaluations", 45), "max_evaluations", "--max-evaluations 90"),
    ],
)
def test_a_limit_that_ended_it_is_named_with_the_command_that_goes_on(call, tmp_path, change, options, ended_by, then):
    folder = tmp_path / "my campaign"
    called = call("calibrate", write_calibration(tmp_path, change), "-o", folder, *options)
    assert called.code == 0 and status(folder)["stopped_by"] == ended_by
    *_, said, command = called.out.splitlines()
    assert said == "Go on with:" and command == f"  graincal resume {shlex.quote(str(folder))} {then}"
    before = status(folder)["evaluations"]
    assert call(*shlex.split(command)[1:]).code == 0 and status(folder)["evaluations"] > before


def test_a_limit_that_is_no_number_is_refused(call, tmp_path):
    called = call("calibrate", write_calibration(tmp_path), "-o", tmp_path / "campaign", "--max-evaluations", "many")
    assert called.code == 1 and "--max-evaluations must be a whole number or false, not many." in called.err
    assert not (tmp_path / "campaign").exists()
