"""Packings: spheres in a periodic cell."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from graincal import _native
from graincal.data import InputError
from graincal.files import check_name, unreadable

LARGEST_OVERLAP = 0.01
"""Overlaps above this share of the smaller radius are no packing at rest, but a mistake in the file."""

SHORTEST, LONGEST = 1e-9, 1e9
"""Metres. Other radii and cell lengths are a mistake too. Volumes, and all else that is computed from these, stay within what numbers hold."""

FURTHEST = 1e6
"""Cells. A centre further away is a mistake too: wrapped, it would have lost digits that tell whom it touches."""

# What a comment says of the cell, and the numbers that follow; a matrix may stand in brackets, or go on in comments of nothing but numbers.
_NUMBER = r"[-+]?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|inf|nan)(?=[\s,;\[\]()]|$)"
_NUMBERS = rf"(?:[ \t,\[\]()]*{_NUMBER})"
_CELL = re.compile(rf"(cell\b(?:(?!cell\b)[^:;\n])*):({_NUMBERS}*(?:[ \t,\[\]()]*\n#{_NUMBERS}+(?=[ \t,\[\]()]*(?:\n|$)))*)")

_HEADER = ["x", "y", "z", "radius"]


@dataclass(frozen=True, eq=False, repr=False)
class Packing:
    """Spheres in a periodic cell: `positions` (N, 3) and `radii` (N,) in metres, `edges` (3, 3) whose columns are the cell's edge vectors along x, y and z.

    Centres outside the cell are wrapped into it. Raises InputError where the figures cannot be a packing.
    """

    positions: NDArray[np.float64]
    radii: NDArray[np.float64]
    edges: NDArray[np.float64]
    name: str = "packing"

    def __post_init__(self) -> None:
        positions = np.ascontiguousarray(self.positions, dtype=np.float64)
        radii = np.ascontiguousarray(self.radii, dtype=np.float64)
        edges = np.ascontiguousarray(self.edges, dtype=np.float64)
        if positions.ndim != 2 or positions.shape[1] != 3 or radii.shape != positions.shape[:1] or len(radii) < 2:
            raise InputError(f"{self.name}: positions must be (N, 3) and radii (N,) for at least two particles, not {positions.shape} and {radii.shape}.")
        if not (np.all(np.isfinite(positions)) and np.all(np.isfinite(radii)) and np.all(np.isfinite(edges))):
            raise InputError(f"{self.name}: positions, radii and cell lengths must be finite numbers.")
        if not np.all(radii > 0):
            raise InputError(f"{self.name}: the radius of particle {1 + int(np.argmin(radii > 0))} must be positive.")
        self._check_cell(edges, radii)
        positions = self._wrapped(positions, edges)
        for name, array in {"positions": positions, "radii": radii, "edges": edges}.items():
            array = array.copy()
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        self._check_overlaps()

    def __repr__(self) -> str:
        return f"Packing({self.count} particles, void ratio {self.void_ratio:.3f}, {self.name})"

    def _repr_html_(self) -> str:
        """What a notebook shows: a table of particles, void ratio, cell and diameters."""
        from graincal.notebook import packing_as_html

        return packing_as_html(self)

    def _check_cell(self, edges: NDArray[np.float64], radii: NDArray[np.float64]) -> None:
        # Stress paths drive the axes, and a cell that leans would be driven along others.
        if edges.shape != (3, 3) or np.any(edges != np.diag(np.diag(edges))) or not np.all(np.diag(edges) > 0):
            raise InputError(f"{self.name}: the cell's edges must lie along x, y and z, and a diagonal matrix of three positive lengths was expected.")
        lengths = np.diag(edges)
        for what, given in {"the radius of particle": radii, "cell length": lengths}.items():
            possible = (SHORTEST <= given) & (given <= LONGEST)
            if not np.all(possible):
                wrong = int(np.argmin(possible))
                raise InputError(f"{self.name}: {what} {wrong + 1} is {given[wrong]:.3g} m, and a length from 1e-9 to 1e9 m was expected.")
        if lengths.min() < 5 * radii.max():
            raise InputError(
                f"{self.name}: the cell is only {lengths.min():.3g} m wide, and must be at least 2.5 times the largest diameter of {2 * radii.max():.3g} m."
            )

    def _wrapped(self, positions: NDArray[np.float64], edges: NDArray[np.float64]) -> NDArray[np.float64]:
        with np.errstate(over="ignore", invalid="ignore"):
            fractional = np.linalg.solve(edges, positions.T).T
        near = np.all(np.abs(fractional) < FURTHEST, axis=1)
        if not np.all(near):
            wrong = int(np.argmin(near))
            centre = ", ".join(f"{coordinate:.3g}" for coordinate in positions[wrong])
            raise InputError(
                f"{self.name}: the centre of particle {wrong + 1} at {centre} m is more than a million cells away, and coordinates in metres in or near the cell were expected."
            )
        outside = np.any((fractional < 0) | (fractional >= 1), axis=1)
        return np.where(outside[:, None], (fractional - np.floor(fractional)) @ edges.T, positions)

    def _check_overlaps(self) -> None:
        # Coincident centres have no direction between them, and no simulation survives that.
        _, first, copies = np.unique(self.positions, axis=0, return_index=True, return_counts=True)
        if np.any(copies > 1):
            same = np.flatnonzero(np.all(self.positions == self.positions[first[np.argmax(copies > 1)]], axis=1)) + 1
            raise InputError(
                f"{self.name}: particles {same[0]} and {same[1]} overlap completely, and at most {LARGEST_OVERLAP:.0%} of the smaller radius is allowed."
            )
        # The engine's own neighbour search; one force pass on springs of any stiffness tells who touches.
        probe = self._simulation(_native.LinearLaw(1.0, 0.0, 0.0, 0.0, 0.0), density=1.0)
        probe.run_prescribed(1, np.zeros((3, 3)), 1e-12, 0.0)
        contacts = probe.contacts()
        smaller = np.minimum(self.radii[contacts["first"]], self.radii[contacts["second"]])
        shares = contacts["overlap"] / smaller
        if shares.size and shares.max() > LARGEST_OVERLAP:
            worst = int(np.argmax(shares))
            first, second = contacts["first"][worst] + 1, contacts["second"][worst] + 1
            raise InputError(
                f"{self.name}: particles {first} and {second} overlap by {shares[worst]:.1%} of the smaller radius, and at most {LARGEST_OVERLAP:.0%} is allowed."
            )

    def _simulation(self, law: _native.LinearLaw, density: float) -> _native.Simulation:
        return _native.Simulation(self.positions, self.radii, self.edges, law, density)

    @property
    def count(self) -> int:
        """The number of particles N."""
        return len(self.radii)

    @property
    def volume(self) -> float:
        """The cell's volume, m^3."""
        return float(np.linalg.det(self.edges))

    @property
    def solid_volume(self) -> float:
        """The spheres' volume, m^3; overlaps are not subtracted."""
        return float(4 / 3 * np.pi * np.sum(self.radii**3))

    @property
    def void_ratio(self) -> float:
        """Volume of voids over volume of solids."""
        return self.volume / self.solid_volume - 1

    @classmethod
    def read(cls, path: str | Path) -> Packing:
        """Read `x,y,z,radius` in metres, after a comment line `# ... cell lengths: Lx Ly Lz`."""
        check_name(path, "a packing file")
        path = Path(path)
        try:
            lines = path.read_text(encoding="utf-8-sig").splitlines()
        except OSError as error:
            raise InputError(unreadable(path, error, "a packing file")) from None
        except UnicodeDecodeError:
            raise InputError(f"{path}: a packing must be a text file with the columns x,y,z,radius.") from None
        # Comments alone, each in a line of its own still: only those that stand together belong together.
        comments = "\n".join(line if line.startswith("#") else "" for line in lines)
        rows = [(number, line) for number, line in enumerate(lines, 1) if line.strip() and not line.startswith("#")]
        cells = [(match[1], re.findall(_NUMBER, match[2])) for match in _CELL.finditer(comments)]
        lengths = next((numbers for name, numbers in cells if name.endswith("cell lengths") and len(numbers) >= 3), [])[:3]
        names = [name.strip() for name in re.split("[,;\t]", rows[0][1])] if rows else []
        if names != _HEADER and (known := _measured(names)):
            raise InputError(f"{path}: this looks like a laboratory file (column '{known[0]}'), and a packing with the header 'x,y,z,radius' was expected.")
        for name, numbers in cells:
            # A matrix, or the upper triangle of one; other numbers after three lengths are said of something else.
            if len(numbers) in (6, 9):
                raise InputError(
                    f"{path}: the comment '{name}:' gives {len(numbers)} numbers, and the three lengths Lx Ly Lz of a cell with edges along x, y and z were expected."
                )
        if not lengths:
            raise InputError(f"{path}: a comment line with 'cell lengths: Lx Ly Lz' in metres is needed before the particles.")
        if not all(length > 0 for length in map(float, lengths)):
            raise InputError(f"{path}: the cell lengths must be positive, not {' '.join(lengths)}.")
        if names != _HEADER or "," not in rows[0][1]:
            raise InputError(f"{path}: the header must be 'x,y,z,radius'.")
        values = []
        for number, line in rows[1:]:
            try:
                row = [float(text) for text in line.split(",")]
            except ValueError:
                row = []
            if len(row) != 4:
                raise InputError(f"{path}: line {number} must hold four numbers x,y,z,radius.")
            values.append(row)
        table = np.array(values).reshape(-1, 4)
        return cls(table[:, :3], table[:, 3], np.diag([float(length) for length in lengths]), name=str(path))

    def write(self, path: str | Path, comment: str = "periodic packing, metres") -> None:
        """Write what `read` reads, with every digit."""
        lengths = " ".join(repr(float(length)) for length in np.diag(self.edges))
        rows = [",".join(repr(float(value)) for value in (*position, radius)) for position, radius in zip(self.positions, self.radii)]
        Path(path).write_text("\n".join([f"# {comment}; cell lengths: {lengths}", "x,y,z,radius", *rows]) + "\n", encoding="utf-8")


def _measured(names: list[str]) -> list[str]:
    """Those of a header's names that laboratories have for what they measure."""
    from graincal.laboratory.vocabulary import guess

    return [name for name in names if guess(name)[0]]
