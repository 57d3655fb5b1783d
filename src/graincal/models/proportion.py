"""A test in units of its confining pressure.

Where stresses, moduli and the grains' density are all multiplied by one factor, accelerations are not, and a test is the same: strains and ratios of stresses
stay, stresses are multiplied. So the engine is given every test at one and the same pressure, and runs at proportional pressures are one run, bit for bit.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

ENGINE_PRESSURE = 2.0**19
"""Pa, of the confining pressure that the engine is given, half a megapascal: figures are then of a size that float32 was tested with."""

_DIGITS = 10
"""Of ratios to the confining pressure. A modulus that has gone through a logarithm and back has lost the last digits of a float64."""


def in_units_of(pressure: float, values: float | Iterable[float]) -> NDArray[np.float64]:
    """Ratios of values (of any shape) to a pressure, the same of all that are in proportion."""
    ratios = np.asarray(values, dtype=np.float64) / pressure
    return np.array([float(f"{ratio:.{_DIGITS}g}") for ratio in ratios.ravel()]).reshape(ratios.shape)


def for_engine(values: float | Iterable[float], pressure: float) -> NDArray[np.float64]:
    """Stresses, moduli, or densities (of any shape) as the engine is given them, for a test at this pressure (Pa)."""
    return ENGINE_PRESSURE * in_units_of(pressure, values)


def from_engine(values: NDArray[np.float64], pressure: float) -> NDArray[np.float64]:
    """The engine's stresses as those of a test at this pressure (Pa)."""
    return values * (pressure / ENGINE_PRESSURE)
