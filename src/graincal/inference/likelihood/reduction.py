"""Curves as a few numbers each: principal components, of the whole of a curve or of one segment after the other."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

# Components are kept until what is left of the variance is below this part, and at most so many of a whole curve, or of each of several segments.
LEFT_OUT = 1e-5
MOST_COMPONENTS, MOST_OF_SEGMENT = 8, 4


def columns(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Curves (..., T, J) observable by observable, as the error model orders them: (..., J T)."""
    return np.swapaxes(values, -1, -2).reshape(*values.shape[:-2], values.shape[-1] * values.shape[-2])


class Reduction:
    """Curves as basis times scores. Those of a segment are the principal components of what the scores of the segments before it do not say of it.

    So the scores of a curve's first segments are known whatever becomes of the others; and over the curves each has a mean of 0, a variance of 1, and no
    correlation with another. One segment gives principal components.

    scores (N, q), basis (K, q); left_out (K,): the variance of what they leave out.
    """

    def __init__(self, curves: NDArray[np.float64], segments: NDArray[np.int64]) -> None:
        """curves (N, K) about their mean; segments (K,): the number of the segment that each of a curve's numbers is of, from 0."""
        count, total, several = len(curves), max(np.sum(curves**2), 1e-300), segments.max() + 1
        self.scores, self.basis = np.empty((count, 0)), np.zeros((curves.shape[1], 0))
        self._segments, self._of, self._deviation = segments, np.empty(0, dtype=np.int64), np.empty(0)
        for segment in range(several):
            mine, before = segments == segment, self.scores.shape[1]
            self.basis[mine] = curves[:, mine].T @ self.scores / count
            left, sizes, right = np.linalg.svd(curves[:, mine] - self.scores @ self.basis[mine].T, full_matrices=False)
            remaining = (np.sum(sizes**2) - np.cumsum(sizes**2)) / total
            enough = int(np.argmax(remaining < LEFT_OUT / several)) + 1
            q = max(min(MOST_COMPONENTS if several == 1 else MOST_OF_SEGMENT, enough, count - 1 - before), 0)
            deviation = np.maximum(sizes[:q] / np.sqrt(count), 1e-12)
            self.scores = np.column_stack([self.scores, left[:, :q] * sizes[:q] / deviation])
            self.basis = np.column_stack([self.basis, np.zeros((curves.shape[1], q))])
            self.basis[mine, before:] = right[:q].T * deviation
            self._of, self._deviation = np.append(self._of, np.full(q, segment)), np.append(self._deviation, deviation)
        self.left_out = np.mean((curves - self.scores @ self.basis.T) ** 2, axis=0)

    def of_first_segments(self, curves: NDArray[np.float64]) -> NDArray[np.float64]:
        """The scores (M, q) of curves (M, K) that are NaN from somewhere on: those of the segments that are there, NaN for the others."""
        scores = np.zeros((len(curves), self.scores.shape[1]))
        for segment in range(self._segments.max() + 1):
            mine, own = self._segments == segment, self._of == segment
            scores[:, own] = (curves[:, mine] - scores @ self.basis[mine].T) @ self.basis[np.ix_(mine, own)] / self._deviation[own] ** 2
        return scores
