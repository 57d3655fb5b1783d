"""A Gaussian process of one number over the unit cube."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.optimize import minimize
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, Kernel, Matern, WhiteKernel
from threadpoolctl import threadpool_limits

# Of the Matern kernel. On the triaxial test 5/2 predicts no better, is the more probable, and is three standard deviations wrong where the posterior is.
SMOOTHNESS = 1.5

# Added to the diagonal, so that a covariance of nearly equal points can be factored.
JITTER = 1e-10


class Process:
    """Values (N,) at points (N, n), by a Matern 3/2 kernel with a length for each parameter and a nugget: what differs between two values at one point."""

    def __init__(self, unit: NDArray[np.float64], values: NDArray[np.float64], start: Kernel | None = None) -> None:
        """start: a kernel to begin the search for the most probable one at. Values that are NaN are not known, and left out with their points."""
        self._known = np.isfinite(values)
        unit, values = unit[self._known], values[self._known]
        size = unit.shape[1]
        kernel = ConstantKernel(1.0, (1e-2, 1e3)) * Matern(np.ones(size), (5e-2, 1e2), nu=SMOOTHNESS) + WhiteKernel(1e-2, (1e-7, 1.0))
        if start is not None:
            kernel.theta = start.theta
        process = GaussianProcessRegressor(kernel, alpha=JITTER, optimizer=_most_probable)
        with threadpool_limits(1), warnings.catch_warnings():
            # A length at the end of its range says that a parameter does not matter.
            warnings.simplefilter("ignore", ConvergenceWarning)
            process.fit(unit, values)
        self.kernel = process.kernel_
        self.nugget = float(self.kernel.k2.noise_level)
        self.values = values
        self._unit = unit
        self._variance = float(self.kernel.k1.k1.constant_value)
        self._lengths = np.broadcast_to(self.kernel.k1.k2.length_scale, (size,))
        self._solved = process.alpha_
        self._inverse = solve_triangular(process.L_, np.eye(len(unit)), lower=True)

    def covariance(self, a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
        """Between the values without nugget at points (M, n) and (N, n): (M, N)."""
        a, b = a / self._lengths, b / self._lengths
        distance = np.sqrt(3 * np.maximum(np.sum(a**2, axis=1)[:, None] + np.sum(b**2, axis=1) - 2 * a @ b.T, 0))
        return self._variance * (1 + distance) * np.exp(-distance)

    def predict(self, unit: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The mean (M,) at points (M, n) and its variance (M,), without the nugget."""
        covariance = self.covariance(unit, self._unit)
        variance = self._variance - np.sum((covariance @ self._inverse.T) ** 2, axis=1)
        return covariance @ self._solved, np.maximum(variance, 0)

    def draw(self, unit: NDArray[np.float64], count: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """What the values without nugget may be at points (M, n), less their mean, together: (count, M)."""
        explained = self.covariance(unit, self._unit) @ self._inverse.T
        values, vectors = np.linalg.eigh(self.covariance(unit, unit) - explained @ explained.T)
        return rng.standard_normal((count, len(unit))) * np.sqrt(np.maximum(values, 0)) @ vectors.T

    def held_out(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """How far each value that is known is from its prediction by the others (N,), and the standard deviation of that, nugget included. Source: Rasmussen and Williams (2006), Eq. 5.12."""
        precision = np.sum(self._inverse**2, axis=0)
        return self._solved / precision, 1 / np.sqrt(precision)

    def log_likelihood(self, unit: NDArray[np.float64]) -> float:
        """Of the values if they were at other points (N, n), but for a constant."""
        unit = unit[self._known]
        covariance = self.covariance(unit, unit)
        covariance[np.diag_indices(len(unit))] = self._variance + self.nugget + JITTER
        factor = np.linalg.cholesky(covariance)
        return float(-0.5 * np.sum(solve_triangular(factor, self.values, lower=True) ** 2) - np.log(np.diag(factor)).sum())


def _most_probable(objective, start: NDArray[np.float64], bounds: Sequence[tuple[float, float]]) -> tuple[NDArray[np.float64], float]:
    """The hyperparameters of the largest marginal likelihood times a prior: lengths about the width of the box (within a factor of three, one sd), a nugget
    of a thousandth of the variance (within a factor of thirty)."""
    count = len(start)
    middle = np.zeros(count)
    width = np.full(count, np.log(3.0))
    middle[0], width[0] = np.log(3.0), np.log(10.0)
    middle[-1], width[-1] = np.log(1e-3), np.log(30.0)

    def penalised(x):
        value, gradient = objective(x)
        away = (x - middle) / width
        return value + 0.5 * np.sum(away**2), gradient + away / width

    found = minimize(penalised, start, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": 100})
    return found.x, found.fun
