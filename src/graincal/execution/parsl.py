"""Tasks in Parsl's blocks: worker processes on this machine, or in jobs of a cluster's scheduler."""

from __future__ import annotations

import functools
import logging
import re
import sys
import time
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from math import inf
from pathlib import Path
from typing import Any

from graincal.data import Failure, InputError
from graincal.execution.away import Place
from graincal.execution.elsewhere import Elsewhere, Say
from graincal.execution.providers import Blocks, cancel_jobs, jobs_of
from graincal.execution.task import LOST, Task
from graincal.execution.threads import Done
from graincal.notation.printable import as_text, printable

HEARTBEATS = (5, 20)
"""Seconds between two signs of life of a block, and after which a silent block, or one that hears nothing, is given up."""

BAD_BLOCKS = 3
"""Blocks in a row that end before any worker has connected, after which no more are asked for."""

GRACE = 60.0
"""Seconds that an outcome may come later than its evaluation must have ended."""

ANSWERS = 120.0
"""Seconds after the start of a block within which its first worker must have said where it is."""

LEAVING = 30.0
"""Seconds that jobs have to leave the queue in."""

DAY = 86_400.0
"""Seconds that an evaluation without a time-out may take where blocks have no end."""

_HTEX = "parsl.executors.high_throughput."


class OnBlocks(Elsewhere):
    """A backend: Parsl's high-throughput executor. A task whose worker, block or node is gone, or whose outcome does not come, is lost: a Failure of that kind.

    label: names the jobs, and must be stored before anything is submitted: what is left of a run with it is cancelled first. longest: the seconds that an evaluation takes at most, if that is known.
    cores: that one evaluation uses. folder: where blocks have their own files, which the nodes must see. Raises InputError where no block can be started.
    """

    # Certificates and what workers print are kept in `folder`, whatever models do.
    without_folder = ""
    own_process = True

    def __init__(self, blocks: Blocks, label: str, done: Done, folder: Path, say: Say, *, longest: float | None = None, cores: int = 1) -> None:
        super().__init__(done, folder, say, needs_folder=True)
        self._blocks, self._label, self._longest, self._cores = blocks, label, longest, cores
        if blocks.cores is not None:
            if blocks.cores < cores:
                raise InputError(f"run.parsl.cores_per_node is {blocks.cores}, and an evaluation uses {cores} cores.")
            self.holds = blocks.max_blocks * blocks.nodes_per_block * (blocks.cores // cores * cores)
        self._workers_of_a_node, self._ticked = 1, time.monotonic()
        self._waited, self._had_a_place = 0.0, dict[Task, float]()

    def begin(self) -> None:
        if left := jobs_of(self._blocks.provider, self._label):
            self._say(f"Cancels jobs that an earlier sitting left: {', '.join(left)}.")
            self._until_gone()
        from parsl import Config, DataFlowKernel

        # It writes a file of its own; what goes wrong is said here.
        logging.getLogger("parsl").addHandler(logging.NullHandler())
        self._executor = self._new_executor()
        self._kernel = DataFlowKernel(
            Config(
                executors=[self._executor],
                retries=0,
                strategy="simple",
                strategy_period=1,
                max_idletime=600,
                run_dir=str(self._folder / "parsl"),
                usage_tracking=0,
                initialize_logging=False,
            )
        )
        if self._blocks.provider != "local":
            self._say(f"Submits a job, whose name begins with parsl.{self._label}: evaluations begin when it runs.")

    def looked(self, place: Place) -> None:
        self._workers_of_a_node = place.workers

    def hand_over(self, function: Callable, *arguments: Any) -> Future:
        return self._kernel.submit(function, app_args=arguments, executors=[self._label], cache=False, ignore_for_cache=(), app_kwargs={})

    def meaning(self, error: BaseException) -> Failure | BaseException:
        """Of workers, blocks and nodes that are gone, lost; of blocks that cannot be had, and of what a worker cannot do at all, the end of the campaign."""
        from parsl.executors.errors import BadStateException
        from parsl.executors.high_throughput.errors import ManagerLost, WorkerLost
        from parsl.jobs.errors import TooManyJobFailuresError

        if isinstance(error, (ManagerLost, WorkerLost)):
            return Failure(LOST, f"what ran the evaluation is gone: {error}.")
        if isinstance(error, (BadStateException, TooManyJobFailuresError)):
            why = printable(_reasons(as_text(error)), 2_000)
            return InputError(
                f"run.parsl: {BAD_BLOCKS} blocks in a row ended before a worker of theirs began ({why}). What they printed is in {self._folder / 'parsl'}, which must be seen from the nodes."
            )
        if isinstance(error, InputError):
            return error
        return InputError(
            f"run.parsl: a worker cannot evaluate ({type(error).__name__}: {as_text(error)}): graincal and all that the models import must be there as here, for example by worker_init."
        )

    def look_after(self) -> None:
        """Raises InputError where Parsl's own process has died. Gives up what is late: no word comes of an outcome that is lost on its way."""
        self._check_interchange()
        now = time.monotonic()
        passed, self._ticked = now - self._ticked, now
        if self.waits_for_the_first:
            self._waited += passed if self._workers() else 0.0
            if self._waited > ANSWERS:
                self._waited = 0.0
                self.look_first()
            return
        tasks = self.under_way
        self._had_a_place = {task: self._had_a_place.get(task, 0.0) for task in tasks}
        # They begin in the order in which they were handed over: the clock of one runs while there is a worker for it.
        for task in tasks[: self._workers()]:
            self._had_a_place[task] += passed
            if self._had_a_place[task] > self._allowed(task):
                # Its next attempt has a clock of its own.
                del self._had_a_place[task]
                self.give_up(task, f"no outcome came within {self._allowed(task):.0f} s.")

    def end(self) -> None:
        if (kernel := getattr(self, "_kernel", None)) is None:
            return
        if self._executor.interchange_proc.poll() is None:
            kernel.cleanup()
        else:
            # Parsl would wait for it for ever.
            self._executor.provider.cancel(list(self._executor.blocks_to_job_id.values()))
        # Also those that were submitted in this moment, of which Parsl may not know the number.
        self._until_gone()

    def _new_executor(self) -> Any:
        from parsl.executors import HighThroughputExecutor
        from parsl.executors.high_throughput.executor import DEFAULT_LAUNCH_CMD
        from parsl.jobs.error_handlers import windowed_error_handler

        period, threshold = HEARTBEATS
        return HighThroughputExecutor(
            label=self._label,
            address="127.0.0.1" if self._blocks.provider == "local" else self._blocks.address,
            provider=self._blocks.make(),
            cores_per_worker=self._cores,
            max_workers_per_node=None if self._blocks.cores is None else self._blocks.cores // self._cores,
            prefetch_capacity=0,
            heartbeat_period=period,
            heartbeat_threshold=threshold,
            drain_period=self._drain_period(),
            block_error_handler=functools.partial(windowed_error_handler, threshold=BAD_BLOCKS),
            # By this Python, whatever PATH says there.
            launch_cmd=DEFAULT_LAUNCH_CMD.replace("process_worker_pool.py", f"exec {sys.executable} -m {_HTEX}process_worker_pool"),
            interchange_launch_cmd=[sys.executable, "-m", "graincal.execution.tied", _HTEX + "interchange"],
        )

    def _drain_period(self) -> int | None:
        """The seconds after which a block takes no more tasks: those that are under way have time to end before its limit."""
        whole = self._blocks.seconds
        if whole == inf:
            return None
        # A time-out beyond the block's own limit says nothing of how long evaluations take.
        last = whole / 10 if self._longest is None or self._longest > whole else self._longest + GRACE
        return int(whole - min(last, whole / 2))

    def _allowed(self, task: Task) -> float:
        """The seconds within which an outcome must come from when there is a worker for it: its evaluation is ended there by its time-out, or with its block."""
        limits = (task.work.timeout, self._blocks.seconds)
        return min((seconds for seconds in limits if seconds is not None and seconds < inf), default=DAY) + GRACE

    def _workers(self) -> int:
        """That are there now. By what the provider said last: Parsl's interchange would have to be asked for others, and one that has died answers nobody."""
        from parsl.jobs.states import JobState

        running = sum(status.state == JobState.RUNNING for status in list(self._executor.status_facade.values()))
        return running * self._blocks.nodes_per_block * self._workers_of_a_node

    def _check_interchange(self) -> None:
        process = self._executor.interchange_proc
        if process.poll() is not None and not self._stopped.is_set():
            raise InputError(f"run.parsl: Parsl's own process on this machine, its interchange, has ended ({process.returncode}).")

    def _until_gone(self) -> None:
        """Cancel the jobs with the run's label until there are none, and name those that stay."""
        provider, until = self._blocks.provider, time.monotonic() + LEAVING
        with suppress(InputError):
            while left := jobs_of(provider, self._label):
                cancel_jobs(left)
                if time.monotonic() > until:
                    self._say(f"These jobs are still in the queue after {LEAVING:.0f} s, and were told to end: {', '.join(left)}.")
                    return
                time.sleep(0.5)


def _reasons(error: str) -> str:
    """Why blocks ended, in what the scheduler or the job printed: each reason once, without Parsl's words about it."""
    blocks = re.split(r"\bError \d+:", " ".join(error.split()))
    # What stands before the first is no reason.
    said = [re.split(r"\bstderr=|\bSTDERR:", each)[-1].strip() or each.strip() for each in blocks[1:] or blocks]
    # Each job has a folder of its own.
    said = [re.sub(r"\S*/slurm_script: line \d+: ", "", each) for each in said]
    return "; ".join(dict.fromkeys(said))
