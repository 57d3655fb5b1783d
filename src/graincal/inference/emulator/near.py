"""By how much a process is too sure or too unsure of itself at a place, as the evaluations near it show."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

# How far evaluations tell of a place: one standard deviation, in each of the coordinates of the processes; and as how many evaluations what holds everywhere counts. Of two emulators of 610 runs of a measured test
# the density of what was held out is the larger by factors of exp(3) and exp(4) a run over all, and of exp(0.4) and exp(0.5) near the reference; over all, half or one and a half times the width gives less.
WIDTH, BEFORE = 0.09, 3.0


class NearBy:
    """Factors of variances at places, from evaluations that were each predicted from the others.

    A process whose lengths are those of the whole box is too sure where responses change faster than elsewhere, and too unsure where they change more slowly. At a place the factor is the mean square of standardised
    errors, evaluations weighted by a Gaussian of their distance, and with BEFORE evaluations more that say what holds everywhere.
    """

    def __init__(self, points: NDArray[np.float64], squares: NDArray[np.float64], everywhere: NDArray[np.float64]) -> None:
        """points (N, n); squares (N, q) of standardised errors there, of each process; everywhere (q,): the factors before there is an evaluation near."""
        self._points, self._squares, self.everywhere = points, squares, everywhere
        self._scale = WIDTH * np.sqrt(2 * points.shape[1])

    def at(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(M, q), at points (M, n)."""
        return self._factors(self._nearness(points))

    def held_out(self) -> NDArray[np.float64]:
        """(N, q), at each of the evaluations by the others."""
        nearness = self._nearness(self._points)
        np.fill_diagonal(nearness, 0.0)
        return self._factors(nearness)

    def _nearness(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        a, b = points / self._scale, self._points / self._scale
        return np.exp(np.minimum(2 * a @ b.T - np.sum(a**2, axis=1)[:, None] - np.sum(b**2, axis=1), 0))

    def _factors(self, nearness: NDArray[np.float64]) -> NDArray[np.float64]:
        return (BEFORE * self.everywhere + nearness @ self._squares) / (BEFORE + nearness.sum(axis=1))[:, None]
