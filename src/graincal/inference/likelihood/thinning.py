"""A dense curve at the states that a likelihood needs: some 50 to 100, closer together where the curve turns.

A logger writes thousands of rows of a curve that is known by some dozens, and the cost of a likelihood grows with the cube of their number. So neighbouring
rows are put together: a state that is kept is the value of the straight line through its rows at the middle of them, which is their mean. What a model gives
at the same rows is put together in the same way, and so are the errors (`Thinning.variances`, `Thinning.alike`): nothing but what differs among the rows of one state is lost.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial.chebyshev import chebvander
from numpy.typing import NDArray

from graincal.data import MeasurementError, Reference

FEWEST, MOST = 50, 100
"""States of a curve that is thinned; one of no more than MOST rows is left as it is."""

STEP = 0.04
"""Of a curve from state to state: the sum of what control and observables advance, each as a part of all that it varies by."""

_CHEBYSHEV = 40
"""Polynomials by which a smooth kernel over a third of the curve is as exact as numbers are."""

_BLOCKS = 400
"""Means of so many blocks of rows say how the curve runs, so that the noise of single rows counts little."""


@dataclass(frozen=True, eq=False)
class Thinning:
    """A reference of T rows, and what is kept of it, K states.

    first (K,): the first row of each state. kept: the states as a reference; the whole itself where nothing is thinned.
    """

    whole: Reference
    kept: Reference
    first: NDArray[np.intp]

    @classmethod
    def of(cls, reference: Reference, thin: bool = True) -> Thinning:
        """thin: whether a reference of more than MOST rows is thinned."""
        if not thin or len(reference.control) <= MOST:
            return cls(reference, reference, np.arange(len(reference.control)))
        first = _first_rows(reference)
        return cls(reference, _means(reference, first), first)

    @property
    def thinned(self) -> bool:
        """Whether fewer states are kept than there are rows."""
        return self.kept is not self.whole

    @property
    def counts(self) -> NDArray[np.intp]:
        """How many rows each state stands for, (K,)."""
        return np.diff(np.append(self.first, len(self.whole.control)))

    def of_one(self, name: str, error: MeasurementError) -> Thinning:
        """That of one of the observables by itself, with its measurement error: the states are the same."""
        whole = self.whole.of_one(name, error)
        return replace(self, whole=whole, kept=_means(whole, self.first) if self.thinned else whole)

    def reduce(self, responses: NDArray[np.float64]) -> NDArray[np.float64]:
        """Responses at all rows (N, T, J) as they are at the states that are kept (N, K, J); NaN where a row of a state is."""
        return np.add.reduceat(responses, self.first, axis=1) / self.counts[:, None] if self.thinned else responses

    def states_of(self, rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """The states that the first rows of a response (t, J) are whole of, (k, J)."""
        if not self.thinned:
            return rows
        ends = np.append(self.first[1:], len(self.whole.control))
        whole = int(np.searchsorted(ends, len(rows), side="right"))
        if not whole:
            return rows[:0]
        return np.add.reduceat(rows[: ends[whole - 1]], self.first[:whole], axis=0) / self.counts[:whole, None]

    def slopes(self) -> NDArray[np.float64]:
        """The slope of each observable over the control at all rows, (T, J): that of the states, which the noise of single rows leaves alone."""
        kept, control = self.kept, self.whole.control
        if len(control) < 2:
            return np.zeros(self.whole.values.shape)
        slopes = np.gradient(kept.values, kept.control, axis=0)
        return np.column_stack([np.interp(control, kept.control, each) for each in slopes.T]) if self.thinned else slopes

    def variances(self, of_rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """The variances at the states (K,) of what has these at the rows (T,), each independent of the others."""
        return np.add.reduceat(of_rows, self.first) / self.counts**2

    def alike(self, deviations: NDArray[np.float64], length: float) -> NDArray[np.float64]:
        """The covariance of the states (K, K) where that of two rows is the product of their deviations (T,) and of exp(-distance / length).

        Between two states it is a product of what each is, for the kernel is; within one it is a sum over pairs of rows.
        """
        control = self.whole.control / length
        if not self.thinned:
            return deviations[:, None] * np.exp(-np.abs(control[:, None] - control[None, :])) * deviations
        shares = deviations / np.repeat(self.counts, self.counts)
        begin, end = (np.repeat(control[rows], self.counts) for rows in (self.first, np.append(self.first[1:], len(control)) - 1))
        to_end, to_begin = (np.add.reduceat(shares * np.exp(-apart), self.first) for apart in (end - control, control - begin))
        between = np.maximum(control[self.first][None, :] - end[self.first][:, None], 0)
        above = np.triu(to_end[:, None] * np.exp(-between) * to_begin, 1)
        return above + above.T + np.diag([self._within(shares[rows], control[rows]) for rows in self._rows()])

    def smoothly_alike(self, length: float) -> NDArray[np.float64]:
        """The covariance of the states (K, K) where that of two rows is exp(-(distance / length)² / 2), not much shorter than the control: by Chebyshev polynomials, of which the means over rows are
        taken."""
        low, extent = self.whole.control[0], np.ptp(self.whole.control) or 1.0
        nodes = np.cos(np.pi * (np.arange(_CHEBYSHEV) + 0.5) / _CHEBYSHEV)
        kernel = np.exp(-0.5 * ((nodes[:, None] - nodes) * (0.5 * extent / length)) ** 2)
        to_coefficients = 2 / _CHEBYSHEV * chebvander(nodes, _CHEBYSHEV - 1).T
        to_coefficients[0] *= 0.5
        means = np.add.reduceat(chebvander(2 * (self.whole.control - low) / extent - 1, _CHEBYSHEV - 1), self.first, axis=0) / self.counts[:, None]
        found = means @ to_coefficients @ kernel @ to_coefficients.T @ means.T
        return 0.5 * (found + found.T)

    def _rows(self) -> list[slice]:
        return [slice(begin, end) for begin, end in zip(self.first, np.append(self.first[1:], len(self.whole.control)))]

    @staticmethod
    def _within(shares: NDArray[np.float64], control: NDArray[np.float64]) -> float:
        """The variance of one state, by shares and control of its rows (n,)."""
        # In parts short enough for no exponential to overflow.
        part_of = np.floor((control - control[0]) / 100)
        total, before, place = 0.0, 0.0, control[0]
        for part in np.split(np.arange(len(shares)), 1 + np.flatnonzero(np.diff(part_of))):
            own, at = shares[part], control[part]
            apart = at - at[0]
            running = np.exp(-apart) * np.cumsum(own * np.exp(apart)) + before * np.exp(-(at - place))
            total += 2 * own @ running - own @ own
            before, place = running[-1], at[-1]
        return float(total)


def _means(reference: Reference, first: NDArray[np.intp]) -> Reference:
    counts = np.diff(np.append(first, len(reference.control)))
    control, *values = (np.add.reduceat(column, first) / counts for column in (reference.control, *reference.measured.values()))
    means = dict(zip(reference.measured, values))
    return Reference(
        control,
        {name: means[name] for name in reference.names},
        reference.variance_shares,
        reference.measurement_errors,
        control_name=reference.control_name,
        control_step=reference.control_step,
        simulated=reference.simulated,
        recorded={name: means[name] for name in reference.recorded},
    )


def _first_rows(reference: Reference) -> NDArray[np.intp]:
    control, values = reference.control, reference.values
    # As many by the rows as by the control, or a few rows far from many would count for nothing.
    even = np.searchsorted(control, np.linspace(control[0], control[-1], _BLOCKS, endpoint=False))
    blocks = np.union1d(np.linspace(0, len(control), min(_BLOCKS, len(control)), endpoint=False).astype(np.intp), even)
    counts = np.diff(np.append(blocks, len(control)))
    middle = np.add.reduceat(control, blocks) / counts
    curve = np.add.reduceat(values, blocks, axis=0) / counts[:, None]
    # To both ends of the control.
    middle, curve = np.concatenate([control[:1], middle, control[-1:]]), np.concatenate([curve[:1], curve, curve[-1:]])
    columns = np.column_stack([middle, curve])
    extents = np.ptp(columns, axis=0)
    advance = np.abs(np.diff(columns, axis=0)) / np.where(extents > 0, extents, 1)
    way = np.append(0, advance.sum(axis=1).cumsum())
    states = int(np.clip(np.ceil(way[-1] / STEP), FEWEST, MOST)) - 2
    of_row = np.minimum((np.interp(control, middle, way) / way[-1] * states).astype(np.intp), states - 1)
    # The ends stand alone: errors that are correlated along a curve hide its slope, but at its ends.
    return np.union1d(np.flatnonzero(np.diff(of_row, prepend=-1)), [1, len(control) - 1])
