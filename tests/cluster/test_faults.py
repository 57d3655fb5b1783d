"""Faults of a cluster, each in a real Slurm of one node with the settings that users have: none ends a campaign or leaves anything behind, and the answer is that of this machine."""

import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest

import graincal as gc
from graincal.campaign.stored.store import Store

from .campaigns import call, evaluated, log_of, start, wait_until, write

pytestmark = pytest.mark.cluster

SLURM = 'executor = "parsl"\nparsl = { provider = "slurm", cores_per_node = 1, walltime = "00:10:00" }'


@pytest.fixture(scope="module")
def answer(tmp_path_factory):
    """The weights that the calibration gives on this machine."""
    folder = tmp_path_factory.mktemp("here")
    call(os.environ, "calibrate", write(folder, seconds=0), "-o", folder / "campaign", "--quiet")
    return weights(folder / "campaign")


@pytest.fixture
def campaign(slurm, tmp_path):
    """A calibration under way on the cluster, with some evaluations done: its process and folder."""
    folder = tmp_path / "campaign"
    process = start(slurm.environment, "calibrate", write(tmp_path, SLURM, seconds=1), "-o", folder, "--quiet", quickly=False)
    wait_until(lambda: evaluated(folder) >= 3, seconds=240, why="an evaluation")
    yield process, folder
    if process.poll() is None:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)


def weights(folder):
    return gc.Result.read(folder).iterations[-1].weights


def ends_well(process, folder, answer):
    _, err = process.communicate(timeout=300)
    assert process.returncode == 0, err
    np.testing.assert_array_equal(weights(folder), answer)


