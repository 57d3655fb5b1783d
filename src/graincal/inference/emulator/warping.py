"""Coordinates in which responses change evenly: powers of the parameters, found from the responses themselves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy
from numpy.typing import NDArray

from graincal.inference.emulator.process import Process
from graincal.inference.emulator.side_by_side import side_by_side

# The log of a power, before there is an evaluation: zero, more or less (one sd). And as far as it may go.
LOG_POWER_STD, MOST_LOG_POWER = 0.5, 1.5

# Nearer to the lower end of a range points are the same: a root's slope has no bound there, and runs that differ by roundings would be set apart.
LEAST = 1e-6


def warped(unit: NDArray[np.float64], powers: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points (N, n) of the unit cube in the coordinates u^power: a power below 1 stretches the lower end of a range, one above 1 the upper end."""
    return np.clip(unit, LEAST, 1) ** powers


def even_powers(processes: Sequence[Process], unit: NDArray[np.float64], start: NDArray[np.float64]) -> NDArray[np.float64]:
    """Powers (n,) that make the values of all processes at points (N, n) the most probable, each process with the kernel that it has.

    A kernel's lengths are the same over the whole of a range, and the response to a rolling coefficient is steep at its lower end and flat beyond.
    One power a parameter serves all processes, so that few evaluations determine it. Source of the idea: Snoek, Swersky, Zemel, Adams (2014), ICML.
    """
    logs_of_unit = np.log(np.clip(unit, LEAST, 1))

    def surprise(logs: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        points = warped(unit, np.exp(logs))
        by_logs = points * logs_of_unit * np.exp(logs)
        total, slope = 0.5 * np.sum((logs / LOG_POWER_STD) ** 2), logs / LOG_POWER_STD**2
        for value, by_points in side_by_side(lambda process: process.surprise(points), processes, len(points) ** 2):
            total, slope = total + value, slope + np.sum(by_points * by_logs, axis=0)
        return total, slope

    bounds = [(-MOST_LOG_POWER, MOST_LOG_POWER)] * len(start)
    return np.exp(scipy.optimize.minimize(surprise, np.log(start), jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": 15}).x)
