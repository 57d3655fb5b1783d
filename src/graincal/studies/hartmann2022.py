"""The studies of Hartmann, Cheng, Thornton (2022), Computers and Geotechnics 141, 104491, by name and in the paper's order."""

from __future__ import annotations

from graincal.studies.errors import Errors
from graincal.studies.fabric import Fabric
from graincal.studies.monte_carlo import MonteCarlo
from graincal.studies.particles import Particles
from graincal.studies.pressures import Pressures
from graincal.studies.proof import Proof
from graincal.studies.range_alpha import RangeAlpha
from graincal.studies.solutions import Solutions
from graincal.studies.stress_only import StressOnly
from graincal.studies.study import Study
from graincal.studies.times import Times

TITLE = "The studies of Hartmann, Cheng, Thornton (2022), repeated with graincal"

STUDIES: dict[str, Study] = {
    study.name: study for study in (MonteCarlo(), Particles(), Solutions(), Proof(), RangeAlpha(), Pressures(), Fabric(), Times(), Errors(), StressOnly())
}
