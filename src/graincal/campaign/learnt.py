"""What each batch brought of the posterior, in figures: for the terminal and programs, which cannot wait for an emulator to be trained again."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from graincal.inference import PosteriorFilter


@dataclass(frozen=True)
class Learnt:
    """What is known after a batch; NaN where there is nothing.

    posterior_shift: how far the batch moved the posterior, in standard deviations (`PosteriorFilter.shift`), and nothing of the runs at the answer. held_out_error: the emulators' error near the
    posterior, as a part of the spread of the responses, of the worst experiment; held_out_ratio: over that of predicting each evaluation by the mean of all. coverage: the part
    of the evaluations nearest to the reference within their 90 % intervals.
    log_evidence with its standard deviation, the emulators' doubt included. effective_sample_size: of the evaluations, as a number of them. pareto_k: of their weights.
    dropped: the part of the posterior's probability that those which were stopped early hold at most. doubt: how far what the emulators do not know may move means or spreads, in
    standard deviations (`sensitivity.Doubt`); confirmed: what the latest fresh runs left of the posterior's probability (`PosteriorFilter.confirmed`).
    mean, std, low, high, answer: of each parameter, the posterior's moments, the ends of its central interval of 90 %, and where the answer is; () where there is nothing.
    """

    posterior_shift: float = math.nan
    held_out_error: float = math.nan
    coverage: float = math.nan
    log_evidence: float = math.nan
    log_evidence_std: float = math.nan
    effective_sample_size: float = math.nan
    pareto_k: float = math.nan
    dropped: float = math.nan
    held_out_ratio: float = math.nan
    doubt: float = math.nan
    confirmed: float = math.nan
    mean: tuple[float, ...] = ()
    std: tuple[float, ...] = ()
    low: tuple[float, ...] = ()
    high: tuple[float, ...] = ()
    answer: tuple[float, ...] = ()

    @property
    def predicts(self) -> bool:
        """Whether the emulators say more than that responses are like those already seen; else the filter draws its next batch without them."""
        return not self.held_out_ratio >= 1

    @classmethod
    def of(cls, filter: PosteriorFilter) -> Learnt:
        """After the filter's last complete batch."""
        emulation, shift = filter.emulation, math.nan if filter.answered else filter.shift()
        if emulation is None:
            return cls()
        deviation = float(np.hypot(filter.doubt.log_evidence.std(), emulation.explored.log_evidence_std))
        posterior = emulation.posterior
        low, high = posterior.interval(0.9)
        return cls(
            shift if math.isfinite(shift) else math.nan,
            max(emulation.held_out),
            emulation.coverage,
            emulation.log_evidence,
            deviation,
            emulation.effective_sample_size,
            emulation.pareto_k,
            emulation.dropped,
            emulation.held_out_ratio,
            filter.doubt.most,
            filter.confirmed,
            *(tuple(map(float, each)) for each in (posterior.mean(), posterior.std(), low, high, emulation.answer)),
        )

    def figures(self) -> dict[str, float | None]:
        """The single figures as JSON has them: None for NaN."""
        return {name: float(value) if math.isfinite(value) else None for name, value in asdict(self).items() if not isinstance(value, tuple)}

    def plain(self) -> dict[str, Any]:
        """All of it as JSON has it."""
        return self.figures() | {name: list(value) for name, value in asdict(self).items() if isinstance(value, tuple)}

    @classmethod
    def restore(cls, plain: Mapping[str, Any]) -> Learnt:
        """What `plain` made."""
        return cls(**{name: math.nan if value is None else tuple(value) if isinstance(value, list) else value for name, value in plain.items()})
