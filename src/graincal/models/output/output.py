"""What a program's output is declared to be, and the response that is read from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graincal.data import Failure, InputError, Response
from graincal.errors import not_installed
from graincal.interpolation import covers, interpolate, span
from graincal.laboratory.backbone import repeated, turned_back
from graincal.laboratory.columns import Conventions
from graincal.laboratory.quantities import STRAINS
from graincal.models.output.columns import Column, evaluate
from graincal.models.output.tables import Columns, Unreadable, read_columns
from graincal.notation.expression import Expression
from graincal.suggestion import did_you_mean

PERCENT = 100.0
"""How many times too large a strain in percent is, taken as a fraction."""

IMPOSSIBLE = 1.0
"""A strain that no test reaches, where its reference is far from it."""

HDF5 = (".h5", ".hdf5")
"""Endings of files that take a package more to be read."""

STANDARD_OUTPUT = "-"
"""The name of a file that stands for what a program prints."""

ROUNDED = 1e-6
"""Of the span of the control that is asked for: programs print their numbers with six digits or more."""

LEFT_OUT = "rows_left_out"
"""The detail of a response that says how many rows were left out, for the control fell back or stood still there."""


@dataclass(frozen=True)
class Output:
    """A table that a program writes.

    columns: quantity -> `Column`, the control among them. file: its name in the evaluation's folder, or "-" for what is printed. zero: quantities that count from the first row that is read. first_row: the number of
    that row, from 1. where: an expression of columns that holds for the rows that are read, such as `stage == 2`. strain: "logarithmic" or "engineering", one word for all strains or quantity -> word.

    Raises InputError for what cannot be.
    """

    columns: Mapping[str, Column]
    file: str = STANDARD_OUTPUT
    zero: tuple[str, ...] = ()
    first_row: int | None = None
    where: str | None = None
    strain: str | Mapping[str, str] = "logarithmic"

    def __post_init__(self) -> None:
        if not self.columns:
            raise InputError('output.columns must name at least the control and one quantity, such as { axial_strain = "eps_a [%]", stress_ratio = "ratio" }.')
        strains = [name for name in self.columns if name in STRAINS]
        for key, names, known in (("zero", self.zero, list(self.columns)), ("strain", self.strain if isinstance(self.strain, Mapping) else (), strains)):
            if unknown := [name for name in names if name not in known]:
                raise InputError(
                    f"output.{key} names '{unknown[0]}'{did_you_mean(unknown[0], known)}, and some of {', '.join(known) or 'no quantity'} were expected."
                )

    @classmethod
    def restored(cls, described: Mapping[str, Any]) -> Output:
        """The output that `asdict` described."""
        return cls(**dict(described) | {"columns": {name: Column(**column) for name, column in described["columns"].items()}, "zero": tuple(described["zero"])})

    def check(self, control: str) -> None:
        """Raise InputError where the control is no column, or nothing else is."""
        if control not in self.columns:
            raise InputError(
                f"output.columns has no {control}, which is the control of the experiment, and a column for it was expected beside {', '.join(self.columns)}."
            )
        if len(self.columns) == 1:
            raise InputError(f"output.columns has {control} alone, and a column for each observable was expected beside it.")
        if self.file.endswith(HDF5) and find_spec("h5py") is None:
            raise not_installed(f"output.file is {self.file}, and an HDF5 file", "h5py", "hdf5")

    def returned(self, control: str) -> tuple[str, ...]:
        """The quantities that a response has."""
        return tuple(name for name in self.columns if name != control)

    def read(self, content: Path | bytes, control: str, at: NDArray[np.float64]) -> Response | Failure:
        """What the output says at the control values `at` (T,), from a file or from what was printed: strains logarithmic, as fractions; stresses in Pa.

        Failures are of the kinds "no_output" (nothing is there), "unreadable", "not_finite" and "incomplete" (it does not reach as far as `at`).
        """
        name = "what it printed" if isinstance(content, bytes) else content.name
        if isinstance(content, bytes) and not content.strip():
            return Failure("no_output", "the program printed nothing, and its output was expected there.")
        if not isinstance(content, bytes) and not content.is_file():
            return Failure("no_output", f"the program wrote no file {self.file}.")
        if not isinstance(content, bytes) and not content.stat().st_size:
            return Failure("no_output", f"the program wrote the file {self.file}, and it is empty.")
        try:
            values = self._values(read_columns(content, name))
        except (Unreadable, InputError) as error:
            return Failure("unreadable", str(error))
        # Whatever a library makes of a file that is broken: it is one evaluation's trouble.
        except Exception as error:
            return Failure("unreadable", f"{name} cannot be read ({type(error).__name__}: {error}).")
        return self._met(values, control, at)

    def taken(self, columns: Columns, control: str, at: NDArray[np.float64]) -> Response | Failure:
        """As `read`, of columns wherever they are from. Raises Unreadable for what they do not hold."""
        return self._met(self._values(columns), control, at)

    def _values(self, columns: Columns) -> dict[str, NDArray[np.float64]]:
        """The quantities at the rows that are chosen, (T,) each."""
        values = {name: column.read(name, columns) for name, column in self.columns.items()}
        lengths = {name: len(each) for name, each in values.items()}
        if len(set(lengths.values())) > 1:
            raise Unreadable(
                f"the columns have different numbers of rows ({', '.join(f'{name} {length}' for name, length in lengths.items())}), and as many in each were expected."
            )
        chosen = self._chosen(columns, next(iter(lengths.values())))
        return {name: self._plain(name, each[chosen]) for name, each in values.items()}

    def _chosen(self, columns: Columns, length: int) -> NDArray[np.bool_]:
        chosen = np.arange(1, length + 1) >= (self.first_row or 1)
        if self.where is not None:
            holds = np.broadcast_to(np.asarray(evaluate(Expression(self.where), columns), dtype=bool), (length,)) if length else chosen
            chosen = chosen & holds
        if not chosen.any():
            said = [f"first_row = {self.first_row}"] * (self.first_row is not None) + [f"where = '{self.where}'"] * (self.where is not None)
            raise Unreadable(f"none of its {length} rows is chosen{' by ' if said else ''}{' and '.join(said)}.")
        return chosen

    def _plain(self, name: str, values: NDArray[np.float64]) -> NDArray[np.float64]:
        if Conventions({}, {}, self.strain, {}).is_engineering(name):
            if np.any(values >= 1):
                raise Unreadable(f"{name} is said to be an engineering strain and reaches {np.nanmax(values):g}, and less than 1 was expected.")
            values = -np.log1p(-values)
        # The sample as it is in the first row that is read is the one that strains count from.
        return values - values[0] if name in self.zero else values

    def _met(self, values: dict[str, NDArray[np.float64]], control: str, at: NDArray[np.float64]) -> Response | Failure:
        """The response at the control values that are asked for."""
        along = values[control]
        if not np.isfinite(along).all():
            known = int(np.argmin(np.isfinite(along)))
            if not known or np.max(along[:known]) < at[-1]:
                return Failure("not_finite", f"{control} is {along[known]} in row {1 + known} of those that are read, before it reaches {at[-1]:g}.")
            values, along = {name: each[:known] for name, each in values.items()}, along[:known]
        whole, kept = along, ~(turned_back(along) | repeated(along))
        details = {LEFT_OUT: float(np.count_nonzero(~kept))}
        along, values = along[kept], {name: each[kept] for name, each in values.items() if name != control}
        along = _with_rounded_ends(along, at)
        # It may cover the reference, by its first hundredth.
        if control in STRAINS and along[-1] > IMPOSSIBLE and along[-1] > at[-1] * PERCENT / 3:
            return Failure("unreadable", f"{control} reaches {along[-1]:g}, and the reference {at[-1]:g}{self._uncovered(along, at, control, whole)}.", details)
        if not covers(along, at):
            return Failure(
                "incomplete",
                f"the output covers {control} {span(along)}, and the reference goes from {at[0]:g} to {at[-1]:g}{self._uncovered(along, at, control, whole)}.",
                details,
            )
        # The states from the last before the reference to the first behind it.
        within = slice(max(0, int(np.searchsorted(along, at[0], side="right")) - 1), int(np.searchsorted(along, at[-1])) + 1)
        for name, each in values.items():
            finite = np.isfinite(each[within])
            if not finite.all():
                return Failure("not_finite", f"{name} is {each[within][np.argmin(finite)]} at {control} {along[within][np.argmin(finite)]:g}.", details)
        return interpolate(Response(along, values, details, control), at)

    def _uncovered(self, along: NDArray[np.float64], at: NDArray[np.float64], control: str, whole: NDArray[np.float64]) -> str:
        """What is most likely behind an output that does not cover the reference, as the end of a sentence; empty where nothing is. whole: the control with the rows that are left out."""
        if control in STRAINS and at[-1] * PERCENT / 3 < along[-1] < at[-1] * PERCENT * 3:
            return f': the program\'s strain may be in percent, and is then named with its unit, such as "{control} [%]", in output.columns'
        if control in STRAINS and along[-1] * PERCENT / 3 < at[-1] < along[-1] * PERCENT * 3:
            return ": the program's strain may be a fraction, and is taken as percent"
        left_out = len(whole) - len(along)
        if control in STRAINS and whole.min() < 0 and -whole.min() > whole.max():
            return f": it goes to {whole.min():.3g}, and shortening is positive here: sign = -1 of its column in output.columns turns it"
        if left_out > len(whole) / 2:
            return f": {left_out} of its {len(whole)} rows are left out, where {control} does not exceed that of an earlier row; where or first_row chooses the rows that are read"
        if along[0] > at[0] and along[-1] >= at[-1]:
            return ": it begins too late, and the program should write its first state too, before anything is strained"
        if along[-1] < at[-1] and along[0] <= at[0]:
            engineering = Conventions({}, {}, self.strain, {}).is_engineering(control)
            enough = control in STRAINS and not engineering and along[-1] < 1 and -np.log1p(-along[-1]) >= at[-1]
            return ": it ends too early" + (', unless its strain is engineering, which strain = "engineering" beside output.columns says' if enough else "")
        return ""


def _with_rounded_ends(along: NDArray[np.float64], at: NDArray[np.float64]) -> NDArray[np.float64]:
    """The control's values, the first and the last of which are those that are asked for where they miss these by no more than a table is rounded."""
    ends, near = along.copy(), ROUNDED * np.ptp(at)
    if 0 < along[0] - at[0] <= near:
        ends[0] = at[0]
    if 0 < at[-1] - along[-1] <= near:
        ends[-1] = at[-1]
    return ends
