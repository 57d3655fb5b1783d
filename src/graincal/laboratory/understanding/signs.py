"""The sign conventions of strains: what stresses, the void ratio and the first movement of the volume prove of them."""

from __future__ import annotations

import numpy as np

from graincal.errors import InputError
from graincal.laboratory.backbone import first_movement, noise
from graincal.laboratory.understanding import remarks
from graincal.laboratory.understanding.case import Case, extent, extreme
from graincal.laboratory.understanding.seen import Seen
from graincal.laboratory.understanding.strains import proof

CLEAR = 5.0
"""A first movement is clear from so many printed digits on."""
CLEAR_PART, TURNS = 0.002, 0.01
"""Of the whole range: what a movement is clear from, and what it turns back by where it turns."""
MANY = 100
PEAK = 0.03
"""Of the rise of a stress: what it falls after a peak."""
WORDS = {1.0: "positive", -1.0: "negative"}


def decide_signs(case: Case) -> None:
    """Set what makes strains positive in compression; ask where nothing proves it."""
    _axial(case)
    volumetric = case.column("volumetric_strain") or case.column("volume_change")
    if volumetric is not None:
        _volumetric(case, volumetric)
    if (radial := case.column("radial_strain")) is not None and case.kind in ("triaxial", "undrained", "constant-mean-stress"):
        # The sample grows across where it is shortened.
        strain = case.column("axial_strain")
        opposite = strain is None or extreme(strain.values) * extreme(radial.values) < 0
        case.strain_sign["radial_strain"] = case.strain_sign.get("axial_strain", 1.0) * (1.0 if opposite else -1.0)


def _axial(case: Case) -> None:
    strain = case.column("axial_strain") or case.column("axial_displacement")
    if strain is None:
        return
    end, key = 1.0 if extreme(strain.values) >= 0 else -1.0, strain.quantity
    if key in case.known.compression:
        case.strain_sign[key] = 1.0 if case.known.compression[key] == "positive" else -1.0
        return
    said = remarks.sign(case.words, of_volume=False)
    wanted = -1.0 if case.extension else 1.0
    case.strain_sign[key] = end * wanted
    if case.kind not in ("triaxial", "undrained", "constant-mean-stress"):
        if end < 0:
            case.decide(f"compression.{key}", "negative", "the sample is compressed under a growing stress")
        return
    convention = _of_stresses(case, strain)
    if said is not None and said != end * wanted:
        _ask(
            case,
            strain,
            end * wanted,
            f"The file says that compression is {WORDS[said]}, and {strain.label} {'grows' if end > 0 else 'falls'} while the axial stress is {'below' if case.extension else 'above'} the lateral one",
        )
    elif convention is None and said is None and end < 0:
        _ask(case, strain, -1.0, f"{strain.label} and the stress are both negative or of opposite signs: a test in extension, or another sign convention")
    elif convention is None and said is None:
        raise InputError(
            f"{case.table.path}: the deviator stress is negative while {strain.label} grows, and nothing else tells a compression from an extension: --compression deviator_stress=negative says that the "
            f"stress has its sign turned in a compression, --compression {key}=negative that the sample is extended."
        )
    elif convention is not None and said is None and end * wanted != convention:
        _ask(
            case,
            strain,
            end * wanted,
            f"{strain.label} {'grows' if end > 0 else 'falls'} while the axial stress is {'below' if case.extension else 'above'} the lateral one, against the sign of the stresses",
        )
    elif end * wanted < 0:
        case.decide(
            f"compression.{key}",
            "negative",
            f"the axial stress is {'below' if case.extension else 'above'} the lateral one, and {strain.label} {'grows' if end > 0 else 'falls'}",
        )


def _of_stresses(case: Case, strain: Seen) -> float | None:
    """The sign of compression among normal stresses; None where there is none, or a stress ratio alone, which has no sign. A ratio above 1 is of compression whatever sign a strain has."""
    normal = [
        sign
        for name, sign in (case.state.quantities.values() if case.state else ())
        if name not in ("deviator_stress", "half_difference_stress", "pore_pressure")
    ]
    if normal:
        return normal[0]
    if case.column("stress_ratio") is not None or case.column("deviator_to_mean_stress") is not None:
        return (1.0 if extreme(strain.values) >= 0 else -1.0) * (-1.0 if case.extension else 1.0)
    deviator = case.column("deviator_stress") or case.column("half_difference_stress")
    if deviator is None:
        return 1.0
    return 1.0 if extreme(deviator.values) > 0 else None


