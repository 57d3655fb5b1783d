"""A campaign whose evaluations run elsewhere is the same campaign: what [run] says of that, and the executor that it names."""

import json
import os
import shutil
import subprocess
import sys

import numpy as np
import pytest

import graincal as gc
from graincal.campaign.asked.place import Place
from graincal.campaign.run.elsewhere import _label
from graincal.campaign.stored.code import refuse_strangers_code
from graincal.campaign.stored.store import Store

from .hyperbola import THE_PAPERS, write_calibration

EXECUTORS = """
import os
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context

open(os.path.join(os.path.dirname(__file__), "imported"), "a").write("x")


def two_processes():
    return ProcessPoolExecutor(2, mp_context=get_context("spawn"))


def nothing():
    return 3


def breaks():
    raise OSError("no such cluster")
"""


def write(folder, run, *replacements):
    folder.mkdir(exist_ok=True)
    (folder / "executors.py").write_text(EXECUTORS)
    return write_calibration(folder, ("workers = 1", f"workers = 2\n{run}"), ("= 3\ns", "= 1\ns"), *replacements)


@pytest.mark.parametrize(
    ("run", "said"),
    [
        ('executor = "slurm"', 'run.executor must be "local", "parsl", or a function as "module:function", not "slurm".'),
        ('executor = "parsel"', 'run.executor must be "local", "parsl", or a function as "module:function", not "parsel" (did you mean "parsl"?).'),
        (
            'executor = "parsl"',
            'run.parsl is missing, and with executor = "parsl" a table [run.parsl] with provider = "local", "slurm", "pbs" or "lsf" was expected.',
        ),
        (
            'parsl = { provider = "local" }',
            'run.executor is missing, and with a table [run.parsl] executor = "parsl" was expected, or "local", which leaves that table aside.',
        ),
        ('executor = "parsl"\nparsl = { }', 'run.parsl.provider is missing, and "local", "slurm", "pbs" or "lsf" was expected.'),
        ('executor = "parsl"\nparsl = { provider = "slrum" }', 'run.parsl.provider must be "local", "slurm", "pbs" or "lsf", not "slrum"'),
        (
            'executor = "parsl"\nparsl = { provider = "local", partition = "fast" }',
            'run.parsl.partition is a key of clusters, and provider = "local" knows none of partition, account',
        ),
        (
            'executor = "parsl"\nparsl = { provider = "pbs" }',
            'run.parsl.cores_per_node is missing, and with provider = "pbs" a whole number above 0 was expected.',
        ),
        (
            'executor = "parsl"\nparsl = { provider = "lsf", cores_per_node = 4, qos = "short" }',
            'run.parsl.qos is a key of provider = "slurm", and not known with "lsf"; scheduler_options may say it.',
        ),
        (
            'executor = "parsl"\nparsl = { provider = "slurm", walltime = "90" }',
            'run.parsl.walltime must be hours, minutes and seconds such as "04:00:00", not "90".',
        ),
        (
            'executor = "parsl"\nparsl = { provider = "slurm", walltime = "00:01:00" }',
            'run.parsl.walltime is "00:01:00", and at least "00:02:00" was expected.',
        ),
        ('executor = "parsl"\nparsl = { provider = "slurm", partition = "a b" }', "run.parsl.partition must be one word of letters, digits and"),
        ('executor = "parsl"\nparsl = { provider = "slurm", max_blocks = 0 }', "run.parsl.max_blocks must be a whole number above 0, not 0."),
    ],
)
def test_what_run_cannot_say_is_a_sentence(call, tmp_path, run, said):
    file = write(tmp_path, run)
    called = call("check", file)
    assert called.code == 1 and called.err.startswith(f"{file}: {said}")


def test_check_imports_no_executor_and_asks_for_no_cluster(call, tmp_path):
    assert "imported" not in call("check", write(tmp_path, 'executor = "executors:two_processes"')).out
    assert not (tmp_path / "imported").exists()
    assert call("check", write(tmp_path, 'executor = "parsl"\nparsl = { provider = "slurm" }')).code != 1


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("executors:missing", "run.executor: function executors:missing: .* has no function missing"),
        ("executors:nothing", "run.executor: executors:nothing must return a concurrent.futures.Executor, not int."),
        ("executors:breaks", r"run.executor: executors:breaks failed \(OSError: no such cluster\)"),
    ],
)
def test_an_executor_that_cannot_be_had_is_a_sentence(call, tmp_path, name, said):
    called = call("calibrate", write(tmp_path, f'executor = "{name}"'), "-o", tmp_path / "campaign", "-q")
    assert called.code == 1
    with pytest.raises(AssertionError, match=said):
        raise AssertionError(called.err)


