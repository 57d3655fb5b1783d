"""The evaluations of one iteration as they come in: kept in the order asked, whatever the order told."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graincal.data import InputError, ParameterSpace, Reference, Samples


class Batch:
    """The samples of one iteration and what has been told of them.

    `responses` holds one (N, T, J) for each reference, NaN where nothing usable was told; `told`, `failed` and `infeasible` are (N,) masks: an
    infeasible sample, whose parameters are impossible, is a failure too.
    """

    def __init__(self, samples: Samples, references: Sequence[Reference], space: ParameterSpace) -> None:
        self.samples = samples
        self.responses = [np.full((len(samples), *reference.values.shape), np.nan) for reference in references]
        self.told = np.zeros(len(samples), dtype=bool)
        self.failed = np.zeros(len(samples), dtype=bool)
        self.infeasible = np.zeros(len(samples), dtype=bool)
        # Generous enough for values that went through a table, strict enough to notice another seed or another space.
        self._tolerance = 1e-6 * (space.high - space.low)

    def untold(self) -> Samples:
        """The samples that have not been told."""
        return self.samples.take(~self.told)

    def tell(
        self,
        samples: Samples,
        responses: Sequence[NDArray[np.float64]] | NDArray[np.float64],
        failed: ArrayLike | None,
        infeasible: ArrayLike | None = None,
    ) -> None:
        """Store the responses of some samples, all or (on InputError) none; see `IterativeBayesianFilter.tell`."""
        if not (hasattr(samples, "ids") and hasattr(samples, "theta")):
            raise InputError(f"tell: samples must be those of ask(), or some of them by take(), not {samples!r}.")
        rows = self._rows(samples)
        arrays = self._arrays(responses, len(rows))
        lost, impossible = _mask("failed", failed, len(rows)), _mask("infeasible", infeasible, len(rows))
        lost |= impossible
        for array in arrays:
            lost |= ~np.isfinite(array).all(axis=(1, 2))
        self.told[rows] = True
        self.failed[rows] = lost
        self.infeasible[rows] = impossible
        for mine, array in zip(self.responses, arrays):
            mine[rows[~lost]] = array[~lost]

    def _rows(self, samples: Samples) -> NDArray[np.intp]:
        ids = np.asarray(samples.ids, dtype=np.int64)
        rows = ids - self.samples.ids[0]
        known = rows < len(self.samples)
        # Ids count up from iteration to iteration, and earlier iterations are complete.
        told = (rows < 0) | self.told[np.clip(rows, 0, len(self.told) - 1)]
        _, first = np.unique(ids, return_index=True)
        repeated = np.ones(len(ids), dtype=bool)
        repeated[first] = False
        for wrong, problem in ((~known | (ids < 0), "was not asked"), (told, "has already been told"), (repeated, "is given twice")):
            if wrong.any():
                raise InputError(f"tell: sample {ids[wrong][0]} {problem}.")
        theta = np.asarray(samples.theta, dtype=np.float64)
        asked = self.samples.theta[rows]
        if theta.shape != asked.shape:
            raise InputError(f"tell: the samples' theta must have the shape {asked.shape}, not {theta.shape}.")
        same = np.all(np.abs(theta - asked) <= self._tolerance, axis=1)
        if not same.all():
            raise InputError(f"tell: sample {ids[~same][0]} has other parameters than the sample that was asked.")
        return rows

    def _arrays(self, responses: Sequence[NDArray[np.float64]] | NDArray[np.float64], count: int) -> list[NDArray[np.float64]]:
        if len(self.responses) == 1:
            array = _numbers(responses)
            arrays = [array[0] if array.ndim == 4 and len(array) == 1 else array]
        elif not isinstance(responses, (Sequence, np.ndarray)):
            raise InputError(f"tell: responses to {len(self.responses)} experiments are needed, an array for each, not {responses!r}.")
        else:
            arrays = [_numbers(response) for response in responses]
        if len(arrays) != len(self.responses):
            raise InputError(f"tell: responses to {len(self.responses)} experiments are needed, and {len(arrays)} given.")
        for number, (array, mine) in enumerate(zip(arrays, self.responses), start=1):
            shape = (count, *mine.shape[1:])
            if array.shape != shape:
                raise InputError(
                    f"tell: the responses to experiment {number} must have the shape {shape} (samples, states, observables), not {array.shape}."
                )
        return arrays


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
