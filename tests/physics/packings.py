"""Packings as YADE was given them, and the records of its first steps on them."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

PREPARED = Path(__file__).parents[1] / "data" / "yade"
"""Packings by `graincal pack` with YADE's steps and curves on them, by benchmarks/yade_curves.py."""

SOURCES = ("prepared", "published")
"""Where packings and records come from: the repository, or the folder of those of Hartmann, Cheng, Thornton (2022)."""


@dataclass(frozen=True)
class Steps:
    """YADE's steps on a packing: its positions (N, 3), radii (N,) and edges (3, 3), and name -> array of the record."""

    packing: tuple[np.ndarray, np.ndarray, np.ndarray]
    record: dict[str, np.ndarray]


def steps_of(request, prepared, published):
    """The steps of the source that a fixture was asked for, from the names (packing, record) that they have in either; the test is skipped where there is none."""
    folder, names = (PREPARED, prepared) if request.param == "prepared" else (request.getfixturevalue("reference_data"), published)
    with np.load(folder / names[1]) as file:
        return Steps(centres_as_they_stand(folder / names[0]), dict(file))


def centres_as_they_stand(path):
    """Positions (N, 3), radii (N,) and edges (3, 3) of a packing file, without wrapping centres into the cell: the record of YADE's steps depends on where
    the origin lies, and graincal's motion as YADE's does too."""
    lengths = [float(text) for text in path.read_text().splitlines()[0].split("cell lengths:")[1].split()]
    table = np.loadtxt(path, delimiter=",", skiprows=2)
    return np.ascontiguousarray(table[:, :3]), np.ascontiguousarray(table[:, 3]), np.diag(lengths)
