"""How probable a reference is, given a response: Gaussian, under each hypothesis on its errors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from graincal.data import Reference
from graincal.inference.likelihood.error_model import ErrorModel
from graincal.inference.likelihood.reduction import columns


def log_likelihood(responses: NDArray[np.float64], reference: Reference, errors: ErrorModel) -> NDArray[np.float64]:
    """log p(y | x) under each hypothesis, (N, H), of responses x (N, T, J) that have no error of their own; -inf where one is not finite."""
    residuals = columns(reference.values) - columns(np.asarray(responses))
    finite = np.isfinite(residuals).all(axis=1)
    logs = np.full((len(residuals), errors.size), -np.inf)
    for h, covariance in enumerate(errors.covariances):
        factor = np.linalg.cholesky(covariance)
        white = scipy.linalg.solve_triangular(factor, residuals[finite].T, lower=True)
        logs[finite, h] = -0.5 * np.sum(white**2, axis=0) - np.log(np.diag(factor)).sum() - 0.5 * len(factor) * np.log(2 * np.pi)
    return logs


def marginal(logs: NDArray[np.float64], log_prior: NDArray[np.float64]) -> NDArray[np.float64]:
    """log p(y | x), (N,), hypotheses (N, H) weighed by their prior."""
    return scipy.special.logsumexp(logs + log_prior, axis=1)


@dataclass(frozen=True, eq=False)
class ReducedLikelihood:
    """The likelihood of responses that are known as centre + basis z, z a Gaussian of mean (N, q) and independent variances (N, q).

    The covariance of the reference is that of each hypothesis, plus `added` (J T, J T), plus basis diag(variance) basis^T. Its inverse and
    determinant follow from those of the first two, which do not change from response to response (Woodbury, 1950).
    """

    log_prior: NDArray[np.float64]
    constant: NDArray[np.float64]  # (H,): -1/2 (r^T S^-1 r + log det 2 pi S) at the centre
    slope: NDArray[np.float64]  # (H, q): B^T S^-1 r at the centre
    curvature: NDArray[np.float64]  # (H, q, q): B^T S^-1 B

    @classmethod
    def of(
        cls, reference: Reference, errors: ErrorModel, centre: NDArray[np.float64], basis: NDArray[np.float64], added: NDArray[np.float64]
    ) -> ReducedLikelihood:
        """Of curves around centre (J T,) along basis (J T, q)."""
        residual = columns(reference.values) - centre
        constant, slope, curvature = [], [], []
        for covariance in errors.covariances:
            factor = scipy.linalg.cho_factor(covariance + added, lower=True)
            solved = scipy.linalg.cho_solve(factor, np.column_stack([residual, basis]))
            constant.append(-0.5 * residual @ solved[:, 0] - np.log(np.diag(factor[0])).sum() - 0.5 * len(residual) * np.log(2 * np.pi))
            slope.append(basis.T @ solved[:, 0])
            curvature.append(basis.T @ solved[:, 1:])
        return cls(errors.log_prior, np.array(constant), np.array(slope), np.array(curvature))

    def hypotheses(self, mean: NDArray[np.float64], variance: NDArray[np.float64]) -> NDArray[np.float64]:
        """log p(y | z), (N, H)."""
        q = mean.shape[1]
        logs = np.empty((len(mean), len(self.constant)))
        deviation = np.sqrt(variance)
        # Bordered by the gradient, one factorisation gives the determinant and the square: the matrix is at least the identity, so the corner stays above 1.
        bordered = np.empty((len(mean), q + 1, q + 1))
        for h in range(len(self.constant)):
            pulled = mean @ self.curvature[h]
            exact = self.constant[h] + mean @ self.slope[h] - 0.5 * np.sum(pulled * mean, axis=1)
            gradient = deviation * (self.slope[h] - pulled)
            corner = 1 + np.sum(gradient**2, axis=1)
            bordered[:, :q, :q] = np.eye(q) + deviation[:, :, None] * self.curvature[h] * deviation[:, None, :]
            bordered[:, q, :q] = bordered[:, :q, q] = gradient
            bordered[:, q, q] = corner
            diagonal = np.einsum("nii->ni", np.linalg.cholesky(bordered))
            logs[:, h] = exact + 0.5 * (corner - diagonal[:, q] ** 2) - np.log(diagonal[:, :q]).sum(axis=1)
        return logs

    def exact(self, components: NDArray[np.float64]) -> NDArray[np.float64]:
        """log p(y | z), (...), of components (..., q) that are known."""
        logs = [
            constant + components @ slope - 0.5 * np.sum(components @ curvature * components, axis=-1)
            for constant, slope, curvature in zip(self.constant, self.slope, self.curvature)
        ]
        return scipy.special.logsumexp(np.stack(logs, axis=-1) + self.log_prior, axis=-1)

    def __call__(self, mean: NDArray[np.float64], variance: NDArray[np.float64]) -> NDArray[np.float64]:
        """log p(y | z), (N,), over all hypotheses."""
        return marginal(self.hypotheses(mean, variance), self.log_prior)

    def expected(self, mean: NDArray[np.float64], variance: NDArray[np.float64]) -> NDArray[np.float64]:
        """The log likelihood that may be expected of responses (N,): over the hypotheses, of the log likelihood expected under each (at least that, by
        Jensen's inequality; exactly, for one hypothesis). Where a response is uncertain it is less than `__call__`'s log of an expectation, which a response
        that is far off but may be anything can have, too."""
        logs = np.empty((len(mean), len(self.constant)))
        for h in range(len(self.constant)):
            squares = np.sum(mean @ self.curvature[h] * mean, axis=1) + variance @ np.diag(self.curvature[h])
            logs[:, h] = self.constant[h] + mean @ self.slope[h] - 0.5 * squares
        return marginal(logs, self.log_prior)
