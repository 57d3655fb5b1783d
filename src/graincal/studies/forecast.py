"""About how much is to be run, in particle-steps, before any packing is prepared."""

from __future__ import annotations

import numpy as np

from graincal.studies import paper
from graincal.studies.settings import Setup

STEPS = 19_000
"""Of one run of the paper's test at the synthetic reference's parameters, by the standard accuracy."""

ITERATIONS = 11
"""That the paper's method takes about, iteration 0 counted."""

OF_POSTERIOR, WITH_RUNS = 800, 200
"""Evaluations that the method "posterior" takes about; the second where it learns from the runs of another calibration."""


def runs(setup: Setup, particles: int, count: int) -> float:
    """Of plain runs at parameters that fit."""
    return float((setup.size.particles or particles) * count * STEPS)


def by_the_paper(setup: Setup, particles: int, box: str, samples: int, iterations: int = ITERATIONS) -> float:
    """Of the iterative filter: iteration 0 fills the box, and later ones are near what fits."""
    later = min(iterations, setup.size.most_iterations) - 1
    return runs(setup, particles, 1) * setup.size.of_samples * samples * (_of_box(box) + later)


def by_the_posterior(setup: Setup, particles: int, box: str, *, with_runs: bool = False) -> float:
    """Of the method "posterior": half of its runs fill the box."""
    evaluations = min(WITH_RUNS if with_runs else OF_POSTERIOR, setup.size.most_evaluations or np.inf)
    return runs(setup, particles, 1) * evaluations * 0.5 * (_of_box(box) + 1)


def _of_box(box: str) -> float:
    """The mean number of steps over a box, in those at the synthetic reference's parameters: they grow with the root of the modulus."""
    low, high = (10 ** (0.5 * (limit - paper.TRUTH[0])) for limit in paper.BOXES[box])
    return float((high - low) / np.log(high / low))
