"""What is to be read from a file: figures in Pa and fractions, and how far the printed digits leave them open."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from .curves import Array


@dataclass(frozen=True)
class Figures:
    """Of one quantity, over the states. What is None is not compared."""

    first: float | None
    last: float | None
    least: float | None
    most: float | None
    within: float

    @classmethod
    def of(cls, values: Array, within: float) -> Figures:
        return cls(float(values[0]), float(values[-1]), float(np.min(values)), float(np.max(values)), within)

    def differences(self, name: str, found: Mapping[str, float]) -> list[str]:
        expected = {"first": self.first, "last": self.last, "min": self.least, "max": self.most}
        return [
            f"{name}: {which} is {found.get(which)}, not {value:.6g} within {self.within:.1g}"
            for which, value in expected.items()
            if value is not None and not _near(found.get(which), value, self.within)
        ]


def _near(found: float | None, value: float, within: float) -> bool:
    return isinstance(found, int | float) and abs(found - value) <= within


@dataclass(frozen=True)
class Expectation:
    """`required`: the observables that must be there; `known`: others, compared where they are there."""

    kind: str
    states: int | None
    confining_pressure: float | None
    control: tuple[str, ...]
    required: Mapping[str, Figures]
    known: Mapping[str, Figures]
    control_figures: Figures | None = None
