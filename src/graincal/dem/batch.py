"""Running a batch of simulations on the engine's own threads."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graincal import _native
from graincal.dem.packing import Packing

_PATIENCE = 0.2
"""Seconds between two looks at whether the user has pressed Ctrl-C."""


@dataclass(frozen=True, eq=False)
class Run:
    """How one simulation of a batch ended: `status` is "finished", or why it did not; `columns` maps names to recorded states (T,).
    `consolidation_flagged`: the packing was not at rest when its shearing began."""

    index: int
    status: str
    columns: dict[str, NDArray[np.float64]]
    consolidation_flagged: bool
    steps: int
    seconds: float


def run_batch(
    packing: Packing,
    laws: Sequence[_native.LinearLaw] | Sequence[_native.HertzLaw],
    stages: Sequence[_native.Stage],
    *,
    density: float,
    expected_steps: Sequence[float],
    threads: int,
    step_limit: int,
    precision: str = "float64",
    economy: _native.Economy = _native.Economy(),
) -> Iterator[Run]:
    """Simulate the packing under each law along the stages and yield the runs in order of completion.

    The longest expected run starts first. Closing the iterator, or an exception in its consumer, stops the simulations under way.
    """
    order = sorted(range(len(laws)), key=lambda index: -expected_steps[index])
    held = _native.Packing(packing.positions, packing.radii, packing.edges)
    batch = _native.Batch(held, list(laws), density, list(stages), order, max(1, min(threads, len(laws))), step_limit, precision=precision, economy=economy)
    try:
        for _ in order:
            while (outcome := batch.next(_PATIENCE)) is None:
                pass
            yield Run(outcome["task"], outcome["status"], outcome["columns"], outcome["consolidation_flagged"], outcome["steps"], outcome["seconds"])
    finally:
        batch.cancel()
