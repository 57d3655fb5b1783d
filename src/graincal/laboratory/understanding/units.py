"""The units of columns that state none, where the file proves them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from graincal.errors import InputError
from graincal.laboratory.quantities import DIMENSIONS, STRAINS
from graincal.laboratory.understanding.case import Case, extent, extreme
from graincal.laboratory.understanding.seen import PLAIN, Seen
from graincal.laboratory.understanding.strains import proof, void_ratio_of
from graincal.laboratory.understanding.volume import of_strains
from graincal.laboratory.units import UNITS, find_unit

SURELY_PERCENT, FRACTION = (1.5, 60.0), (0.05, 0.5)
"""The largest axial strain of a test is a percentage within the one, for no sample is sheared to 150 %, nor by much more than half its height; within the other it may be a fraction."""
AT_A_TENTH = 0.5
"""Of its largest, the deviator stress of a sample that is sheared by percents has come to so much at a tenth of its strain; one that is sheared by a part of a percent has not."""
PORE_MOVES = 0.02
"""Of the change of the stresses: what a pore pressure changes by in a test whose volume stays."""
STRESS_UNITS = "units.stresses"
"""The key of the question for the unit of all stresses that have none."""
TOO_SMALL_A_PART = 0.004
"""A volumetric strain that stays below this part of the axial one is not that of a drained sand: the two are in different units."""


def decide_void_ratio(case: Case) -> None:
    """A void ratio is a fraction whatever stands above it: no sand has one of 0.007."""
    column = case.void_ratio
    if column is None:
        return
    plain = void_ratio_of(column.quantity, column.values)
    if plain is None:
        low, high = np.nanmin(column.values), np.nanmax(column.values)
        case.replace(replace(column, unusable=f"{column.quantity}, but values from {low:g} to {high:g} are none"))
        return
    unit = UNITS["%"] if np.nanmin(column.values) > 10 else PLAIN
    if column.unit is not None and column.unit != unit:
        case.decide(
            f"units.{column.quantity}",
            unit.symbol,
            f"values from {np.nanmin(column.values):g} on are a void ratio in that unit, and '{column.unit.symbol}' stands above {column.label}",
        )
    case.replace(replace(column, unit=unit))


def decide_strains(case: Case) -> None:
    """The units of strains: those that are stated, or what the void ratio or the size of their values prove."""
    strains = [column for name in STRAINS if (column := case.column(name))]
    for column in strains:
        if column.quantity != "radial_strain" and (proven := _by_void_ratio(case, column)):
            _prove(case, column, proven)
    strains = [column for name in STRAINS if (column := case.column(name))]
    stated = [(column, column.unit) for column in strains if column.unit is not None]
    bare = [column for column in strains if column.unit is None]
    if stated and bare:
        for column in bare:
            _ask(case, column, stated[0][1].symbol, f"{column.label} has no unit, and {stated[0][0].label} is in {stated[0][1].symbol}")
    elif bare:
        _by_size(case, bare)
    _doubt_sizes(case)
    refuse_porosity(case)


def refuse_porosity(case: Case) -> None:
    """Refuse a column of void ratios that changes with the volumetric strain as a porosity does, and not as a void ratio."""
    column, found, axial = case.column("void_ratio"), of_strains(case), case.column("axial_strain")
    if found is None and axial is not None:
        found = axial.plain, axial.last_digit  # without lateral strain, that of an oedometer
    if column is None or found is None or np.nanmax(column.plain) >= 0.8:
        return
    values, digits = found
    as_void_ratio, as_porosity = (
        proof(values, digits, void_ratio_of(quantity, column.plain), 3 * column.last_digit, "-") for quantity in ("void_ratio", "porosity")
    )
    if as_void_ratio is None and as_porosity is not None:
        raise InputError(
            f"{case.table.path}: {column.label} is called a void ratio, and it changes with the strain as a porosity does: --column porosity={column.index + 1} reads it as that."
        )


def _by_void_ratio(case: Case, column: Seen) -> str | None:
    """The unit that the void ratio proves of a strain that is the whole sample's volumetric one; None where it proves nothing, or the unit is stated so."""
    if (ratio := case.void_ratios) is None or (column.unit is not None and column.quantity == "axial_strain"):
        return None
    found = proof(column.values, column.digits, ratio, case.void_ratio_digits, None)
    return found.unit if found and (column.unit is None or found.unit != column.unit.symbol) else None


