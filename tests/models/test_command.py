"""A program as a model: what it is given, what it writes, and each way in which it may come to nothing. Whatever it does, nothing of it is left."""

import json
import os
import pickle
import shutil
import signal
import stat
import subprocess
import sys
import textwrap
import threading
import time
from dataclasses import replace
from pathlib import Path
from uuid import uuid4

import numpy as np
import pytest

from graincal import Failure, InputError, Response
from graincal.execution import Scheduler
from graincal.models.command import program
from graincal.models.output import STANDARD_OUTPUT, Output

from .programs import AT, OUTPUT, PYTHON, WRITES, ends, model, outcome, outcomes, running, samples, shell


def test_a_program_is_evaluated_at_the_reference_s_control():
    first, second = outcomes(model(), 2.0, 3.0)
    np.testing.assert_array_equal(first.control, AT)
    np.testing.assert_allclose(first.values["stress_ratio"], 1 + 2 * AT, rtol=1e-14)
    np.testing.assert_allclose(second.values["stress_ratio"], 1 + 3 * AT, rtol=1e-14)
    assert first.details["seconds"] > 0 and first.details["exit_code"] == 0


def test_it_can_be_sent_to_another_process():
    (task,) = model().tasks(samples(2.0), AT)
    sent = pickle.loads(pickle.dumps(task.work))
    assert sent.key == task.work.key and isinstance(sent(task.argument), Response)


def test_standard_output_may_be_the_declared_output():
    declared = Output(OUTPUT.columns, STANDARD_OUTPUT)
    found = outcome(shell("echo noise >&2; echo 'eps_a [%],ratio'; for k in 0 5 11; do echo $k,$k; done", output=declared))
    np.testing.assert_allclose(found.values["stress_ratio"], 100 * AT)
    assert outcome(shell("echo only this >&2", output=declared)).kind == "no_output"


# What a program is given.


def test_no_shell_and_every_digit(tmp_path):
    made = model(
        command=("printf", "%s\n", "$HOME; `true` {{ a }} {{ twice }}"),
        output=Output(OUTPUT.columns, STANDARD_OUTPUT),
        derived={"twice": "2 * a"},
        root=tmp_path,
        keep="all",
    )
    outcome(made, 0.1 + 0.2)
    assert (tmp_path / "00000" / "attempt-0" / "standard-output.txt").read_text() == "$HOME; `true` 0.30000000000000004 0.6000000000000001\n"


def test_templates_links_environment_and_a_file_of_parameters(tmp_path):
    (tmp_path / "case.template").write_text("E << E >>\r\n{{ as it is }} {% too %}\r\n<<% if a > 1 %>>large<<% else %>>small<<% endif %>>\r\n\r\n", newline="")
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "grains.txt").write_text("grains")
    script = "cat sub/case.in grains.txt data/grains.txt > seen; printf '%s' \"$GIVEN\" > environment; echo 'eps_a [%],ratio' > curve.csv; for k in 0 5 11; do echo $k,$k; done >> curve.csv"
    options = {
        "templates": {"sub/case.in": "case.template"},
        "delimiters": ("<<", ">>"),
        "link": ("data", "data/grains.txt"),
        "environment": {"GIVEN": "E={{ E }}"},
        "derived": {"E": "10**a"},
    }
    for name, expected in (("p.json", '{\n  "a": 2.0,\n  "E": 100.0\n}\n'), ("p.csv", "a,E\n2.0,100.0\n"), ("p.table", "a E\n2.0 100.0\n")):
        root = tmp_path / name
        assert isinstance(outcome(shell(script, folder=tmp_path, root=root, keep="all", parameters_file=name, **options)), Response)
        folder = root / "00000" / "attempt-0"
        assert (folder / "seen").read_bytes() == b"E 100.0\r\n{{ as it is }} {% too %}\r\nlarge\r\n\r\ngrainsgrains"
        assert (folder / "environment").read_text() == "E=100.0" and (folder / name).read_text() == expected
        if name.endswith("json"):
            assert json.loads((folder / name).read_text()) == {"a": 2.0, "E": 100.0}


def test_a_derived_value_that_overflows_is_a_failure():
    found = outcome(model(WRITES, "{{ E }}", derived={"E": "10**a"}), 400.0)
    assert found.kind == "not_finite" and "E = 10**a is inf at a = 400.0" in found.reason


