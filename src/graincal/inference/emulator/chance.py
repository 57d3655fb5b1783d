"""How probable it is that an evaluation fails, from those that did."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from graincal.inference.emulator.process import Kernel, Process

# So much of the variance of labels is never explained, that a chance may be small and never nothing: of failures that may be anybody's fault, and of parameters that a model calls impossible,
# which it does wherever they are.
OF_FAILURES, OF_IMPOSSIBLE = 0.1, 0.02


class Chance:
    """The chance over the unit cube that an evaluation is of those that are marked, such as failures.

    A Gaussian process of the labels 0 and 1, and the probability that a label there is nearer to 1. least: the part of the labels' variance that is never explained.
    Source: Rasmussen and Williams (2006), section 6.5, least-squares classification.
    """

    def __init__(self, unit: NDArray[np.float64], marked: NDArray[np.bool_], least: float, known: Kernel | None = None) -> None:
        """unit (N, n), marked (N,): some, and not all. known: the kernel, found before of the same evaluations."""
        self._rate, self._least = float(marked.mean()), least
        self._deviation = np.sqrt(self._rate * (1 - self._rate))
        self._process = Process(unit, (marked - self._rate) / self._deviation, known=known)

    @property
    def kernel(self) -> Kernel:
        """By which it can be made again of the same evaluations."""
        return self._process.kernel

    def of(self, unit: NDArray[np.float64]) -> NDArray[np.float64]:
        """The chance (M,) at points (M, n)."""
        return scipy.special.ndtr(self._above(unit))

    def log_of_none(self, unit: NDArray[np.float64]) -> NDArray[np.float64]:
        """The log of the probability (M,) that an evaluation at points (M, n) is not marked."""
        return scipy.special.log_ndtr(-self._above(unit))

    def _above(self, unit: NDArray[np.float64]) -> NDArray[np.float64]:
        """How many standard deviations a label is above a half."""
        mean, variance = self._process.predict(unit)
        return (self._rate - 0.5 + self._deviation * mean) / (self._deviation * np.sqrt(variance + max(self._process.nugget, self._least)))


def chance(unit: NDArray[np.float64], marked: NDArray[np.bool_], least: float, known: Kernel | None = None) -> Chance | None:
    """Of evaluations of which some are marked; None where none is or all are, which tells nothing of where."""
    return Chance(unit, marked, least, known) if marked.any() and not marked.all() else None
