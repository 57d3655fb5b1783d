"""A contact law with its five parameters, and what it comes to for two spheres, as other programs want to know it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from graincal.models.economy import DENSITY
from graincal.notation.printable import printable


class Pair(NamedTuple):
    """Two touching spheres by the linear law (docs/contact-laws.md): stiffnesses kn and ks, N/m, km of bending and twisting, N m, and the arm of the largest moment: it is that times the normal force, m."""

    normal: float
    shear: float
    rolling: float
    arm: float


@dataclass(frozen=True, eq=False)
class Contact:
    """A contact law by its name, values of its five parameters by their names, and the radii (N,) of the spheres it is for, m. source: where the values come from, in a sentence."""

    law: str
    values: Mapping[str, float]
    radii: NDArray[np.float64]
    source: str

    @property
    def modulus(self) -> float:
        """Pa: of the contact with the linear law, of the grains with Hertz-Mindlin."""
        return float(10.0 ** self.values["log_E"])

    @property
    def friction(self) -> float:
        """The coefficient of friction, tan of the angle."""
        return float(np.tan(np.radians(self.values["phi"])))

    @property
    def rolls(self) -> bool:
        """Whether there is any resistance to rolling and twisting."""
        return self.values["nu"] > 0 and self.values["beta_m"] > 0 and self.values["eta_m"] > 0

    @property
    def density(self) -> float:
        """Of the grains, kg/m^3, without scaling."""
        return DENSITY

    def pair(self, first: float, second: float) -> Pair:
        """Two spheres of these radii, m, by the linear law."""
        normal = 2 * self.modulus * first * second / (first + second)
        shear = self.values["nu"] * normal
        return Pair(normal, shear, self.values["beta_m"] * first * second * shear, self.values["eta_m"] * min(first, second))

    def heading(self, mark: str) -> list[str]:
        """The first lines of any program, behind its mark of a comment: what these lines are and where they come from."""
        given = ", ".join(f"{name} = {value!r}" for name, value in self.values.items())
        said = [f"Contact parameters from graincal: {self.source}", f"Contact law {self.law}: {given}"]
        # A comment ends with its line, whatever the names in it are, and some programs read no other characters.
        return [f"{mark} {printable(line, None)}".encode("ascii", "backslashreplace").decode("ascii") for line in said]
