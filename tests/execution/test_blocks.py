"""Parsl's blocks: on this machine as they are, and the scripts that are submitted to clusters, compared with stored ones."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from graincal.data import InputError, Response
from graincal.execution import Scheduler, Task
from graincal.models.function_work import FunctionWork

parsl = pytest.importorskip("parsl", reason="Parsl is not installed: pip install '.[cluster]'")

from graincal.execution import parsl as on_blocks  # noqa: E402
from graincal.execution.parsl import _reasons  # noqa: E402
from graincal.execution.providers import Blocks, jobs_of  # noqa: E402

AT = np.array([0.1, 0.2])
MODULE = """
import ctypes, os, signal, time


def behaves(theta):
    if theta[0] == 1:
        ctypes.string_at(0)
    if theta[0] == 2:
        time.sleep(60)
    if theta[0] == 3 and not os.path.exists("{folder}/killed"):
        open("{folder}/killed", "w").close()
        # Its owner is the worker, which is gone then.
        os.kill(os.getppid(), signal.SIGKILL)
        time.sleep(60)
    return {{"stress_ratio": [theta[0], os.getpid()]}}
"""


@pytest.fixture(autouse=True)
def faults_are_seen_within_seconds(monkeypatch):
    monkeypatch.setattr(on_blocks, "HEARTBEATS", (1, 5))


def local(folder, **options):
    options.setdefault("blocks", Blocks("local", cores_per_node=2))
    blocks = options.pop("blocks")
    return lambda done: on_blocks.OnBlocks(blocks, "graincal-test", done, folder, print, **options)


def processes_of(folder: Path) -> list[int]:
    """Those that live and have a path of the folder in their command line."""
    found = []
    for each in Path("/proc").iterdir():
        try:
            if each.name.isdecimal() and int(each.name) != os.getpid() and str(folder).encode() in (each / "cmdline").read_bytes():
                found.append(int(each.name))
        except OSError:
            continue
    return found


def test_a_folder_that_the_nodes_do_not_see_is_not_mended_by_scratch(tmp_path, monkeypatch):
    hand_over = on_blocks.OnBlocks.hand_over

    def unseen(self, *arguments):
        (tmp_path / ".seen").unlink(missing_ok=True)
        return hand_over(self, *arguments)

    monkeypatch.setattr(on_blocks.OnBlocks, "hand_over", unseen)
    scheduler = Scheduler("all", local(tmp_path))
    try:
        scheduler.submit([Task(FunctionWork(abs, None, AT), np.array([1.0]))])
        with pytest.raises(InputError, match="is not seen from the node .*; a folder on a file system that the nodes share was expected.$"):
            scheduler.next()
    finally:
        scheduler.close()


def test_crashes_time_outs_and_lost_workers(tmp_path):
    (tmp_path / "module.py").write_text(MODULE.format(folder=tmp_path))
    work = FunctionWork("module:behaves", tmp_path, AT, timeout=3.0)
    scheduler = Scheduler("all", local(tmp_path, longest=3.0))
    try:
        scheduler.submit([Task(work, np.array([float(n)]), name=n) for n in range(6)])
        ended = {each.task.name: each for each in (scheduler.next() for _ in range(6))}
        assert processes_of(tmp_path)
    finally:
        scheduler.close()
    kinds = {n: getattr(each.outcome, "kind", None) for n, each in ended.items()}
    assert kinds == {0: None, 1: "crashed", 2: "timed_out", 3: None, 4: None, 5: None}
    # The crash is tried once more when nothing else is under way, and the worker that was lost was none of the evaluation's own.
    assert [ended[n].attempts for n in range(4)] == [1, 2, 1, 2]
    assert isinstance(ended[0].outcome, Response) and ended[0].outcome.values["stress_ratio"][1] != os.getpid()
    deadline = time.monotonic() + 10
    while (left := processes_of(tmp_path)) and time.monotonic() < deadline:
        time.sleep(0.2)
    assert not left


def test_an_interchange_that_dies_ends_the_campaign_in_words(tmp_path):
    (tmp_path / "module.py").write_text(MODULE.format(folder=tmp_path))
    work = FunctionWork("module:behaves", tmp_path, AT)
    scheduler = Scheduler("all", local(tmp_path))
    scheduler.submit([Task(work, np.array([0.0]), name=0), Task(work, np.array([2.0]), name=2)])
    assert isinstance(scheduler.next().outcome, Response)
    (backend,) = scheduler._backends.values()
    os.kill(backend._executor.interchange_proc.pid, signal.SIGKILL)
    with pytest.raises(InputError, match="its interchange, has ended"):
        scheduler.next()
    start = time.monotonic()
    scheduler.close()
    assert time.monotonic() - start < 20


def test_blocks_that_never_begin_end_the_campaign_in_words(tmp_path):
    blocks = Blocks("local", cores_per_node=1, worker_init="echo no such module >&2; exit 3")
    scheduler = Scheduler("all", local(tmp_path, blocks=blocks))
    scheduler.submit([Task(FunctionWork("module:behaves", tmp_path, AT), np.zeros(1))])
    with pytest.raises(InputError, match=r"3 blocks in a row ended before a worker of theirs began \(.*no such module.*What they printed is in"):
        scheduler.next()
    scheduler.close()


def test_each_reason_of_blocks_is_said_once():
    of_sbatch = "Error {}: Failed to start block {}: Cannot launch job x.{}: Could not read job ID from submit command standard output; recode=1, stdout=, stderr=sbatch: error: invalid partition specified: big\n"
    of_shell = "Error {}: Job is marked as MISSING.\nSTDERR: /spool/job0000{}/slurm_script: line 12: module: command not found{}\n"
    assert _reasons("Executor x failed due to:\n" + "".join(of_sbatch.format(n, n, n) for n in (1, 2, 3))) == "sbatch: error: invalid partition specified: big"
    assert _reasons("Executor x failed due to:\n" + "".join(of_shell.format(n, n, "") for n in (1, 2, 3))) == "module: command not found"
    assert _reasons("no address was found") == "no address was found"


def test_a_result_that_is_lost_without_a_word_is_asked_for_again(tmp_path, monkeypatch):
    monkeypatch.setattr(on_blocks, "GRACE", 0.0)
    (tmp_path / "module.py").write_text(MODULE.format(folder=tmp_path))

    class Loses(on_blocks.OnBlocks):
        lost = False

        def _ended(self, task, future):
            if not self.lost:
                self.lost = True
                return
            super()._ended(task, future)

    make = lambda done: Loses(Blocks("local", cores_per_node=2), "graincal-test", done, tmp_path, print)  # noqa: E731
    scheduler = Scheduler("all", make)
    scheduler.submit([Task(FunctionWork("module:behaves", tmp_path, AT, timeout=10.0), np.zeros(1))])
    ended = scheduler.next()
    scheduler.close()
    assert ended.attempts == 2 and isinstance(ended.outcome, Response)


GIVEN = {
    "partition": "fast",
    "account": "soil",
    "walltime": "02:00:00",
    "cores_per_node": 16,
    "memory_per_node": 32,
    "max_blocks": 4,
    "worker_init": "module load yade",
}
REPLIES = {"slurm": "Submitted batch job 7", "pbs": "7.server", "lsf": "Job <7> is submitted to queue <fast>."}
OPTIONS = {"slurm": "#SBATCH --constraint=avx512", "pbs": "#PBS -l place=excl", "lsf": "#BSUB -R 'select[avx512]'"}


@pytest.mark.parametrize("provider", ["slurm", "pbs", "lsf"])
@pytest.mark.parametrize("which", ["given", "defaults"])
def test_the_script_that_is_submitted_is_the_stored_one(tmp_path, monkeypatch, provider, which):
    submit = tmp_path / "bin"
    submit.mkdir()
    for program in ("sbatch", "qsub", "bsub"):
        (submit / program).write_text(f"#!/bin/sh\necho \"$0 $*\" | sed 's|.*/bin/||' > {tmp_path}/called\necho '{REPLIES[provider]}'\n")
        (submit / program).chmod(0o755)
    monkeypatch.setenv("PATH", str(submit), prepend=os.pathsep)
    given = GIVEN | {"scheduler_options": OPTIONS[provider]} | ({"qos": "short", "nodes_per_block": 2} if provider == "slurm" else {})
    blocks = Blocks(provider, **(given if which == "given" else {} if provider == "slurm" else {"cores_per_node": 8}))
    made = blocks.make()
    made.script_dir = str(tmp_path)
    assert made.submit("exec the-workers", 1, "parsl.graincal-1.block-0") == ("7.server" if provider == "pbs" else "7")
    script = next(path for path in tmp_path.iterdir() if path.name.startswith("parsl.") and path.suffix != ".ec").read_text()
    # The time stands in the name, and the folder is this test's.
    said = (tmp_path / "called").read_text()
    text = re.sub(r"(block-0)\.[\d.]*\d", r"\1", (script + f"\n# submitted by: {said}").replace(str(tmp_path), "/campaign/parsl/000/submit_scripts"))
    stored = Path(__file__).parent / "submit_scripts" / f"{provider}_{which}.sh"
    if os.environ.get("GRAINCAL_STORE_SCRIPTS"):
        stored.write_text(text)
    assert text == stored.read_text()


def test_jobs_of_a_label_are_told_from_others(tmp_path, monkeypatch):
    (tmp_path / "squeue").write_text(
        "#!/bin/sh\nprintf '7 parsl.graincal-1.block-0.123\\n8 parsl.graincal-12.block-0.1\\n9 other\\n10 parsl.graincal-1.block-1.4\\n'\n"
    )
    (tmp_path / "squeue").chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    assert jobs_of("slurm", "graincal-1") == ["7", "10"]
    monkeypatch.setenv("PATH", str(tmp_path / "nowhere"))
    with pytest.raises(InputError, match="squeue, which says what jobs there are, failed"):
        jobs_of("slurm", "graincal-1")


def test_where_there_is_no_cluster_it_is_said(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(InputError, match='run.parsl.provider = "slurm" submits jobs by sbatch, and there is no such program in PATH'):
        Blocks("slurm").check()


def test_a_process_that_is_tied_ends_with_its_owner(tmp_path):
    code = "import subprocess, sys, time; print(subprocess.Popen([sys.executable, '-m', 'graincal.execution.tied', 'timeit', '-n', '1', '-r', '1', 'import time; time.sleep(60)']).pid, flush=True); time.sleep(60)"
    owner = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    tied = int(owner.stdout.readline())
    deadline = time.monotonic() + 30
    # Not before it has said so to the system.
    while (
        b"timeit" not in Path(f"/proc/{tied}/cmdline").read_bytes()
        or "sleep" not in Path(f"/proc/{tied}/wchan").read_text()
        and time.monotonic() < deadline - 25
    ):
        time.sleep(0.1)
    owner.kill()
    owner.wait()
    while Path(f"/proc/{tied}").exists() and Path(f"/proc/{tied}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z":
        assert time.monotonic() < deadline
        time.sleep(0.1)
