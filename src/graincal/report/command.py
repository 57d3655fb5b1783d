"""The command line that simulates a calibrated sample again."""

from __future__ import annotations

import shlex

import numpy as np

from graincal.data import Reference, Samples
from graincal.models import TriaxialTest
from graincal.models.triaxial import PARAMETERS

PLACEHOLDER = "packing.csv"
"""Stands for the file of a packing that was not read from one."""


def simulate_command(test: TriaxialTest, samples: Samples, reference: Reference) -> str:
    """The line for one sample of a triaxial test, over the strains of a reference, in steps as wide as the reference's."""
    theta = dict(zip(PARAMETERS, test.arrange(samples)[0]))
    strain = reference.control
    increment = np.median(np.diff(strain, prepend=0.0 if strain[0] > 0 else strain[:0]))
    words = ["graincal", "simulate", "triaxial", "--packing", test.packing.name if from_file(test) else PLACEHOLDER]
    words += ["--confining-pressure", f"{test.confining_pressure:.8g}"]
    for name, value in theta.items():
        words += ["-p", f"{name}={value:.8g}"]
    if test.law != "linear":
        words += ["--law", test.law]
    words += ["--axial-strain", f"{strain[-1]:.4g}", "--increment", f"{increment:.4g}"]
    words += ["--density-scaling", f"{test.density_scaling:.8g}", "-o", "curve.csv"]
    return shlex.join(words)


def from_file(test: TriaxialTest) -> bool:
    """Whether the test's packing was read from a file, whose path is then its name."""
    return test.packing.name.endswith(".csv")
