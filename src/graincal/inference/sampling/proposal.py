"""The proposal of the next iteration: a Gaussian mixture of the weighted samples, truncated to the box."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import scipy
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from graincal.data import ParameterSpace

COVARIANCES = ("tied", "full")

# The least standard deviation of a component, in widths of the box: what keeps a mixture fitted to a single point a density.
LEAST_WIDTH = 1e-3

# Points that the mass of a component is integrated by. Where constraints cut through it, the integrand is no smooth function: then so many again, until its standard error, were they independent, is small
# enough; quasi-random ones do better than that.
POINTS, ROUNDS, CUT_EXACT = 4096, 16, 0.01

# Below this mass in the box, drawing by rejection costs more than ten thousand draws a sample, and a fit to points of the box has gone wrong.
LEAST_MASS = 1e-4


class ProposalOutsideBox(ArithmeticError):
    """Too little of a mixture lies where the prior holds parameters possible to draw from it. The message says how much."""


def systematic_resampling(weights: NDArray[np.float64], count: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """Rows drawn in proportion to their weights (N,), (count,) indices in ascending order.

    One random number shifts an even comb over the cumulated weights: row i appears count w_i times on average, and never a whole
    time more or less than that. Rows of weight zero never appear.
    """
    cumulated = np.cumsum(weights)
    comb = (np.arange(count) + rng.random()) / count
    # Rounding may carry the last tooth to 1 exactly, past the last row.
    return np.searchsorted(cumulated / cumulated[-1], np.minimum(comb, np.nextafter(1, 0)), side="right")


@dataclass(frozen=True, eq=False)
class TruncatedMixture:
    """A Gaussian mixture in coordinates scaled by the box (the unit cube), cut off at its faces and where constraints do not hold, and renormalised.

    `weights` (K,) sum to 1; `means` (K, n); `covariances` (K, n, n).
    """

    space: ParameterSpace
    weights: NDArray[np.float64]
    means: NDArray[np.float64]
    covariances: NDArray[np.float64]

    @cached_property
    def mass(self) -> float:
        """The part of the whole mixture that the prior holds possible, to a relative 1e-3 up to five parameters; with constraints to a relative 1e-2."""
        if self.space.constraints:
            return _mass_left(self)
        return float(
            self.weights
            @ [_in_cube(mean, np.linalg.cholesky(covariance), _even_points(len(mean)))[0].mean() for mean, covariance in zip(self.means, self.covariances)]
        )

    def log_density(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        """The log of the density (N,) at theta (N, n), in the parameters' own units: it integrates to 1 over the prior's part of the box and is -inf outside."""
        unit = np.atleast_2d(self.space.to_unit(theta))
        logs = []
        for mean, factor in zip(self.means, np.linalg.cholesky(self.covariances)):
            z = (unit - mean) @ scipy.linalg.solve_triangular(factor, np.eye(len(mean)), lower=True).T
            logs.append(-0.5 * np.einsum("mi,mi->m", z, z) - np.log(np.diag(factor)).sum() - 0.5 * len(mean) * np.log(2 * np.pi))
        inside = scipy.special.logsumexp(np.array(logs), axis=0, b=self.weights[:, None])
        return np.where(self.space.contains(theta), inside - np.log(self.mass) - self.space.log_box_volume, -np.inf)

    def draw(self, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """`count` independent points (count, n) of the truncated mixture, drawn from the whole one and kept where the prior holds them possible.

        Raises ProposalOutsideBox where that is less than 1e-4 of the mixture.
        """
        mass = self.mass
        if mass < LEAST_MASS:
            raise ProposalOutsideBox(f"only {mass:.1e} of the proposal's mass lies within {places(self.space)}")
        factors = np.linalg.cholesky(self.covariances)
        kept = np.empty((0, self.space.size))
        # Each round is expected to yield `count` points, so a few rounds do; the bound is there to never loop on a wrong mass.
        for _ in range(100):
            size = int(np.ceil(count / mass))
            component = rng.choice(len(self.weights), size=size, p=self.weights)
            unit = self.means[component] + np.einsum("mij,mj->mi", factors[component], rng.standard_normal((size, self.space.size)))
            kept = np.concatenate([kept, unit[self.space.allows(unit)]])
            if len(kept) >= count:
                # low + 1 * (high - low) may round to the number after high.
                return np.clip(self.space.from_unit(kept[:count]), self.space.low, self.space.high)
        raise ProposalOutsideBox(f"{len(kept)} of {count} draws from the proposal fell within {places(self.space)} in 100 rounds")


def places(space: ParameterSpace) -> str:
    """What the prior holds possible, in words."""
    return "the parameters' ranges" + (" and constraints" if space.constraints else "")


def fit_mixture(
    space: ParameterSpace,
    theta: NDArray[np.float64],
    weights: NDArray[np.float64],
    rng: np.random.Generator,
    *,
    covariance: str = "tied",
    components: int | None = None,
    copies: int | None = None,
    steps: int = 1000,
) -> TruncatedMixture:
    """The mixture that describes samples theta (N, n) with their normalised weights (N,), to propose the next ones from.

    A variational Gaussian mixture under a Dirichlet process of at most `components` (N / 10 by default), which share one covariance ("tied") or have
    their own ("full"). It takes no weights, so it is trained on `copies` (10 N by default) systematically resampled, scaled by the box, in
    so many steps at most.
    Source: Cheng et al. (2019); Hartmann, Cheng, Thornton (2022), section 2.2.
    """
    # Late, as it takes longer to import than all that a command which fits nothing does.
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.mixture import BayesianGaussianMixture

    rows = systematic_resampling(weights, copies or 10 * len(theta), rng)
    copied = space.to_unit(theta)[rows]
    components = components or max(1, len(theta) // 10)
    floor = LEAST_WIDTH**2
    # One start: the best of several is the one that hugs the clumps of copies closest, and the iterations then narrow too early.
    mixture = BayesianGaussianMixture(
        n_components=components,
        covariance_type=covariance,
        weight_concentration_prior_type="dirichlet_process",
        covariance_prior=np.atleast_2d(np.cov(copied.T)) + floor * np.eye(space.size),
        reg_covar=floor,
        max_iter=steps,
        random_state=int(rng.integers(2**31)),
    )
    # With several threads k-means sums in the order they finish, and the last digits would change from run to run.
    with threadpool_limits(1), warnings.catch_warnings():
        # A fit that has not converged, or has fewer points than components, is a proposal all the same.
        warnings.simplefilter("ignore", ConvergenceWarning)
        mixture.fit(copied)
    covariances = np.broadcast_to(mixture.covariances_, (components, space.size, space.size))
    return TruncatedMixture(space, mixture.weights_ / mixture.weights_.sum(), mixture.means_, covariances)


def _mass_left(mixture: TruncatedMixture) -> float:
    """The probability that a mixture lies in the cube where constraints hold too: by draws from each component that the faces cut off, each with the mass that it stands for. The same at every call."""
    from scipy.stats import qmc

    count, size = mixture.means.shape
    factors = np.linalg.cholesky(mixture.covariances)
    sequences = [qmc.Halton(d=size, scramble=True, seed=np.random.default_rng([0, component])) for component in range(count)]
    first, second = np.zeros((2, count))
    for done in range(1, ROUNDS + 1):
        for component, (mean, factor, sequence) in enumerate(zip(mixture.means, factors, sequences)):
            masses, unit = _in_cube(mean, factor, sequence.random(POINTS))
            masses = masses * mixture.space.allows(np.clip(unit, 0, 1))
            first[component] += masses.sum()
            second[component] += (masses**2).sum()
        points = done * POINTS
        mass = mixture.weights @ first / points
        error = np.sqrt(mixture.weights**2 @ (second / points - (first / points) ** 2) / points)
        if error <= CUT_EXACT * mass:
            break
    return float(mass)


def _in_cube(mean: NDArray[np.float64], factor: NDArray[np.float64], uniform: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Masses (M,), whose mean is the probability that a Gaussian lies in the unit cube, and points (M, n) in it that they belong to; from its Cholesky factor and even points (M, n) of the cube.

    By Genz's separation of variables (1992). It stays relatively accurate where the mass is small.
    """
    size = len(mean)
    z = np.zeros((len(uniform), size))
    mass = np.ones(len(uniform))
    for i in range(size):
        centre = mean[i] + z[:, :i] @ factor[i, :i]
        below, above = scipy.special.ndtr(-centre / factor[i, i]), scipy.special.ndtr((1 - centre) / factor[i, i])
        mass *= above - below
        inner = below + uniform[:, i] * (above - below)
        # Far in a tail both ends round to 0 or 1, whose quantiles are infinite; the mass there is zero whatever stands in z.
        z[:, i] = scipy.special.ndtri(np.clip(inner, 1e-300, 1 - 1e-16))
    return mass, mean + z @ factor.T


@lru_cache(maxsize=8)
def _even_points(size: int) -> NDArray[np.float64]:
    from scipy.stats import qmc

    return qmc.Halton(d=size, scramble=True, seed=np.random.default_rng(0)).random(POINTS)
