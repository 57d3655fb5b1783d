"""Units of strains, the measure of strains, and the void ratio: what one proves of the other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graincal.laboratory.units import UNITS

MEASURES = ("engineering", "logarithmic")
DISTINCT = 10.0
"""Two measures are told apart where they differ by so many times what is printed."""
WITHIN = 3.0
"""A strain agrees with a void ratio within so many times what is printed, for both are rounded and computed from rounded readings."""


@dataclass(frozen=True)
class Proof:
    """What a void ratio proves of a strain of the whole sample: its unit, its measure (empty where both agree), and its sign, 1.0 for compression positive."""

    unit: str
    measure: str
    sign: float


def void_ratio_of(quantity: str, values: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """The void ratio (T,) of printed values of a void ratio, a porosity or a specific volume, as fractions; None for what none can be."""
    values = values / 100.0 if np.nanmin(values) > 10 else values
    if quantity == "porosity":
        return values / (1 - values) if 0.1 < np.nanmin(values) and np.nanmax(values) < 0.8 else None
    if quantity == "specific_volume":
        values = values - 1
    return values if 0.1 < np.nanmin(values) and np.nanmax(values) < 4 else None


def of_void_ratio(void_ratio: NDArray[np.float64], measure: str) -> NDArray[np.float64]:
    """The strain of the sample's volume (T,) from the first row on, compression positive."""
    first = void_ratio[0]
    return (first - void_ratio) / (1 + first) if measure == "engineering" else np.log((1 + first) / (1 + void_ratio))


def proof(printed: NDArray[np.float64], digits: float, void_ratio: NDArray[np.float64] | None, void_digits: float, unit: str | None) -> Proof | None:
    """What the void ratio (T,) proves of a printed strain (T,), whose last digit is a step of `digits`; of the unit only where `unit` is None. None where it is not known, where they
    do not agree in any way, or the volume does not change by more than what is printed."""
    if void_ratio is None:
        return None
    both = ~np.isnan(printed) & ~np.isnan(void_ratio)
    if np.sum(both) < 3:
        return None
    printed, void_ratio = printed[both] - printed[both][0], void_ratio[both]
    rounding = void_digits / (1 + void_ratio[0])
    expected = {measure: of_void_ratio(void_ratio, measure) for measure in MEASURES}
    if np.ptp(expected["engineering"]) < DISTINCT * rounding:
        return None
    best: tuple[float, str, str, float] | None = None
    for symbol in (unit,) if unit else ("%", "-", "permille"):
        factor = UNITS[symbol].factor
        for sign in (1.0, -1.0):
            for measure in MEASURES:
                off = float(np.max(np.abs(sign * factor * printed - expected[measure]))) / (rounding + factor * digits)
                if best is None or off < best[0]:
                    best = off, symbol, measure, sign
    assert best is not None, "something was tried"
    off, symbol, measure, sign = best
    apart = float(np.max(np.abs(expected["engineering"] - expected["logarithmic"]))) / (rounding + UNITS[symbol].factor * digits)
    if off > WITHIN and (off > 0.3 * apart or apart < DISTINCT):
        # Near enough to know sign and unit, and not the measure.
        near = off * (rounding + UNITS[symbol].factor * digits) < 0.1 * float(np.ptp(expected["engineering"]))
        return Proof(symbol, "", sign) if near else None
    return Proof(symbol, measure if apart >= DISTINCT else "", sign)


def multiplied(axial: NDArray[np.float64], radial: NDArray[np.float64], volumetric: NDArray[np.float64], digits: float) -> bool:
    """Whether the strains (T,), fractions with compression positive, are engineering ones: (1 - εv) = (1 - εa)(1 - εr)² and not the sum."""
    both = ~np.isnan(axial + radial + volumetric)
    product = 1 - (1 - axial[both]) * (1 - radial[both]) ** 2
    linear = axial[both] + 2 * radial[both]
    apart = np.max(np.abs(product - linear), initial=0.0)
    return bool(apart >= DISTINCT * 3 * digits and np.max(np.abs(volumetric[both] - product)) <= WITHIN * 3 * digits)
