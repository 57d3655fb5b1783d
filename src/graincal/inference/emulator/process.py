"""A Gaussian process of one number over the unit cube."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

# Added to the diagonal, so that a covariance of nearly equal points can be factored.
JITTER = 1e-10

# The same, of what values may be beside those that are known, as a part of the variance: a difference of two covariances has lost digits.
ROUNDING = 1e-7

# Kernels are found by so many of the values at the most; all are predicted by.
JUDGED_BY = 400

# Predictions are made at so many points at once that their covariances with the values fit the processor's cache, and at no fewer than keep it at work.
MOST_AT_ONCE, FEWEST_AT_ONCE = 2**17, 64

# Of the inverse of a factor, half of which is zero, so many rows at once are multiplied by as far as they are not.
ROWS = 128

# Ends of the variance, the lengths and the nugget; what each is thought to be before there is a value, and how far from that it may well be (a factor, one sd):
# lengths about the width of the box, a nugget of a thousandth of the variance.
_ENDS = ((1e-2, 1e3), (5e-2, 1e2), (1e-7, 1.0))
_MIDDLE, _FACTOR = (3.0, 1.0, 1e-3), (10.0, 3.0, 30.0)


class Kernel(NamedTuple):
    """The covariance of a process: variance x Matern 3/2 over distances in parts of `lengths` (n,), and the nugget, which is that of what differs between two values
    at one point. On the triaxial test Matern 5/2 predicts no better, is the more probable, and is three standard deviations wrong where the posterior is."""

    variance: float
    lengths: NDArray[np.float64]
    nugget: float

    def distances(self, a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
        """√3 times those between points (M, n) and (N, n): (M, N)."""
        a, b = a / self.lengths, b / self.lengths
        squared = np.sum(a**2, axis=1)[:, None] + np.sum(b**2, axis=1) - 2 * a @ b.T
        return np.sqrt(3 * np.maximum(squared, 0, out=squared), out=squared)

    def covariance(self, a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
        """Between the values without nugget at points (M, n) and (N, n): (M, N)."""
        distance = self.distances(a, b)
        return (self.variance * (1 + distance)) * np.exp(-distance)


class Process:
    """Values (N,) at points (N, n), by the most probable kernel."""

    def __init__(self, unit: NDArray[np.float64], values: NDArray[np.float64], start: Kernel | None = None, known: Kernel | None = None) -> None:
        """start: a kernel to begin the search for the most probable one at; known: that one, found before. Values that are NaN are not known, and left out with their points."""
        self._known = np.isfinite(values)
        self._unit, self.values = unit[self._known], values[self._known]
        judges = judged_by(len(self.values))
        with threadpool_limits(1):
            self.kernel = known or _most_probable(self._unit[judges], self.values[judges], start)
            factor = _Factor(self.kernel, self._unit)
            self._solved = factor.solve(self.values)
            self._inverse = scipy.linalg.lapack.dtrtri(factor.lower, lower=1)[0]

    @property
    def nugget(self) -> float:
        """The variance of one value about the others at its point."""
        return self.kernel.nugget

    def predict(self, unit: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The mean (M,) at points (M, n) and its variance (M,), without the nugget."""
        mean, explained = np.empty((2, len(unit)))
        at_once = max(FEWEST_AT_ONCE, MOST_AT_ONCE // len(self.values))
        for begin in range(0, len(unit), at_once):
            rows = slice(begin, begin + at_once)
            covariance = self.kernel.covariance(unit[rows], self._unit)
            mean[rows] = covariance @ self._solved
            explained[rows] = self._explained(covariance)
        return mean, np.maximum(self.kernel.variance - explained, 0)

    def _explained(self, covariance: NDArray[np.float64]) -> NDArray[np.float64]:
        """How much of the variance at points the values explain, (M,), by the covariances (M, N): the squares of the inverse factor times these."""
        explained = np.zeros(len(covariance))
        # What is right of the factor's diagonal is zero. BLAS's own product of a triangle, as SciPy calls it, is as fast by one thread, and no faster by two.
        for begin in range(0, len(self.values), ROWS):
            end = begin + ROWS
            part = covariance[:, :end] @ self._inverse[begin:end, :end].T
            explained += np.einsum("ij,ij->i", part, part)
        return explained

    def drawn(self, unit: NDArray[np.float64], normal: NDArray[np.float64]) -> NDArray[np.float64]:
        """What the values without nugget may be at points (M, n), less their mean, together: (count, M), from as many standard normal numbers."""
        explained = self.kernel.covariance(unit, self._unit) @ self._inverse.T
        covariance = self.kernel.covariance(unit, unit) - explained @ explained.T
        # Of points near to values that are known, or to one another, it is not positive definite but for roundings.
        covariance[np.diag_indices(len(unit))] += ROUNDING * self.kernel.variance
        lower, failed = scipy.linalg.lapack.dpotrf(covariance, lower=1, clean=1)
        if failed:
            raise np.linalg.LinAlgError("the covariance of what values may be is not positive definite")
        return normal @ lower.T

    def held_out(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """How far each value that is known is from its prediction by the others (N,), and the standard deviation of that, nugget included. Source: Rasmussen and Williams (2006), Eq. 5.12."""
        precision = np.sum(self._inverse**2, axis=0)
        return self._solved / precision, 1 / np.sqrt(precision)

    def surprise(self, unit: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        """Less the log likelihood of the values that kernels are judged by if all were at other points (N, n), but for a constant; and its slope (N, n) by these."""
        rows = np.flatnonzero(self._known)[judged_by(len(self.values))]
        points, values = unit[rows], self.values[judged_by(len(self.values))]
        factor = _Factor(self.kernel, points)
        surprise, residual = factor.surprise(values)
        pull = residual * (1.5 * self.kernel.variance * np.exp(-factor.distances))
        slope = np.zeros_like(unit)
        # Less 1/2 sum of `pull` times the squared distances, each of which has two ends, is what the surprise goes with.
        slope[rows] = 2 * (pull @ points - pull.sum(axis=1)[:, None] * points) / self.kernel.lengths**2
        return surprise, slope


def judged_by(count: int) -> slice:
    """Which of so many values a kernel is found by: all, or every second, third, ... of them."""
    return slice(None, None, -(-count // JUDGED_BY))


class _Factor:
    """The covariance of values at points (N, n), factored."""

    def __init__(self, kernel: Kernel, unit: NDArray[np.float64]) -> None:
        self.distances = kernel.distances(unit, unit)
        self.without_nugget = (kernel.variance * (1 + self.distances)) * np.exp(-self.distances)
        covariance = self.without_nugget.copy()
        covariance[np.diag_indices(len(unit))] = kernel.variance + kernel.nugget + JITTER
        self.lower, failed = scipy.linalg.lapack.dpotrf(covariance, lower=1, clean=1)
        if failed:
            raise np.linalg.LinAlgError("the covariance of a process is not positive definite")

    def solve(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        return scipy.linalg.cho_solve((self.lower, True), values, check_finite=False)

    def surprise(self, values: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        """Less the log likelihood of the values, but for a constant, and twice its slope by the covariance, (N, N): K⁻¹ - K⁻¹ y yᵀ K⁻¹. Source: Rasmussen and Williams (2006),
        Eq. 5.9."""
        solved = self.solve(values)
        below = scipy.linalg.lapack.dpotri(self.lower, lower=1)[0]
        inverse = np.tril(below) + np.tril(below, -1).T
        return float(0.5 * values @ solved + np.log(np.diag(self.lower)).sum()), inverse - np.outer(solved, solved)


def _most_probable(unit: NDArray[np.float64], values: NDArray[np.float64], start: Kernel | None) -> Kernel:
    """The kernel of the largest marginal likelihood times its prior."""
    size = unit.shape[1]
    ends, middle, width = (np.log(np.array([each[0], *[each[1]] * size, each[2]])) for each in (_ENDS, _MIDDLE, _FACTOR))
    first = np.array([1.0, *np.ones(size), 1e-2]) if start is None else np.array([start.variance, *start.lengths, start.nugget])

    def kernel(logs: NDArray[np.float64]) -> Kernel:
        numbers = np.exp(logs)
        return Kernel(float(numbers[0]), numbers[1:-1], float(numbers[-1]))

    def surprise(logs: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        tried = kernel(logs)
        factor = _Factor(tried, unit)
        value, residual = factor.surprise(values)
        by_squares = residual * (1.5 * tried.variance * np.exp(-factor.distances))
        scaled, of_rows = unit / tried.lengths, by_squares.sum(axis=1)
        along = of_rows @ scaled**2 - np.einsum("ik,ik->k", scaled, by_squares @ scaled)
        slope = np.array([0.5 * np.sum(residual * factor.without_nugget), *(2 * along), 0.5 * tried.nugget * np.trace(residual)])
        away = (logs - middle) / width
        return value + 0.5 * away @ away, slope + away / width

    found = scipy.optimize.minimize(surprise, np.log(first), jac=True, method="L-BFGS-B", bounds=[tuple(each) for each in ends], options={"maxiter": 100})
    return kernel(found.x)
