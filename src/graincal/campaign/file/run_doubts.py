"""What speaks against how a simulator's output is read, by the first curve that it gave: a unit, a sign or a column that is another."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.asked.doubt import Doubt
from graincal.campaign.asked.experiment import Experiment
from graincal.campaign.asked.tested import Tested
from graincal.campaign.file.strain_doubts import strain_doubts
from graincal.campaign.file.stress_doubts import stress_doubts
from graincal.data import Reference, Response
from graincal.laboratory.backbone import first_movement
from graincal.laboratory.quantities import STRAINS

OTHER_UNIT = 30.0
"""How many times more or less an observable changes than in the reference, from which another unit is likelier than other parameters."""

MOSTLY = -0.5
"""The correlation of two curves below which one is like the other turned around."""


def doubts_of_run(experiment: Experiment, met: Response) -> list[str]:
    """Sentences; none where nothing speaks against it. met: what a run gave at the rows of the reference."""
    reference = experiment.reference
    curves = {name: met.values[name] for name in reference.measured}
    if not all(np.isfinite(curve).all() for curve in curves.values()):
        return []
    recorded = {name: curve for name, curve in curves.items() if name not in reference.observables}
    fitted = {name: curve for name, curve in curves.items() if name in reference.observables}
    tested = replace(Tested.of(experiment), reference=Reference(reference.control, fitted, control_name=reference.control_name, recorded=recorded))
    # What is said of the reference is so of the test, such as one that begins sheared.
    known = {doubt.code for doubt in _doubts(Tested.of(experiment))}
    return [f"Of this run: {doubt.sentence}" for doubt in _doubts(tested) if doubt.code not in known] + _beside(reference, curves)


def _doubts(tested: Tested) -> list[Doubt]:
    return [*strain_doubts(tested), *stress_doubts(tested)]


def _beside(reference: Reference, curves: Mapping[str, NDArray[np.float64]]) -> list[str]:
    """Of curves (T,) that are far from what was measured."""
    said = []
    for name, measured in reference.measured.items():
        known, curve = np.ptp(measured), curves[name]
        if known and (np.ptp(curve) > OTHER_UNIT * known or np.ptp(curve) < known / OTHER_UNIT):
            said.append(f"{name} changes by {np.ptp(curve):.3g} in this run and by {known:.3g} in the reference: is its unit another, or its column?")
        elif name in STRAINS and _turned(curve, measured):
            said.append(f"{name} goes the other way than in the reference: is its sign another? Contraction and shortening are positive.")
    return said


def _turned(curve: NDArray[np.float64], measured: NDArray[np.float64]) -> bool:
    """Whether a curve (T,) goes the other way at first, and as a whole: other parameters may do one of the two."""
    if first_movement(curve) * first_movement(measured) >= 0:
        return False
    return float(np.corrcoef(curve, measured)[0, 1]) < MOSTLY
