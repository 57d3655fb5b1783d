"""Whether intervals hold the truth, on the engine's own test: truths from the prior, each one run on another packing than the calibration's.

    GRAINCAL_REFERENCE_DATA=... python benchmarks/known_truths.py --folder DIR [--truths 30] [--runs 600] [--scratch]

Each truth is drawn from the paper's ranges, and run once on a packing of its own that is prepared like the paper's packing of 1,000 particles (drained triaxial compression at 0.5 MPa to 20 % of axial strain);
a truth whose run fails is drawn again. The calibration is on the paper's packing, by defaults. All learn from one library of `graincal explore` that is made first (--runs), so that each takes minutes; with
--scratch none does. All are counted at their end, settled or not. Printed are how many of the intervals of 50 and 90 % hold the truth, and the truth's mean log density above the prior's; and the same had all
covariances of the errors been half or twice as large, which ought to be refused: of so many intervals those that hold the truth lie between the numbers in brackets in 95 of 100 such tables.
Everything is in DIR, and gone on with where it was broken off.
"""

from __future__ import annotations

import argparse
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binom

import graincal as gc
from graincal.campaign import Experiment, begin, resume
from graincal.campaign.calibration import Calibration
from graincal.campaign.runs import known_runs
from graincal.campaign.store import holds_campaign
from graincal.dem.siblings import siblings
from graincal.inference.sensitivity import under_other_errors

PRESSURE, STRAIN = 0.5e6, np.arange(0.0, 0.2001, 0.005)
NAMES = ("stress_ratio", "volumetric_strain")
FIRST_SEED = 201
"""Of the packings of the truths: none of those that calibrations prepare."""
LEVELS, FACTORS = (0.5, 0.9), (1.0, 0.5, 2.0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, required=True)
    parser.add_argument("--truths", type=int, default=30)
    parser.add_argument("--runs", type=int, default=600)
    parser.add_argument("--scratch", action="store_true")
    arguments = parser.parse_args()
    packing = gc.Packing.read(Path(os.environ["GRAINCAL_REFERENCE_DATA"]) / "packing_1000.csv")
    test, space = gc.TriaxialTest(packing, PRESSURE), gc.ParameterSpace.paper()
    library = None if arguments.scratch else gc.explore(test, space, to=STRAIN[-1], folder=arguments.folder / "library", runs=arguments.runs)
    held, gained, settled = np.zeros((len(FACTORS), len(LEVELS)), dtype=int), [], 0
    for number in range(arguments.truths):
        result = calibrate(test, space, number, library, arguments.folder / f"{number:02d}")
        truth = np.array([result.truth[name] for name in space.names])
        held += [[inside(posterior, truth, level) for level in LEVELS] for posterior in under_factors(result)]
        gained.append(result.emulation.log_likelihood(space.to_unit(truth[None]))[0] - result.log_evidence)
        settled += result.settled
        print(f"truth {number}: {'settled' if result.settled else 'not settled'} after {result.evaluations}, ε {result.answer.mean:.2f} %, log density {gained[-1]:+.1f}; held so far {held[0].tolist()}", flush=True)
    total = arguments.truths * space.size
    for factor, counts in zip(FACTORS, held):
        bands = [f"{count} of {total} of {level:.0%} ({binom.ppf(0.025, total, level):.0f} to {binom.ppf(0.975, total, level):.0f})" for count, level in zip(counts, LEVELS)]
        print(f"covariances times {factor:g}: {', '.join(bands)}")
    print(f"{settled} of {arguments.truths} settled; the truth's log density is {np.mean(gained):.2f} above the prior's on the mean")


def calibrate(test: gc.TriaxialTest, space: gc.ParameterSpace, number: int, library: Path | None, folder: Path) -> gc.Result:
    """To its end, gone on with where it was broken off."""
    if folder.exists() and holds_campaign(folder):
        return resume(folder)
    truth, curve = reference(test, space, number)
    asked = Calibration(space, [Experiment("truth", test, curve)], seed=number, truth=dict(zip(space.names, truth.tolist())))
    return begin(replace(asked, known=known_runs([library], asked)) if library else asked, folder)


def reference(test: gc.TriaxialTest, space: gc.ParameterSpace, number: int) -> tuple[NDArray[np.float64], gc.Reference]:
    """The truth (n,) of a number, and its run."""
    (packing,) = siblings(test.packing, 1, first_seed=FIRST_SEED + number)
    rng = np.random.default_rng(number)
    while True:
        truth = space.from_unit(rng.random(space.size))
        response = replace(test, packing=packing, packings=()).simulate([truth], at=STRAIN)[0]
        if isinstance(response, gc.Response):
            return truth, gc.Reference(STRAIN, {name: response.values[name] for name in NAMES}, simulated=True)


def under_factors(result: gc.Result) -> list[gc.Posterior]:
    """The posterior, had the covariances of the errors been so many times as large."""
    known = result.knowledge
    errors = [tuple(replace(each, covariances=factor * each.covariances) for each in known.errors) for factor in FACTORS[1:]]
    rng = np.random.default_rng(0)
    return [result.posterior, *(under_other_errors(result.emulation, result.space, known.kept, known.scatters, each, rng) for each in errors)]


def inside(posterior: gc.Posterior, truth: NDArray[np.float64], level: float) -> int:
    """How many parameters' intervals hold the truth."""
    low, high = posterior.interval(level)
    return int(np.sum((low <= truth) & (truth <= high)))


if __name__ == "__main__":
    main()