def test_a_named_executor_gives_the_same_and_is_no_part_of_what_is_asked(call, tmp_path):
    here, there = write(tmp_path / "here", ""), write(tmp_path / "there", 'executor = "executors:two_processes"')
    assert call("calibrate", here, "-o", tmp_path / "a", "-q").code == 0
    called = call("calibrate", there, "-o", tmp_path / "b", "-q")
    assert called.code == 0, called.err
    assert "by the executor of executors:two_processes." in (tmp_path / "b" / "log.txt").read_text()
    a, b = gc.Result.read(tmp_path / "a"), gc.Result.read(tmp_path / "b")
    np.testing.assert_array_equal(a.samples, b.samples)
    np.testing.assert_array_equal(a.iterations[-1].weights, b.iterations[-1].weights)
    # It may go on elsewhere, by its copy of the file.
    copy = tmp_path / "b" / "campaign.toml"
    copy.write_text(copy.read_text().replace("executors:two_processes", "local"))
    called = call("resume", tmp_path / "b", "--max-iterations", "2", "-q")
    assert called.code == 0 and "was changed" not in called.out
    assert "Goes on by workers of this machine, where it was begun by the executor of executors:two_processes." in (tmp_path / "b" / "log.txt").read_text()
    assert call("resume", tmp_path / "a", "--max-iterations", "2", "-q").code == 0
    np.testing.assert_array_equal(*(gc.Result.read(tmp_path / each).iterations[-1].weights for each in "ab"))


def test_a_library_is_filled_by_it_too(call, tmp_path):
    file = write(tmp_path, 'executor = "executors:two_processes"')
    assert call("explore", file, "--runs", "6", "-o", tmp_path / "library", "-q").code == 0
    assert len(Store.open(tmp_path / "library").runs()) == 6 and (tmp_path / "imported").exists()


def test_early_stops_are_refused_where_no_run_can_be_watched(call, tmp_path):
    file = write(
        tmp_path,
        'executor = "executors:two_processes"',
        (THE_PAPERS, 'method = "posterior"\nearly_stop = true'),
        ("s = false\ngl_error_increment = false\nerror = false\nerror_increment = false\n", ""),
    )
    called = call("calibrate", file, "-o", tmp_path / "campaign")
    assert called.code == 1 and "filter.early_stop must be false where evaluations run by the executor of executors:two_processes" in called.err


def test_a_timeout_is_refused_where_nobody_keeps_it(call, tmp_path):
    file = write(tmp_path, 'executor = "executors:two_processes"', ('"soil:respond"', '"soil:respond", timeout = 5'))
    called = call("check", file)
    assert called.code == 1 and 'experiment "drained": its model has a timeout, which the executor of executors:two_processes cannot keep' in called.err


def test_a_strangers_executor_and_lines_of_scripts_need_a_word(call, tmp_path, monkeypatch):
    file = write(tmp_path, 'executor = "executors:two_processes"')
    assert call("calibrate", file, "-o", tmp_path / "campaign", "-q").code == 0
    monkeypatch.setattr(os, "getuid", lambda: 12345)
    store = Store.open(tmp_path / "campaign")
    with pytest.raises(gc.data.InputError, match="to go on with it runs code: soil:respond of .*; the executor of executors:two_processes.*--trust"):
        refuse_strangers_code(store)
    with pytest.raises(gc.data.InputError, match=r'Parsl \(slurm\), worker_init = "module load yade"'):
        refuse_strangers_code(store, Place("parsl", {"provider": "slurm", "worker_init": "module load yade"}))


def test_jobs_of_a_copied_folder_are_others(call, tmp_path):
    assert call("calibrate", write(tmp_path, ""), "-o", tmp_path / "campaign", "-q").code == 0
    shutil.copytree(tmp_path / "campaign", tmp_path / "copy")
    label = _label(Store.open(tmp_path / "campaign"), tmp_path / "campaign")
    assert label == _label(Store.open(tmp_path / "campaign"), tmp_path / "campaign") and label != _label(Store.open(tmp_path / "copy"), tmp_path / "copy")


