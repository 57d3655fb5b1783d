"""What was measured in a test, beside what is known of the test: what it takes to see that a reference is impossible."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.asked.experiment import Experiment
from graincal.data import Reference
from graincal.models import ConstantMeanStressTest, StressPathTest, TriaxialTest, UndrainedTest
from graincal.models.stress_path import STRAINS

OTHER = ""
"""The kind of a model that is no built-in test."""

AT_REST = 1e-5
"""Axial strain up to which a test has not begun."""

_SHEAR = (TriaxialTest.kind, ConstantMeanStressTest.kind, UndrainedTest.kind)


@dataclass(frozen=True, eq=False)
class Tested:
    """A reference and what is known of its test. kind: one of TESTS, or OTHER. pressure: the confining pressure, Pa; void_ratio: that of the packing; both None where they are not known."""

    reference: Reference
    kind: str = OTHER
    pressure: float | None = None
    void_ratio: float | None = None

    @classmethod
    def of(cls, experiment: Experiment) -> Tested:
        """That of an experiment of a calibration."""
        model = experiment.model
        if not isinstance(model, StressPathTest):
            return cls(experiment.reference)
        return cls(experiment.reference, model.kind, model.confining_pressure, model.first_packing.void_ratio)

    @property
    def control(self) -> NDArray[np.float64]:
        """The control's values, (T,)."""
        return self.reference.control

    @property
    def by_strain(self) -> bool:
        """Whether it is driven by axial strain, or extension."""
        return self.reference.control_name in STRAINS

    @property
    def extension(self) -> bool:
        return self.reference.control_name == "axial_extension"

    @property
    def shear(self) -> bool:
        """Whether it shears an isotropically compressed sample, as far as is known."""
        return self.by_strain and self.kind in (OTHER, *_SHEAR)

    @property
    def drained_shear(self) -> bool:
        return self.shear and self.kind != UndrainedTest.kind

    @property
    def undrained(self) -> bool:
        return self.kind == UndrainedTest.kind

    @property
    def from_rest(self) -> bool:
        """Whether the first row is the beginning of shear."""
        return self.by_strain and abs(self.control[0]) <= AT_REST

    def observable(self, name: str) -> NDArray[np.float64] | None:
        """Its values (T,), if it was measured, fitted or not."""
        return self.reference.measured.get(name)

    def at(self, row: int) -> str:
        """A row by its control, for a sentence."""
        return f"{self.reference.control_name} {self.control[row]:.4g}"
