"""How much runs at one place differ, by those at the answer, and whether that is what the emulator misses."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from graincal.data import Response
from graincal.notation.numbers import ALIKE

if TYPE_CHECKING:
    from graincal.campaign.found.record import Record

MOST = 0.5
"""Of the square of what the emulator misses held-out runs by, from which scatter is most of it."""


class Scatter(NamedTuple):
    """In parts of the reference's peaks, root mean square over states and observables: what the runs at the answer differ by (sd), and what the emulator misses held-out runs by near the posterior."""

    of_runs: float
    missed: float

    @property
    def is_most(self) -> bool:
        """Whether what is missed is for the most part scatter, which no emulator knows of a single run."""
        return ALIKE < self.of_runs and self.of_runs**2 > MOST * self.missed**2


def scatter_of(result: Record) -> Scatter | None:
    """Of the experiment of which the emulator misses most. None before two runs at the answer have whole responses, and where it was not stored what the emulator misses."""
    found, answer = result.found, result.answer
    if found is None or answer is None or not found.spread:
        return None
    number = int(np.argmax(found.held_out))
    experiment = result.experiments[number]
    responses = [response for sample in answer.samples if isinstance(response := result.response(int(sample), number), Response)]
    if len(responses) < 2:
        return None
    peaks = np.abs(experiment.reference.values).max(axis=0)
    variances = experiment.observables_of(responses).var(axis=0, ddof=1) / np.where(peaks > 0, peaks, 1.0) ** 2
    of_runs = float(np.sqrt(variances.mean()))
    return Scatter(of_runs, found.held_out[number] * found.spread[number]) if np.isfinite(of_runs) else None
