"""Which kind of test a file is of: from what its columns prove, and only then from its words."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from graincal.laboratory.backbone import noise
from graincal.laboratory.understanding import remarks
from graincal.laboratory.understanding.case import IN_WORDS, Case, extent, extreme
from graincal.laboratory.understanding.strains import proof
from graincal.laboratory.understanding.stress_state import CONSTANT, variation
from graincal.laboratory.understanding.volume import of_strains, volume_changes

KINDS = ("triaxial", "undrained", "constant-mean-stress", "oedometric", "isotropic")
COMPRESSED = 1.5
"""A compression test goes to so many times its first stress at the least."""
DRIFT = 0.2
"""A lateral stress is held in a drained test whose corrections for membrane and area let it drift by less than this part."""
STILL, CHANGED = 0.02, 0.1
"""Of the lateral stress: a pore pressure that changes by less than the one stays, by more than the other it changes; between them its change has to be clear of its noise."""
CLEAR_OF_NOISE = 8.0


def decide_kind(case: Case) -> None:
    """Set the kind of the test, and whether it is an extension; ask where it is not proven."""
    proven, because = _proven(case)
    said = remarks.kind(case.words)
    if case.known.kind is not None:
        case.kind = case.known.kind
        case.decide("kind", case.kind, "you gave it", by="person")
        if proven and proven != case.kind:
            case.ask("kind", f"You say {case.kind}, and the file is of {IN_WORDS[proven]}, because {because}: which is it?", KINDS, proven, "--kind")
    elif other := remarks.other_test(case.words):
        case.kind = proven or "triaxial"
        case.ask("kind", f"The file speaks of '{other}', which is none of the tests that are calibrated on: is it one of them after all?", KINDS, "", "--kind")
    elif said == "constant-mean-stress" and proven == "triaxial" and (case.state is None or case.state.lateral is None):
        # A change of volume alone does not tell the two apart.
        case.kind = said
        case.decide("kind", said, "the file says so in words", by="words")
    elif proven and said and said != proven and not (proven == "constant-mean-stress" and said == "triaxial"):
        case.kind = proven
        case.ask(
            "kind",
            f"The file says {IN_WORDS[said]}, and its columns are of {IN_WORDS[proven]}, because {because}: which is it?",
            (said, proven),
            proven,
            "--kind",
        )
    elif proven:
        case.kind = proven
        case.decide("kind", proven, because)
    elif said:
        case.kind = said
        case.decide("kind", said, "the file says so in words", by="words")
    else:
        _ask(case)
    case.extension = case.kind in ("triaxial", "undrained", "constant-mean-stress") and _is_extension(case)


def _ask(case: Case) -> None:
    if case.shortening is None:
        case.kind = "oedometric" if case.column("axial_stress") else "isotropic"
        case.ask(
            "kind", "Nothing in the file tells an oedometer test from an isotropic compression: which is it?", ("oedometric", "isotropic"), case.kind, "--kind"
        )
    else:
        case.kind = "triaxial"
        case.ask("kind", f"{_undecided(case)}: which is it?", KINDS[:3], "triaxial", "--kind")


def _undecided(case: Case) -> str:
    """Why the columns prove no kind of a test in which the sample is sheared."""
    lateral = case.state.lateral if case.state is not None else None
    if volume_changes(case) and lateral is not None and variation(lateral) >= DRIFT:
        return f"The volume changes while the effective lateral stress goes from {np.nanmin(lateral):.6g} to {np.nanmax(lateral):.6g} Pa, which is neither a drained test at a constant one nor one at constant volume"
    reasons = "; ".join(
        f"{column.label} would be {column.unusable}"
        for column in case.columns
        if column.unusable and column.meaning.quantity in ("volume_change", "volumetric_strain", "pore_pressure", "excess_pore_pressure", "void_ratio")
    )
    return "The file has neither a change of volume nor a pore pressure that tells a drained from an undrained test" + (f" ({reasons})" if reasons else "")


def _proven(case: Case) -> tuple[str, str]:
    """The kind that the columns prove, and by what; empty where they prove none."""
    for look in (_one_dimensional, _isotropic, _sheared):
        kind, because = look(case)
        if kind:
            return kind, because
    return "", ""


def _one_dimensional(case: Case) -> tuple[str, str]:
    """An oedometer: no lateral strain, so that the volume changes as the height does."""
    strain, ratio, volumetric = case.column("axial_strain"), case.void_ratios, case.column("volumetric_strain")
    if case.table.sheet.startswith("CONS"):
        return "oedometric", "the group CONS is of consolidation tests"
    if strain is None or case.state is not None and case.state.lateral is not None and case.state.axial is not None:
        return "", ""
    if ratio is not None and proof(strain.values, strain.digits, ratio, case.void_ratio_digits, strain.unit.symbol if strain.unit else None):
        return "oedometric", f"the void ratio changes with {strain.label} as it does without lateral strain"
    if (
        volumetric is not None
        and case.column("axial_stress")
        and np.nanmax(np.abs(strain.plain - volumetric.plain)) <= 2 * (strain.last_digit + volumetric.last_digit) < 0.1 * np.nanmax(np.abs(strain.plain))
    ):
        return "oedometric", f"{volumetric.label} is {strain.label}: there is no lateral strain"
    return "", ""


def _isotropic(case: Case) -> tuple[str, str]:
    state = case.state
    if state is not None and state.mean is not None and state.deviator is not None:
        mean = state.mean
        if np.nanmax(np.abs(state.deviator)) < 0.05 * np.nanmax(np.abs(mean)) and np.nanmax(mean) > COMPRESSED * np.nanmin(mean[mean > 0], initial=np.inf):
            return "isotropic", "the axial and the lateral stress are the same throughout"
        return "", ""
    stresses = {
        column.quantity
        for column in case.columns
        if column.quantity in ("axial_stress", "lateral_stress", "mean_stress", "deviator_stress", "half_sum_stress", "stress_ratio")
    }
    if stresses == {"mean_stress"} and case.shortening is None and (case.void_ratio or case.column("volumetric_strain")):
        return "isotropic", "its only stress is the mean stress, and the volume changes with it"
    return "", ""


def _sheared(case: Case) -> tuple[str, str]:
    """A triaxial test: whether the volume stays, and what stress does."""
    if case.shortening is None:
        return "", ""
    state, changed = case.state, volume_changes(case)
    pore = _pore_changes(case)
    if pore and not changed:
        return "undrained", f"{pore}" + (" and the volume does not change" if changed is False else "")
    lateral = state.lateral if state is not None else None
    mean = state.mean if state is not None else None
    if changed is False:
        # An effective lateral stress that is held is none of a test at constant volume.
        held = lateral is not None and _lateral_is_effective(case) and variation(lateral) < CONSTANT
        return ("", "") if held else ("undrained", "the volume does not change")
    if changed and not pore and not _has_deviator(case) and of_strains(case) is None:
        return "", ""  # an axial stress alone, with a void ratio, is of an oedometer as well
    if changed and not pore:
        if mean is not None and lateral is not None and variation(mean) < CONSTANT / 2 and variation(lateral) > 2 * CONSTANT:
            return "constant-mean-stress", f"the mean effective stress stays at {np.nanmean(mean):.6g} Pa, and the lateral one does not"
        if lateral is None or variation(lateral) < DRIFT:
            return "triaxial", "the volume changes" + _held(lateral)
        return "", ""
    if changed is None and mean is not None and lateral is not None and variation(mean) < CONSTANT / 2 and variation(lateral) > 2 * CONSTANT and not case.wet:
        return "constant-mean-stress", f"the mean stress stays at {np.nanmean(mean):.6g} Pa, and the lateral one does not"
    if changed is None and lateral is not None and _lateral_is_effective(case) and variation(lateral) < CONSTANT:
        return "triaxial", f"the effective lateral stress stays at {np.nanmean(lateral):.6g} Pa while the sample is sheared"
    if changed is None and lateral is not None and _lateral_is_effective(case):
        if mean is not None and variation(mean) < CONSTANT / 2:
            return "constant-mean-stress", f"the mean effective stress stays at {np.nanmean(mean):.6g} Pa"
        return "undrained", "the effective lateral stress changes, and no column has a change of volume"
    return "", ""


def _has_deviator(case: Case) -> bool:
    """Whether the columns say how far the stresses differ."""
    return (
        (case.state is not None and case.state.deviator is not None)
        or any(case.column(name) for name in ("stress_ratio", "deviator_to_mean_stress"))
        or case.state is None
    )


def _held(lateral: NDArray[np.float64] | None) -> str:
    """What the effective lateral stress of a drained test does, behind another proof."""
    if lateral is None:
        return ""
    if variation(lateral) < CONSTANT / 2:
        return f", and the effective lateral stress stays at {np.nanmean(lateral):.6g} Pa"
    return f", and the effective lateral stress changes little, from {np.nanmin(lateral):.6g} to {np.nanmax(lateral):.6g} Pa"


def _lateral_is_effective(case: Case) -> bool:
    """Whether the lateral stress is said to be, or comes from, effective ones: a constant total one proves nothing."""
    named = [column for column in case.columns if column.index in (case.state.quantities if case.state else {})]
    return any(column.meaning.effective for column in named if column.quantity in ("lateral_stress", "mean_stress", "half_sum_stress", "axial_stress")) or any(
        name == "pore_pressure" for name, _ in (case.state.quantities.values() if case.state else ())
    )


def _pore_changes(case: Case) -> str:
    """In words, that the pore pressure changes; empty where it does not, or not clearly, or nothing says how large the stresses are."""
    column, state = case.column("excess_pore_pressure") or case.column("pore_pressure"), case.state
    stress = None if state is None else state.lateral if state.lateral is not None else state.deviator
    if column is None or stress is None:
        return ""
    change, scale = extent(column.plain), abs(extreme(stress))
    if change <= STILL * scale or (change <= CHANGED * scale and change <= CLEAR_OF_NOISE * noise(column.plain[~np.isnan(column.plain)])):
        return ""
    return f"{column.label} changes by {change:.6g} Pa"


def _is_extension(case: Case) -> bool:
    """Whether the axial stress falls below the lateral one."""
    if case.state is not None and case.state.deviator is not None:
        return extreme(case.state.deviator) < 0
    if (part := case.column("deviator_to_mean_stress")) is not None:
        return extreme(part.values) < 0
    ratio = case.column("stress_ratio")
    return ratio is not None and float(np.nanmedian(ratio.plain)) < 0.95
