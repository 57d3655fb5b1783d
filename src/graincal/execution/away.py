"""In a worker process elsewhere, such as that of a cluster's node: evaluations of works that are sent to it once."""

from __future__ import annotations

import os
import socket
from collections import OrderedDict
from pathlib import Path
from typing import Any, NamedTuple

from graincal import build
from graincal.data import Failure, Response
from graincal.execution.processes import Processes
from graincal.execution.task import Task, Work
from graincal.execution.tied import end_with

KEPT = 8
"""Works that a process keeps, those that it was last asked for."""

_works: OrderedDict[str, tuple[Work, Processes | None]] = OrderedDict()


class Unknown(NamedTuple):
    """Stands in the place of an outcome: this process was not sent the work yet, or not for long."""

    key: str


class Place(NamedTuple):
    """Where a worker process is: the node's name, whether it sees a folder, how many workers began with it on the node, and what graincal is there."""

    node: str
    sees: bool
    workers: int
    graincal: dict[str, str]


def look(file: str) -> Place:
    """Where this process is. file: one that must be seen from here."""
    _end_with_owner()
    return Place(socket.gethostname(), Path(file).is_file(), int(os.environ.get("PARSL_WORKER_COUNT", 1)), build.describe())


def evaluate(key: str, work: Work | None, argument: Any, own_process: bool) -> Response | Failure | Unknown:
    """What a task comes to. work: None where this process may hold it by its key already.

    own_process: a work that asks for a process has one, a child of this one, which may crash and is ended by its time-out; otherwise that is this process. Raises what the work raises.
    """
    if own_process:
        _end_with_owner()
    if key not in _works:
        if work is None:
            return Unknown(key)
        _keep(key, work, Processes(work, _nobody) if own_process and work.own_process else None)
    _works.move_to_end(key)
    work, processes = _works[key]
    return work(argument) if processes is None else processes.run(Task(work, argument))


def _keep(key: str, work: Work, processes: Processes | None) -> None:
    _works[key] = work, processes
    while len(_works) > KEPT:
        _, (_, oldest) = _works.popitem(last=False)
        if oldest is not None:
            oldest.stop()


def _end_with_owner() -> None:
    """A worker whose owner is killed would go on with its task, beside the one that takes its place."""
    end_with(os.getppid())


def _nobody(*_: Any) -> None:
    """Whoever runs a task here is told by its return."""