def processes(text: str) -> list[int]:
    """Those whose command line holds a text."""
    found = []
    for each in Path("/proc").iterdir():
        try:
            if each.name.isdecimal() and text in (each / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace"):
                found.append(int(each.name))
        except OSError:
            continue
    return found


def lives(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def children(pid: int) -> list[int]:
    return [int(child) for task in Path(f"/proc/{pid}/task").iterdir() for child in (task / "children").read_text().split()]


def manager_of(folder) -> int:
    """The process that leads a block's workers."""
    return next(pid for pid in processes("process_worker_pool") if str(folder) in Path(f"/proc/{pid}/cmdline").read_text() and children(pid))


def goes_on(folder, more: int, seconds: float = 120) -> float:
    done = evaluated(folder)
    return wait_until(lambda: evaluated(folder) >= done + more, seconds, "further evaluations")


def say(fault: str, what: str) -> None:
    print(f"\n{fault}: {what}", flush=True)


def test_a_worker_is_killed(slurm, campaign, answer):
    process, folder = campaign
    manager = manager_of(folder)
    (worker,) = [pid for pid in children(manager) if "spawn_main" in Path(f"/proc/{pid}/cmdline").read_text() and children(pid)]
    beneath = children(worker)
    os.kill(worker, signal.SIGKILL)
    wait_until(lambda: not any(map(lives, beneath)), 10, "the end of what the worker ran")
    say("worker killed", f"the next outcome {goes_on(folder, 1):.0f} s later, in the same block")
    ends_well(process, folder, answer)


def test_a_manager_is_killed(slurm, campaign, answer):
    process, folder = campaign
    manager = manager_of(folder)
    # Beside them it has a process of Parsl's own, which evaluates nothing; where Slurm knows processes by cgroups it ends with the job.
    workers = [pid for pid in children(manager) if children(pid)]
    theirs = [pid for worker in workers for pid in children(worker)]
    others = [pid for pid in children(manager) if pid not in workers]
    assert theirs
    os.kill(manager, signal.SIGKILL)
    took = wait_until(lambda: not any(map(lives, workers + theirs)), 30, "the end of its workers")
    say("manager killed", f"its workers, and what they ran, were gone after {took:.1f} s, the next outcome {goes_on(folder, 1):.0f} s after that")
    for pid in filter(lives, others):
        os.kill(pid, signal.SIGKILL)
    ends_well(process, folder, answer)


def test_a_block_is_cancelled(slurm, campaign, answer):
    process, folder = campaign
    slurm.call("scancel", *slurm.jobs("running"))
    say("block cancelled", f"the next outcome {goes_on(folder, 1):.0f} s later, in another block")
    ends_well(process, folder, answer)


def test_the_node_is_drained_and_comes_back(slurm, campaign, answer):
    process, folder = campaign
    slurm.call("scontrol", "update", f"nodename={slurm.host}", "state=drain", "reason=test")
    goes_on(folder, 2)
    slurm.call("scancel", *slurm.jobs("running"))
    time.sleep(40)
    done = evaluated(folder)
    assert slurm.jobs("pending") and process.poll() is None
    slurm.call("scontrol", "update", f"nodename={slurm.host}", "state=resume")
    say(
        "node drained, block cancelled",
        f"the block that takes its place waits, and {done} of 40 evaluations are done; when the node is back, the next outcome {goes_on(folder, 1):.0f} s later",
    )
    ends_well(process, folder, answer)


def test_a_job_comes_to_its_limit(slurm, tmp_path, answer):
    folder = tmp_path / "campaign"
    process = start(slurm.environment, "calibrate", write(tmp_path, SLURM, seconds=4), "-o", folder, "--quiet", quickly=False)
    wait_until(lambda: evaluated(folder) >= 1, seconds=240, why="an evaluation")
    (block,) = slurm.jobs("running")
    slurm.call("scontrol", "update", f"jobid={block}", "timelimit=1")
    took = wait_until(lambda: block not in slurm.jobs("running"), 180, "the end of the job")
    say(
        "job ended at its limit, of which it was not told", f"{took:.0f} s after it was set to a minute; the next outcome {goes_on(folder, 1):.0f} s after that"
    )
    ends_well(process, folder, answer)


def test_a_block_takes_no_tasks_at_the_end_of_its_time(slurm, tmp_path, answer):
    folder = tmp_path / "campaign"
    file = write(tmp_path, SLURM.replace("00:10:00", "00:02:00"), 4, 2, ('"soil:slowly"', '"soil:slowly", timeout = 10'))
    process = start(slurm.environment, "calibrate", file, "-o", folder, "--quiet", quickly=False)
    ends_well(process, folder, answer)
    attempts = [attempts for _, _, attempts, _ in Store.open(folder).runs()]
    say(
        "a calibration longer than a block's 2 minutes",
        f"{len(list((folder / 'parsl' / '000' / 'submit_scripts').glob('*.stdout')))} blocks one after the other, {sum(attempts) - len(attempts)} evaluations lost",
    )
    assert sum(attempts) == len(attempts)


def test_graincal_is_killed_and_the_blocks_end_by_themselves(slurm, campaign, answer):
    process, folder = campaign
    process.kill()
    took = wait_until(lambda: not slurm.jobs(), 60, "the end of the block")
    say("graincal killed (SIGKILL)", f"its block was gone from squeue after {took:.0f} s")
    wait_until(lambda: not processes(str(folder)), 10, "the end of all its processes")
    call(slurm.environment, "resume", folder, "--quiet")
    np.testing.assert_array_equal(weights(folder), answer)


def test_graincal_is_killed_while_its_block_waits(slurm, tmp_path, answer):
    slurm.call("scontrol", "update", f"nodename={slurm.host}", "state=drain", "reason=test")
    folder = tmp_path / "campaign"
    process = start(slurm.environment, "calibrate", write(tmp_path, SLURM, seconds=1), "-o", folder, "--quiet", quickly=False)
    wait_until(lambda: slurm.jobs("pending"), 60, "a job in the queue")
    (block,) = slurm.jobs("pending")
    process.kill()
    slurm.call("scontrol", "update", f"nodename={slurm.host}", "state=resume")
    wait_until(lambda: block in slurm.jobs("running"), 60, "the start of the job")
    took = wait_until(lambda: not slurm.jobs(), 60, "the end of the job")
    say("graincal killed while its block was queued", f"the block ended {took:.0f} s after it began")


def test_jobs_that_were_left_are_cancelled_first(slurm, tmp_path, answer):
    slurm.call("scontrol", "update", f"nodename={slurm.host}", "state=drain", "reason=test")
    folder = tmp_path / "campaign"
    process = start(slurm.environment, "calibrate", write(tmp_path, SLURM, seconds=1), "-o", folder, "--quiet", quickly=False)
    wait_until(lambda: slurm.jobs("pending"), 60, "a job in the queue")
    (block,) = slurm.jobs("pending")
    process.kill()
    process = start(slurm.environment, "resume", folder, "--quiet", quickly=False)
    wait_until(lambda: block not in slurm.jobs() and slurm.jobs("pending"), 60, "another job in its place")
    assert f"Cancels jobs that an earlier sitting left: {block}." in log_of(folder)
    slurm.call("scontrol", "update", f"nodename={slurm.host}", "state=resume")
    say("graincal killed while its block was queued, and resumed", f"job {block} was cancelled before another was submitted")
    ends_well(process, folder, answer)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_jobs_are_gone_when_the_command_returns(slurm, campaign, answer, number):
    process, folder = campaign
    began = time.monotonic()
    process.send_signal(number)
    process.communicate(timeout=60)
    took = time.monotonic() - began
    assert process.returncode == 128 + number and not slurm.jobs()
    say(signal.Signals(number).name, f"graincal returned after {took:.1f} s, and squeue was empty")
    assert not processes(str(folder))
    call(slurm.environment, "resume", folder, "--quiet")
    np.testing.assert_array_equal(weights(folder), answer)
