"""What a model's response would be: its curves reduced to a few numbers, and a Gaussian process on the parameters for each of them."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.optimize import minimize
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, Kernel, Matern, WhiteKernel
from threadpoolctl import threadpool_limits

from graincal.data import Reference
from graincal.inference.likelihood import columns

# Of the Matern kernel. On the triaxial test 5/2 predicts no better, is the more probable, and is three standard deviations wrong where the posterior is.
SMOOTHNESS = 1.5

# Components are kept until what is left of the variance is below this part, and at most so many.
LEFT_OUT = 1e-5
MOST_COMPONENTS = 8


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Each evaluation as predicted by an emulator trained on the others.

    error (N,): root mean square of predicted minus found, over that of the curves about their mean. within (N, q): whether each component lies
    in its 90 % interval, nugget included.
    """

    error: NDArray[np.float64]
    within: NDArray[np.bool_]


class Emulator:
    """Predicts responses over the unit cube, (T, J) each, from those of N evaluations.

    Curves are scaled by the reference's peaks and reduced to q principal components. Each component is a Gaussian process with a Matern 3/2 kernel,
    one length for each parameter, and a nugget: what differs between two runs at one Theta. The
    nugget is in the covariance of the simulator, and not in the variance of the mean response. Source: Higdon et al. (2008), JASA 103.

    centre (J T,), basis (J T, q): a response is centre + basis z, observable by observable. simulator (J T, J T): the covariance of runs at one
    Theta. truncation (J T,): the variance of what the components leave out.
    """

    def __init__(
        self,
        unit: NDArray[np.float64],
        responses: NDArray[np.float64],
        reference: Reference,
        start: Emulator | None = None,
        seen: slice | NDArray[np.intp] = slice(None),
    ) -> None:
        """unit (N, n), responses (N, T, J), of evaluations that succeeded, at least two. start: an emulator of fewer of them, to begin the search at.

        seen: an index of the parameters that the model sees; the others are not looked at.
        """
        peaks = np.abs(reference.values).max(axis=0)
        scale = np.repeat(np.where(peaks > 0, peaks, 1.0), len(reference.control))
        curves = columns(responses) / scale
        middle = curves.mean(axis=0)
        left, sizes, right = np.linalg.svd(curves - middle, full_matrices=False)
        remaining = 1 - np.cumsum(sizes**2) / max(np.sum(sizes**2), 1e-300)
        q = min(MOST_COMPONENTS, int(np.argmax(remaining < LEFT_OUT)) + 1, len(unit) - 1)
        deviation = np.maximum(sizes[:q] / np.sqrt(len(unit)), 1e-12)
        scores = left[:, :q] * sizes[:q] / deviation
        self.centre = scale * middle
        self.basis = scale[:, None] * right[:q].T * deviation
        left_out = curves - middle - scores * deviation @ right[:q]
        self.truncation = scale**2 * np.mean(left_out**2, axis=0)
        self._seen = seen
        starts = [process.kernel for process in start._processes] if start is not None else []
        self._processes = [_Process(unit[:, seen], score, starts[k] if k < len(starts) else None) for k, score in enumerate(scores.T)]
        self.inflation = np.ones(q)
        self.nuggets = np.array([process.nugget for process in self._processes])
        self._total = np.sqrt(np.mean((curves - middle) ** 2))
        self._size = deviation / np.sqrt(curves.shape[1])

    @property
    def simulator(self) -> NDArray[np.float64]:
        """The covariance of a run about the mean response at its Theta, (J T, J T)."""
        return (self.basis * self.nuggets) @ self.basis.T

    def predict(self, unit: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The mean (M, q) of the components of the mean response at points (M, n), and the variance of that mean (M, q), without the nugget."""
        means, variances = zip(*(process.predict(unit[:, self._seen]) for process in self._processes))
        return np.column_stack(means), self.inflation * np.column_stack(variances)

    def trust(self, weights: NDArray[np.float64]) -> None:
        """Widen the variances of the mean to what the evaluations show, each predicted from the others, where it matters: by weights (N,) that sum to 1.

        A process whose lengths fit the whole box is too sure of itself where responses change faster than elsewhere. It is never made surer.
        """
        errors, deviations = zip(*(process.held_out() for process in self._processes))
        self.inflation = np.maximum(1.0, weights @ (np.column_stack(errors) / np.column_stack(deviations)) ** 2)

    def curves(self, components: NDArray[np.float64], observables: int) -> NDArray[np.float64]:
        """Components (M, q) as curves (M, T, J)."""
        flat = self.centre + components @ self.basis.T
        return np.swapaxes(flat.reshape(*flat.shape[:-1], observables, -1), -1, -2)

    def held_out(self) -> HeldOut:
        """How it predicts each evaluation from the others."""
        errors, deviations = zip(*(process.held_out() for process in self._processes))
        errors, deviations = np.column_stack(errors), np.column_stack(deviations)
        return HeldOut(np.sqrt(np.sum((errors * self._size) ** 2, axis=1)) / self._total, np.abs(errors) <= 1.6449 * deviations)


class _Process:
    """A Gaussian process of one component."""

    def __init__(self, unit: NDArray[np.float64], values: NDArray[np.float64], start: Kernel | None) -> None:
        size = unit.shape[1]
        kernel = ConstantKernel(1.0, (1e-2, 1e3)) * Matern(np.ones(size), (5e-2, 1e2), nu=SMOOTHNESS) + WhiteKernel(1e-2, (1e-7, 1.0))
        if start is not None:
            kernel.theta = start.theta
        process = GaussianProcessRegressor(kernel, alpha=1e-10, optimizer=_most_probable)
        with threadpool_limits(1), warnings.catch_warnings():
            # A length at the end of its range says that a parameter does not matter.
            warnings.simplefilter("ignore", ConvergenceWarning)
            process.fit(unit, values)
        self.kernel = process.kernel_
        self.nugget = float(self.kernel.k2.noise_level)
        self._unit = unit
        self._variance = float(self.kernel.k1.k1.constant_value)
        self._lengths = np.broadcast_to(self.kernel.k1.k2.length_scale, (size,))
        self._solved = process.alpha_
        self._inverse = solve_triangular(process.L_, np.eye(len(unit)), lower=True)

    def predict(self, unit: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        a, b = unit / self._lengths, self._unit / self._lengths
        squared = np.maximum(np.sum(a**2, axis=1)[:, None] + np.sum(b**2, axis=1) - 2 * a @ b.T, 0)
        distance = np.sqrt(3 * squared)
        covariance = self._variance * (1 + distance) * np.exp(-distance)
        variance = self._variance - np.sum((covariance @ self._inverse.T) ** 2, axis=1)
        return covariance @ self._solved, np.maximum(variance, 0)

    def held_out(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        # Rasmussen and Williams (2006), Eq. 5.12.
        precision = np.sum(self._inverse**2, axis=0)
        return self._solved / precision, 1 / np.sqrt(precision)


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
