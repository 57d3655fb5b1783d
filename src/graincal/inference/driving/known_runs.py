"""Runs that were made before, by another calibration or for none: what they gave, and what of the parameter space they leave open."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from graincal.data import InputError, ParameterSpace, Reference
from graincal.inference.sampling.proposal import places

# A place is covered that has a run as near as this many times the distance of neighbours among places that fill the ranges.
NEAR = 1.5


@dataclass(frozen=True, eq=False)
class KnownRuns:
    """M runs of the same models, in the order of their sources.

    theta (M, n) in the order of the space's names; responses, one (M, K, J) for each reference, at the states that are kept of it (`Thinning`), NaN where there is none. infeasible (M,): no response,
    for the parameters are impossible; missing (M,): no response for another reason. sources: where they are from, a sentence each. They are learnt from, carry no weight, and the answer is none of them.
    """

    theta: NDArray[np.float64]
    responses: tuple[NDArray[np.float64], ...]
    infeasible: NDArray[np.bool_]
    missing: NDArray[np.bool_]
    sources: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.theta)

    def check(self, space: ParameterSpace, references: Sequence[Reference]) -> None:
        """Raise InputError where they are not of these parameters and references."""
        shapes = [(len(self), *reference.values.shape) for reference in references]
        if self.theta.shape != (len(self), space.size) or [each.shape for each in self.responses] != shapes:
            raise InputError(
                "known runs must be of the same parameters, experiments and observables as the calibration, at the states that are kept of its references."
            )
        if not np.all(space.contains(self.theta)):
            raise InputError(f"known runs must lie within {places(space)}.")


def uncovered(points: NDArray[np.float64], known: NDArray[np.float64], least: int) -> NDArray[np.intp]:
    """Which of points (M, n) that fill the unit cube have none of the known ones (N, n) near them, in their order; at least so many, those the farthest from all."""
    if not len(known):
        return np.arange(len(points))
    apart, _ = scipy.spatial.cKDTree(known).query(points)
    neighbours, _ = scipy.spatial.cKDTree(points).query(points, k=2)
    far = apart > NEAR * np.median(neighbours[:, 1])
    far[np.argsort(-apart, kind="stable")[:least]] = True
    return np.flatnonzero(far)
