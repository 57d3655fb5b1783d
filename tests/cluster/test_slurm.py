"""A whole calibration through a real Slurm gives what it gives on this machine, bit for bit, although a block is cancelled in it and graincal is killed."""

import signal

import numpy as np

import graincal as gc
from graincal.campaign.stored.store import Store

from .campaigns import call, evaluated, start, wait_until, write

SLURM = 'executor = "parsl"\nparsl = { provider = "slurm", cores_per_node = 1, walltime = "00:10:00" }'


def test_the_same_answer_as_on_this_machine_through_faults(slurm, tmp_path):
    file = write(tmp_path / "slurm", SLURM)
    folder = tmp_path / "campaign"
    process = start(slurm.environment, "calibrate", file, "-o", folder, "--quiet")
    wait_until(lambda: evaluated(folder) >= 3, seconds=240, why="an evaluation")
    (block,) = slurm.jobs("running")
    slurm.call("scancel", block)
    # The evaluations that were lost with the block run again in the one that takes its place.
    done = evaluated(folder)
    wait_until(lambda: evaluated(folder) >= done + 8, seconds=240, why="a block in the place of the one that was cancelled")
    process.send_signal(signal.SIGKILL)
    process.wait()
    call(slurm.environment, "resume", folder, "--quiet")
    assert not slurm.jobs()

    here = write(tmp_path / "here")
    call(slurm.environment, "calibrate", here, "-o", tmp_path / "local", "--quiet")
    ours, theirs = (gc.Result.read(tmp_path / name) for name in ("campaign", "local"))
    np.testing.assert_array_equal(ours.samples, theirs.samples)
    np.testing.assert_array_equal(ours.iterations[-1].weights, theirs.iterations[-1].weights)
    of_each = [Store.open(tmp_path / name).outcomes([int(id) for id in range(len(ours.samples))], 0) for name in ("campaign", "local")]
    for one, other in zip(*of_each, strict=True):
        assert type(one) is type(other)
        for name in getattr(one, "values", ()):
            np.testing.assert_array_equal(one.values[name], other.values[name])
