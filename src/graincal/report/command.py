"""The command line that simulates a calibrated sample again."""

from __future__ import annotations

import shlex
import tomllib

import numpy as np

from graincal.campaign import Experiment
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
    words += ["--axial-strain", f"{strain[-1]:.4g}", "--increment", f"{increment:.4g}"]
    words += ["--density-scaling", f"{test.density_scaling:.8g}", "-o", "curve.csv"]
    return shlex.join(words)


def pack_command(experiment: Experiment, source: str, output: str = PLACEHOLDER) -> str | None:
    """The line that makes the packing that a calibration file (its text, `source`) has prepared for an experiment; None for one from elsewhere."""
    entries = tomllib.loads(source).get("experiment", [])
    model = next((entry["model"] for entry in entries if entry["name"] == experiment.name), {})
    if "particles" not in model:
        return None
    words = ["graincal", "pack", "--particles", str(model["particles"]), "--void-ratio", f"{model['void_ratio']:.8g}"]
    words += ["--grading", model.get("grading", "toyoura"), "--seed", str(model.get("seed", 1)), "-o", output]
    return shlex.join(words)


def from_file(test: TriaxialTest) -> bool:
    """Whether the test's packing was read from a file, whose path is then its name."""
    return test.packing.name.endswith(".csv")
