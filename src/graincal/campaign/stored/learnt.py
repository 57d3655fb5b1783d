"""What each batch brought of the posterior, in figures: for the terminal and programs, which cannot wait for an emulator to be trained again."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graincal.inference import PosteriorFilter
from graincal.inference.posterior.likely_runs import LikelyRuns, likely_runs


@dataclass(frozen=True)
class Learnt:
    """What is known after a batch; NaN where there is nothing.

    posterior_shift: how far the batch moved the posterior, in standard deviations (`PosteriorFilter.shift`), and nothing of the runs at the answer. held_out_error: the emulators' error near the
    posterior, as a part of the spread of the responses, of the worst experiment; held_out_ratio: over that of predicting each evaluation by the mean of all. coverage: the part
    of the evaluations nearest to the reference within their 90 % intervals.
    log_evidence with its standard deviation, the emulators' doubt included. effective_runs: how many evaluations of equal weight those in the posterior amount to. pareto_k: of their weights.
    dropped: the part of the posterior's probability that those which were stopped early hold at most. doubt: how far what the emulators do not know may move means or spreads, in
    standard deviations (`sensitivity.Doubt`); confirmed: what the latest fresh runs left of the posterior's probability (`PosteriorFilter.confirmed`).
    mean, std, low, high, answer: of each parameter, the posterior's moments, the ends of its central interval of 90 %, and where the answer is; () where there is nothing.
    siblings, apart: of each experiment, how many packings like its own were run, 0 where none could be, and how far its own is from their mean (`PackingScatter`), NaN where that is not known;
    fits_about_as_well: the runs that fit about as well as the answer; None where no run has a response.
    """

    posterior_shift: float = math.nan
    held_out_error: float = math.nan
    coverage: float = math.nan
    log_evidence: float = math.nan
    log_evidence_std: float = math.nan
    effective_runs: float = math.nan
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
    siblings: tuple[int, ...] = ()
    apart: tuple[float, ...] = ()
    fits_about_as_well: LikelyRuns | None = None

    @property
    def predicts(self) -> bool:
        """Whether the emulators say more than that responses are like those already seen; else the filter draws its next batch without them."""
        return not self.held_out_ratio >= 1

    @classmethod
    def of(cls, filter: PosteriorFilter) -> Learnt:
        """After the filter's last complete batch."""
        emulation, shift = filter.emulation, math.nan if filter.answered else filter.shift()
        without_emulator = cls(
            siblings=tuple(known.packings if known else 0 for known in filter.packings),
            apart=tuple(known.apart if known else math.nan for known in filter.packings),
            fits_about_as_well=likely_runs(filter.evaluations, filter.kept, filter.errors, len(filter.iterations[-1].samples) if filter.answered else 0),
        )
        if emulation is None:
            return without_emulator
        posterior, doubt = emulation.posterior, emulation.doubt
        low, high = posterior.interval()
        return replace(
            without_emulator,
            posterior_shift=shift if math.isfinite(shift) else math.nan,
            held_out_error=max(emulation.held_out),
            coverage=emulation.coverage,
            log_evidence=emulation.log_evidence,
            log_evidence_std=float(np.hypot(doubt.log_evidence.std(), emulation.explored.log_evidence_std)),
            effective_runs=emulation.effective_runs,
            pareto_k=emulation.pareto_k,
            dropped=emulation.dropped,
            held_out_ratio=emulation.held_out_ratio,
            doubt=doubt.most,
            confirmed=filter.confirmed,
            mean=_floats(posterior.mean()),
            std=_floats(posterior.std()),
            low=_floats(low),
            high=_floats(high),
            answer=_floats(emulation.answer),
        )

    def figures(self) -> dict[str, float | None]:
        """The single figures as JSON has them: None for NaN."""
        return {name: _or_none(float(value)) for name, value in vars(self).items() if not isinstance(value, tuple) and name != "fits_about_as_well"}

    def plain(self) -> dict[str, Any]:
        """All of it as JSON has it."""
        several = {name: [_or_none(each) for each in value] for name, value in vars(self).items() if isinstance(value, tuple)}
        return self.figures() | several | {"fits_about_as_well": self.fits_about_as_well and asdict(self.fits_about_as_well)}

    @classmethod
    def restore(cls, plain: Mapping[str, Any]) -> Learnt:
        """What `plain` made."""
        restored: dict[str, Any] = {name: _restored(value) for name, value in plain.items() if name != "fits_about_as_well"}
        fits = plain.get("fits_about_as_well")
        likely: dict[str, Any] | None = fits and {name: _restored(value) for name, value in fits.items()}
        return cls(**restored, fits_about_as_well=LikelyRuns(**likely) if likely else None)


def _or_none(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _floats(values: NDArray[np.float64]) -> tuple[float, ...]:
    return tuple(map(float, values))


def _restored(value: float | list[float | None] | None) -> float | tuple[float, ...]:
    return tuple(map(_or_nan, value)) if isinstance(value, list) else _or_nan(value)


def _or_nan(value: float | None) -> float:
    return math.nan if value is None else value
