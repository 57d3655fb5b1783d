"""What packings differ by in a test that they were not run in: as in the test that they were."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from graincal.data import Reference
from graincal.inference.likelihood.packings import LENGTH, PackingScatter, gaussian_kernel


def packings_elsewhere(
    scatter: PackingScatter, known: Reference, known_along: NDArray[np.float64], reference: Reference, along: NDArray[np.float64]
) -> PackingScatter:
    """The scatter of packings in a test whose mean response is `reference`, from that in the test `known`; along (T,): how far along each test its rows are, from 0 to 1.

    An observable of both has the covariance found, as parts of its peaks, at rows as far along the test. Another has the root mean square of the standard deviations found, as parts of
    the peaks, correlated over a third of the curve.
    """
    names, states, rows = known.names, len(known.control), len(along)
    between = np.column_stack([np.interp(along, known_along, each) for each in np.eye(states)])
    peaks, known_peaks = (np.abs(each.values).max(axis=0) for each in (reference, known))
    relative = scatter.covariance / np.outer(np.repeat(known_peaks, states), np.repeat(known_peaks, states))
    mean = np.sqrt(between @ np.diag(relative).reshape(len(names), states).mean(axis=0))
    covariance = np.zeros((len(reference.names) * rows,) * 2)
    for i, one in enumerate(reference.names):
        for j, other in enumerate(reference.names):
            block = None
            if one in names and other in names:
                a, b = names.index(one) * states, names.index(other) * states
                block = between @ relative[a : a + states, b : b + states] @ between.T
            elif i == j:
                block = mean[:, None] * gaussian_kernel(along, LENGTH) * mean
            if block is not None:
                covariance[i * rows : (i + 1) * rows, j * rows : (j + 1) * rows] = peaks[i] * peaks[j] * block
    return PackingScatter(covariance, scatter.degrees, scatter.packings, np.nan)