def _volumetric(case: Case, column: Seen) -> None:
    key = column.quantity
    if key in case.known.compression:
        case.strain_sign[key] = 1.0 if case.known.compression[key] == "positive" else -1.0
        return
    said = remarks.sign(case.words, of_volume=True)
    proven, because = _proven(case, column)
    if proven is None:
        axial = case.strain_sign.get("axial_strain", 1.0)
        case.strain_sign[key] = said or axial
        if said is None and extent(column.plain) > 0:
            _ask(case, column, axial, f"Nothing proves whether {column.label} is positive where the volume shrinks or where it grows")
    else:
        case.strain_sign[key] = proven
        if said is not None and said != proven:
            _ask(case, column, proven, f"The file says that compression is {WORDS[said]}, and {column.label} is the other way round, because {because}")
        else:
            case.decide(f"compression.{key}", WORDS[proven], because)


def _proven(case: Case, column: Seen) -> tuple[float | None, str]:
    if (ratio := case.void_ratios) is not None and (
        found := proof(
            column.values,
            column.digits,
            ratio,
            case.void_ratio_digits,
            column.unit.symbol if column.unit and column.unit.dimension == "fraction" else None,
        )
    ):
        return found.sign, f"the void ratio falls where {column.label} {'grows' if found.sign > 0 else 'falls'}"
    axial, radial = case.column("axial_strain"), case.column("radial_strain")
    if axial is not None and radial is not None:
        for sign in (1.0, -1.0):
            off = np.nanmax(np.abs(sign * column.plain - axial.plain - 2 * radial.plain))
            if off < 0.2 * np.nanmax(np.abs(column.plain)):
                return sign * case.strain_sign.get("axial_strain", 1.0), f"{column.label} is the sum of the strains of the three axes in that sign"
    if case.kind in ("oedometric", "isotropic"):
        end = extreme(column.values)
        return (1.0 if end >= 0 else -1.0), "the volume shrinks under a growing stress"
    return _first_movement(case, column) if not case.extension and case.kind != "undrained" else (None, "")


def _first_movement(case: Case, column: Seen) -> tuple[float | None, str]:
    """The sign by which a drained sample contracts first. One whose volume moves one way only has either contracted, without a
    peak of the stress, or its contraction was not read: then the sign of the axial strain has to agree."""
    values = column.values[~np.isnan(column.values)]
    movement = first_movement(values)
    clear = max(CLEAR * column.digits, CLEAR * _noise(values), CLEAR_PART * np.ptp(values))
    if abs(movement) < clear or _went_the_other_way(values, movement) >= clear:
        return None, ""
    turns = np.ptp(values) - abs(values[-1] - values[0]) >= max(clear, TURNS * np.ptp(values))
    convention = case.strain_sign.get("axial_strain", 1.0)
    if not turns and (_has_peak(case) or convention != np.sign(movement)):
        return None, ""
    return (
        1.0 if movement > 0 else -1.0
    ), f"{column.label} moves first to {'higher' if movement > 0 else 'lower'} values, and a drained sample contracts first"


def _went_the_other_way(values: np.ndarray, movement: float) -> float:
    """How far the first values (T,) went the other way before the movement: a dense sample may contract by less than a hundredth of what it dilates by."""
    away = (values - values[0]) * np.sign(movement)
    return float(-np.min(away[: int(np.argmax(away >= abs(movement))) + 1]))


def _noise(values: np.ndarray) -> float:
    """That of so many values (T,) that their course is smooth from one to the next; 0 of fewer."""
    return noise(values) if len(values) > MANY else 0.0


def _has_peak(case: Case) -> bool:
    """Whether the stress falls by a part of its rise before the end, as that of a dense sample that dilates."""
    ratio = case.column("stress_ratio")
    stress = case.state.deviator if case.state is not None and case.state.deviator is not None else ratio.plain if ratio is not None else None
    if stress is None:
        return True
    stress = stress[~np.isnan(stress)]
    return bool(stress.max() - stress[-1] > PEAK * np.ptp(stress))


def _ask(case: Case, column: Seen, proposed: float, sentence: str) -> None:
    case.ask(
        f"compression.{column.quantity}",
        f"{sentence}: which sign has compression?",
        ("positive", "negative"),
        WORDS[proposed],
        f"--compression {column.quantity}={WORDS[proposed]}",
    )
