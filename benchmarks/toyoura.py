"""The measured test by defaults alone: whether calibrations settle by themselves, agree with one another, and fit.

    GRAINCAL_REFERENCE_DATA=... python benchmarks/toyoura.py [--seeds 1 2 3] [--strain logarithmic] [--folder DIR]

Toyoura sand at 0.5 MPa, its strains as printed, all 33 points, on the paper's packing of 1,000 particles; five parameters over the paper's ranges, no measurement error stated. Each seed is
a calibration in DIR/SEED, which is gone on with where it was broken off. Printed are the evaluations, the wall time from the first to the last of them, the posterior's moments, and the errors
of the runs at the answer; and how far posteriors are apart: means in parts of the smaller standard deviation, and the largest ratio of two standard deviations.
"""

from __future__ import annotations

import argparse
import itertools
import os
import time
from datetime import datetime
from pathlib import Path

import numpy as np

import graincal as gc
from graincal.campaign import begin, resume
from graincal.campaign.asked.calibration import Calibration
from graincal.campaign.found.status import status
from graincal.campaign.stored.store import holds_campaign


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3])
    parser.add_argument("--strain", choices=("logarithmic", "engineering"), default="logarithmic")
    parser.add_argument("--folder", type=Path, default=Path("toyoura"))
    arguments = parser.parse_args()
    posteriors, errors = [], []
    for seed in arguments.seeds:
        folder = arguments.folder / str(seed)
        start = time.perf_counter()
        result = resume(folder) if folder.exists() and holds_campaign(folder) else begin(calibration(seed, arguments.strain), folder)
        show(seed, folder, result, time.perf_counter() - start)
        posteriors.append(result.posterior)
        errors.append(result.answer.errors)
    compare(posteriors)
    print(f"all runs at the answers: ε {np.mean(np.concatenate(errors)):.2f} %")


def calibration(seed: int, strain: str) -> Calibration:
    """By defaults alone."""
    data = Path(os.environ["GRAINCAL_REFERENCE_DATA"])
    reference = gc.Reference.read(data / "toyoura_0.5MPa.csv", strain=strain)
    test = gc.TriaxialTest(gc.Packing.read(data / "packing_1000.csv"), 0.5e6)
    return Calibration(gc.ParameterSpace.paper(), [gc.Experiment("Toyoura, 0.5 MPa", test, reference)], seed=seed)


def show(seed: int, folder: Path, result: gc.Result, seconds: float) -> None:
    """One calibration in three lines."""
    said = status(folder)
    started, ended = (datetime.fromisoformat(said[key]) for key in ("started", "updated"))
    print(
        f"seed {seed}: {'settled' if said['settled'] else 'not settled'} after {result.evaluations} evaluations, {(ended - started).total_seconds() / 60:.1f} min ({seconds / 60:.1f} min now)"
    )
    print("   " + ", ".join(f"{name} {mean:.3f} ± {std:.3f}" for name, mean, std in zip(result.space.names, result.posterior.mean(), result.posterior.std())))
    print(
        "   answer " + ", ".join(f"{value:.3f}" for value in result.answer.theta) + f": ε {result.answer.mean:.2f} ± {result.answer.spread:.2f} %", flush=True
    )


def compare(posteriors: list[gc.Posterior]) -> None:
    """How far each two are apart at most."""
    for (i, one), (j, other) in itertools.combinations(enumerate(posteriors), 2):
        apart = np.abs(one.mean() - other.mean()) / np.minimum(one.std(), other.std())
        ratio = np.exp(np.abs(np.log(one.std() / other.std())))
        print(f"{i + 1} and {j + 1}: means {apart.max():.2f} sd apart at most, standard deviations by a factor of {ratio.max():.2f} at most")


if __name__ == "__main__":
    main()
