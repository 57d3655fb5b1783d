"""What packings of one material differ by, from runs of a few of them at a few places of the parameter space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graincal.data import ParameterSpace
from graincal.inference.likelihood.reduction import columns

SIBLINGS, PLACES = 6, 3
"""Packings like the calibration's own, and places where they are run. What two packings differ by hardly changes from place to place (docs/posterior.md): more packings tell
more than more places."""

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
    """From responses of siblings (S, P, T, J) at P places, NaN where there is none, and of the calibration's own packing (P, T, J). None where too few came to an end.

    The covariance found is shrunk towards a smooth one with the same variances, for a few packings have few directions.
    """
    known: NDArray[np.bool_] = np.all(np.isfinite(responses), axis=(2, 3))
    usable = np.flatnonzero(known.sum(axis=0) >= FEWEST)
    if not len(usable):
        return None
    found, degrees, apart = np.zeros(()), 0, []
    for place in usable:
        curves = columns(responses[known[:, place], place])
        middle, count = curves.mean(axis=0), len(curves)
        found = found + (curves - middle).T @ (curves - middle)
        degrees += count - 1
        if np.isfinite(own[place]).all():
            variance = np.var(curves, axis=0, ddof=1) * (1 + 1 / count)
            varies = variance > 0
            apart.append(np.sqrt(np.mean((columns(own[place]) - middle)[varies] ** 2 / variance[varies])))
    found = found / degrees
    share = _between(responses[:, usable][known[:, usable].all(axis=1)])
    if share is not None:
        found = share[:, None] * found * share
    runs = max(known[:, place].sum() for place in usable) - 1
    smooth = _smooth(np.sqrt(np.diag(found)), control, responses.shape[3])
    covariance = (runs * found + PRIOR_RUNS * smooth) / (runs + PRIOR_RUNS)
    return PackingScatter(siblings.share * covariance, float(runs), int(known.any(axis=1).sum()), float(np.mean(apart)) if apart else np.nan)


def _between(responses: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Of packings that all came to a response at all places (S, P, T, J): the part of the standard deviation between them at one place that they keep from place to place, (J T,); the rest is what runs
    scatter by, and the less the more places there are. None for fewer than FEWEST packings, or one place."""
    packings, places = responses.shape[:2]
    if packings < FEWEST or places < 2:
        return None
    curves = columns(responses)
    curves = curves - curves.mean(axis=0)
    kept = curves.mean(axis=1)
    within = np.sum((curves - kept[:, None]) ** 2, axis=(0, 1)) / ((packings - 1) * (places - 1))
    between = np.maximum(np.sum(kept**2, axis=0) / (packings - 1) - within / places, 0)
    return np.sqrt(between / np.maximum(between + within, 1e-300))


def _smooth(deviations: NDArray[np.float64], control: NDArray[np.float64], observables: int) -> NDArray[np.float64]:
    """A covariance with these standard deviations (J T,), correlated along each curve and not between observables."""
    alike = np.kron(np.eye(observables), gaussian_kernel(control, LENGTH))
    return deviations[:, None] * alike * deviations


def gaussian_kernel(control: NDArray[np.float64], length: float) -> NDArray[np.float64]:
    """The correlation (T, T) of what is alike over `length`, in lengths of the whole curve."""
    extent = control[-1] - control[0] if len(control) > 1 else 1.0
    return np.exp(-0.5 * ((control[:, None] - control) / (length * extent)) ** 2)
