"""What a study finds: rows of its tables, its figures, and whether the paper's conclusions hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from graincal.drawing.figure import Figure
from graincal.studies.judging import Judgement


@dataclass(frozen=True)
class Row:
    """One number of one of the paper's tables.

    setting: the row of the paper's table. quantity: its column. paper: what the paper printed, None where it printed nothing. ours: what graincal
    found, one number a seed; none where it was not run. floor: by how much runs at one and the same parameters differ in it; None where that is not
    known. method: by which ours were found; none for plain runs. missing: why it cannot be run, in words. remark: what is to be said beside ours, as
    that calibrations were cut.
    """

    setting: str
    quantity: str
    paper: float | None
    ours: tuple[float, ...] = ()
    floor: float | None = None
    method: str = ""
    missing: str = ""
    remark: str = ""

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
    """A table by the paper's number, or by a name where the paper prints its figures in the text: its title and rows. notes: what is to be said below
    it.
    """

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
class Conclusion:
    """What the paper concludes, in a sentence of ours, and what graincal's numbers say of it.

    of_paper: whether it is the paper's, and not one more of graincal's.
    """

    claim: str
    judgement: Judgement
    of_paper: bool = True


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


def conclusions(claims: Mapping[str, Judgement], of_paper: bool = True) -> tuple[Conclusion, ...]:
    """Claims with what is judged of them."""
    return tuple(Conclusion(claim, judgement, of_paper) for claim, judgement in claims.items())
