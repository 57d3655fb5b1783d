"""What a study finds: rows of its tables, its figures, and whether the paper's conclusions hold."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from graincal.report.drawing import Figure

HOLDS, DOES_NOT_HOLD, CANNOT_BE_TOLD = "holds", "does not hold", "cannot be told"


@dataclass(frozen=True)
class Row:
    """One number of one of the paper's tables.

    setting: the row of the paper's table. quantity: its column. paper: what the paper printed, None where it printed nothing. ours: what graincal found, one number a seed; none where it was not run.
    floor: by how much runs at one and the same parameters differ in it; None where that is not known. method: by which ours were found; none for plain runs.
    """

    setting: str
    quantity: str
    paper: float | None
    ours: tuple[float, ...] = ()
    floor: float | None = None
    method: str = ""

    @property
    def median(self) -> float:
        """Of ours; NaN without any."""
        return float(np.median(self._finite)) if self._finite else np.nan

    @property
    def low(self) -> float:
        """The smallest of ours."""
        return min(self._finite, default=np.nan)

    @property
    def high(self) -> float:
        """The largest of ours."""
        return max(self._finite, default=np.nan)

    @property
    def _finite(self) -> list[float]:
        return [value for value in self.ours if np.isfinite(value)]


@dataclass(frozen=True)
class Table:
    """A table by the paper's number, or by a name where the paper prints its figures in the text: its title and rows. notes: what is to be said below it."""

    number: int | str
    title: str
    rows: tuple[Row, ...]
    notes: tuple[str, ...] = ()

    @property
    def file(self) -> str:
        """The name of its file."""
        return f"table-{self.number:02d}.csv" if isinstance(self.number, int) else f"{self.number}.csv"

    @property
    def heading(self) -> str:
        return f"Table {self.number}: {self.title}" if isinstance(self.number, int) else self.title


@dataclass(frozen=True)
class Judgement:
    """Whether something holds, and a sentence that follows from the numbers."""

    verdict: str
    reason: str


@dataclass(frozen=True)
class Conclusion:
    """What the paper concludes, in a sentence of ours, and what graincal's numbers say of it."""

    claim: str
    judgement: Judgement


@dataclass(frozen=True)
class Findings:
    """Of one study. figures: by the paper's numbers. notes: sentences on how it was done that its reader must know."""

    tables: tuple[Table, ...] = ()
    figures: Mapping[int, Figure] = field(default_factory=dict)
    conclusions: tuple[Conclusion, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def numbered_figures(self) -> dict[int, Figure]:
        """In the order of their numbers, which are in their titles."""
        return {number: replace(figure, title=f"Figure {number}: {figure.title}") for number, figure in sorted(self.figures.items())}


@dataclass(frozen=True)
class Values:
    """A quantity of which a conclusion speaks: what it is called, and its values, one a seed. floor: by how much runs at the same parameters differ in it."""

    name: str
    values: tuple[float, ...]
    floor: float = 0.0
    unit: str = " %"

    @classmethod
    def of(cls, name: str, values: Iterable[float], floor: float | None = 0.0, unit: str = " %") -> Values:
        """Those that are finite."""
        return cls(name, tuple(float(value) for value in values if np.isfinite(value)), floor or 0.0, unit)

    @property
    def median(self) -> float:
        return float(np.median(self.values))

    @property
    def spread(self) -> float:
        """From the smallest to the largest."""
        return max(self.values) - min(self.values)

    def __str__(self) -> str:
        return f"{self.name} is {self.median:.3g}{self.unit}"

    def as_sentence(self) -> str:
        """To begin a sentence with."""
        said = str(self)
        return said if said.startswith("ε") else said[0].upper() + said[1:]


def smaller(one: Values, other: Values) -> Judgement:
    """Whether one quantity is smaller than another, by more than runs at the same parameters differ and more than the seeds spread."""
    if nothing := [each.name for each in (one, other) if not each.values]:
        return Judgement(CANNOT_BE_TOLD, f"{nothing[0]} was not run.")
    difference, scatter = other.median - one.median, max(one.floor, other.floor)
    spread = max(one.spread, other.spread)
    said = f"{one.as_sentence()}, and {other}"
    if abs(difference) <= scatter:
        return Judgement(CANNOT_BE_TOLD, f"{said}: runs at the same parameters differ by {scatter:.2g}{one.unit}, which is as much.")
    if abs(difference) <= spread:
        return Judgement(CANNOT_BE_TOLD, f"{said}: seeds spread over {spread:.2g}{one.unit}, which is as much.")
    return Judgement(HOLDS if difference > 0 else DOES_NOT_HOLD, f"{said}.")


def at_most(one: Values, limit: float) -> Judgement:
    """Whether a quantity is at most a number: it is where that holds for every seed, and is not where every seed exceeds the number by more than runs at the same parameters differ."""
    if not one.values:
        return Judgement(CANNOT_BE_TOLD, f"{one.name} was not run.")
    said = f"{one.as_sentence()}{f', from {min(one.values):.3g} to {max(one.values):.3g} over seeds' if one.spread else ''}; the limit is {limit:.3g}{one.unit}"
    if max(one.values) <= limit:
        return Judgement(HOLDS, f"{said}.")
    if min(one.values) > limit + one.floor:
        return Judgement(DOES_NOT_HOLD, f"{said}.")
    why = f"runs at the same parameters differ by {one.floor:.2g}{one.unit}" if one.floor else "seeds lie on both sides"
    return Judgement(CANNOT_BE_TOLD, f"{said}, and {why}.")


def off(shown: str, found: Iterable[float], truth: float) -> Values:
    """By how many percent values of a parameter are off a true one."""
    return Values.of(f"the error of {shown}", [100 * abs(value / truth - 1) for value in found])


def all_of(judgements: Sequence[Judgement]) -> Judgement:
    """Of a conclusion that speaks of several differences: it holds where each does, and does not where one does not."""
    for verdict in (DOES_NOT_HOLD, CANNOT_BE_TOLD):
        if found := [each for each in judgements if each.verdict == verdict]:
            rest = "" if len(found) == len(judgements) else f" That is {len(found)} of {len(judgements)} comparisons."
            return Judgement(verdict, found[0].reason + rest)
    if not judgements:
        return Judgement(CANNOT_BE_TOLD, "Nothing of it was run.")
    return Judgement(HOLDS, " ".join(each.reason for each in judgements[:2]) + (f" So it is in all {len(judgements)} comparisons." if len(judgements) > 2 else ""))
