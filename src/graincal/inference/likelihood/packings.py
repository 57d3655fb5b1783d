"""What packings of one material differ by, from runs of a few of them at a few places of the parameter space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graincal.data import ParameterSpace
from graincal.inference.likelihood.reduction import columns

SIBLINGS, PLACES = 6, 3
"""Packings like the calibration's own, and places where they are run. Near a good fit, what two packings differ by hardly changes from place to place (docs/posterior.md): more
packings tell more than more places."""

REPEATS, REPEATED = 2, 2
"""Runs of a packing at a place, and how many of the packings have them: what runs scatter by is a small part of what packings differ by, and a few tell it. The others are run once."""

FEWEST = 4
"""Packings that came to a response at a place, for that one to count."""

BEST = 0.1
"""Of the evaluations: the part among which places are chosen."""

FACTORS = 3
"""Hypotheses on how much more or less packings differ by than those that were run."""

LENGTH = 1 / 3
"""Of the curve: what packings differ by is alike over this, before there is a run."""

PRIOR_RUNS = 4
"""So many packings' worth is that thought, beside the packings that were run."""


@dataclass(frozen=True)
class Siblings:
    """How the model of one experiment can be run on packings like its own.

    own: how many packings its runs are spread over, whose mean is emulated. share: the variance between packings as large as its own over that between the siblings,
    less than one where these are smaller. shared: how many experiments are run on the same packing: what it differs by is then much the same in all of them, and not found out anew by each.
    """

    own: int = 1
    share: float = 1.0
    shared: int = 1


@dataclass(frozen=True, eq=False)
class PackingScatter:
    """Of one experiment: the covariance (J T, J T) of one packing's response about the mean of all packings, observable by observable, in their units.

    degrees: as of a variance that is found from so many values and one. packings: how many it was found from. apart: how far the calibration's own packing is from the
    mean of its siblings, root mean square of what two single packings are apart: about 1 for one more of them.
    """

    covariance: NDArray[np.float64]
    degrees: float
    packings: int
    apart: float

    @property
    def factors(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Hypotheses on the factor by which the variance is other than it was found to be, and their probabilities: three points of a Gaussian of its logarithm."""
        width = np.sqrt(3 * 2 / self.degrees)
        return (float(np.exp(-width)), 1.0, float(np.exp(width))), (1 / 6, 2 / 3, 1 / 6)


def places(space: ParameterSpace, theta: NDArray[np.float64], errors: NDArray[np.float64], count: int = PLACES) -> NDArray[np.float64]:
    """Of evaluations at theta (N, n) with these errors (N,), NaN for those without, the best one and others of the best tenth, as far apart as can be: (`count`, n), or as many as there are."""
    order = np.argsort(errors, kind="stable")[: np.isfinite(errors).sum()]
    best = order[: max(count, int(np.ceil(BEST * len(order))))]
    unit, chosen = space.to_unit(theta[best]), [0]
    while len(chosen) < min(count, len(best)):
        apart = np.min(np.linalg.norm(unit[:, None] - unit[chosen], axis=2), axis=1)
        chosen.append(int(np.argmax(apart)))
    return theta[best[chosen]]


def packing_scatter(responses: NDArray[np.float64], own: NDArray[np.float64], control: NDArray[np.float64], siblings: Siblings) -> PackingScatter | None:
    """From responses of siblings (S, P, R, T, J), up to R runs of each at P places, NaN where there is none, and of the calibration's own packing (P, T, J). None where too few came to an end.

    The covariance found is shrunk towards a smooth one with the same variances, for a few packings have few directions.
    """
    curves = columns(responses)
    known: NDArray[np.bool_] = np.all(np.isfinite(curves), axis=3)
    runs = known.sum(axis=2)  # (S, P)
    usable = np.flatnonzero((runs > 0).sum(axis=0) >= FEWEST)
    if not len(usable):
        return None
    curves = np.where(known[..., None], curves, 0.0)
    means = curves.sum(axis=2) / np.maximum(runs, 1)[..., None]
    of_runs = _of_runs(curves, means, known)
    found, degrees, apart = np.zeros(()), 0, []
    for place in usable:
        there = runs[:, place] > 0
        each, count = means[there, place], int(there.sum())
        middle = each.mean(axis=0)
        found = found + (each - middle).T @ (each - middle)
        degrees += count - 1
        if np.isfinite(own[place]).all():
            # The mean of some runs scatters less than the one run of the own packing.
            in_means = np.mean(1 / runs[there, place])
            variance = np.var(each, axis=0, ddof=1) * (1 + 1 / count) + of_runs * (1 - in_means)
            varies = variance > 0
            if varies.any():
                apart.append(np.sqrt(np.mean((columns(own[place]) - middle)[varies] ** 2 / variance[varies])))
    found = found / degrees
    between = np.diag(found)
    in_means = np.mean(1 / runs[:, usable][runs[:, usable] > 0])
    share = np.sqrt(np.maximum(between - in_means * of_runs, 0) / np.maximum(between, np.finfo(np.float64).tiny))
    found = share[:, None] * found * share
    packings = int((runs[:, usable] > 0).sum(axis=0).max()) - 1
    smooth = _smooth(np.sqrt(np.diag(found)), control, responses.shape[4])
    covariance = (packings * found + PRIOR_RUNS * smooth) / (packings + PRIOR_RUNS)
    return PackingScatter(siblings.share * covariance, float(packings), int((runs > 0).any(axis=1).sum()), float(np.mean(apart)) if apart else np.nan)


def _of_runs(curves: NDArray[np.float64], means: NDArray[np.float64], known: NDArray[np.bool_]) -> NDArray[np.float64]:
    """The variance of single runs of one packing at one place, (J T,), pooled over packings and places; 0 where none came to a response twice."""
    degrees = np.maximum(known.sum(axis=2) - 1, 0).sum()
    apart = np.where(known[..., None], curves - means[:, :, None], 0.0)
    return np.sum(apart**2, axis=(0, 1, 2)) / max(int(degrees), 1)


def _smooth(deviations: NDArray[np.float64], control: NDArray[np.float64], observables: int) -> NDArray[np.float64]:
    """A covariance with these standard deviations (J T,), correlated along each curve and not between observables."""
    alike = np.kron(np.eye(observables), gaussian_kernel(control, LENGTH))
    return deviations[:, None] * alike * deviations


def gaussian_kernel(control: NDArray[np.float64], length: float) -> NDArray[np.float64]:
    """The correlation (T, T) of what is alike over `length`, in lengths of the whole curve."""
    extent = control[-1] - control[0] if len(control) > 1 else 1.0
    return np.exp(-0.5 * ((control[:, None] - control) / (length * extent)) ** 2)