def test_a_template_sees_values_and_nothing_else(tmp_path):
    for text in ("{{ a.__class__.__mro__ }}", "{% include 'other' %}", "{{ 1 / 0 }}", "{{ a.append(1) }}", "{{ 9 ** (9 ** 9) }}", "{{ 'a' * 99999999999 }}"):
        (tmp_path / "t").write_text(text)
        found = outcome(model(templates={"case.in": "t"}, folder=tmp_path))
        assert found.kind == "not_started" and found.reason.startswith("template case.in could not be filled in")


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"environment": {"X": "{{ b }}"}}, "environment.X names b, which is no parameter and not derived, and some of a were expected"),
        ({"derived": {"b": "10**c"}}, "derived.b is"),
        ({"derived": {"a": "1"}}, "derived.a is the name of a parameter"),
        ({"derived": {"b": "a.real"}}, "a point between names"),
        ({"templates": {"x": "nowhere"}}, "nowhere: there is no such file, and a template was expected"),
        ({"link": ("nowhere",)}, "link names nowhere, and there is no"),
        ({"environment": {"X": "{{ a"}}, "environment.X: line 1 cannot be read as a template"),
    ],
)
def test_what_no_sample_can_mend_is_said_before_anything_is_run(options, expected, tmp_path):
    with pytest.raises(InputError, match=expected):
        model(folder=tmp_path, **options).check(AT, samples())


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"templates": {"curve.csv": "t"}}, "curve.csv is the name of two files"),
        ({"templates": {"./curve.csv": "t"}}, "curve.csv is the name of two files"),
        ({"link": ("some/data",), "templates": {"data/case.in": "t"}}, "data/case.in lies within data"),
        ({"link": ("data",), "parameters_file": "data/sub/p.json"}, "data/sub/p.json lies within data"),
        ({"link": ("notes/printed.txt",)}, "printed.txt is the name of a file that graincal writes"),
        ({"link": ("outcome.txt",)}, "outcome.txt is the name of a file that graincal writes"),
        ({"templates": {"../case.in": "t"}}, "../case.in leads out of the folder"),
    ],
)
def test_nothing_is_written_over_another_file_or_through_a_link(options, expected):
    with pytest.raises(InputError, match=expected):
        model(**options)


# How it may come to nothing.


@pytest.mark.parametrize(
    ("script", "kind", "said"),
    [
        ("exit 3", "exit_code", "exit code 3"),
        ("exit 137", "exit_code", "exit code 137"),
        ("kill -SEGV $$", "crashed", "SIGSEGV"),
        ("kill -TERM $$", "crashed", "SIGTERM"),
        ("kill -KILL $$", "lost", "killed from outside by SIGKILL"),
        ("true", "no_output", "wrote no file curve.csv"),
        (": > curve.csv", "no_output", "is empty"),
        ("mkdir curve.csv", "no_output", "wrote no file"),
        ("mkfifo curve.csv", "no_output", "wrote no file"),
        ("ln -s /etc/passwd curve.csv", "unreadable", "leads out of the folder"),
        ("echo words > curve.csv", "unreadable", ""),
        ("printf 'eps_a [%%],ratio\\n0,1\\n9,2\\n' > curve.csv", "incomplete", "0 to 0.09"),
        ("printf 'eps_a [%%],ratio\\n0,1\\n5,nan\\n11,2\\n' > curve.csv", "not_finite", "stress_ratio is nan"),
        ("echo the reason >&2; exit 1", "exit_code", "It printed last: the reason"),
        ("exit 42", "infeasible", "infeasible_exit_codes names"),
    ],
)
def test_each_kind_of_failure(script, kind, said):
    found = outcome(shell(script, limits={"infeasible_exit_codes": (42,)}))
    assert isinstance(found, Failure) and found.kind == kind and said in found.reason, found


def test_exit_codes_mean_what_is_declared(tmp_path):
    good = "printf 'eps_a [%%],ratio\\n0,1\\n11,2\\n' > curve.csv; exit 7"
    assert isinstance(outcome(shell(good, limits={"success_exit_codes": (0, 7)})), Response)
    # A licence that is not free: run again, until it is.
    found = list(
        _ended(
            shell(
                f"echo >> {tmp_path}/tried; test $(wc -l < {tmp_path}/tried) -ge 3 || exit 75; {good}",
                limits={"success_exit_codes": (7,), "retry_exit_codes": (75,)},
            )
        )
    )
    assert isinstance(found[0].outcome, Response) and found[0].attempts == 3


