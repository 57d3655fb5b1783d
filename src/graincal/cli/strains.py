"""The axial strains that --axial-strain and --increment ask for."""

from __future__ import annotations

from typing import TYPE_CHECKING

from graincal.data import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray


def axial_strains(last: float, increment: float) -> NDArray:
    """From 0 to the last one, below 0 in extension; the last step may be shorter."""
    import numpy as np

    size = abs(last)
    if not 0 < increment <= size < 1:
        raise InputError(f"--axial-strain and --increment must be fractions with 0 < increment <= |strain| < 1, not {last:g} and {increment:g}.")
    states = round(size / increment)
    sizes = np.append(increment * np.arange(states), size) if abs(states * increment - size) < 1e-9 else np.append(np.arange(0, size, increment), size)
    return sizes if last > 0 else 0.0 - sizes