def test_by_parsl_it_is_the_same_and_a_function_that_lies_beside_the_file_is_found(call, tmp_path):
    pytest.importorskip("parsl", reason="Parsl is not installed: pip install '.[cluster]'")
    file = write(tmp_path / "there", 'executor = "parsl"\nparsl = { provider = "local", cores_per_node = 2 }')
    assert call("calibrate", file, "-o", tmp_path / "b", "-q").code == 0
    assert call("calibrate", write(tmp_path / "here", ""), "-o", tmp_path / "a", "-q").code == 0
    np.testing.assert_array_equal(*(gc.Result.read(tmp_path / each).iterations[-1].weights for each in "ab"))
    assert json.loads(Store.open(tmp_path / "b").meta("place"))["blocks"] == {"provider": "local", "cores_per_node": 2}


PROGRAM = """from soil import STRAIN, respond
import sys
curves = respond([float(sys.argv[1]), float(sys.argv[2])])
print("axial_strain,stress_ratio,volumetric_strain")
for row in zip(STRAIN.tolist(), curves["stress_ratio"].tolist(), curves["volumetric_strain"].tolist()):
    print(*map(repr, row), sep=",")
"""


def of_a_program(*keys):
    """What puts the program of the test's soil in the place of its function."""
    columns = 'columns = { axial_strain = "axial_strain", stress_ratio = "stress_ratio", volumetric_strain = "volumetric_strain" }'
    command = f'command = ["{sys.executable}", "program.py", "{{{{ strength }}}}", "{{{{ dilatancy }}}}"], link = ["program.py", "soil.py"]'
    model = ", ".join(['kind = "command"', command, 'keep = "all"', "time_limit = 60", f'output = {{ file = "-", {columns} }}', *keys])
    return '{ kind = "python", function = "soil:respond" }', f"{{ {model} }}"


def test_a_program_runs_by_parsl_in_the_campaigns_folder(call, tmp_path):
    pytest.importorskip("parsl", reason="Parsl is not installed: pip install '.[cluster]'")
    file = write(tmp_path / "there", 'executor = "parsl"\nparsl = { provider = "local", cores_per_node = 2 }', of_a_program())
    (tmp_path / "there" / "program.py").write_text(PROGRAM)
    called = call("calibrate", file, "-o", tmp_path / "b", "-q")
    assert called.code == 0, called.err
    assert call("calibrate", write(tmp_path / "here", ""), "-o", tmp_path / "a", "-q").code == 0
    np.testing.assert_array_equal(*(gc.Result.read(tmp_path / each).iterations[-1].weights for each in "ab"))
    assert len(list((tmp_path / "b" / "evaluations").glob("*/attempt-0"))) == 20


def test_where_programs_run_in_scratch_the_nodes_need_not_see_the_campaigns_folder(call, tmp_path, monkeypatch):
    pytest.importorskip("parsl", reason="Parsl is not installed: pip install '.[cluster]'")
    if subprocess.run(["unshare", "--mount", "true"], capture_output=True).returncode:
        pytest.skip("this machine lets nobody hide a folder from a process (unshare --mount)")
    home, scratch, campaign = (tmp_path / name for name in ("home", "scratch", "b"))
    for folder in (home, scratch):
        folder.mkdir()
    monkeypatch.setenv("HOME", str(home))
    # The block begins again where the campaign's folder is another one.
    hides = f'[ -n "$HIDDEN" ] || HIDDEN=1 exec unshare --mount bash "$0"; mount -t tmpfs none "{campaign}"'
    file = write(
        tmp_path / "there",
        f'executor = "parsl"\nparsl = {{ provider = "local", cores_per_node = 2, worker_init = \'{hides}\' }}',
        of_a_program(f'scratch = "{scratch}"'),
    )
    (tmp_path / "there" / "program.py").write_text(PROGRAM)
    called = call("calibrate", file, "-o", campaign)
    assert called.code == 0, called.err
    assert f"they need not see {campaign}" in " ".join(called.out.split())
    assert call("calibrate", write(tmp_path / "here", ""), "-o", tmp_path / "a", "-q").code == 0
    np.testing.assert_array_equal(*(gc.Result.read(tmp_path / each).iterations[-1].weights for each in "ab"))
    assert not list(campaign.glob("evaluations/*")) and not (campaign / "parsl").exists() and not list(scratch.iterdir())


def test_without_parsl_it_is_said_what_to_install(call, tmp_path, monkeypatch):
    file = write(tmp_path, 'executor = "parsl"\nparsl = { provider = "local" }')
    monkeypatch.setitem(sys.modules, "parsl", None)
    assert "needs Parsl, which is not installed" in call("check", file).out
    called = call("calibrate", file, "-o", tmp_path / "campaign")
    assert called.code == 1 and "pip install '.[cluster]'" in called.err and not (tmp_path / "campaign").exists()
