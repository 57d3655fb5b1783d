"""Gradings: how a soil's mass is shared among grain sizes."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from graincal.data import InputError
from graincal.files import check_name, unreadable
from graincal.suggestion import did_you_mean


@dataclass(frozen=True, eq=False)
class Grading:
    """A grading curve: diameters `sizes` (K,) in metres and the percentage of mass `passing` (K,) each, both increasing.

    What passes the smallest size is left out; the rest is scaled to the whole. Between two sizes the curve is a straight line.
    """

    sizes: NDArray[np.float64]
    passing: NDArray[np.float64]
    name: str = "grading"
    enlarged: float = 1.0
    """About how many times larger than in the soil itself the sizes are."""

    def __post_init__(self) -> None:
        sizes = np.array(self.sizes, dtype=np.float64)
        passing = np.array(self.passing, dtype=np.float64)
        if sizes.ndim != 1 or sizes.shape != passing.shape or len(sizes) < 2:
            raise InputError(f"{self.name}: a grading needs at least two sizes, each with its percentage passing.")
        if not (np.all(np.isfinite(sizes)) and np.all(sizes > 0) and np.all(np.diff(sizes) > 0)):
            raise InputError(f"{self.name}: sizes must be positive and increase from row to row.")
        if not (np.all(np.diff(passing) >= 0) and passing[0] >= 0 and passing[-1] > passing[0] and abs(passing[-1] - 100) < 1e-9):
            raise InputError(f"{self.name}: percentages passing must increase from row to row and end at 100.")
        object.__setattr__(self, "sizes", sizes)
        object.__setattr__(self, "passing", passing)

    @classmethod
    def named(cls, name: str | Path) -> Grading:
        """A grading known by its name ("toyoura"), of a median size in mm and a coefficient of uniformity ("d50=0.14,Cu=1.5"), or read from a file with the columns
        `size [mm],passing [%]`. Raises InputError for what is none of these.
        """
        if str(name) in _KNOWN:
            return _KNOWN[str(name)]
        if "=" not in str(name) or Path(name).exists():
            return cls.read(name)
        said = _D50_CU.match(str(name))
        try:
            d50, uniformity = map(float, said.groups() if said else ())
        except ValueError:
            raise InputError(f"the grading {str(name)!r}: d50 in mm and Cu = d60/d10, with decimal points, such as d50=0.14,Cu=1.5, were expected.") from None
        return cls.of_d50(1e-3 * d50, uniformity)

    @classmethod
    def of_d50(cls, d50: float, uniformity: float) -> Grading:
        """The grading that is straight over the logarithm of the size, with half of the mass below the diameter d50 in metres and the coefficient of uniformity
        Cu = d60/d10: d = d50 Cu^((passing - 50 %) / 50 %), from d50/Cu to d50 Cu. Raises InputError where d50 is not above 0 or Cu not above 1.
        """
        if not (0 < d50 < np.inf and 1 < uniformity < np.inf):
            raise InputError(
                f"a grading of d50 = {1e3 * d50:g} mm and Cu = {uniformity:g}: a size above 0 and a coefficient of uniformity above 1 were expected."
            )
        passing = np.linspace(0, 100, _STEPS + 1)
        return cls(d50 * uniformity ** (passing / 50 - 1), passing, name=f"d50={1e3 * d50:g},Cu={uniformity:g}")

    @classmethod
    def read(cls, path: str | Path) -> Grading:
        check_name(path, "a grading")
        path = Path(path)
        wanted = ["size [mm]", "passing [%]"]
        try:
            with path.open(newline="", encoding="utf-8-sig") as file:
                rows = [[cell.strip() for cell in row] for row in csv.reader(file) if any(row) and not row[0].startswith("#")]
        except OSError as error:
            expected = f"a grading, {', '.join(map(repr, _KNOWN))}, d50=SIZE,Cu=NUMBER or a CSV file with the columns {', '.join(wanted)},"
            raise InputError(unreadable(f"{path}{did_you_mean(str(path), _KNOWN)}", error, expected)) from None
        except (UnicodeDecodeError, csv.Error):
            raise InputError(f"{path}: a grading must be a text file with the columns {', '.join(wanted)}.") from None
        if not rows or rows[0] != wanted:
            raise InputError(f"{path}: the header must be '{','.join(wanted)}'.")
        try:
            table = np.array([(float(size), float(passing)) for size, passing in rows[1:]]).reshape(-1, 2)
        except ValueError:
            raise InputError(f"{path}: every row below the header must hold two numbers, a size and a percentage.") from None
        return cls(table[:, 0] * 1e-3, table[:, 1], name=str(path))

    def diameters(self, count: int, generator: np.random.Generator) -> NDArray[np.float64]:
        """`count` diameters in metres, in random order. One from each of as many equal shares of the number curve, so that few grains follow the
        grading closely."""
        share = np.diff(self.passing) / (self.passing[-1] - self.passing[0])
        lower, upper = self.sizes[:-1], self.sizes[1:]
        # Mass even over diameter between two sizes: number density falls with the cube, its integral with the square.
        number = share / (upper - lower) * 0.5 * (lower**-2 - upper**-2)
        cumulative = np.concatenate([[0.0], np.cumsum(number)]) / number.sum()
        quantile = (np.arange(count) + generator.random(count)) / count
        bin_index = np.clip(np.searchsorted(cumulative, quantile, side="right") - 1, 0, len(lower) - 1)
        within = (quantile - cumulative[bin_index]) / (cumulative[bin_index + 1] - cumulative[bin_index])
        a, b = lower[bin_index] ** -2, upper[bin_index] ** -2
        return generator.permutation((a - within * (a - b)) ** -0.5)

    @property
    def identity(self) -> list[list[float]]:
        """What two gradings that give the same grains have in common."""
        return [self.sizes.tolist(), self.passing.tolist()]


@dataclass(frozen=True, eq=False)
class GrainSizes:
    """The sizes of a packing's own grains, as a grading: `found` (N,), diameters in metres."""

    found: NDArray[np.float64]
    name: str = "of the packing"

    def diameters(self, count: int, generator: np.random.Generator) -> NDArray[np.float64]:
        """`count` diameters in metres, in random order: those found, or for another count one from each of as many equal shares of them."""
        if count == len(self.found):
            return generator.permutation(self.found)
        shares = (np.arange(count) + generator.random(count)) / count
        return generator.permutation(np.sort(self.found)[(shares * len(self.found)).astype(np.intp)])

    @property
    def identity(self) -> list[list[float]]:
        """As that of a `Grading`."""
        return [np.sort(self.found).tolist()]


_D50_CU = re.compile(r"\s*d50\s*=\s*([\d.eE+-]*)\s*(?:mm)?\s*[,;]?\s*Cu\s*=\s*(\S*)\s*$", re.IGNORECASE)

_STEPS = 50
"""Straight pieces of a curve that is straight over the logarithm of the size."""

_KNOWN = {
    # Toyoura sand, Hartmann, Cheng, Thornton (2022), enlarged as their packing of 1000 particles is: only ratios of sizes matter to the contact law. Half of
    # the mass passes 6.3 mm here, and about 0.2 mm in the sand.
    "toyoura": Grading(
        np.array([5.75, 6.85, 8.16, 9.69, 11.50, 13.69, 16.26]) / 1.685 * 1e-3,
        np.array([1.3, 2.1, 5.8, 17.4, 81.1, 92.7, 100.0]),
        name="toyoura",
        enlarged=30.0,
    ),
}