def _ended(model):
    scheduler = Scheduler(1)
    scheduler.submit(model.tasks(samples(2.0), AT))
    while scheduler.left:
        yield scheduler.next()
    scheduler.close()


def test_a_program_that_is_killed_from_outside_is_run_again_three_times(tmp_path):
    (ended,) = _ended(shell("kill -KILL $$", root=tmp_path))
    assert ended.outcome.kind == "lost" and ended.attempts == 4
    assert sorted(each.name for each in (tmp_path / "00000").iterdir()) == [f"attempt-{number}" for number in range(4)]


def test_a_program_that_is_not_there_is_named_with_the_path():
    found = outcome(model(command=("no-such-simulator",), environment={"PATH": "/here:/there"}))
    assert found.kind == "not_started" and "there is no program no-such-simulator in PATH, which is /here:/there" in found.reason


def test_what_a_program_is_not_told_is_known():
    told = model(command=("run", "{{ E }}", "{{ phi }}"), derived={"E": "10**log_E", "beside": "2 * nu"})
    assert told.unread(("log_E", "phi", "nu"), [0.1]) == ["nu"]
    assert replace(told, parameters_file="all.json").unread(("log_E", "phi", "nu"), [0.1]) == []


def test_a_program_that_is_not_at_its_path_is_named():
    found = outcome(model(command=("/nowhere/yade",)))
    assert found.kind == "not_started" and found.reason == "there is no program /nowhere/yade, or the one that its first line names is missing."
    assert "no program ./sim in the evaluation's folder" in outcome(model(command=("./sim",))).reason


def test_a_linked_program_runs_by_its_place_and_one_that_must_not_be_run_is_said(tmp_path):
    program = tmp_path / "sim"
    program.write_text("#!/bin/sh\nprintf 'eps_a [%%],ratio\\n0,1\\n11,2\\n' > curve.csv\n")
    refused = outcome(model(command=("./sim",), link=("sim",), folder=tmp_path))
    assert refused.kind == "not_started" and "Permission denied" in refused.reason
    program.chmod(0o755)
    assert isinstance(outcome(model(command=("./sim",), link=("sim",), folder=tmp_path)), Response)
    program.write_text("#!/no/such/interpreter\n")
    assert outcome(model(command=("./sim",), link=("sim",), folder=tmp_path)).kind == "not_started"


def test_a_program_that_takes_too_long_is_ended_though_it_hears_no_signal():
    mark = uuid4().hex
    found = outcome(shell(f"trap '' TERM; while :; do sleep 100; echo {mark}; done", limits={"time_limit": 0.3}))
    assert found.kind == "timed_out" and "0.3 s" in found.reason and ends(mark, 0)


def test_a_program_that_holds_too_much_memory_is_ended():
    found = outcome(model("held = []\nwhile True: held.append(bytearray(10**6))", limits={"memory": 100e6}))
    assert found.kind == "out_of_memory"


def test_memory_is_that_of_all_that_a_program_starts():
    held = "import time; held = bytearray(80 * 10**6); time.sleep(60)"
    starts = f"import subprocess, sys\nfor each in [subprocess.Popen([sys.executable, '-I', '-S', '-c', {held!r}]) for _ in range(3)]: each.wait()"
    assert outcome(model(starts, limits={"memory": 200e6})).kind == "out_of_memory"


def test_of_gigabytes_that_are_printed_the_last_are_kept(tmp_path):
    prints = "import sys\nfor k in range(300): sys.stdout.write('x' * 10**6)\nsys.stdout.write('\\nthe end\\n')\nsys.exit(1)"
    found = outcome(model(prints, root=tmp_path))
    assert found.kind == "exit_code" and found.reason.endswith("It printed last: the end")
    assert (tmp_path / "00000" / "attempt-0" / "printed.txt").stat().st_size == 64 * 1024


def test_what_is_printed_may_be_no_text():
    assert outcome(shell("printf '\\377\\000\\033[31m' ; exit 1")).kind == "exit_code"


