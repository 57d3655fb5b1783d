"""Where evaluations run: tasks, the backends that run them, and the scheduler that decides which of them runs when."""

from typing import TYPE_CHECKING

from graincal.lazily import exported

if TYPE_CHECKING:
    from graincal.execution.cores import available_cores, number_of_workers
    from graincal.execution.processes import CRASHED, try_in_a_process
    from graincal.execution.scheduler import Ended, Scheduler, run
    from graincal.execution.task import LOST, Limit, Outcomes, Task, Watch, Work

__all__ = [
    "CRASHED",
    "LOST",
    "Ended",
    "Limit",
    "Outcomes",
    "Scheduler",
    "Task",
    "Watch",
    "Work",
    "available_cores",
    "number_of_workers",
    "run",
    "try_in_a_process",
]

__getattr__ = exported(
    __name__,
    {
        "graincal.execution.cores": ["available_cores", "number_of_workers"],
        "graincal.execution.processes": ["CRASHED", "try_in_a_process"],
        "graincal.execution.scheduler": ["Ended", "Scheduler", "run"],
        "graincal.execution.task": ["LOST", "Limit", "Outcomes", "Task", "Watch", "Work"],
    },
)
