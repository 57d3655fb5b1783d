"""Evaluations as they come in: kept in the order asked, whatever the order told."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graincal.data import InputError, ParameterSpace, Samples
from graincal.inference.likelihood.early_stop import EarlyStop
from graincal.inference.likelihood.errors import errors_so_far, observable_errors, sample_errors
from graincal.inference.likelihood.thinning import Thinning

# In widths of the ranges: generous enough for values that went through a table, strict enough to notice another seed or another space.
TOLERANCE = 1e-6


class Batch:
    """The samples of one iteration and what has been told of them.

    `responses` holds one (N, K, J) for each reference, at the states that are kept of it, NaN where nothing usable was told; `observable_errors` (N, P) and
    `errors` (N,) are those at all of its rows (Hartmann, Cheng, Thornton 2022, Eq. 5 and 6), of a sample that was stopped at those that it came to. `told`, `failed`,
    `infeasible` and `stopped` are (N,) masks: an infeasible sample, whose parameters are impossible, is a failure too; one that was stopped is none.
    early_stop: when runs of it may be stopped.
    """

    def __init__(self, samples: Samples, thinnings: Sequence[Thinning], space: ParameterSpace, early_stop: EarlyStop | None = None) -> None:
        self.samples = samples
        self.early_stop = early_stop
        self.thinnings = tuple(thinnings)
        self.responses = [np.full((len(samples), *thinning.kept.values.shape), np.nan) for thinning in thinnings]
        self.observable_errors = np.full((len(samples), sum(len(thinning.whole.names) for thinning in thinnings)), np.nan)
        self.errors = np.full(len(samples), np.nan)
        self.told = np.zeros(len(samples), dtype=bool)
        self.failed = np.zeros(len(samples), dtype=bool)
        self.infeasible = np.zeros(len(samples), dtype=bool)
        self.stopped = np.zeros(len(samples), dtype=bool)
        self.space = space

    def keep(
        self,
        rows: NDArray[np.intp],
        arrays: Sequence[NDArray[np.float64]],
        lost: NDArray[np.bool_],
        impossible: NDArray[np.bool_],
        stopped: NDArray[np.bool_],
    ) -> None:
        """Keep what became of some samples (N,): responses at all rows, one (N, T, J) for each reference, not looked at where they are `lost` (N,)."""
        self.told[rows] = True
        self.failed[rows] = lost
        self.infeasible[rows] = impossible
        self.stopped[rows] = stopped
        references = [thinning.whole for thinning in self.thinnings]
        for mine, array, thinning in zip(self.responses, arrays, self.thinnings):
            mine[rows[~lost]] = thinning.reduce(array[~lost])
        whole = ~(lost | stopped)
        pairs = np.concatenate([observable_errors(array[whole], reference) for array, reference in zip(arrays, references)], axis=1)
        self.observable_errors[rows[whole]] = pairs
        self.errors[rows[whole]] = sample_errors(pairs, np.concatenate([reference.shares for reference in references]))
        if stopped.any():
            self.observable_errors[rows[stopped]], self.errors[rows[stopped]] = errors_so_far([array[stopped] for array in arrays], references)


class Batches:
    """The batches under way, the earliest first. Ids count up from sample to sample and from batch to batch.

    `asked` counts the samples of all batches there ever were.
    """

    def __init__(self) -> None:
        self._under_way: deque[Batch] = deque()
        self._last: Batch | None = None
        self.asked = 0

    def __len__(self) -> int:
        return len(self._under_way)

    def __iter__(self) -> Iterator[Batch]:
        return iter(self._under_way)

    def add(self, batch: Batch) -> None:
        """Ask for one more."""
        self._under_way.append(batch)
        self._last = batch
        self.asked += len(batch.samples)

    @property
    def _latest(self) -> Batch:
        assert self._last is not None, "a filter asks for its first batch as it is made"
        return self._last

    def take_complete(self) -> Batch | None:
        """The earliest, if all of it has been told, which is then under way no more; None otherwise."""
        return self._under_way.popleft() if self._under_way and self._under_way[0].told.all() else None

    def untold(self) -> Samples:
        """The samples that have not been told, of all batches."""
        return _joined([batch.samples.take(~batch.told) for batch in self._under_way] or [self._latest.samples.take(slice(0))])

    def tell(
        self,
        samples: Samples,
        responses: Sequence[NDArray[np.float64]] | NDArray[np.float64],
        failed: ArrayLike | None,
        infeasible: ArrayLike | None = None,
        stopped: ArrayLike | None = None,
    ) -> None:
        """Store the responses of some samples, all or (on InputError) none; see `AskTellFilter.tell`."""
        if not (hasattr(samples, "ids") and hasattr(samples, "theta")):
            raise InputError(f"tell: samples must be those of ask(), or some of them by take(), not {samples!r}.")
        rows = self._rows(samples)
        arrays = self._arrays(responses, len(rows))
        lost, impossible = _mask("failed", failed, len(rows)), _mask("infeasible", infeasible, len(rows))
        lost |= impossible
        ended = _mask("stopped", stopped, len(rows)) & ~lost
        for array in arrays:
            lost |= ~ended & ~np.isfinite(array).all(axis=(1, 2))
        for batch in self._under_way:
            mine = (rows >= 0) & (rows < len(batch.samples))
            batch.keep(rows[mine], [array[mine] for array in arrays], lost[mine], impossible[mine], ended[mine])
            rows = rows - len(batch.samples)

    def _rows(self, samples: Samples) -> NDArray[np.intp]:
        """Which samples they are, counted from the first of the batches under way."""
        ids = np.asarray(samples.ids, dtype=np.int64)
        all_asked = _joined([batch.samples for batch in self._under_way] or [self._latest.samples.take(slice(0))])
        is_told = np.concatenate([*(batch.told for batch in self._under_way), [True]])
        rows = ids - (self.asked - len(all_asked))
        known = ids < self.asked
        # Earlier batches are complete.
        told = (rows < 0) | is_told[np.clip(rows, 0, len(all_asked))]
        _, first = np.unique(ids, return_index=True)
        repeated = np.ones(len(ids), dtype=bool)
        repeated[first] = False
        for wrong, problem in ((~known | (ids < 0), "was not asked"), (told, "has already been told"), (repeated, "is given twice")):
            if wrong.any():
                raise InputError(f"tell: sample {ids[wrong][0]} {problem}.")
        theta = np.asarray(samples.theta, dtype=np.float64)
        asked = all_asked.theta[rows]
        if theta.shape != asked.shape:
            raise InputError(f"tell: the samples' theta must have the shape {asked.shape}, not {theta.shape}.")
        to_unit = self._latest.space.to_unit
        same = np.all(np.abs(to_unit(theta) - to_unit(asked)) <= TOLERANCE, axis=1)
        if not same.all():
            raise InputError(f"tell: sample {ids[~same][0]} has other parameters than the sample that was asked.")
        return rows

    def _arrays(self, responses: Sequence[NDArray[np.float64]] | NDArray[np.float64], count: int) -> list[NDArray[np.float64]]:
        shapes = [thinning.whole.values.shape for thinning in self._latest.thinnings]
        if len(shapes) == 1:
            array = _numbers(responses)
            arrays = [array[0] if array.ndim == 4 and len(array) == 1 else array]
        elif not isinstance(responses, (Sequence, np.ndarray)):
            raise InputError(f"tell: responses to {len(shapes)} experiments are needed, an array for each, not {responses!r}.")
        else:
            arrays = [_numbers(response) for response in responses]
        if len(arrays) != len(shapes):
            raise InputError(f"tell: responses to {len(shapes)} experiments are needed, and {len(arrays)} given.")
        for number, (array, expected) in enumerate(zip(arrays, shapes), start=1):
            shape = (count, *expected)
            if array.shape != shape:
                raise InputError(f"tell: the responses to experiment {number} must have the shape {shape} (samples, states, observables), not {array.shape}.")
        return arrays


def _joined(parts: Sequence[Samples]) -> Samples:
    """Samples one after the other."""
    return Samples(np.concatenate([part.ids for part in parts]), np.concatenate([part.theta for part in parts]), parts[0].names)


def _numbers(response: ArrayLike) -> NDArray[np.float64]:
    try:
        return np.asarray(response, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError("tell: responses must be numbers, in arrays with as many rows for every sample.") from None


def _mask(name: str, marks: ArrayLike | None, count: int) -> NDArray[np.bool_]:
    mask = np.zeros(count, dtype=bool) if marks is None else np.array(marks, dtype=bool)
    if mask.shape != (count,):
        raise InputError(f"tell: {name} must have one entry for each of the {count} samples, not the shape {mask.shape}.")
    return mask