def _prove(case: Case, column: Seen, symbol: str) -> None:
    if column.unit is not None:
        _ask(case, column, symbol, f"{column.label} says {column.unit.symbol}, and the void ratio changes as if it were {_in_words(symbol)}")
        return
    case.decide(f"units.{column.quantity}", symbol, f"the void ratio changes with {column.label} so")
    case.replace(replace(column, unit=UNITS[symbol]))
    for other in (case.column(name) for name in STRAINS):
        if other is not None and other.unit is None and _by_void_ratio(case, other) is None:
            case.replace(replace(other, unit=UNITS[symbol]))
            case.decide(f"units.{other.quantity}", symbol, f"strains of a file without units share one, and that of {column.label} is proven")


def _by_size(case: Case, bare: list[Seen]) -> None:
    """Strains that share no stated unit: percent or fractions, by the largest of them."""
    axial = next((column for column in bare if column.quantity == "axial_strain"), None)
    value = abs(extreme((axial or bare[0]).values))
    symbol = (
        "%"
        if SURELY_PERCENT[0] < value <= SURELY_PERCENT[1]
        else "-"
        if FRACTION[0] <= value <= FRACTION[1] and axial is not None and _is_far_sheared(case, axial)
        else None
    )
    if symbol is None or axial is None:
        for column in bare:
            _ask(
                case,
                column,
                "%" if value > FRACTION[1] else "-",
                f"{column.label} has no unit, and values to {abs(extreme(column.values)):g} may be percent or fractions",
            )
        return
    because = f"{axial.label} goes to {value:g}, " + (
        "and no sample is strained by more than its length"
        if symbol == "%"
        else "and the stress has come to most of its largest at a tenth of that: the sample is sheared by more than so many percent"
    )
    for column in bare:
        case.decide(f"units.{column.quantity}", symbol, because)
        case.replace(replace(column, unit=UNITS[symbol]))


def _is_far_sheared(case: Case, axial: Seen) -> bool:
    """Whether the stress has grown to most of its largest at a tenth of the axial strain."""
    names = ("deviator_stress", "half_difference_stress", "axial_stress", "total_axial_stress", "stress_ratio", "deviator_to_mean_stress")
    stress = next((column for name in names if (column := case.column(name))), None)
    if stress is None:
        return False
    both = ~np.isnan(axial.values) & ~np.isnan(stress.values)
    strain, values = np.abs(axial.values[both]), np.abs(stress.values[both] - stress.values[both][0])
    early = strain <= 0.1 * strain.max()
    return bool(values[early].max(initial=0.0) >= AT_A_TENTH * values.max())


def _doubt_sizes(case: Case) -> None:
    """A volumetric strain that is a hundredth of what the axial one makes likely."""
    axial, volumetric = case.column("axial_strain"), case.column("volumetric_strain")
    if axial is None or volumetric is None or any(question.key.startswith("units.") for question in case.questions):
        return
    largest, change = abs(extreme(axial.plain)), extent(volumetric.plain)
    if 0.01 < largest < 1 and 0 < change < TOO_SMALL_A_PART * largest and change > 20 * volumetric.last_digit and not _pore_moves(case):
        other = "-" if volumetric.unit and volumetric.unit.symbol == "%" else "%"
        _ask(case, volumetric, other, f"{volumetric.label} changes by {change:.2g} while the axial strain goes to {largest:.3g}, as if its unit were another")


def _pore_moves(case: Case) -> bool:
    """Whether a pore pressure changes beside the stresses, as in a test whose volume stays."""
    pore = case.column("pore_pressure") or case.column("excess_pore_pressure")
    stresses = [
        column
        for column in case.columns
        if column.quantity in ("deviator_stress", "axial_stress", "total_axial_stress", "half_difference_stress", "mean_stress")
    ]
    return pore is not None and extent(pore.plain) > PORE_MOVES * max((extent(column.plain) for column in stresses), default=0.0)


def _ask(case: Case, column: Seen, proposed: str, sentence: str) -> None:
    case.replace(replace(column, unit=UNITS[proposed]))
    case.ask(f"units.{column.quantity}", f"{sentence}: in which unit is it?", ("%", "-"), proposed, f"--column {column.quantity}={column.index + 1}:UNIT")


def _in_words(symbol: str) -> str:
    return "a fraction" if symbol == "-" else f"in {symbol}"


