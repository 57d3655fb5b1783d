"""What is being found out about a file: what is known of it, what was decided with which proof, and what is asked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from graincal.errors import InputError
from graincal.laboratory.decisions import Decision, Question
from graincal.laboratory.table import Table
from graincal.laboratory.understanding import remarks
from graincal.laboratory.understanding.seen import Seen, one
from graincal.laboratory.understanding.strains import void_ratio_of
from graincal.laboratory.understanding.stress_state import StressState

IN_WORDS = {
    "triaxial": "a drained triaxial test", "undrained": "an undrained triaxial test", "constant-mean-stress": "a triaxial test at constant mean stress",
    "oedometric": "an oedometer test", "isotropic": "an isotropic compression",
}  # fmt: skip


class NotUnderstood(InputError):
    """A file whose columns are not known by their names."""


@dataclass(frozen=True)
class Known:
    """What a person knows beyond the file. columns: quantity -> place and unit (None for the file's). compression: quantity -> "positive" or "negative".
    stress_unit: that of the stresses whose headers state none. sample_height and sample_volume in m and m³."""

    kind: str | None = None
    strain: str | Mapping[str, str] | None = None
    confining_pressure: float | None = None
    void_ratio: float | None = None
    columns: Mapping[str, tuple[str | int, str | None]] = field(default_factory=dict)
    stress_unit: str | None = None
    compression: Mapping[str, str] = field(default_factory=dict)
    stage: str | int | None = None
    rows: tuple[int, int] | None = None
    sheet: str | int | None = None
    encoding: str | None = None
    sample_height: float | None = None
    sample_volume: float | None = None


@dataclass(eq=False)
class Case:
    """A file on its way to being understood. `columns`: as they are seen; `summed`: those whose sum is the volumetric strain of a recorder;
    `bare_stresses`: the indices of columns of stresses whose unit is asked."""

    table: Table
    known: Known
    words: tuple[str, ...]
    columns: list[Seen]
    summed: tuple[Seen, ...] = ()
    state: StressState | None = None
    kind: str = ""
    extension: bool = False
    strain_sign: dict[str, float] = field(default_factory=dict)
    measures: dict[str, str] = field(default_factory=dict)
    bare_stresses: tuple[int, ...] = ()
    decided: list[Decision] = field(default_factory=list)
    questions: list[Question] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def column(self, quantity: str) -> Seen | None:
        return one(self.columns, quantity)

    def replace(self, column: Seen) -> None:
        self.columns = [column if other.index == column.index else other for other in self.columns]

    def decide(self, what: str, value: object, because: str, **how: str) -> None:
        self.decided.append(Decision(what, str(value), because, **how))

    def ask(self, key: str, sentence: str, answers: tuple[str, ...] = (), proposed: str = "", option: str = "") -> None:
        if not any(question.key == key for question in self.questions):
            self.questions.append(Question(key, sentence, answers, proposed, option))

    @property
    def shortening(self) -> Seen | None:
        """The column that the axial strain follows from."""
        return self.column("axial_strain") or self.column("axial_displacement")

    @property
    def sample_height(self) -> float | None:
        """m, of the sample when a displacement of it is 0."""
        return self.known.sample_height or remarks.sample_height(self.words)

    @property
    def sample_volume(self) -> float | None:
        """m³, of the sample when a change of it is 0."""
        return self.known.sample_volume or remarks.sample_volume(self.words)

    @property
    def void_ratio(self) -> Seen | None:
        """The column that the void ratio follows from."""
        return next((column for quantity in ("void_ratio", "porosity", "specific_volume") if (column := self.column(quantity))), None)

    @property
    def void_ratios(self) -> NDArray[np.float64] | None:
        """The void ratio (T,); None where no column gives it."""
        column = self.void_ratio
        return None if column is None else void_ratio_of(column.quantity, column.values)

    @property
    def void_ratio_digits(self) -> float:
        """The step of the void ratio that its column prints, or that a step of the porosity makes."""
        column = self.void_ratio
        assert column is not None, "asked where there is a void ratio"
        return column.last_digit / (1 - float(np.nanmax(column.plain))) ** 2 if column.quantity == "porosity" else column.last_digit

    @property
    def wet(self) -> bool:
        """Whether the file speaks of a pore or back pressure."""
        return any(self.column(name) for name in ("pore_pressure", "excess_pore_pressure", "back_pressure")) or remarks.back_pressure(self.words) is not None


def extreme(values: NDArray[np.float64]) -> float:
    """The value (of T) furthest from 0."""
    values = values[~np.isnan(values)]
    return float(values[np.argmax(np.abs(values))]) if values.size else 0.0


def extent(values: NDArray[np.float64]) -> float:
    """From the lowest to the highest of the values (T,); 0 without any."""
    values = values[~np.isnan(values)]
    return float(np.ptp(values)) if values.size else 0.0
