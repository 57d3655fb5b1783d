"""The command line that simulates a calibrated sample again."""

from __future__ import annotations

import os
import shlex
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graincal.campaign import Experiment
from graincal.campaign.found.record import Record
from graincal.data import Reference, Samples
from graincal.models import Model, StressPathTest, TableTest, TriaxialTest
from graincal.models.compression import CompressionTest
from graincal.models.contact_laws import DEFAULT_LAW
from graincal.models.stress_path import STRAINS
from graincal.notation.toml import read_toml
from graincal.positions import POSITION, positions

PLACEHOLDER = "packing.csv"
"""Stands for the file of a packing that was not read from one."""


def simulate_command(test: StressPathTest, samples: Samples, reference: Reference, at: str = "", output: str = "curve.csv") -> str:
    """The line for one sample of a built-in test: over the strains of a reference in steps as wide as the reference's, or to its stresses. at: the
    calibration file whose reference it is compared with, at that one's own strains. output: where the curve goes."""
    theta = dict(zip(test.parameters, test.arrange(samples)[0]))
    words = ["graincal", "simulate", test.kind, "--packing", _from_anywhere(test.first_packing.name) if from_file(test) else PLACEHOLDER]
    if test.confining_pressure is not None:
        words += ["--confining-pressure", f"{test.confining_pressure:.8g}"]
    for name, value in theta.items():
        words += ["-p", f"{name}={value:.8g}"]
    if test.law != DEFAULT_LAW:
        words += ["--law", test.law]
    densities = {name: value for name in ("density_scaling", "inertial_number") if (value := getattr(test, name)) is not None}
    for name, value in (densities | test.economies).items():
        words += [f"--{name.replace('_', '-')}", value if isinstance(value, str) else f"{value:.8g}"]
    words += ["--at", at] if at else _path(test, reference.control)
    if test.rest_every is not None:
        words += ["--rest-every", f"{test.rest_every:.8g}"]
    words += ["-o", output]
    return shlex.join(words)


def pack_command(experiment: Experiment, source: str, output: str = PLACEHOLDER) -> str | None:
    """The line that makes the packing that a calibration file (its text, `source`) has prepared for an experiment; None for one from elsewhere."""
    entries = read_toml(source).get("experiment", [])
    model: dict[str, Any] = next((entry["model"] for entry in entries if entry["name"] == experiment.name), {})
    if "particles" not in model:
        return None
    words = ["graincal", "pack", "--particles", str(model["particles"]), "--void-ratio", f"{model['void_ratio']:.8g}"]
    words += ["--grading", model.get("grading", "toyoura"), "--seed", str(model.get("seed", 1)), "-o", output]
    return shlex.join(words)


def _path(test: StressPathTest, control: NDArray[np.float64]) -> list[str]:
    if isinstance(test, TableTest):
        return ["--table", _from_anywhere(test.table.name)]
    if test.control in STRAINS:
        increment = np.median(np.diff(control, prepend=0.0 if control[0] > 0 else control[:0]))
        last = -control[-1] if test.control == "axial_extension" else control[-1]
        return ["--axial-strain", f"{last:.4g}", "--increment", f"{increment:.4g}"]
    name, stresses, _ = test.abscissa(_with_turns(test, control))
    option = {"axial_stress": "--axial-stress", "mean_stress": "--pressure"}[name]
    return [word for stress in stresses for word in (option, f"{stress:.8g}")]


def _with_turns(test: StressPathTest, control: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rows of a path with those at which it turns around, which it is not told otherwise."""
    if not isinstance(test, CompressionTest) or test.control != POSITION:
        return control
    turned = positions(test.turns_in_units, 1.0)
    rows = np.union1d(control, turned[turned < control[-1]])
    # The row of a turn is the turn, and the path begins where it does.
    apart = np.all(np.abs(rows[:, None] - np.append(0.0, turned)) > 1e-6, axis=1) | np.isin(rows, turned)
    return rows[apart]


def comparison(result: Record, experiment: Experiment) -> str:
    """The calibration file that --at finds the reference of an experiment in, which is then the only one that it may mean; empty where there is none."""

    compared = experiment.model
    if not isinstance(compared, TriaxialTest) or experiment.reference.control_name != "axial_strain":
        return ""
    pressure = compared.confining_pressure

    def may_be_meant(model: Model) -> bool:
        return not isinstance(model, StressPathTest) or (isinstance(model, TriaxialTest) and bool(np.isclose(model.confining_pressure, pressure)))

    alone = sum(may_be_meant(each.model) for each in result.experiments) == 1
    return result.calibration.file if alone else ""


def _from_anywhere(name: str) -> str:
    """The path of a file from the root, where it is there."""
    return os.path.abspath(name) if os.path.exists(name) else name


def from_file(test: StressPathTest) -> bool:
    """Whether the test's packing was read from a file, whose path is then its name."""
    return test.first_packing.name.endswith(".csv")
