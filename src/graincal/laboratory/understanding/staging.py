"""Which rows of a machine's file are the shear: by the words of its stages, by what happens in them, or not at all."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from graincal.errors import InputError
from graincal.laboratory.backbone import runs
from graincal.laboratory.decisions import Decision
from graincal.laboratory.quantities import VOID_RATIOS
from graincal.laboratory.stages import choose_rows, say_stages, stages
from graincal.laboratory.table import Table
from graincal.laboratory.understanding import remarks
from graincal.laboratory.understanding.case import Case, Known
from graincal.laboratory.understanding.seen import Seen, one, see

_SHEAR = re.compile(
    r"shear|scher|cisaill|corte|cizall|cisalh|taglio|afschuif|ścin|smyk|kesme|срез|сдвиг|девиаторн|剪|せん断|전단|^compression$|(?<![^\W\d_])(?<!un[-_ ])(?<!re[-_ ])(?<!pre[-_ ])(?<!off[-_ ])loading",
    re.IGNORECASE,
)
COMPRESSIONS = ("oedometric", "isotropic")
_DRIVING = {"axial_stress", "mean_stress"}
_OF_SHEAR = {
    "deviator_stress",
    "half_difference_stress",
    "stress_ratio",
    "deviator_to_mean_stress",
    "lateral_stress",
    "total_lateral_stress",
    "radial_strain",
    "volume_change",
}
"""What a test without shear has no columns of."""
MOST_OTHER_STRAIN = 1 / 3
"""A stage before the shear strains the sample by a smaller part of what the shear does."""
SETTLED = 0.15
"""A lateral stress is held in the shear to this part of it; corrections for the membrane alone let it drift by a tenth."""
ISOTROPIC = 0.1
CONSOLIDATED = 0.3
"""Of its largest: what an effective lateral stress changes by in a consolidation, and by less in a shear before there is a deviator stress."""
UNSHEARED = 0.05
"""Of the largest deviator stress: what there may be of one before the shear."""
ANEW, LOOP = 0.5, 0.1
"""A test that falls back to less than the one part of its strain, and grows again by more than the other, is no unload-reload loop, which takes the elastic strain back."""
OFFSET = {"axial_strain": (0.01, 0.1), "volumetric_strain": (0.002, 0.1)}
"""So large, and so large a part of its range, is no strain where a sample has hardly been sheared."""


def shear_stage(table: Table, known: Known) -> tuple[Table, str | None, list[Decision]]:
    """The rows of the shear stage, the stage's name, and why. The whole table for one without stages, with a single one, or of a compression test.

    Raises InputError, which names the stages and their lines, where it cannot be told which of them is the shear, or where it stands in more than one place.
    """
    found = stages(table)
    if len(found) < 2 or _is_compression(table, known):
        return table, None, []
    by_word = [name for name in found if _SHEAR.search(name)]
    if len(by_word) == 1:
        chosen, because, by = by_word[0], f"its stages are {say_stages(table)}, and this one is called so", "words"
    elif (by_strain := _by_strain(table, found, known.columns)) is not None:
        chosen, because, by = by_strain, f"its stages are {say_stages(table)}, and the sample is sheared in this one alone", "proof"
    else:
        raise InputError(
            f"{table.path}: the file has the stages {say_stages(table)}, and which of them is the shear cannot be told: --stage NAME, or stage under [experiment.reference], chooses one."
        )
    kept, _ = choose_rows(table, chosen, None)
    return kept, chosen, [Decision("stage", chosen, because, by)]


def _is_compression(table: Table, known: Known) -> bool:
    """Whether a file is of a test without shear, whose stages are its steps of load: a void ratio or a settlement under a single stress."""
    if known.kind is not None:
        return known.kind in COMPRESSIONS
    there = {column.quantity for column in see(table, known.columns) if column.has_numbers}
    if there & _OF_SHEAR:
        return False
    stress, change = bool(there & _DRIVING), bool(there & {*VOID_RATIOS, "axial_displacement"})
    return stress and (change or remarks.kind((*table.remarks, *table.header)) in COMPRESSIONS)


def _by_strain(table: Table, found: dict[str, list[int]], said: Mapping[str, tuple[str | int, str | None]]) -> str | None:
    """The stage in which the axial strain grows, and the deviator stress with it, if there is one alone."""
    columns = see(table, said)
    strain = one(columns, "axial_strain")
    if strain is None:
        return None
    grown = {name: _range(strain.values[rows]) for name, rows in found.items()}
    largest = max(grown, key=grown.__getitem__)
    if any(value > MOST_OTHER_STRAIN * grown[largest] for name, value in grown.items() if name != largest):
        return None
    stress = next((column for name in ("deviator_stress", "axial_stress") if (column := one(columns, name))), None)
    if stress is not None and _range(stress.values[found[largest]]) <= UNSHEARED * _range(stress.values):
        return None
    return largest


def _range(values: NDArray[np.float64]) -> float:
    values = values[~np.isnan(values)]
    return float(np.ptp(values)) if values.size else 0.0


def refuse_hidden_stages(
    table: Table, columns: list[Seen], lateral: NDArray[np.float64] | None, deviator: NDArray[np.float64] | None, effective: NDArray[np.float64] | None = None
) -> None:
    """Refuse a table without stages whose first rows are a saturation or a consolidation: the lateral stress (T,), a total one where it is known, is another there than
    in the rest, the effective one changes by much, or the volume changes, before there is a deviator stress (T,)."""
    if deviator is None:
        return
    largest = float(np.nanmax(np.abs(deviator)))
    quiet = np.abs(deviator) <= UNSHEARED * largest
    first = next((span for span in runs(quiet) if span[0] == 0), None)
    if first is None or first[1] < 1:
        return
    last, lines = first[1], table.lines
    if lateral is not None:
        rest = float(np.nanmedian(lateral[last + 1 :])) if last + 1 < len(lateral) else float("nan")
        other = np.flatnonzero(np.abs(lateral[: last + 1] - rest) > SETTLED * abs(rest))
        if other.size >= 2:
            raise _of_stages(table, f"the lateral stress goes from {lateral[0]:g} to {rest:g} Pa while there is hardly a deviator stress", lines[last])
    if effective is not None:
        # Isotropic beside the stress itself, too: a dense undrained sample comes to a deviator stress many times that.
        still = int(np.argmin(np.append(np.abs(deviator[: last + 1]) <= ISOTROPIC * np.abs(effective[: last + 1]), False))) - 1
        if still >= 1 and (moved := abs(effective[still] - effective[0])) > CONSOLIDATED * np.nanmax(np.abs(effective[: still + 1])):
            raise _of_stages(table, f"the effective lateral stress changes by {moved:g} Pa while there is hardly a deviator stress", lines[still])
    volume = next((column for name in ("volumetric_strain", "volume_change") if (column := one(columns, name))), None)
    strain = one(columns, "axial_strain")
    if volume is not None and strain is not None and last >= 2:
        changed, strained = (_range(column.values[: last + 1]) / (_range(column.values) or 1) for column in (volume, strain))
        if changed > 0.2 and changed > 5 * strained:
            raise _of_stages(table, f"the volume changes by {100 * changed:.0f} % of its whole change while there is hardly a deviator stress", lines[last])


def refuse_restarts(path: str, strain: NDArray[np.float64], lines: Sequence[int]) -> None:
    """Refuse a strain (T,), compression positive, that begins anew: tests below one another, cycles, or a slip that a test turns back behind."""
    highest = np.maximum.accumulate(strain - strain[0])
    for at in np.flatnonzero((strain - strain[0] < ANEW * highest) & (highest > LOOP * highest[-1])).tolist():
        rest = strain[at:]
        if np.max(rest) - rest[np.argmin(rest[: np.argmax(rest) + 1])] > LOOP * highest[at]:
            before = int(np.argmax(strain[:at]))
            raise InputError(
                f"{path}: the axial strain falls from line {lines[before]} to line {lines[at]} to less than half, and grows again: these are several tests or stages below one another, cycles, or a slip on one line; "
                f"--rows FIRST-LAST chooses the lines of one test, such as {lines[0]}-{lines[before]}."
            )


def refuse_other_zero(case: Case) -> None:
    """Refuse strains that are not near 0 on the first row of a test without stages, while there is hardly a deviator stress: they count from before the shear."""
    stress = (
        case.state.deviator
        if case.state is not None and case.state.deviator is not None
        else ratio.plain - 1
        if (ratio := case.column("stress_ratio")) is not None
        else None
    )
    if stress is None:
        return
    there = ~np.isnan(stress)
    stress = np.abs(stress[there])
    if stress[0] > 2 * UNSHEARED * np.max(stress):
        return
    for name, (large, part) in OFFSET.items():
        if (column := case.column(name)) is not None and abs(first := column.plain[there][0]) > max(large, part * _range(column.plain)):
            raise InputError(
                f"{case.table.path}: {column.label} is {100 * first:.4g} % on line {np.array(case.table.lines)[there][0]}, where there is hardly a deviator stress, so that strains seem to count from before the shear; "
                f"--rows {case.table.lines[0]}-{case.table.lines[-1]} counts them from its first line."
            )


def _of_stages(table: Table, what: str, last: int) -> InputError:
    return InputError(
        f"{table.path}: {what}, up to about line {last}: a consolidation or a saturation seems to stand before the shear, and the file does not say where the shear begins; "
        f"--rows FIRST-{table.lines[-1]} chooses its lines."
    )
