"""The change of a sample's volume, from whichever columns give it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from graincal.laboratory.understanding.case import Case, extent, extreme

CHANGES, STAYS = 0.02, 0.005
"""Of the axial strain: a volume that changes by more than the one changes, by less than the other it stays; between them it proves nothing."""
DIGITS = 5.0
"""Of so many printed digits nothing is proven."""
FEW = 3
"""Rows, below which nothing is proven."""


def volumetric(case: Case) -> tuple[NDArray[np.float64], float] | None:
    """The volumetric strain (T,), a fraction, about and with either sign, and the step of its last digit; None where no column gives it."""
    if (found := of_strains(case)) is not None:
        return found
    if (ratio := case.void_ratios) is None:
        return None
    return np.log1p(ratio), case.void_ratio_digits / 2


def of_strains(case: Case) -> tuple[NDArray[np.float64], float] | None:
    """As `volumetric`, from what is measured of strains or of the volume, and not of the void ratio."""
    axial, radial = case.column("axial_strain"), case.column("radial_strain")
    if (own := case.column("volumetric_strain")) is not None:
        return own.plain, own.last_digit
    if case.summed:
        return np.sum([column.plain for column in case.summed], axis=0), max(column.last_digit for column in case.summed)
    if (change := case.column("volume_change")) is not None and (volume := case.sample_volume):
        return change.plain / volume, change.last_digit / volume
    if axial is not None and radial is not None:
        opposite = 1.0 if extreme(axial.values) * extreme(radial.values) < 0 else -1.0
        small = [np.sign(column.plain) * np.log1p(np.abs(column.plain)) for column in (axial, radial)]
        return small[0] + 2 * opposite * small[1], 3 * max(axial.last_digit, radial.last_digit)
    return None


def volume_changes(case: Case) -> bool | None:
    """Whether the volume changes; None where no column says, or none says it clearly."""
    found, strain = volumetric(case), case.shortening
    if found is None or strain is None:
        return None
    values, digits = found
    there = int(np.sum(~np.isnan(values)))
    sheared = extent(strain.plain) if strain.quantity == "axial_strain" else 0.1
    change = extent(values)
    if there < FEW:
        return None
    # Engineering strains of the axes do not add up to that of the volume.
    least = CHANGES if case.column("radial_strain") is None or case.column("volumetric_strain") is not None else 0.05
    if change > max(least * sheared, DIGITS * digits):
        return True
    return False if change <= max(STAYS * sheared, 2 * digits) else None
