"""The expectation of a draft: the truth's figures, and what the printed digits leave open.

| quantity | from | rounding of it, with h half of the last digit |
|---|---|---|
| strains | themselves, from the stage's first row on | 2.5 h |
| volumetric strain | axial + 2 radial, or a density | 8 h of the strains, 3 h of the density |
| stress ratio | two of three stresses | 3 h (1 + R)/lateral |
| stress ratio | itself, q/p' | 2 h, 6 h |
| q, excess pore pressure | stresses | 4 h |
| void ratio | itself, porosity, the strain | 2.5 h, 8 h, 5 h |
"""

from __future__ import annotations

import numpy as np

from .curves import COMPRESSION_LINES
from .draft import STRAIN_QUANTITIES, Draft
from .expectation import Expectation, Figures

STRESS_QUANTITIES = (
    "axial_stress", "lateral_stress", "deviator_stress", "mean_stress", "s", "t", "pore_pressure", "total_axial_stress", "total_lateral_stress",
)  # fmt: skip
SHOWN_DIGITS = 1e-6
"""Of the control's range, which is shown with six digits."""


def expected(draft: Draft) -> Expectation:
    test = draft.test
    if test.family in COMPRESSION_LINES:
        control = ("position", "mean_stress") if test.family == "isotropic one way" else ("position",)
        return Expectation(test.kind, len(test.axial_strain), None, control, {"void_ratio": _void_ratio(draft)}, {})
    quantities = {column.quantity for column in draft.columns}
    required, known = _observables(draft), {}
    if quantities & {"void_ratio", "porosity"}:
        known["void_ratio"] = _void_ratio(draft)
        known["volumetric_strain"] = _volumetric(draft)
    if not quantities & {"volumetric_strain", "radial_strain"}:
        required.pop("volumetric_strain", None)
    if test.kind == "undrained":
        known["stress_ratio"] = _ratio(draft)
    control = "axial_extension" if test.extends else "axial_strain"
    figures = Figures.of(np.abs(test.axial_strain), 2.5 * draft.rounding(*STRAIN_QUANTITIES) + SHOWN_DIGITS)
    return Expectation(test.kind, len(test.axial_strain), test.pressure, (control,), required, known, figures)


def _observables(draft: Draft) -> dict[str, Figures]:
    if draft.test.kind != "undrained":
        return {"stress_ratio": _ratio(draft), "volumetric_strain": _volumetric(draft)}
    within = 4 * draft.rounding(*STRESS_QUANTITIES)
    return {
        "deviatoric_stress": Figures.of(draft.test.of("deviator_stress"), within),
        "excess_pore_pressure": Figures.of(draft.test.of("excess_pore_pressure"), within),
    }


def _ratio(draft: Draft) -> Figures:
    ratio = draft.test.of("stress_ratio")
    of_stresses = 3 * draft.rounding(*STRESS_QUANTITIES) * float(np.max((1 + ratio) / draft.test.lateral_stress))
    return Figures.of(ratio, of_stresses + 2 * draft.rounding("stress_ratio") + 6 * draft.rounding("deviator_to_mean_stress"))


def _volumetric(draft: Draft) -> Figures:
    within = 8 * draft.rounding("radial_strain") or 2.5 * draft.rounding("volumetric_strain") or 3 * draft.rounding("void_ratio", "porosity")
    return Figures.of(draft.test.volumetric_strain, within)


def _void_ratio(draft: Draft) -> Figures:
    from_strain = 0.0 if any(column.quantity in ("void_ratio", "porosity") for column in draft.columns) else 5 * draft.rounding("axial_strain")
    return Figures.of(draft.test.of("void_ratio"), from_strain + 2.5 * draft.rounding("void_ratio") + 8 * draft.rounding("porosity"))