def decide_stresses(case: Case) -> None:
    """Stresses of one file share a unit; one that no header states is asked."""
    stresses = [column for column in case.columns if DIMENSIONS.get(column.quantity) == "pressure" and not column.unusable]
    if any(column.said for column in stresses):
        # A person who names some columns and their units does without the others that have none.
        for column in [column for column in stresses if column.unit is None and not column.said]:
            case.replace(replace(column, unusable=f"{column.quantity}, but it has no unit, and other columns were named"))
            stresses.remove(column)
    bare = [column for column in stresses if column.unit is None]
    if not bare:
        return
    stated = {column.unit.symbol for column in stresses if column.unit is not None}
    largest = max(abs(extreme(column.values)) for column in bare)
    proposed = next(iter(stated)) if len(stated) == 1 else "kPa" if 5 < largest < 3e4 else "Pa" if largest >= 3e4 else "MPa"
    proven = case.known.stress_unit or _by_pressure(case, bare, proposed)
    found = find_unit(proven or proposed)
    assert found is not None, "a unit that a person gives was looked at before"
    for column in bare:
        case.replace(replace(column, unit=UNITS[found.symbol if proven else proposed]))
    names = ", ".join(column.label for column in bare)
    if proven:
        because = "you gave it" if case.known.stress_unit else "the confining pressure that you gave is that of the column in this unit"
        case.decide("units", proven, f"{because}, for {names}", by="person" if case.known.stress_unit else "proof")
    else:
        why = f"the others are in {proposed}" if len(stated) == 1 else "no stress of the file has one"
        case.ask(
            STRESS_UNITS,
            f"{names} {'has' if len(bare) == 1 else 'have'} no unit, and {why}: in which unit {'is it' if len(bare) == 1 else 'are they'}?",
            ("Pa", "kPa", "MPa", "psi", "kgf/cm2"),
            proposed,
            "--stress-unit",
        )
        case.bare_stresses = tuple(column.index for column in bare)


def _by_pressure(case: Case, bare: list[Seen], proposed: str) -> str | None:
    """The unit in which a column of lateral stress is the confining pressure that a person gave."""
    lateral = next((column for column in bare if column.quantity in ("lateral_stress", "total_lateral_stress")), None)
    if lateral is None or case.known.confining_pressure is None:
        return None
    value = abs(float(lateral.values[~np.isnan(lateral.values)][0]))
    fits = [symbol for symbol, unit in UNITS.items() if unit.dimension == "pressure" and abs(value * unit.factor / case.known.confining_pressure - 1) < 0.01]
    return proposed if proposed in fits else fits[0] if fits else None


def decide_height(case: Case) -> None:
    """A displacement is of use with the sample's height alone."""
    column = case.column("axial_displacement")
    if column is not None and case.sample_height is None:
        case.replace(
            replace(
                column, unusable="axial_displacement, but no line above the table is known as the sample's height, or more than one: --sample-height gives it"
            )
        )
    elif column is not None and column.unit is None:
        case.replace(replace(column, unusable="axial_displacement, but it has no unit"))


def decide_volume(case: Case) -> float | None:
    """The sample's volume in m³ where a change of volume is read; and that column's unit, where one alone makes strains of it that a sample has."""
    column, volume = case.column("volume_change"), case.sample_volume
    if column is None or case.column("volumetric_strain") is not None:
        return None
    if volume is None:
        case.replace(
            replace(
                column,
                unusable="volume_change, but no lines above the table are known as the sample's volume, or its height and diameter, or more than one: --sample-volume gives it",
            )
        )
        return None
    if column.unit is None:
        change = extent(column.values)
        possible = [symbol for symbol in ("mm3", "cm3", "l", "m3") if 1e-3 < change * UNITS[symbol].factor / volume < 0.4]
        proposed = possible[0] if possible else "mm3"
        case.replace(replace(column, unit=UNITS[proposed]))
        if len(possible) == 1:
            case.decide(
                "units.volume_change",
                proposed,
                f"in another unit {column.label} would be more than the sample's volume, {volume * 1e9:.6g} mm3, or nothing of it",
            )
        else:
            case.ask(
                "units.volume_change",
                f"{column.label} has no unit: in which unit is it?",
                tuple(possible),
                proposed,
                f"--column volume_change={column.index + 1}:UNIT",
            )
    return volume
