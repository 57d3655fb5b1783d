"""Running a batch of simulations on the engine's own threads."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graincal import _native
from graincal.data import InputError
from graincal.dem.packing import Packing

_PATIENCE = 0.2
"""Seconds between two looks at whether the user has pressed Ctrl-C."""


@dataclass(frozen=True, eq=False)
class Run:
    """How one simulation of a batch ended: `status` is "finished", "stopped" by whoever watched it, or why it did not; `columns` maps names to recorded
    states (T,), those that it came to.
    `consolidation_flagged`: the packing was not at rest when its shearing began."""

    index: int
    status: str
    columns: dict[str, NDArray[np.float64]]
    consolidation_flagged: bool
    steps: int
    seconds: float


def run_batch(
    packing: Packing | Sequence[Packing],
    laws: Sequence[_native.LinearLaw | _native.HertzLaw],
    stages: Sequence[_native.Stage],
    *,
    density: float,
    expected_steps: Sequence[float],
    threads: int,
    step_limit: int,
    precision: str = "float64",
    economy: _native.Economy = _native.Economy(),
    stopped: Callable[[], bool] = lambda: False,
    watch: Callable[[int, Mapping[str, NDArray[np.float64]]], bool] | None = None,
) -> Iterator[Run]:
    """Simulate a packing under each law along the stages and yield the runs in order of completion. packing: one, or one for each law.

    The longest expected run starts first, by its steps (`expected_steps`) and its particles. Closing the iterator, or an exception in its consumer, stops
    the simulations under way; and so does `stopped`, which is asked several times a second, from any other thread: then there are no more runs.
    watch(index, columns) is shown the states of a run so far each time that there is one more, from several threads, and stops that run by returning True;
    what it raises is raised here. Raises InputError where the system does not give as many threads.
    """
    packings = [packing] * len(laws) if isinstance(packing, Packing) else packing
    distinct = {id(each): each for each in packings}
    number = {key: k for k, key in enumerate(distinct)}
    held = [_native.Packing(each.positions, each.radii, each.edges) for each in distinct.values()]
    order = sorted(range(len(laws)), key=lambda index: -expected_steps[index] * packings[index].count)
    useful = max(1, min(threads, len(laws)))
    try:
        batch = _native.Batch(
            held, list(laws), density, list(stages), order, useful, step_limit, precision=precision, economy=economy, watch=watch,
            packing_of=[number[id(each)] for each in packings],
        )  # fmt: skip
    except RuntimeError as error:
        raise InputError(f"workers: {error}, and a number that the system has room for was expected.") from None
    left = len(laws)
    try:
        while left and not stopped():
            outcome = batch.next(_PATIENCE)
            if outcome is None:
                continue
            left -= 1
            yield Run(outcome["task"], outcome["status"], outcome["columns"], outcome["consolidation_flagged"], outcome["steps"], outcome["seconds"])
    finally:
        batch.cancel()
