"""The built-in models: a class for each stress path."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graincal import _native
from graincal.data import InputError
from graincal.dem import stress_path
from graincal.dem.stress_path_table import StressPathTable
from graincal.models.compression import CompressionTest
from graincal.models.proportion import ENGINE_PRESSURE, for_engine
from graincal.models.stress_path import STRAINS, Panel, StressPathTest, one_row
from graincal.positions import POSITION

WITHOUT_STRESSES = 0.5e6
"""Pa, at which the inertial number is meant where a path has no stress at all."""


class _AxialTest(StressPathTest):
    """A path that is driven by axial strain: `path(confining_pressure, axial_strains)` gives its stages."""

    controls = STRAINS
    path: ClassVar[staticmethod[[float, stress_path.Values], list[_native.Stage]]]

    def stages(self, confining_pressure: float, at: NDArray[np.float64]) -> list[_native.Stage]:
        """Consolidation, and a recorded state at each axial strain."""
        return self.path(confining_pressure, -at if self.control == "axial_extension" else at)


class TriaxialTest(_AxialTest):
    """A drained triaxial test: the lateral stresses are held at the confining pressure while the axial strain is imposed."""

    kind = "triaxial"
    title = "triaxial test"
    path = staticmethod(stress_path.drained_triaxial)


class ConstantMeanStressTest(_AxialTest):
    """A triaxial test at constant mean stress: the lateral stresses make up for the axial one, and p stays the confining pressure."""

    kind = "constant-mean-stress"
    title = "triaxial test at constant mean stress"
    path = staticmethod(stress_path.constant_mean_stress)


class UndrainedTest(_AxialTest):
    """An undrained triaxial test of a saturated sample, by its equivalent at constant volume: all stresses are effective ones.

    `excess_pore_pressure` is that of a test whose total lateral stress is held at the confining pressure: what the effective one has lost of it.
    """

    kind = "undrained"
    title = "undrained triaxial test"
    also_returned = ("lateral_stress", "excess_pore_pressure")
    held = ("volumetric_strain", "void_ratio")
    shown = (Panel("deviatoric_stress"), Panel("excess_pore_pressure"), Panel("deviatoric_stress", over="mean_stress"))
    path = staticmethod(stress_path.undrained_triaxial)

    def derived(self, c: Mapping[str, NDArray[np.float64]]) -> dict[str, NDArray[np.float64]]:
        """The columns of every path, and the excess pore pressure."""
        columns = super().derived(c)
        return columns | {"excess_pore_pressure": ENGINE_PRESSURE - columns["lateral_stress"]}


class OedometricTest(CompressionTest):
    """One-dimensional compression without lateral strain, to axial strains, to axial stresses, or along a cycle of them. K0 is lateral over axial stress."""

    kind = "oedometric"
    title = "oedometric test"
    stress = "axial_stress"
    controls = ("axial_strain", "axial_stress", POSITION)
    also_returned = ("axial_stress", "lateral_stress")
    shown = (Panel("axial_stress", over="axial_strain"), Panel("void_ratio", over="axial_stress", logarithmic=True))

    def stages(self, confining_pressure: float, at: NDArray[np.float64]) -> list[_native.Stage]:
        """Consolidation, and a recorded state at each axial strain or stress."""
        if self.control == "axial_strain":
            return stress_path.oedometric(confining_pressure, at)
        return stress_path.oedometric_to_stresses(confining_pressure, self.driving_stresses(confining_pressure, at))


class IsotropicTest(CompressionTest):
    """Isotropic compression to a list of pressures, up and down in the order given, or along a cycle of them."""

    kind = "isotropic"
    title = "isotropic test"
    held = ("stress_ratio",)
    stress = "mean_stress"
    controls = ("mean_stress", POSITION)
    shown = (Panel("void_ratio", over="mean_stress", logarithmic=True), Panel("coordination_number", over="mean_stress", logarithmic=True))

    def stages(self, confining_pressure: float, at: NDArray[np.float64]) -> list[_native.Stage]:
        """Consolidation, and a recorded state at each pressure."""
        return stress_path.isotropic(confining_pressure, self.driving_stresses(confining_pressure, at))


@dataclass(frozen=True, eq=False, repr=False)
class TableTest(StressPathTest):
    """A stress path of one's own: the stages of a table. Its states are those of the rows that are recorded, by the row's number.

    confining_pressure: Pa, of an isotropic consolidation before the table's first row; None for none.
    """

    confining_pressure: float | None = None  # type: ignore[assignment]  # the one test that may have none, which `optional` says
    table: StressPathTable = field(kw_only=True)

    kind = "table"
    title = "test along a table"
    controls = ("stage",)
    also_returned = ("strain_x", "strain_y", "strain_z", "stress_xx", "stress_yy", "stress_zz")
    optional = ("confining_pressure",)

    @property
    def unit_of_stress(self) -> float:
        """Pa: the confining pressure, or else the mean of the stresses in the first row of the table that has some; of a table without stresses that of the paper's test."""
        if self.confining_pressure is not None:
            return self.confining_pressure
        stresses = next((found for row in self.table.rows if (found := [goal.target for goal in row.goals if goal.stress])), [WITHOUT_STRESSES])
        return float(np.mean(stresses))

    def stages(self, confining_pressure: float, at: NDArray[np.float64]) -> list[_native.Stage]:
        """The table's stages, after consolidation if there is one."""
        consolidated = None if self.confining_pressure is None else confining_pressure
        return self.table.stages(consolidated, lambda stress: float(for_engine(stress, self.unit_of_stress)))

    def states(self, at: ArrayLike) -> NDArray[np.float64]:
        """All recorded stages, whichever are asked for. Raises InputError for one that is not among them."""
        recorded = np.array(self.table.recorded, dtype=np.float64)
        asked = one_row(at)
        if asked is None or not np.all(np.isin(asked, recorded)):
            raise InputError(f"{self.table.name}: stages must be one row of the numbers of recorded ones, {', '.join(map(str, self.table.recorded))}.")
        return recorded

    def derived(self, c: Mapping[str, NDArray[np.float64]]) -> dict[str, NDArray[np.float64]]:
        """The columns of every path, and the number of the stage."""
        return super().derived(c) | {"stage": np.array(self.table.recorded, dtype=np.float64)}


TESTS: dict[str, type[StressPathTest]] = {
    test.kind: test for test in (TriaxialTest, OedometricTest, IsotropicTest, UndrainedTest, ConstantMeanStressTest, TableTest)
}
"""The built-in tests by the names that files and the command line have for them."""
