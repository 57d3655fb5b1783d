"""The effective stresses of a triaxial sample from whatever stresses a file has: which columns are total, and by which convention p and q are meant."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from graincal.laboratory.quantities import OF_CAMBRIDGE_AND_MIT, STRESS_FORMS, TOTAL
from graincal.laboratory.stresses import spread, weights
from graincal.laboratory.understanding.seen import Seen

AGREES = 0.005
"""Columns agree that differ by less than this part of the largest stress."""
CONSTANT = 0.06
"""A stress is held constant that stays within this part of itself."""
CLEARER = 3.0
"""A stress is the constant one where others vary so many times more."""
LARGEST_RATIO = 20.0


@dataclass(frozen=True, eq=False)
class StressState:
    """What the stresses of a file come to. quantities: column index -> name in STRESS_FORMS and sign. axial, lateral: effective, (T,), Pa or what the unit is; None
    where they are not decided. deviator: their difference, also where it alone is known. pore: (T,) or None. because: the proof, empty where no choice was to be made."""

    quantities: dict[int, tuple[str, float]]
    axial: NDArray[np.float64] | None
    lateral: NDArray[np.float64] | None
    deviator: NDArray[np.float64] | None
    pore: NDArray[np.float64] | None
    because: str = ""

    @property
    def mean(self) -> NDArray[np.float64] | None:
        return None if self.axial is None or self.lateral is None else (self.axial + 2 * self.lateral) / 3


def variation(values: NDArray[np.float64]) -> float:
    """The range of values (T,) as a part of their mean."""
    values = values[~np.isnan(values)]
    mean = float(np.mean(np.abs(values))) if values.size else 0.0
    return float(np.ptp(values)) / mean if mean > 0 else 0.0


def stress_states(columns: Sequence[Seen], wet: bool, signs: Mapping[str, float]) -> tuple[list[StressState], list[str]]:
    """The ways in which the columns of stresses can be understood without contradicting one another, the likely ones first; and why the others cannot be so.

    wet: whether the file speaks of a pore or back pressure, so that a stress may be a total one. signs: of compression, by quantity, where a person says it.
    """
    found: list[StressState] = []
    reasons: list[str] = []
    for choice in _choices(columns, wet, signs):
        forms = [STRESS_FORMS[name] for name, _ in choice]
        values = np.stack([sign * column.plain for column, (_, sign) in zip(columns, choice)])
        state = _state(columns, choice, forms, values)
        if isinstance(state, StressState):
            found.append(state)
        elif state not in reasons:
            reasons.append(state)
    return _distinct(found), reasons


def _choices(columns: Sequence[Seen], wet: bool, known: Mapping[str, float]) -> Iterator[tuple[tuple[str, float], ...]]:
    effective_partners = {column.meaning.quantity for column in columns if column.meaning.effective}
    normal = [column for column in columns if column.quantity not in ("deviator_stress", "half_difference_stress", "pore_pressure")]
    flipped = -1.0 if normal and np.nanmedian(np.concatenate([column.values for column in normal])) < 0 else 1.0
    # q alone is the difference of the stresses; beside a p it is what belongs to that p.
    both = {column.quantity for column in columns if column.meaning.symbol and not column.said} >= {"mean_stress", "deviator_stress"}
    options: list[list[tuple[str, float]]] = []
    for column in columns:
        name, said = column.quantity, column.meaning
        names = [name]
        if said.symbol and not column.said and name in OF_CAMBRIDGE_AND_MIT and (both or name != "deviator_stress"):
            names.append(OF_CAMBRIDGE_AND_MIT[name])
        if not column.said and said.effective is None and name in TOTAL:
            of_total = [TOTAL[each] for each in names]
            # σ1 beside σ1' is the total one.
            names = (
                of_total
                if (name in effective_partners and name in ("axial_stress", "lateral_stress")) or (said.cell and wet)
                else [*names, *of_total]
                if wet
                else names
            )
        signs = (
            (flipped,)
            if name not in ("deviator_stress", "half_difference_stress", "pore_pressure")
            else (1.0,)
            if name == "pore_pressure" or flipped > 0
            else (-1.0, 1.0)
        )
        signs = (known[name],) if name in known else signs
        options.append([(each, sign) for each in names for sign in signs])
    for choice in product(*options):
        conventions = {
            name in OF_CAMBRIDGE_AND_MIT.values() for (name, _), column in zip(choice, columns) if both and column.meaning.symbol and not column.said
        }
        if len(conventions) <= 1:
            yield choice


def _state(columns: Sequence[Seen], choice: tuple[tuple[str, float], ...], forms: Sequence[Sequence[float]], values: NDArray[np.float64]) -> StressState | str:
    """What the columns come to if they are what the choice says, or why they cannot be that."""
    complete = ~np.any(np.isnan(values), axis=0)
    if not np.any(complete):
        return "no row holds a number in each of them"
    if np.linalg.matrix_rank(np.array(forms)) < len(forms) and spread(forms, values[:, complete]) > AGREES:
        return f"as {', '.join(name for name, _ in choice)} they contradict one another by {100 * spread(forms, values[:, complete]):.2g} % of the largest"
    axial, lateral, deviator, pore = (
        None if (found := weights(STRESS_FORMS[name], forms)) is None else found @ values
        for name in ("axial_stress", "lateral_stress", "deviator_stress", "pore_pressure")
    )
    if axial is not None and lateral is not None and (doubt := _doubt(axial[complete], lateral[complete])):
        return doubt
    if pore is not None and not any(name == "pore_pressure" for name, _ in choice) and pore[complete][0] < -AGREES * np.nanmax(np.abs(values)):
        # A total stress is above the effective one where a test begins.
        return f"the total stresses would begin {-pore[complete][0]:.6g} Pa below the effective ones"
    quantities = {column.index: (name, sign) for column, (name, sign) in zip(columns, choice)}
    return StressState(quantities, axial, lateral, deviator, pore)


def _doubt(axial: NDArray[np.float64], lateral: NDArray[np.float64]) -> str:
    """Why effective stresses (T,) can be those of no sample; empty where they can."""
    scale, low = float(np.max(np.abs(axial))), min(float(np.min(axial)), float(np.min(lateral)))
    if np.min(lateral) <= 0 and np.max(np.abs(lateral)) < 0.02 * scale:
        return "the lateral stress is 0, as in an unconfined test or of a sensor that was set to 0, and one above it was expected"
    if low < -0.02 * scale:
        return f"an effective stress would fall to {low:.6g} Pa"
    above = lateral > 0
    ratio = float(np.median(axial[above] / lateral[above])) if np.any(above) else np.inf
    if not 1 / LARGEST_RATIO < ratio < LARGEST_RATIO:
        return f"the axial stress would be {ratio:.3g} times the lateral one, which is no soil's, but may be of another unit"
    return ""


def _distinct(states: list[StressState]) -> list[StressState]:
    """Those that come to other stresses than the ones before."""
    kept: list[StressState] = []
    for state in states:
        if not any(_alike(state, other) for other in kept):
            kept.append(state)
    return kept


def _alike(a: StressState, b: StressState) -> bool:
    pairs = [(a.axial, b.axial), (a.lateral, b.lateral), (a.deviator, b.deviator)]
    if any((left is None) != (right is None) for left, right in pairs):
        return False
    if a.axial is None and a.lateral is None and _names_total(a) != _names_total(b):
        return False
    return all(left is None or right is None or np.nanmax(np.abs(left - right)) <= AGREES * np.nanmax(np.abs(left)) for left, right in pairs)


def _names_total(state: StressState) -> bool:
    return any(name in TOTAL.values() for name, _ in state.quantities.values())


def decide(states: list[StressState]) -> tuple[StressState | None, list[StressState]]:
    """The state that the columns prove, and all that are possible where they prove none: the one whose lateral stress, effective or total, is held constant."""
    if len(states) <= 1:
        return (states[0] if states else None), states
    whole = [state for state in states if state.axial is not None and state.lateral is not None]
    if len(whole) < len(states):
        return None, states
    moving = any(state.pore is not None and variation(state.pore) > CONSTANT for state in whole)
    # Where the pore pressure moves, what an apparatus holds is the total stress.
    held = [
        ("the total lateral stress", _total_lateral),
        ("the effective lateral stress", lambda state: state.lateral),
        ("the mean effective stress", lambda state: state.mean),
    ]
    for what, stress in held if moving else [held[1], held[2], held[0]]:
        if (best := _clearest([stress(state) for state in whole], variation, CONSTANT)) is not None:
            value = stress(whole[best])
            return replace(
                whole[best], because=f"{what} that they give is then constant ({np.nanmean(value):.6g} within {100 * variation(value):.2g} %)"
            ), states
    if (best := _clearest([_part(state.deviator, state.mean) for state in whole], lambda part: abs(float(part[~np.isnan(part)][0])), CONSTANT)) is not None:
        return replace(whole[best], because="the axial and the lateral stress that they give are then the same at the beginning"), states
    return None, states


def _part(deviator: NDArray[np.float64] | None, mean: NDArray[np.float64] | None) -> NDArray[np.float64] | None:
    """The deviator stress (T,) as a part of the mean one; infinite where that is 0, and NaN in rows that lack one. None where one of them is not known."""
    if deviator is None or mean is None:
        return None
    loaded = mean != 0
    return np.where(loaded, deviator / np.where(loaded, mean, 1.0), np.inf)


def _total_lateral(state: StressState) -> NDArray[np.float64] | None:
    return None if state.pore is None or state.lateral is None else state.lateral + state.pore


def _clearest(values: Sequence[NDArray[np.float64] | None], size: Callable[[NDArray[np.float64]], float], small: float) -> int | None:
    """Which of the values has a small size while all others are clearly larger; None where none does."""
    known = [value for value in values if value is not None]
    if len(known) < len(values):
        return None
    ranked = sorted((size(value), at) for at, value in enumerate(known))
    return ranked[0][1] if ranked[0][0] < small and ranked[1][0] > max(CLEARER * ranked[0][0], small / 2) else None
