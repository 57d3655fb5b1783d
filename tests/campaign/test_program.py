"""A whole calibration of a program: what it finds, what it keeps, and that it survives what happens to programs and to graincal itself."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from uuid import uuid4

import numpy as np
import pytest
from models.programs import ends, running

import graincal as gc
from graincal.campaign.file.config import read_calibration
from graincal.campaign.found.status import status
from graincal.campaign.stored.store import Store
from graincal.data import InputError

EXAMPLE = Path(__file__).parents[2] / "examples" / "c_program"

PROGRAM = """
import sys, time
a, b = map(float, sys.argv[1:3])
time.sleep(WAITS)
with open("curve.csv", "w") as file:
    file.write("eps_a,ratio\\n")
    for k in range(12):
        e = k / 100
        file.write(f"{e!r},{1 + a * e / (b + e)!r}\\n")
"""

FILE = """
[parameters]
a = { range = [1, 4] }
b = { range = [0.001, 0.05] }

[[experiment]]
name        = "test"
observables = { stress_ratio = { relative_error = 0.01 } }
reference   = { file = "reference.csv", strain = "logarithmic" }

[experiment.model]
kind       = "command"
command    = [PYTHON, "-I", "-S", "program.py", "{{ a }}", "{{ b }}", "MARK"]
link       = ["program.py"]
output     = { file = "curve.csv", columns = { axial_strain = "eps_a", stress_ratio = "ratio" } }
time_limit = 60

[filter]
method = "iterative-bayesian"
alpha  = 4

[stop]
max_iterations = 2

