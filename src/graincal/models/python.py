"""Anybody's own model: a Python function."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from numbers import Real
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graincal.data import Failure, InputError, Response, Samples
from graincal.execution import OneByOne, Processes, available_cores, evaluate_each, evaluate_in_processes
from graincal.interpolation import covers, span
from graincal.models.named_function import describe_exception, find_function

Function = Callable[[NDArray[np.float64]], Mapping[str, ArrayLike]]


@dataclass(frozen=True, eq=False)
class PythonModel:
    """A function of theta (n,), in the order of the parameter space, that returns a mapping of names to (T,): observables and any further quantities.

    function: the function itself, or its name as "module:name".
    control: the control values (K,) that the returned values belong to, increasing; by default the reference's own, and then K = T.
    executor: any `concurrent.futures.Executor` to evaluate on. By default a function runs on threads, where every function can, and which suits
    one that waits for another program or computes in NumPy; a function given by its name runs in processes, each of which imports it.
    folder: where the module of a named function is looked for before the usual places.
    timeout: the seconds that one evaluation may take. Only a process can be ended from outside, so it goes with a function given by its name and no
    executor. What the function started in its process ends with it.

    The function may return a `Failure` itself: of the kind "infeasible" where the parameters are impossible. An exception in it, values that are not numbers or not as many as the control's, or the time-out, make that evaluation a Failure.
    Values may be NaN or infinite; which of them must be finite the experiment knows.
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
            if not isinstance(self.function, str) or self.executor is not None:
                raise InputError('a timeout needs a function given by its name, "module:name", and no executor: only then does it run in a process that can be ended.')

    def evaluate(self, samples: Samples, at: ArrayLike, workers: int | None = None) -> Iterator[tuple[int, Response | Failure]]:
        """Evaluate each sample and yield (row, Response or Failure) in order of completion.

        at (T,): the control values that are asked for; a model with its own `control` answers on that. workers: threads or processes, all cores by
        default. Raises InputError where the model's control does not cover what is asked for, or where a named function cannot be found.
        """
        call = self._evaluation(at)
        tasks = [np.array(theta) for theta in samples.theta]
        if tasks:
            yield from self._run(call, tasks, workers or available_cores())

    def one_by_one(self, at: ArrayLike) -> OneByOne:
        """Evaluations of single samples, where `evaluate` would run them. Raises InputError as `evaluate` does."""
        call = self._evaluation(at)
        if self.executor is not None:
            futures: set[Future] = set()
            stopped = threading.Event()

            def hand_over(sample: Samples) -> Response | Failure:
                future = self.executor.submit(call, np.array(sample.theta[0]))
                futures.add(future)
                future.add_done_callback(futures.discard)
                if stopped.is_set():
                    future.cancel()
                return future.result()

            def stop() -> None:
                stopped.set()
                for future in list(futures):
                    future.cancel()

            return OneByOne(hand_over, stop, queues=True)
        if isinstance(self.function, str):
            processes = Processes(partial(find_function, self.function, self.folder), self.timeout)
            return OneByOne(lambda sample: processes.run(call, np.array(sample.theta[0])), processes.stop)
        return OneByOne(lambda sample: call(np.array(sample.theta[0])))

    def _evaluation(self, at: ArrayLike) -> _Evaluation:
        at = np.asarray(at, dtype=np.float64)
        if self.control is not None and not covers(self.control, at):
            raise InputError(f"the model covers the control values {span(self.control)}, and {span(at)} are asked for.")
        if isinstance(self.function, str):
            find_function(self.function, self.folder)
        return _Evaluation(self.function, self.folder, at if self.control is None else self.control)

    def _run(self, call: _Evaluation, tasks: list[NDArray[np.float64]], workers: int) -> Iterator[tuple[int, Response | Failure]]:
        if self.executor is not None:
            yield from evaluate_each(call, tasks, self.executor)
        elif isinstance(self.function, str):
            # Imported before the clock of the time-out runs.
            prepare = partial(find_function, self.function, self.folder)
            yield from evaluate_in_processes(call, tasks, workers, prepare=prepare, timeout=self.timeout)
        else:
            threads = ThreadPoolExecutor(workers)
            try:
                yield from evaluate_each(call, tasks, threads)
            finally:
                threads.shutdown(wait=False, cancel_futures=True)


@dataclass(frozen=True, eq=False)
class _Evaluation:
    """One evaluation, wherever it runs: it can be sent to another process if its function can."""

    function: Function | str
    folder: Path | None
    control: NDArray[np.float64]

    def __call__(self, theta: NDArray[np.float64]) -> Response | Failure:
        function = find_function(self.function, self.folder) if isinstance(self.function, str) else self.function
        start = time.perf_counter()
        try:
            returned = function(theta)
        except (Exception, SystemExit) as error:
            return Failure("error", f"{describe_exception(error)}.", {"seconds": time.perf_counter() - start})
        details = {"seconds": time.perf_counter() - start}
        if isinstance(returned, Failure):
            return replace(returned, details={**details, **returned.details})
        try:
            return Response(self.control, self._columns(returned), details)
        except _Unusable as reason:
            return Failure("output", str(reason), details)

    def _columns(self, returned: object) -> dict[str, NDArray[np.float64]]:
        if not isinstance(returned, Mapping) or not returned:
            raise _Unusable(f"the function must return a mapping of names to values, and returned {type(returned).__name__}.")
        columns = {}
        for name, values in returned.items():
            try:
                column = np.array(values, dtype=np.float64)
            except (TypeError, ValueError):
                raise _Unusable(f"{name} is not an array of numbers.") from None
            if column.shape != self.control.shape:
                raise _Unusable(f"{name} has the shape {column.shape}, and one value for each of the {self.control.size} control values was expected.")
            columns[str(name)] = column
        return columns


class _Unusable(ValueError):
    """What a function returned is no response. The message says why."""
