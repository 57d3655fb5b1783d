"""Where evaluations run: on any `concurrent.futures.Executor`, or on worker processes of graincal's own."""

from typing import TYPE_CHECKING

from graincal.lazily import exported

if TYPE_CHECKING:
    from graincal.execution.cores import available_cores, number_of_workers
    from graincal.execution.executor import evaluate_each
    from graincal.execution.one_by_one import OneByOne
    from graincal.execution.processes import CRASHED, Processes, evaluate_in_processes

__all__ = ["CRASHED", "OneByOne", "Processes", "available_cores", "evaluate_each", "evaluate_in_processes", "number_of_workers"]

__getattr__ = exported(
    __name__,
    {
        "graincal.execution.cores": ["available_cores", "number_of_workers"],
        "graincal.execution.executor": ["evaluate_each"],
        "graincal.execution.one_by_one": ["OneByOne"],
        "graincal.execution.processes": ["CRASHED", "Processes", "evaluate_in_processes"],
    },
)