FORKS = """
import os, signal, subprocess, sys, time
mark = sys.argv[1]
sleeps = [sys.executable, "-I", "-S", "-c", f"import signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN); time.sleep(600) # {mark}"]
subprocess.Popen(sleeps)
subprocess.Popen(sleeps, start_new_session=True)
if os.fork() == 0:
    os.setsid()
    if os.fork() == 0:
        subprocess.Popen(sleeps, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    os._exit(0)
time.sleep(float(sys.argv[2]))
"""
"""Starts others: in its group, in a session of their own, and as a daemon does."""


@pytest.mark.parametrize(("sleeps", "kind"), [("0.3", "no_output"), ("600", "timed_out")])
def test_what_a_program_starts_ends_with_it(sleeps, kind):
    mark = uuid4().hex
    found = outcome(model(FORKS, mark, sleeps, limits={"time_limit": 2.0}))
    assert found.kind == kind and ends(mark, 0)


MPI = ("mpirun", "--allow-run-as-root", "--oversubscribe", "-np", "2")
RANK = "rank = os.environ.get('OMPI_COMM_WORLD_RANK', os.environ.get('PMI_RANK', '0'))"


def _has_open_mpi():
    return shutil.which("mpirun") is not None and b"Open MPI" in subprocess.run(["mpirun", "--version"], capture_output=True).stdout


@pytest.mark.skipif(not _has_open_mpi(), reason="there is no mpirun of Open MPI, which starts the ranks of a parallel program")
def test_the_ranks_of_a_parallel_program_end_with_it(tmp_path):
    mark = uuid4().hex
    works = f"import os; {RANK}\nif rank == '0':\n" + textwrap.indent(WRITES, "    ")
    assert isinstance(outcome(model(command=(*MPI, *PYTHON, works, "{{ a }}"), cores=2)), Response)
    waits = f"import signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN); time.sleep(600) # {mark}"
    found = []
    thread = threading.Thread(target=lambda: found.append(outcome(model(command=(*MPI, *PYTHON, waits), cores=2, limits={"time_limit": 6.0}))))
    thread.start()
    deadline = time.monotonic() + 6
    # mpirun has the mark too.
    while len(running(mark)) < 3 and time.monotonic() < deadline:
        time.sleep(0.02)
    assert len(running(mark)) == 3
    thread.join()
    assert found[0].kind == "timed_out" and ends(mark, 0)


def test_evaluations_that_nobody_waits_for_any_more_end_at_once():
    mark = uuid4().hex
    scheduler = Scheduler(2)
    scheduler.submit(model(FORKS, mark, "600").tasks(samples(1.0, 2.0, 3.0), AT))
    while len(running(mark)) < 8:
        time.sleep(0.02)
    begun = time.monotonic()
    scheduler.close()
    assert time.monotonic() - begun < 5 and ends(mark, 3)


def test_a_program_whose_keeper_is_killed_is_lost_and_ends(monkeypatch):
    mark = uuid4().hex
    killed = []

    def kill():
        while not running(mark):
            time.sleep(0.02)
        while not (
            keepers := [each for each in running("keeper.py") if Path(f"/proc/{each}/stat").read_text().rpartition(")")[2].split()[1] == str(os.getpid())]
        ):
            time.sleep(0.02)
        for each in keepers:
            os.kill(each, signal.SIGKILL)
            killed.append(each)

    thread = threading.Thread(target=kill)
    thread.start()
    ended = program.run(program.Program((*PYTHON, f"import time; time.sleep(600) # {mark}"), Path.cwd(), dict(os.environ), 60))
    thread.join()
    assert ended.how == "lost" and killed and ends(mark, 5)


def test_nothing_is_left_when_the_owner_is_killed(tmp_path):
    mark = uuid4().hex
    script = tmp_path / "owner.py"
    script.write_text(
        textwrap.dedent(f"""
        import os
        from pathlib import Path
        from graincal.models.command import program
        program.run(program.Program({(*PYTHON, FORKS, mark, "600")!r}, Path({str(tmp_path)!r}), dict(os.environ), 600))
    """)
    )
    owner = subprocess.Popen([sys.executable, str(script)])
    while len(running(mark)) < 4:
        assert owner.poll() is None
        time.sleep(0.02)
    owner.kill()
    owner.wait()
    assert ends(mark, 5)


