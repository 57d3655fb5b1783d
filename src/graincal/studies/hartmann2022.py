"""The studies of Hartmann, Cheng, Thornton (2022), Computers and Geotechnics 141, 104491, by name and in the paper's order."""

from __future__ import annotations

from graincal.studies.proof import Proof
from graincal.studies.range_alpha import RangeAlpha
from graincal.studies.study import Study

TITLE = "The studies of Hartmann, Cheng, Thornton (2022), repeated with graincal"

STUDIES: dict[str, Study] = {study.name: study for study in (Proof(), RangeAlpha())}
