"""How a stress follows from others: sums of the effective axial and lateral stress and the pore pressure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from graincal.laboratory.quantities import STRESS_FORMS

WANTED = {"deviatoric_stress": STRESS_FORMS["deviator_stress"]} | {
    name: STRESS_FORMS[name] for name in ("axial_stress", "lateral_stress", "mean_stress", "pore_pressure")
}
"""What a reference may have, by the same weights."""


def weights(wanted: Sequence[float], forms: Sequence[Sequence[float]]) -> NDArray[np.float64] | None:
    """The weights (k,) by which stresses of the given forms, (k, 3), sum up to the wanted form (3,); None where they do not decide it."""
    if not forms:
        return None
    given, target = np.array(forms, dtype=np.float64), np.array(wanted, dtype=np.float64)
    found = np.asarray(np.linalg.lstsq(given.T, target, rcond=None)[0], dtype=np.float64)
    if np.max(np.abs(given.T @ found - target)) > 1e-9:
        return None
    # One column alone, where it is the wanted stress: its digits stay as they are printed.
    own = np.flatnonzero(np.max(np.abs(given - target), axis=1) < 1e-12)
    return np.eye(len(given), dtype=np.float64)[own[0]] if own.size else found


def contradiction(stresses: Mapping[str, NDArray[np.float64]]) -> float:
    """By how much stresses (T,) of the names in STRESS_FORMS contradict one another at the most, as a part of the largest; 0 where none is said twice."""
    values = np.stack(list(stresses.values()))
    return spread([STRESS_FORMS[name] for name in stresses], values)


def spread(forms: Sequence[Sequence[float]], values: NDArray[np.float64]) -> float:
    """As `contradiction`, of values (k, T) with the forms (k, 3)."""
    given = np.array(forms, dtype=np.float64)
    known = np.linalg.lstsq(given, values, rcond=None)[0]
    largest = float(np.max(np.abs(values)))
    return float(np.max(np.abs(given @ known - values))) / largest if largest > 0 else 0.0
