"""Where Parsl starts its blocks: on this machine, or as jobs of Slurm, PBS or LSF."""

from __future__ import annotations

import math
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from shutil import which
from typing import TYPE_CHECKING, Any

from graincal.data import InputError
from graincal.errors import not_installed
from graincal.execution.cores import available_cores

if TYPE_CHECKING:
    from parsl.providers.base import ExecutionProvider

SUBMIT = {"local": None, "slurm": "sbatch", "pbs": "qsub", "lsf": "bsub"}
"""The providers, and the program by which each of them submits a job."""

POLLING = 5
"""Seconds between two questions to a cluster's scheduler."""


@dataclass(frozen=True)
class Blocks:
    """The jobs, or on this machine the groups of worker processes, that evaluations run in: [run.parsl] of a calibration file.

    walltime: HH:MM:SS. memory_per_node: GB. cores_per_node: None for whole nodes, or all cores of this machine. worker_init: lines of the shell before the workers start. scheduler_options: lines such as "#SBATCH --constraint=fast".
    """

    provider: str
    partition: str | None = None
    account: str | None = None
    qos: str | None = None
    walltime: str = "01:00:00"
    nodes_per_block: int = 1
    cores_per_node: int | None = None
    memory_per_node: int | None = None
    max_blocks: int = 1
    worker_init: str = ""
    scheduler_options: str = ""
    address: str | None = None

    @property
    def seconds(self) -> float:
        """How long a block may run: on this machine, without end."""
        hours, minutes, seconds = map(int, self.walltime.split(":"))
        return math.inf if self.provider == "local" else 3600.0 * hours + 60 * minutes + seconds

    @property
    def cores(self) -> int | None:
        """Of a node that evaluations may use; None where it is not known before."""
        return available_cores() if self.provider == "local" and self.cores_per_node is None else self.cores_per_node

    def check(self) -> None:
        """Raise InputError where Parsl, or the program that submits jobs, is not here."""
        try:
            import parsl  # noqa: F401
        except ImportError as error:
            raise not_installed('run.executor = "parsl"', "Parsl", "cluster", error) from None
        program = SUBMIT[self.provider]
        if program and which(program) is None:
            raise InputError(
                f'run.parsl.provider = "{self.provider}" submits jobs by {program}, and there is no such program in PATH; a machine of the cluster was expected, or another run.executor.'
            )

    def make(self) -> ExecutionProvider:
        """Parsl's provider."""
        return _MAKERS[self.provider](self, {"init_blocks": 1, "min_blocks": 0, "max_blocks": self.max_blocks, "worker_init": self.worker_init})


def jobs_of(provider: str, label: str) -> list[str]:
    """The numbers of the jobs that have not ended of the run with a label, by Slurm; of other providers none are known. Raises InputError where Slurm does not answer."""
    if provider != "slurm":
        return []
    try:
        listed = subprocess.run(["squeue", "--noheader", "--me", "--format=%A %j"], capture_output=True, text=True, check=True, timeout=60).stdout
    except (OSError, subprocess.SubprocessError) as error:
        raise InputError(f"run.parsl: squeue, which says what jobs there are, failed ({getattr(error, 'stderr', None) or error}).") from None
    rows = (line.split(maxsplit=1) for line in listed.splitlines() if line.strip())
    return [number for number, name in rows if name.startswith(f"parsl.{label}.block-")]


def cancel_jobs(jobs: list[str]) -> None:
    """Cancel jobs of Slurm; those that have ended meanwhile are none of its mistakes."""
    if jobs:
        subprocess.run(["scancel", *jobs], capture_output=True, timeout=60, check=False)


def _local(blocks: Blocks, common: Mapping[str, Any]) -> ExecutionProvider:
    from parsl.launchers import SimpleLauncher
    from parsl.providers import LocalProvider

    return LocalProvider(launcher=SimpleLauncher(), **common)


def _slurm(blocks: Blocks, common: Mapping[str, Any]) -> ExecutionProvider:
    from parsl.launchers import SimpleLauncher, SrunLauncher
    from parsl.providers import SlurmProvider

    class Slurm(SlurmProvider):
        status_polling_interval = POLLING

    return Slurm(
        partition=blocks.partition,
        account=blocks.account,
        qos=blocks.qos,
        walltime=blocks.walltime,
        nodes_per_block=blocks.nodes_per_block,
        cores_per_node=blocks.cores_per_node,
        mem_per_node=blocks.memory_per_node,
        # Workers take all cores that they see, so that without a number the node must be theirs.
        exclusive=blocks.cores_per_node is None,
        # A job that Slurm begins again would come back beside the one that took its place.
        scheduler_options=_lines("#SBATCH --no-requeue", blocks.scheduler_options),
        # Since Slurm 22.05 srun does not take this number from its job.
        launcher=SimpleLauncher()
        if blocks.nodes_per_block == 1
        else SrunLauncher(overrides="" if blocks.cores_per_node is None else f"--cpus-per-task={blocks.cores_per_node}"),
        **common,
    )


def _pbs(blocks: Blocks, common: Mapping[str, Any]) -> ExecutionProvider:
    from parsl.launchers import SimpleLauncher
    from parsl.providers import PBSProProvider

    class PBS(PBSProProvider):
        status_polling_interval = POLLING

    return PBS(
        queue=blocks.partition,
        account=blocks.account,
        walltime=blocks.walltime,
        cpus_per_node=blocks.cores_per_node,
        select_options="" if blocks.memory_per_node is None else f"mem={blocks.memory_per_node}gb",
        scheduler_options=_lines("#PBS -r n", blocks.scheduler_options),
        launcher=SimpleLauncher(),
        **common,
    )


def _lsf(blocks: Blocks, common: Mapping[str, Any]) -> ExecutionProvider:
    from parsl.launchers import SimpleLauncher
    from parsl.providers import LSFProvider

    class LSF(LSFProvider):
        status_polling_interval = POLLING

    memory = "" if blocks.memory_per_node is None else f'#BSUB -R "rusage[mem={blocks.memory_per_node}GB]"'
    return LSF(
        queue=blocks.partition,
        project=blocks.account,
        walltime=blocks.walltime,
        cores_per_block=blocks.cores_per_node,
        cores_per_node=blocks.cores_per_node,
        request_by_nodes=False,
        # Its options in the script are read from the standard input alone.
        bsub_redirection=True,
        scheduler_options=_lines("#BSUB -rn", memory, blocks.scheduler_options),
        launcher=SimpleLauncher(),
        **common,
    )


_MAKERS = {"local": _local, "slurm": _slurm, "pbs": _pbs, "lsf": _lsf}


def _lines(*texts: str) -> str:
    return "\n".join(text for text in texts if text)