[run]
workers = 2
"""


def write(folder, program=PROGRAM, waits=0.0, mark="mark", replace=()):
    """A calibration file with its program and reference, in a folder."""
    strain = np.arange(1, 11) / 100
    rows = [f"{e!r},{1 + 3 * e / (0.01 + e)!r}" for e in map(float, strain)]
    (folder / "reference.csv").write_text("\n".join(["axial_strain,stress_ratio", *rows, ""]))
    (folder / "program.py").write_text(program.replace("WAITS", repr(waits)))
    text = FILE.replace("PYTHON", f'"{sys.executable}"').replace("MARK", mark)
    for old, new in replace:
        assert old in text
        text = text.replace(old, new)
    (folder / "calibration.toml").write_text(text)
    return folder / "calibration.toml"


def calibrate(file, folder):
    from graincal.campaign.run.running import begin

    return begin(read_calibration(file), folder)


def test_the_example_in_c_finds_what_made_its_reference(tmp_path, call, fewer_draws):
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        pytest.skip("there is no C compiler (cc or gcc) to build the example with")
    shutil.copytree(EXAMPLE, tmp_path / "example")
    subprocess.run([compiler, "-O2", "-o", "simulate", "simulate.c"], cwd=tmp_path / "example", check=True)
    checked = call("check", tmp_path / "example" / "calibration.toml", "--run")
    assert "The first sample in" in checked.out and "0 to 0." in checked.out and checked.code == 0
    file = tmp_path / "example" / "calibration.toml"
    file.write_text(file.read_text().replace("max_evaluations = 60", "max_evaluations = 30"))
    result = calibrate(file, tmp_path / "campaign")
    assert not result.failures
    assert result.answer.theta == pytest.approx([3.1, np.log10(0.012), 0.35], rel=0.05)
    assert not list((tmp_path / "campaign" / "evaluations").iterdir())


def test_failures_are_outcomes_and_their_folders_are_kept(tmp_path):
    file = write(tmp_path, PROGRAM.replace("time.sleep", "a > 3.5 and sys.exit(9)\ntime.sleep"))
    result = calibrate(file, tmp_path / "campaign")
    assert 0 < result.failures < result.evaluations
    (kind, reason, count), *others = result.failure_kinds()
    assert kind == "exit_code" and count == result.failures and not others
    kept = sorted(int(each.name) for each in (tmp_path / "campaign" / "evaluations").iterdir())
    assert kept == np.flatnonzero(result.failed).tolist()


def test_one_experiment_of_several_has_a_folder_of_its_own(tmp_path):
    file = write(tmp_path, replace=[("time_limit = 60", 'time_limit = 60\nkeep = "all"')])
    text = file.read_text()
    second = text[text.index("[[experiment]]") : text.index("[filter]")].replace('"test"', '"another test"')
    file.write_text(text.replace("[filter]", second + "[filter]"))
    calibrate(file, tmp_path / "campaign")
    found = tmp_path / "campaign" / "evaluations"
    assert sorted(each.name for each in found.iterdir()) == ["another_test", "test"]
    assert (found / "test" / "00000" / "attempt-0" / "curve.csv").exists() and (found / "another_test" / "00009" / "attempt-0").exists()


def test_a_campaign_none_of_whose_evaluations_can_be_started_stops_and_goes_on_when_that_is_mended(tmp_path, monkeypatch):
    (tools := tmp_path / "tools").mkdir()
    file = write(tmp_path, replace=[(f'"{sys.executable}", "-I"', '"simulator", "-I"')])
    folder = tmp_path / "campaign"
    with pytest.raises(InputError, match='experiment "test": no evaluation could be started: there is no program simulator in PATH, which is'):
        calibrate(file, folder)
    assert Store.open(folder).counts() == {"samples": 8, "evaluated": 0, "failed": 0, "stopped": 0}
    (tools / "simulator").symlink_to(sys.executable)
    monkeypatch.setenv("PATH", f"{tools}:{os.environ['PATH']}")
    assert not gc.resume(folder).failures


def test_what_ran_in_one_experiment_is_kept_where_nothing_can_be_started_in_another(tmp_path, monkeypatch):
    (tools := tmp_path / "tools").mkdir()
    file = write(tmp_path)
    text = file.read_text()
    second = (
        text[text.index("[[experiment]]") : text.index("[filter]")]
        .replace('"test"', '"another test"')
        .replace(f'"{sys.executable}", "-I"', '"simulator", "-I"')
    )
    file.write_text(text.replace("[filter]", second + "[filter]"))
    folder = tmp_path / "campaign"
    for _ in range(2):
        with pytest.raises(InputError, match='experiment "another test": no evaluation could be started: there is no program simulator'):
            gc.resume(folder) if folder.exists() else calibrate(file, folder)
        assert [attempts for _, _, attempts, _ in Store.open(folder).runs()] == [1, 0] * 8
    (tools / "simulator").symlink_to(sys.executable)
    monkeypatch.setenv("PATH", f"{tools}:{os.environ['PATH']}")
    assert not gc.resume(folder).failures


def test_a_file_that_a_program_is_given_and_that_was_changed_is_said(tmp_path):
    file = write(tmp_path)
    folder = tmp_path / "campaign"
    calibrate(file, folder)
    (tmp_path / "program.py").write_text(PROGRAM.replace("WAITS", "0.0") + "\n# changed\n")
    gc.resume(folder, max_iterations=3, error=False, error_increment=False, s=False, gl_error_increment=False)
    assert "program.py: this code was changed" in (folder / "log.txt").read_text()


def start(file, folder, *options):
    command = [sys.executable, "-c", "from graincal.cli import main; main()", *options, str(file), "-o", str(folder)] if options else []
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def test_killed_with_programs_under_way_it_leaves_none_and_goes_on_to_the_same_answer(tmp_path):
    mark, folder = uuid4().hex, tmp_path / "campaign"
    file = write(tmp_path, waits=0.4, mark=mark)
    process = start(file, folder, "calibrate", "-q")
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline and not (len(running(mark)) >= 2 and folder.exists() and status(folder)["evaluations"] >= 2):
        time.sleep(0.02)
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert ends(mark, 5)
    left = [each.name for each in (folder / "evaluations").iterdir()]
    resumed = gc.resume(folder)
    assert left and not list((folder / "evaluations").iterdir())
    # A controller that was killed counts as no attempt.
    assert {attempts for _, _, attempts, _ in Store.open(folder).runs()} == {1}
    (whole := tmp_path / "whole").mkdir()
    uninterrupted = calibrate(write(whole, waits=0.0, mark=mark), whole / "campaign")
    np.testing.assert_array_equal(resumed.samples, uninterrupted.samples)
    np.testing.assert_array_equal(resumed.errors, uninterrupted.errors)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_asked_to_end_with_programs_under_way_it_leaves_none(tmp_path, number):
    mark, folder = uuid4().hex, tmp_path / "campaign"
    process = start(write(tmp_path, waits=100.0, mark=mark), folder, "calibrate", "-q")
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline and len(running(mark)) < 2:
        time.sleep(0.02)
    process.send_signal(number)
    assert process.wait(30) == (130 if number == signal.SIGINT else 143)
    assert ends(mark, 2) and status(folder)["evaluations"] == 0 and not Store.open(folder).failure_kinds()
    assert not list((folder / "evaluations").iterdir())


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ('"program.py"]', '"program.py"]\ntemplates = { "../x" = "program.py" }', 'model.templates is "../x", and the name of a file within the folder of an evaluation was expected.'),
        ('file = "curve.csv"', 'file = "/etc/passwd"', 'model.output.file is "/etc/passwd", and the name of a file within the folder of an evaluation, or "-" for what is printed, was expected.'),
        ("time_limit = 60", "time_limit = 0", "model.time_limit must be a number of seconds above 0, not 0."),
        ("time_limit = 60", 'keep = "some"', 'model.keep must be "failed", "all" or "none", not "some".'),
        ("time_limit = 60", "retry_exit_codes = [0]", "model.retry_exit_codes has 0, which success_exit_codes has too, and each exit code was expected to mean one thing."),
        ("time_limit = 60", 'delimiters = ["<", ">"]', 'model.delimiters is ["<", ">"], and two that differ, of two signs or more each, were expected, such as ["<<", ">>"].'),
        ("time_limit = 60", "timelimit = 60", "model.timelimit is not a key that is known here (did you mean \"time_limit\"?)"),
        ('axial_strain = "eps_a", ', "", "output.columns has no axial_strain, which is the control of the experiment"),
        ('stress_ratio = "ratio"', 'stress_ratio = { column = "ratio", unit = "furlong" }', 'model.output.columns.stress_ratio.unit is "furlong", and one of -, %,'),
        ('stress_ratio = "ratio"', 'strength = "ratio"', "stress_ratio is not an observable of the model"),
        ('stress_ratio = "ratio" }', 'stress_ratio = "ratio" }, where = "stage"', 'model.output.where is "stage", and an expression of columns such as "stage == 2" was expected: it compares nothing.'),
        ('"{{ b }}"', '"{{ c }}"', "command, argument 5 names c, which is no parameter and not derived, and some of a, b were expected."),
    ],
)  # fmt: skip
def test_a_mistake_is_one_sentence_with_the_key(tmp_path, old, new, sentence):
    with pytest.raises(InputError, match=re.escape(sentence)) as refused:
        read_calibration(write(tmp_path, replace=[(old, new)]))
    assert str(refused.value).startswith(f'{tmp_path / "calibration.toml"}: experiment "test"') and "\n" not in str(refused.value)


def test_check_runs_nothing_of_the_user_s_and_with_run_it_draws_what_was_read(tmp_path, call):
    file = write(
        tmp_path,
        PROGRAM + f"open({str(tmp_path / 'ran')!r}, 'w')\n",
        replace=[("time_limit = 60", 'time_limit = 60\ntemplates = { "case.in" = "case.in.template" }')],
    )
    (tmp_path / "case.in.template").write_text("a {{ a }}\n")
    checked = call("check", file, "--plot", tmp_path / "one.png")
    assert checked.code == 0 and not (tmp_path / "ran").exists()
    assert re.search(
        r'Inputs of the first sample in "test":\n  a = [\d.]+, b = [\d.]+\n  \S+ -I -S program.py \S+ \S+ mark\n  program.py is a link to \S+\n  case.in:\n    a [\d.]+\n',
        checked.out,
    )
    ran = call("check", file, "--run", "--plot", tmp_path / "two.png")
    assert ran.code == 0 and (tmp_path / "ran").exists() and re.search(r"stress_ratio +\S+  1\.\d+ to \d.*\n +reference +\S+", ran.out)
    assert (tmp_path / "two.png").stat().st_size > (tmp_path / "one.png").stat().st_size
    (tmp_path / "program.py").write_text("print('what is wrong'); raise SystemExit(3)")
    failed = call("check", file, "--run")
    assert "failed, exit_code: the program ended with the exit code 3" in failed.out and "    what is wrong" in failed.out
    assert "one of them was expected" in call("check", file, "--run", "--json").err


def test_runs_of_a_program_serve_another_calibration_of_it_whatever_its_limits(tmp_path):
    file = write(tmp_path)
    calibrate(file, tmp_path / "campaign")
    posterior = [('method = "iterative-bayesian"\nalpha  = 4', ""), ("max_iterations = 2", "max_evaluations = 11")]
    file = write(tmp_path, replace=[*posterior, ("time_limit = 60", "time_limit = 50\nmemory = 1e9")])
    known = read_calibration(file, [tmp_path / "campaign"]).known
    assert len(known) == 16 and "program.py '{{ a }}' '{{ b }}' mark" in known.sources[0]
    with pytest.raises(InputError, match="they differ in command"):
        read_calibration(write(tmp_path, mark="other", replace=posterior), [tmp_path / "campaign"])


def test_a_store_has_all_of_a_program_again(tmp_path):
    file = write(
        tmp_path,
        replace=[
            (
                "time_limit = 60",
                'memory = 1e9\ncores = 2\nmax_at_once = 1\nscratch = "/tmp"\nsuccess_exit_codes = [0, 4]\nderived = { c = "a + b" }\nparameters_file = "p.json"',
            )
        ],
    )
    calibration = read_calibration(file)
    with_store = Store.create(calibration, tmp_path)
    with_store.close()
    store = Store.open(tmp_path)
    assert store.keeps(calibration) and store.calibration.experiments[0].model.described() == calibration.experiments[0].model.described()
