"""One evaluation as a record that can be sent to where it runs."""

from __future__ import annotations

from collections.abc import Callable, Generator, Hashable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

from graincal.data import Failure, Response

Watch = Callable[[Response], bool]
"""Is shown the first of a run's states; the run need not go on where it returns True."""


LOST = "lost"
"""The kind of a failure that is none of the evaluation's own: where it ran is gone, or it was killed from outside. It is run again (`Scheduler`)."""


class Limit(NamedTuple):
    """How many tasks of one name may run at once, whatever work they are of: those that need a licence."""

    name: Hashable
    most: int


class Work(Protocol):
    """What the evaluations of a model share: a packing, a function, files.

    It is called with the argument of a task, wherever that runs, and returns a Response or a Failure. What it raises ends whoever asked. key: names it; to a process it is sent once.
    executor: where it is to run, None for this machine's workers. own_process: whether each evaluation runs in a process, which may crash, be ended after `timeout` seconds, and has imported what
    `prepare` imports. Otherwise it runs on threads: then `run(argument, stopped, watch)`, where there is one, is called instead, which asks `stopped()` several times a second whether to go on.
    """

    @property
    def key(self) -> str: ...

    @property
    def executor(self) -> Executor | None: ...

    @property
    def own_process(self) -> bool: ...

    @property
    def timeout(self) -> float | None: ...

    def __call__(self, argument: Any, /) -> Response | Failure: ...

    def prepare(self) -> None: ...


@dataclass(frozen=True, eq=False)
class Task:
    """An evaluation: work, and the argument that makes it this one.

    name: by which whoever submits it knows it again. cost: how much it takes, in comparison with other tasks of its model; of tasks of the same `order` the most costly begins first. watch: a rule by which its run may be
    stopped early; work that cannot be watched runs to its end. cores: how many workers' places it takes; all of them, where there are fewer. limit: how many like it may run at once.
    """

    work: Work
    argument: Any
    name: Hashable = None
    cost: float = 1.0
    order: tuple[int, ...] = ()
    watch: Watch | None = None
    cores: int = 1
    limit: Limit | None = None


class Model(Protocol):
    """What describes evaluations and runs none: it turns samples into tasks."""

    def tasks(self, samples: Any, at: Any) -> Sequence[Task]: ...


Outcomes = Generator[tuple[int, Response | Failure]]
"""(row, outcome), in the order in which evaluations end."""
