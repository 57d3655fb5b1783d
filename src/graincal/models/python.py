"""Anybody's own model: a Python function."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass
from numbers import Real
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from graincal.data import InputError, Samples
from graincal.execution import Task, try_in_a_process
from graincal.interpolation import covers, span
from graincal.models.function_work import Function, FunctionWork
from graincal.models.model import Model

LONGEST_TIMEOUT = 1e8
"""Seconds, three years: longer ones are more than a system's clocks wait for."""

_FOUND: set[tuple[str, Path | None]] = set()
"""Named functions that were found, by their names and folders: to look for one takes half a second."""


@dataclass(frozen=True, eq=False)
class PythonModel(Model):
    """A function of theta (n,), in the order of the parameter space, that returns a mapping of names to (T,): observables and any further quantities.

    function: the function itself, or its name as "module:name".
    control: the control values (K,) that the returned values belong to, increasing; by default the reference's own, and then K = T.
    executor: any `concurrent.futures.Executor` to evaluate on. By default a function runs on threads, where every function can, and which suits
    one that waits for another program or computes in NumPy; a function given by its name runs in processes, each of which imports it.
    folder: where the module of a named function is looked for before the usual places.
    timeout: the seconds that one evaluation may take. Only a process can be ended from outside, so it goes with a function given by its name and no
    executor. What the function started in its process ends with it.

    The function may return a `Failure` itself: of the kind "infeasible" where the parameters are impossible. An exception in it, values that are not numbers or not as many as the control's, or the time-out, make that evaluation a Failure.
    Values may be NaN or infinite; which of them must be finite the experiment knows. A further quantity whose name is not printable, or longer than 500 characters, is kept under a name that is; one without a name is left out.
    """

    function: Function | str
    control: ArrayLike | None = None
    executor: Executor | None = None
    folder: Path | None = None
    timeout: float | None = None

    def __post_init__(self) -> None:
        if not (callable(self.function) or isinstance(self.function, str)):
            raise InputError(f'a Python model needs a function, or its name as "module:name", not {self.function!r}.')
        if self.control is not None:
            control = np.array(self.control, dtype=np.float64)
            if control.ndim != 1 or not control.size or not np.all(np.isfinite(control)) or not np.all(np.diff(control) > 0):
                raise InputError("the control values of a Python model must be finite numbers that increase.")
            object.__setattr__(self, "control", control)
        if self.timeout is not None:
            if isinstance(self.timeout, bool) or not isinstance(self.timeout, Real) or not 0 < self.timeout < np.inf:
                raise InputError(f"the timeout of a Python model must be a number of seconds above 0, not {self.timeout!r}.")
            if self.timeout > LONGEST_TIMEOUT:
                raise InputError(f"the timeout of a Python model is {self.timeout:g} s, and at most {LONGEST_TIMEOUT:g} s was expected.")
            if not isinstance(self.function, str) or self.executor is not None:
                raise InputError(
                    'a timeout needs a function given by its name, "module:name", and no executor: only then does it run in a process that can be ended.'
                )

    def tasks(self, samples: Samples, at: ArrayLike) -> list[Task]:
        """A call of the function for each sample.

        at (T,): the control values that are asked for; a model with its own `control` answers on that. Raises InputError where the model's control does not cover what is asked for.
        """
        work = self._work(at)
        return [Task(work, np.array(theta)) for theta in samples.theta]

    def check(self, at: ArrayLike, samples: Samples) -> None:
        """Raise InputError where the control does not cover what is asked for, or where a named function cannot be found: it is imported in a process of its own, for importing it runs somebody's code."""
        work = self._work(at)
        if isinstance(self.function, str) and (self.function, self.folder) not in _FOUND:
            try_in_a_process(work)
            _FOUND.add((self.function, self.folder))

    def _work(self, at: ArrayLike) -> FunctionWork:
        asked = np.asarray(at, dtype=np.float64)
        control = asked if self.control is None else np.asarray(self.control, dtype=np.float64)
        if self.control is not None and not covers(control, asked):
            raise InputError(f"the model covers the control values {span(control)}, and {span(asked)} are asked for.")
        return FunctionWork(self.function, self.folder, control, self.timeout, self.executor)
