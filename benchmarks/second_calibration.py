"""A second calibration on a packing, from runs that were made before: how long it takes to settle, and whether its answer is as good as one from scratch.

    GRAINCAL_REFERENCE_DATA=... python benchmarks/second_calibration.py --runs DIR [--seed 11] [--folder DIR] [--scratch]

DIR holds a campaign of benchmarks/toyoura.py (Toyoura sand at 0.5 MPa on the paper's packing of 1,000 particles), or a library of `graincal explore` on that packing. Two calibrations learn from it: of the
same curve by another seed, and of a curve at 0.2 MPa, which is a run of the engine at known parameters on a sibling of the packing; a run at 0.5 MPa is one at 0.2 MPa with its modulus in proportion.
With --scratch the second one is made without them too. Printed are the runs known before, those made, wall time from the first to the last of these, the posterior's moments, and the errors of the runs at
the answer.
"""

from __future__ import annotations

import argparse
import os
from datetime import datetime
from pathlib import Path

import numpy as np
from toyoura import calibration

import graincal as gc
from graincal.campaign import Experiment
from graincal.campaign.asked.calibration import Calibration
from graincal.campaign.found.status import status
from graincal.campaign.run.running import begin_or_resume
from graincal.dem.siblings import siblings

TRUTH = {"log_E": 8.8, "nu": 0.15, "phi": 30.0, "beta_m": 0.1, "eta_m": 0.4}
PRESSURE = 0.2e6
STRAIN = np.arange(0.0, 0.1101, 0.005)
SIBLING = 101
"""The seed of the packing that the curve at 0.2 MPa is of."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=11)
    parser.add_argument("--folder", type=Path, default=Path("second"))
    parser.add_argument("--scratch", action="store_true")
    arguments = parser.parse_args()
    first, other = calibration(arguments.seed, "logarithmic"), at_other_pressure(arguments.seed)
    asked = {"0.5 MPa again": (first, [arguments.runs]), "0.2 MPa": (other, [arguments.runs])}
    if arguments.scratch:
        asked["0.2 MPa from scratch"] = (other, [])
    for name, (calibrated, runs) in asked.items():
        folder = arguments.folder / name.replace(" ", "-")
        show(name, begin_or_resume(folder, lambda calibrated=calibrated: calibrated, runs), folder)


def at_other_pressure(seed: int) -> Calibration:
    """Against a run at TRUTH and PRESSURE on a sibling of the packing."""
    packing = gc.Packing.read(Path(os.environ["GRAINCAL_REFERENCE_DATA"]) / "packing_1000.csv")
    (sibling,) = siblings(packing, 1, first_seed=SIBLING)
    curve = gc.TriaxialTest(sibling, PRESSURE).simulate([list(TRUTH.values())], at=STRAIN)[0]
    reference = gc.Reference(STRAIN, {name: curve.values[name] for name in ("stress_ratio", "volumetric_strain")}, simulated=True)
    return Calibration(gc.ParameterSpace.paper(), [Experiment("0.2 MPa", gc.TriaxialTest(packing, PRESSURE), reference)], seed=seed, truth=TRUTH)


def show(name: str, result: gc.Result, folder: Path) -> None:
    """One calibration in three lines."""
    said = status(folder)
    started, ended = (datetime.fromisoformat(said[key]) for key in ("started", "updated"))
    known = len(result.calibration.known) if result.calibration.known else 0
    print(
        f"{name}: {'settled' if said['settled'] else 'not settled'} after {result.evaluations} runs beside {known} known, {(ended - started).total_seconds():.0f} s"
    )
    print("   " + ", ".join(f"{name} {mean:.3f} ± {std:.3f}" for name, mean, std in zip(result.space.names, result.posterior.mean(), result.posterior.std())))
    print(
        "   answer " + ", ".join(f"{value:.3f}" for value in result.answer.theta) + f": ε {result.answer.mean:.2f} ± {result.answer.spread:.2f} %", flush=True
    )


if __name__ == "__main__":
    main()
