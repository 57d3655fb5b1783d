"""Void ratios that no soil has, or not the packing that is to stand for it."""

from __future__ import annotations

import math

from graincal.campaign.asked.doubt import Doubt
from graincal.campaign.asked.tested import Tested

POSSIBLE = (0.1, 3.0)
OFF, NEAR = 0.02, 0.005
"""How far the first void ratio may be from the packing's: beyond the one it is another sample, beyond the other a part of the misfit."""
POROSITIES = (0.25, 0.5)
PER_DECADE = 0.1
"""By how much the void ratio of sand falls, at the most, from one stress to ten times that."""

_READINGS = {
    "porosity-as-void-ratio": ("a porosity n, for e = n/(1 - n)", lambda value: value / (1 - value) if POROSITIES[0] <= value <= POROSITIES[1] else math.nan),
    "specific-volume-as-void-ratio": ("a specific volume v, for e = v - 1", lambda value: value - 1),
    "void-ratio-percent": ("in percent", lambda value: value / 100),
}
_PERCENT_POROSITY = (
    "a porosity in percent, for e = n/(1 - n)",
    lambda value: value / (100 - value) if 100 * POROSITIES[0] <= value <= 100 * POROSITIES[1] else math.nan,
)


def void_ratio_doubts(tested: Tested) -> list[Doubt]:
    """What is to be said of the void ratio, by itself and beside the packing's."""
    values = tested.observable("void_ratio")
    if values is None:
        return []
    first, packing = float(values[0]), tested.void_ratio if tested.kind != "table" else None
    if packing is not None and not _off(tested, first, packing):
        near = abs(first - packing) > NEAR and tested.from_rest
        text = (
            f"void_ratio begins at {first:.4g} and the packing has {packing:.4g}: what they differ by, {abs(first - packing):.2g}, is a part of every misfit."
        )
        return [*_impossible(values.min(), values.max()), *([Doubt("void-ratio-near", text)] if near else [])]
    if packing is not None:
        if read := _as_other(tested, first, packing):
            return [read]
        text = f"void_ratio begins at {first:.4g} in the reference and the packing has {packing:.4g}, which are two samples: prepare the packing at the sample's void ratio, or of its relative density"
        return [*_impossible(values.min(), values.max()), Doubt("void-ratio-off", f"{text} (and compare volumetric_strain instead).")]
    return _impossible(values.min(), values.max())


def _off(tested: Tested, first: float, packing: float) -> bool:
    """Whether the first void ratio cannot be that of the packing, after what it has been strained or compressed by up to there."""
    moved = (1 + packing) * max(0.0, float(tested.control[0])) if tested.by_strain else 0.0
    compressed = 0.0
    if not tested.by_strain and tested.pressure and tested.reference.control_name in ("axial_stress", "mean_stress") and tested.control[0] > 0:
        compressed = PER_DECADE * max(0.0, math.log10(float(tested.control[0]) / tested.pressure))
    return not packing - OFF - moved - compressed <= first <= packing + OFF + moved


def _as_other(tested: Tested, first: float, packing: float) -> Doubt | None:
    """What the first value is if it is something else, by which it agrees with the packing."""
    for code, (called, void_ratio) in (*_READINGS.items(), ("void-ratio-percent", _PERCENT_POROSITY)):
        if not _off(tested, void_ratio(first), packing):
            text = f"void_ratio begins at {first:.4g}, and the packing has {packing:.4g}: it looks like {called} = {void_ratio(first):.4g}. Name a column of void ratios, or convert it."
            return Doubt(code, text)
    return None


def _impossible(lowest: float, highest: float) -> list[Doubt]:
    low, high = POSSIBLE
    if low <= lowest and highest <= high:
        return []
    meant = "is it in percent?" if highest > high else "is it something else?"
    return [Doubt("void-ratio-impossible", f"void_ratio goes from {lowest:.4g} to {highest:.4g}, and {low:g} to {high:g} was expected of a soil: {meant}")]
