"""Curves that are linear in three parameters, and their exact posterior under correlated errors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from graincal import ParameterSpace, Reference

CONTROL = np.linspace(0, 1, 30)
CORRELATION_LENGTH = 0.1
DESIGN = np.stack([np.ones_like(CONTROL), CONTROL, np.sin(3 * CONTROL)], axis=1)


def curves(theta: NDArray[np.float64]) -> NDArray[np.float64]:
    """Responses (N, T, 1)."""
    return (theta @ DESIGN.T)[:, :, None]


@dataclass(frozen=True, eq=False)
class LinearCase:
    """A reference with errors of `noise` times its peak, in a box at least seven standard deviations wide each way, and what is known of it.

    theta | y is Gaussian about the generalised least squares solution, and the evidence is that of y ~ N(A theta, Sigma) integrated over the box.
    """

    reference: Reference
    space: ParameterSpace
    mean: NDArray[np.float64]
    covariance: NDArray[np.float64]
    log_evidence: float

    @property
    def deviation(self) -> NDArray[np.float64]:
        """The posterior's standard deviations."""
        return np.sqrt(np.diag(self.covariance))


def linear_case(noise: float, scatter: NDArray[np.float64] | None = None) -> LinearCase:
    """The case of a relative noise; scatter (T, T): the covariance of the reference beside its errors, where a simulation made it."""
    values = DESIGN @ np.array([1.0, 0.5, -0.3])
    deviation = noise * np.abs(values).max()
    reference = Reference(CONTROL, {"y": values + 0.5 * deviation * np.cos(9 * CONTROL)}, measurement_errors={"y": deviation}, simulated=scatter is not None)
    kernel = np.exp(-np.abs(CONTROL[:, None] - CONTROL[None, :]) / CORRELATION_LENGTH)
    covariance = deviation**2 * kernel + (1e-6 * np.abs(reference.values).max()) ** 2 * np.eye(len(CONTROL)) + (0 if scatter is None else scatter)
    factor = cho_factor(covariance, lower=True)
    covariance = np.linalg.inv(DESIGN.T @ cho_solve(factor, DESIGN))
    mean = covariance @ DESIGN.T @ cho_solve(factor, reference.values[:, 0])
    # The box's centre is not that of the posterior.
    space = ParameterSpace({name: (m - 7 * s, m + 9 * s) for name, m, s in zip("abc", mean, np.sqrt(np.diag(covariance)))})
    residual = reference.values[:, 0] - DESIGN @ mean
    log_peak = -0.5 * residual @ cho_solve(factor, residual) - np.log(np.diag(factor[0])).sum() - 0.5 * len(CONTROL) * np.log(2 * np.pi)
    log_evidence = log_peak + 0.5 * np.linalg.slogdet(2 * np.pi * covariance)[1] - space.log_volume
    return LinearCase(reference, space, mean, covariance, float(log_evidence))