# Where it keeps its files.


def test_folders_are_for_the_user_alone_and_those_of_failures_are_kept(tmp_path):
    root = tmp_path / "evaluations"
    outcomes(shell("test $1 = 3.0 && exit 1; printf 'eps_a [%%],ratio\\n0,1\\n11,2\\n' > curve.csv", root=root), 1.0, 2.0, 3.0)
    assert [each.name for each in root.iterdir()] == ["00002"]
    kept = root / "00002" / "attempt-0"
    assert [stat.S_IMODE(each.stat().st_mode) for each in (root, root / "00002", kept)] == [0o700] * 3
    assert (kept / "outcome.txt").read_text().startswith("exit_code: the program ended with the exit code 1.")


@pytest.mark.parametrize(("keep", "kept"), [("all", ["00000", "00001"]), ("failed", ["00001"]), ("none", [])])
def test_what_is_kept(keep, kept, tmp_path):
    made = shell("test $1 = 1.0 || exit 1; printf 'eps_a [%%],ratio\\n0,1\\n11,2\\n' > curve.csv", root=tmp_path, keep=keep)
    outcomes(made, 1.0, 2.0)
    assert sorted(each.name for each in tmp_path.iterdir()) == kept


def test_the_last_hundred_are_kept(tmp_path, monkeypatch):
    monkeypatch.setattr("graincal.models.command.folders.MOST_KEPT", 3)
    outcomes(shell("exit 1", root=tmp_path), *range(6), workers=1)
    assert sorted(each.name for each in tmp_path.iterdir()) == ["00003", "00004", "00005"]
    # Of several attempts each counts.
    outcome(shell("exit 75", root=tmp_path, limits={"retry_exit_codes": (75,)}))
    assert [each.name for each in sorted(tmp_path.glob("*/*"))] == ["attempt-1", "attempt-2", "attempt-3"]


def test_scratch_runs_elsewhere_and_brings_the_declared_output_back(tmp_path, monkeypatch):
    (scratch := tmp_path / "scratch").mkdir()
    monkeypatch.setenv("NODE_DISK", str(scratch))
    (tmp_path / "kept").mkdir()
    found = outcome(
        model(
            WRITES + "open('large', 'w').write('x')\nimport os; open('where.txt', 'w').write(os.getcwd())",
            root=tmp_path / "kept",
            keep="all",
            scratch="$NODE_DISK",
        )
    )
    assert isinstance(found, Response) and not list(scratch.iterdir())
    assert sorted(each.name for each in (tmp_path / "kept" / "00000" / "attempt-0").iterdir()) == ["curve.csv", "outcome.txt", "printed.txt"]
    # A machine that does not see the campaign's folder.
    assert isinstance(outcome(model(root=tmp_path / "not" / "seen", keep="all", scratch="$NODE_DISK")), Response) and not (tmp_path / "not").exists()
    assert outcome(model(scratch="$NO_SUCH_NAME")).kind == "not_started" and outcome(model(scratch=str(tmp_path / "nowhere"))).kind == "not_started"


def test_without_a_folder_of_its_own_nothing_is_left(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    outcomes(model(), 1.0, 2.0)
    outcome(shell("exit 1"))
    assert not list(tmp_path.iterdir())


def test_what_a_killed_controller_left_is_removed_and_counts_as_no_attempt(tmp_path):
    (tmp_path / "00000" / "attempt-0").mkdir(parents=True)
    (tmp_path / "00001" / "attempt-0").mkdir(parents=True)
    (tmp_path / "00001" / "attempt-0" / "outcome.txt").write_text("finished\n")
    made = shell("exit 1").in_folder(tmp_path)
    outcome(made)
    assert sorted(str(each.relative_to(tmp_path)) for each in tmp_path.glob("*/*")) == ["00000/attempt-0", "00001/attempt-0"]


def test_a_folder_that_a_program_has_locked_is_no_trouble(tmp_path):
    outcome(shell("mkdir locked; touch locked/file; chmod 500 locked; printf 'eps_a [%%],ratio\\n0,1\\n11,2\\n' > curve.csv", root=tmp_path))
    shutil.rmtree(tmp_path, ignore_errors=True)
