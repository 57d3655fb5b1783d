"""Stresses that no test of sand has: of another unit, another pressure, another measure or another test."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.asked.doubt import Doubt
from graincal.campaign.asked.tested import OTHER, Tested
from graincal.laboratory.quantities import unsheared
from graincal.models import ConstantMeanStressTest, TriaxialTest, UndrainedTest

HIGHEST, HIGHEST_AT_LOW_PRESSURE, LOW_PRESSURE = 8.0, 14.0, 50e3
"""The stress ratio of no sand at a confining pressure from LOW_PRESSURE on (Pa), and below or where that is not known."""
LOWEST, LOWEST_IN_SHEAR, BARELY = 0.9, 0.98, 0.999
"""In compression: no sand is below the first at all, or below the second once sheared by 1 %; what is below the third is said."""
BEGUN = 0.01
APART_AT_REST = 1.2
"""By how many times the stress ratio may differ from 1 where the strain is 0."""
LIQUEFIED = 0.05
"""Of the confining pressure: an effective stress below it gives a stress ratio that means nothing."""

Curve = NDArray[np.float64]


def stress_doubts(tested: Tested) -> list[Doubt]:
    """What is to be said of the stress ratio, the deviatoric, the mean and other stresses, and the pore pressure."""
    said = [*_not_positive(tested), *_pore_pressure(tested), *_mean_stress(tested), *_of_control(tested)]
    ratio = tested.observable("stress_ratio")
    if ratio is not None:
        said += _lateral_stress(tested)
        said += _of_ratio(tested, ratio, np.ones(len(ratio), dtype=bool), "the stress ratio") if tested.by_strain else _any_ratio(tested, ratio)
    q = tested.observable("deviatoric_stress")
    if q is not None and tested.pressure and tested.by_strain:
        said += _of_deviatoric(tested, q, tested.pressure)
    return said


def _of_ratio(tested: Tested, ratio: Curve, known: NDArray[np.bool_], called: str) -> list[Doubt]:
    """Of a stress ratio (T,) at the rows where it is known (T,)."""
    if not known.any():
        return []
    if found := unsheared(float(ratio[known].min()), float(ratio[known].max())):
        return [Doubt("unsheared", found.replace("the stress ratio", called, 1))]
    if not tested.shear:
        return _any_ratio(tested, ratio)
    wrong = _in_extension(tested, ratio, known, called) if tested.extension else _in_compression(tested, ratio, known, called)
    if any(doubt.code == "stress-ratio-low" for doubt in wrong):
        return wrong
    if tested.from_rest and known[0] and not 1 / APART_AT_REST <= ratio[0] <= APART_AT_REST:
        two = " One of σ1 that is given as q begins at 2." if abs(ratio[0] - 2) < 0.1 else ""
        text = f"{called} is {ratio[0]:.3g} at {tested.at(0)}, and 1 was expected of a sample that is compressed isotropically.{two} Is it another measure, or was the sample consolidated under a deviator?"
        wrong.append(Doubt("begins-sheared", text))
    return wrong


def _in_compression(tested: Tested, ratio: Curve, known: NDArray[np.bool_], called: str) -> list[Doubt]:
    lowest, highest = _row(ratio, known, np.argmin), _row(ratio, known, np.argmax)
    sheared = known & (tested.control > BEGUN)
    said = []
    if ratio[lowest] < LOWEST or (sheared.any() and ratio[sheared].min() < LOWEST_IN_SHEAR):
        where = lowest if ratio[lowest] < LOWEST else _row(ratio, sheared, np.argmin)
        text = f"{called} is {ratio[where]:.3g} at {tested.at(where)}, and σ1/σ3 is at least 1 in compression: is the sign, the measure (q/p, q/σ3) or the confining pressure another?"
        return [Doubt("stress-ratio-low", text)]
    if ratio[lowest] < BARELY:
        said.append(Doubt("below-one", f"{called} is {ratio[lowest]:.4g} at {tested.at(lowest)}, slightly below 1: the zero of the load cell, or seating."))
    limit = HIGHEST if (tested.pressure or 0.0) >= LOW_PRESSURE else HIGHEST_AT_LOW_PRESSURE
    if ratio[highest] > limit:
        under = f" at {tested.pressure:g} Pa" if tested.pressure else ""
        text = f"{called} reaches {ratio[highest]:.3g} at {tested.at(highest)}, and no sand reaches {limit:g}{under}: is the unit of the stress right, and the confining pressure?"
        said.append(Doubt("stress-ratio-high", text))
    return said


def _in_extension(tested: Tested, ratio: Curve, known: NDArray[np.bool_], called: str) -> list[Doubt]:
    lowest, highest, sheared = _row(ratio, known, np.argmin), _row(ratio, known, np.argmax), known & (tested.control > BEGUN)
    if ratio[highest] > 1.1 or (sheared.any() and ratio[sheared].max() > 1.02):
        where = highest if ratio[highest] > 1.1 else _row(ratio, sheared, np.argmax)
        text = f"{called} is {ratio[where]:.3g} at {tested.at(where)}, and axial over lateral stress is at most 1 in extension: is it the inverse, or is the sign of q another?"
        return [Doubt("stress-ratio-low", text)]
    if ratio[lowest] < 1 / HIGHEST_AT_LOW_PRESSURE:
        text = f"{called} falls to {ratio[lowest]:.3g} at {tested.at(lowest)}, and no sand comes below 1/{HIGHEST_AT_LOW_PRESSURE:g}: is the unit of the stress right, and the confining pressure?"
        return [Doubt("stress-ratio-high", text)]
    return []


def _any_ratio(tested: Tested, ratio: Curve) -> list[Doubt]:
    """Of a test that is no shear of an isotropically compressed sample: its stress ratio may begin anywhere, and is as that of a soil."""
    lowest, highest = int(np.argmin(ratio)), int(np.argmax(ratio))
    if ratio[lowest] < 1 / HIGHEST_AT_LOW_PRESSURE:
        return [Doubt("stress-ratio-low", f"the stress ratio is {ratio[lowest]:.3g} at {tested.at(lowest)}, which no soil has.")]
    if ratio[highest] > HIGHEST_AT_LOW_PRESSURE:
        return [Doubt("stress-ratio-high", f"the stress ratio is {ratio[highest]:.3g} at {tested.at(highest)}, which no soil has.")]
    return []


def _row(values: Curve, chosen: NDArray[np.bool_], of: Callable[[Curve], np.intp]) -> int:
    """The row of an extreme among the chosen ones."""
    return int(np.flatnonzero(chosen)[of(values[chosen])])


def _of_deviatoric(tested: Tested, q: Curve, pressure: float) -> list[Doubt]:
    """Of the deviatoric stress, by the stress ratio that it makes where the lateral stress is known."""
    called = "the stress ratio that deviatoric_stress makes"
    if tested.kind == TriaxialTest.kind:
        return _of_ratio(tested, 1 + q / pressure, np.ones(len(q), dtype=bool), called)
    if tested.kind == ConstantMeanStressTest.kind:
        lateral = pressure - q / 3
        if lateral.min() <= 0:
            row = int(np.argmin(lateral))
            text = f"deviatoric_stress is {q[row]:.4g} Pa at {tested.at(row)}, and from 3 times the mean stress of {pressure:g} Pa on the lateral stress would be tension: is the unit right?"
            return [Doubt("negative-stress", text)]
        return _of_ratio(tested, 1 + q / lateral, np.ones(len(q), dtype=bool), called)
    return _undrained_deviatoric(tested, q, pressure) if tested.undrained else []


def _undrained_deviatoric(tested: Tested, q: Curve, pressure: float) -> list[Doubt]:
    pore = tested.observable("excess_pore_pressure")
    if pore is not None:
        lateral = pressure - pore
        known = lateral > LIQUEFIED * pressure
        ratio = 1 + q / np.where(known, lateral, pressure)
        return _of_ratio(tested, ratio, known, "the effective stress ratio that deviatoric_stress and excess_pore_pressure make")
    largest, way = float(np.abs(q).max()) / pressure, -1.0 if tested.extension else 1.0
    against = float((-way * q).max()) / pressure
    # A dense sample without its pore pressure may come to many times the confining pressure.
    if largest > 100:
        return [
            Doubt(
                "stress-ratio-high",
                f"deviatoric_stress reaches {largest:.3g} times the confining pressure of {pressure:g} Pa: is its unit right, and the pressure?",
            )
        ]
    if largest < LIQUEFIED:
        return [
            Doubt(
                "unsheared",
                f"deviatoric_stress stays below {largest:.2g} times the confining pressure of {pressure:g} Pa, as if the sample were never sheared: is its unit right?",
            )
        ]
    if against > 0.1:
        side = "above 0, and it is below in extension" if tested.extension else "below 0, and it is above in compression"
        return [Doubt("stress-ratio-low", f"deviatoric_stress goes {side}: its sign is another.")]
    return []


def _pore_pressure(tested: Tested) -> list[Doubt]:
    pore, pressure = tested.observable("excess_pore_pressure"), tested.pressure
    if pore is None or not pressure or not tested.undrained:
        return []
    said, row = [], int(np.argmax(pore))
    if pore[row] > 1.02 * pressure:
        text = f"excess_pore_pressure is {pore[row]:.4g} Pa at {tested.at(row)}, more than the confining pressure of {pressure:g} Pa: no effective stress would be left."
        said.append(Doubt("pore-pressure-beyond", f"{text} Is its unit right, does it hold the back pressure, is the confining pressure the effective one?"))
    if tested.from_rest and abs(pore[0]) > 0.1 * pressure:
        text = f"excess_pore_pressure is {pore[0]:.4g} Pa at {tested.at(0)}, and 0 was expected: it counts from the end of consolidation, without the back pressure."
        said.append(Doubt("pore-pressure-not-excess", text))
    if np.abs(pore).max() < 1e-3 * pressure and np.abs(tested.control).max() >= BEGUN:
        text = f"excess_pore_pressure stays within {np.abs(pore).max():.3g} Pa at a confining pressure of {pressure:g} Pa, which no undrained test does: is its unit right, or is the test drained?"
        said.append(Doubt("pore-pressure-small", text))
    return said


def _mean_stress(tested: Tested) -> list[Doubt]:
    mean, pressure = tested.observable("mean_stress"), tested.pressure
    if mean is None or not pressure or not tested.shear or tested.kind == OTHER:
        return []
    away = np.abs(mean / pressure - 1)
    row = int(np.argmax(away)) if tested.kind == ConstantMeanStressTest.kind else 0
    if (row or tested.from_rest or tested.kind == ConstantMeanStressTest.kind) and away[row] > 0.2:
        text = f"mean_stress is {mean[row]:.4g} Pa at {tested.at(row)}, and the confining pressure of {pressure:g} Pa was expected there: is its unit right, and the pressure?"
        return [Doubt("mean-stress-not-confining", text)]
    return []


def _not_positive(tested: Tested) -> list[Doubt]:
    said = []
    for name in ("mean_stress", "axial_stress", "lateral_stress", "stress_xx", "stress_yy", "stress_zz"):
        values = tested.observable(name)
        if values is not None and values.min() <= 0:
            row = int(np.argmin(values))
            text = f"{name} is {values[row]:.4g} Pa at {tested.at(row)}, and sand takes no tension: stresses are effective and positive in compression."
            said.append(Doubt("negative-stress", text))
    return said


def _of_control(tested: Tested) -> list[Doubt]:
    name, pressure = tested.reference.control_name, tested.pressure
    if name not in ("axial_stress", "mean_stress") or not pressure:
        return []
    low, high = float(tested.control.min()), float(tested.control.max())
    if high < 0.2 * pressure or low > 300 * pressure:
        text = f"{name} goes from {low:.4g} to {high:.4g} Pa, and the test begins at a confining pressure of {pressure:g} Pa: is one of them in another unit?"
        return [Doubt("stresses-elsewhere", text)]
    return []


def _lateral_stress(tested: Tested) -> list[Doubt]:
    """That a constant lateral stress made the stress ratio of a test whose lateral stress is not constant."""
    if "stress_ratio" not in tested.reference.at_pressure or tested.kind not in (UndrainedTest.kind, ConstantMeanStressTest.kind, "oedometric"):
        return []
    text = "the stress ratio is made of a stress and a constant lateral stress, and that changes in this test"
    return [Doubt("lateral-stress-not-constant", f"{text}: compare deviatoric_stress instead, or name a column of σ1/σ3.")]
