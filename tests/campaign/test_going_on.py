"""What ends a run says the command that goes on with it."""

import shlex

import pytest

from graincal.campaign import Calibration, Experiment
from graincal.campaign.found.next_command import next_command
from graincal.campaign.found.status import status
from graincal.campaign.run.breaking_off import said_how_to_go_on
from graincal.campaign.stored.store import LOOK
from graincal.data import InputError

from . import hyperbola
from .hyperbola import write_calibration

GIVES_UP = """
from concurrent.futures import Executor, Future

class GivesUp(Executor):
    def submit(self, function, *arguments, **named):
        future = Future()
        future.set_exception(RuntimeError("no more workers"))
        return future

def gives_up():
    return GivesUp()
"""


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
    assert call("status", folder).out.endswith(f"go on with:{command[1:]}\n") and status(folder)["next_command"] == command.strip()
    before = status(folder)["evaluations"]
    assert call(*shlex.split(command)[1:]).code == 0 and status(folder)["evaluations"] > before


def test_a_limit_that_nobody_set_is_doubled_too():
    asked = Calibration(hyperbola.SPACE, (Experiment("drained", hyperbola.model(), hyperbola.reference()),))
    assert next_command("campaign", asked, "max_evaluations") == "graincal resume campaign --max-evaluations 120"
    assert next_command("campaign", asked, "posterior_shift") is None and next_command("campaign", asked, None) == "graincal resume campaign"


def test_what_keeps_it_from_going_on_by_itself_says_the_command_too(call, tmp_path):
    (tmp_path / "executors.py").write_text(GIVES_UP)
    folder = tmp_path / "my campaign"
    called = call("calibrate", write_calibration(tmp_path, ("[run]", '[run]\nexecutor = "executors:gives_up"')), "-o", folder)
    assert called.code == 1 and "it gave up an evaluation" in called.err
    assert called.err.endswith(f"All that was finished is stored; when this is mended, go on with:\n  graincal resume {shlex.quote(str(folder))}\n")


def test_a_library_that_breaks_off_says_the_command_too(call, tmp_path):
    (tmp_path / "executors.py").write_text(GIVES_UP)
    folder = tmp_path / "a library"
    file = write_calibration(tmp_path, ("[run]", '[run]\nexecutor = "executors:gives_up"'))
    called = call("explore", file, "--runs", 4, "-o", folder)
    assert called.code == 1 and called.err.endswith(f"go on with:\n  graincal resume {shlex.quote(str(folder))}\n")


def test_a_first_look_leaves_the_command_to_its_campaign(call, tmp_path):
    folder = tmp_path / "campaign"
    assert call("calibrate", write_calibration(tmp_path), "-o", folder, "-q").code == 0
    for of, said in (
        (folder / LOOK, "no more workers"),
        (folder, f"no more workers\nAll that was finished is stored; when this is mended, go on with:\n  graincal resume {folder}"),
    ):
        with pytest.raises(InputError) as raised, said_how_to_go_on(of):
            raise InputError("no more workers")
        assert str(raised.value) == said


def test_a_library_says_how_its_runs_are_used(call, tmp_path):
    folder = tmp_path / "a library"
    called = call("explore", write_calibration(tmp_path), "--runs", 4, "-o", folder)
    assert called.code == 0
    assert called.out.endswith(f"  graincal calibrate CALIBRATION.toml --runs {shlex.quote(str(folder))} -o NEW_FOLDER\n")


def test_a_limit_that_is_no_number_is_refused(call, tmp_path):
    called = call("calibrate", write_calibration(tmp_path), "-o", tmp_path / "campaign", "--max-evaluations", "many")
    assert called.code == 1 and "--max-evaluations must be a whole number or false, not many." in called.err
    assert not (tmp_path / "campaign").exists()


def test_a_function_of_a_references_rows_does_not_go_to_another_value(call, tmp_path):
    called = call("explore", write_calibration(tmp_path), "--runs", 4, "--to", 0.15, "-o", tmp_path / "library")
    assert called.code == 1 and "leave --to out" in called.err and not (tmp_path / "library").exists()
