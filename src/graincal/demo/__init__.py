"""A whole calibration on an embedded default: what `graincal demo` runs."""

from __future__ import annotations

from importlib.resources import as_file, files
from typing import Literal

import numpy as np

from graincal.campaign import Experiment
from graincal.campaign.asked.calibration import Calibration
from graincal.data import Failure, ParameterSpace, Reference, Response
from graincal.dem.packing import Packing
from graincal.inference import Stop
from graincal.models import TriaxialTest

TRUTH = {"log_E": 8.6, "nu": 0.25, "phi": 32.0, "beta_m": 0.15, "eta_m": 0.35}
CONFINING_PRESSURE = 0.5e6
MEASUREMENT_ERRORS = {"stress_ratio": 0.01, "volumetric_strain": 1e-4}
"""Standard deviations of good devices. None is added to the reference: that runs scatter is error enough, and the calibration learns by how much."""
AXIAL_STRAIN = np.arange(0.0, 0.0501, 0.002)
FIRST_BATCH = 100
REFERENCE_DENSITY_SCALING = 1.5e3
"""The reference is a run of its own: another density scaling takes other time steps, and no sample can repeat it grain for grain."""


def packing() -> Packing:
    """The embedded packing: 500 particles of the Toyoura grading at a void ratio of 0.68, by `graincal pack --seed 1` of an earlier build (tests/data/SOURCES.md)."""
    return _embedded("packing_500.csv")


def sibling() -> Packing:
    """Another packing of as many grains of the same sizes at the same void ratio, by `graincal.dem.siblings` with the seed 101: what the reference is simulated on, as no sand is the packing that it is
    calibrated with."""
    return _embedded("packing_500_sibling.csv")


def reference(grains: Packing) -> Reference:
    """The synthetic reference: the response at TRUTH on a packing."""
    test = TriaxialTest(grains, CONFINING_PRESSURE, density_scaling=REFERENCE_DENSITY_SCALING)
    response = _answered(test.simulate([list(TRUTH.values())], at=AXIAL_STRAIN)[0])
    names = ("stress_ratio", "volumetric_strain")
    return Reference(AXIAL_STRAIN, {name: response.values[name] for name in names}, measurement_errors=MEASUREMENT_ERRORS, simulated=True)


def first_curve(grains: Packing) -> Response:
    """The response in the middle of the ranges: what one knows before calibrating."""
    space = ParameterSpace.paper()
    return _answered(TriaxialTest(grains, CONFINING_PRESSURE).simulate([0.5 * (space.low + space.high)], at=AXIAL_STRAIN)[0])


def calibration(grains: Packing, measured: Reference, *, workers: int | Literal["all"] = "all", seed: int = 1) -> Calibration:
    """All five parameters over the paper's ranges, by the defaults but for fewer runs that fill the ranges: to be settled within two minutes."""
    return Calibration(
        ParameterSpace.paper(),
        [Experiment("demo", TriaxialTest(grains, CONFINING_PRESSURE), measured)],
        filter_options={"first_batch": FIRST_BATCH},
        stop=Stop(max_evaluations=600),
        seed=seed,
        workers=workers,
        truth=TRUTH,
    )


def _embedded(name: str) -> Packing:
    with as_file(files(__name__) / name) as path:
        return Packing.read(path)


def _answered(outcome: Response | Failure) -> Response:
    if isinstance(outcome, Failure):
        raise RuntimeError(f"the demo's simulation failed: {outcome.reason}")
    return outcome
