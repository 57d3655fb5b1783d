"""Where evaluations run: on any `concurrent.futures.Executor`, or on worker processes of graincal's own."""

from graincal.execution.cores import available_cores, number_of_workers
from graincal.execution.executor import evaluate_each
from graincal.execution.one_by_one import OneByOne
from graincal.execution.processes import CRASHED, Processes, evaluate_in_processes

__all__ = ["CRASHED", "OneByOne", "Processes", "available_cores", "evaluate_each", "evaluate_in_processes", "number_of_workers"]
