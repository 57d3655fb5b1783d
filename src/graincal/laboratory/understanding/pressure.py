"""The confining pressure of a test, and the stresses at which its path turns around."""

from __future__ import annotations

import math

import numpy as np

from graincal.laboratory.loading_path import since, turns_of
from graincal.laboratory.understanding import remarks
from graincal.laboratory.understanding.case import Case
from graincal.laboratory.understanding.compared import driving_stress, is_held

CONTRADICTED = 0.05
"""A pressure that is said in words is that of the columns within this part of it."""


def decide_pressure(case: Case) -> float | None:
    """Pa: what a person says, else what the columns come to, else what a remark says of an effective one; None, with a question, where nothing does."""
    found, because = _found(case)
    given = case.known.confining_pressure
    if given is not None:
        if found is not None and case.kind not in ("oedometric", "isotropic") and not math.isclose(given, found, rel_tol=0.01):
            case.notes.append(f"The file says a confining pressure of {found:g} Pa, and you {given:g} Pa: yours is taken.")
        return given
    if found is None:
        case.ask(
            "confining_pressure",
            because or "The file does not say the confining pressure: what is it, as an effective stress in Pa?",
            (),
            "",
            "--confining-pressure",
        )
        return None
    if case.bare_stresses and because.startswith("columns"):
        case.ask(
            "confining_pressure",
            "It follows from the columns once the unit of their stresses is known: what is it in Pa?",
            (),
            f"{found:.6g}",
            "--stress-unit, or --confining-pressure",
        )
        return found
    told = remarks.confining_pressures(case.words)
    said = told[0] if len(told) == 1 else None
    if said is not None and because.startswith("columns") and not math.isclose(said[0], found, rel_tol=CONTRADICTED) and (said[1] or not case.wet):
        case.ask(
            "confining_pressure",
            f"A line above the table says a confining pressure of {said[0]:g} Pa, and the columns come to {found:.6g} Pa: which is it?",
            (f"{said[0]:g}", f"{found:.6g}"),
            f"{found:.6g}",
            "--confining-pressure",
        )
        return found
    case.decide("confining_pressure", f"{found:.6g}", because.removeprefix("columns: "), by="proof" if because.startswith("columns") else "words")
    return found


def _found(case: Case) -> tuple[float | None, str]:
    """The pressure and its proof; or None and, where there is a reason to ask in other words, the question."""
    if case.kind in ("oedometric", "isotropic"):
        stress = driving_stress(case)
        return float(stress[0]), "columns: the path begins at the first stress above 0"
    state = case.state
    if state is not None and state.lateral is not None:
        stress = state.mean if case.kind == "constant-mean-stress" and state.mean is not None else state.lateral
        stress = stress[~np.isnan(stress)]
        what = "the mean effective stress" if case.kind == "constant-mean-stress" else "the effective lateral stress"
        if case.kind == "triaxial" and not is_held(case):
            return round(float(np.mean(stress)), 6), f"columns: {what} is so in the mean of all rows; it goes from {np.min(stress):.6g} to {np.max(stress):.6g}"
        return round(float(stress[0]), 6), f"columns: {what} has this value where the shear begins"
    told, back = remarks.confining_pressures(case.words), remarks.back_pressure(case.words)
    if not told:
        return None, ""
    if len(told) > 1:
        return None, f"The file says {' and '.join(f'{value:g} Pa' for value, _ in told)}: which is the effective confining pressure of this test, in Pa?"
    value, effective = told[0]
    if back is not None and not effective and not (math.isnan(back) and case.column("deviator_stress") is None):
        return None, f"The file says {value:g} Pa and speaks of a back pressure: what is the effective confining pressure, in Pa?"
    return value, "a line above the table says so"


def decide_turns(case: Case, control: str) -> tuple[float, ...]:
    """The stresses at which the path of a compression test turns around, Pa."""
    if control != "position":
        return ()
    stress = driving_stress(case)
    start = case.known.confining_pressure or float(stress[0])
    return tuple(round(turn, 6) for turn in turns_of(stress[since(stress, start)], start))
