"""How far an answer moves with the packing: calibrations of one curve on packings prepared alike.

    GRAINCAL_REFERENCE_DATA=... python benchmarks/packings.py --folder DIR [--packings 5] [--particles 1000 2000] [--seeds 3] [--runs 200]

Five packings of each size are prepared alike (void ratio 0.68, Toyoura grading). Two curves are calibrated on each, by three seeds: the synthetic reference of Hartmann et al. (2022), and Toyoura sand at 0.5 MPa. Each calibration is
conditional on its packing: packing_scatter = false, so that what packings differ by is no error. The calibrations of a packing and seed begin with a library of runs of their own that fill the paper's ranges, so that what a
library scatters by is between seeds and not between packings, and they go on by their own rule.

Printed are, for each parameter and for the error ε of the answer, the standard deviations between packings and between the seeds of a packing, by analysis of variance with their intervals of 95 % (generalised pivots, Weerahandi
1993), and beside them the posterior's own on the mean: what is left once packing and seed are known. Everything is kept in DIR; the same command continues where it was interrupted.
"""

from __future__ import annotations

import argparse
import json
import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import graincal as gc
from graincal.campaign import Experiment
from graincal.campaign.asked.calibration import Calibration
from graincal.campaign.run.running import begin_or_resume
from graincal.dem.preparation import prepare

PRESSURE, VOID_RATIO, STRAIN = 0.5e6, 0.68, 0.2
SPACE = gc.ParameterSpace.paper()
CURVES = {"synthetic": ("synthetic_reference.csv", True), "Toyoura": ("toyoura_0.5MPa.csv", False)}
PIVOTS = 100_000


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, required=True)
    parser.add_argument("--packings", type=int, default=5)
    parser.add_argument("--particles", type=int, nargs="+", default=[1000, 2000])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--runs", type=int, default=200, help="that fill the ranges, for each packing and seed")
    arguments = parser.parse_args()
    for particles in arguments.particles:
        found = {curve: np.empty((arguments.packings, arguments.seeds, 2, SPACE.size + 1)) for curve in CURVES}
        for number in range(arguments.packings):
            test = gc.TriaxialTest(prepare(particles, VOID_RATIO, seed=number + 1), PRESSURE)
            for seed in range(1, arguments.seeds + 1):
                place = arguments.folder / f"{particles}-{number + 1}" / f"seed-{seed}"
                library = gc.explore(test, SPACE, to=STRAIN, folder=place / "library", runs=arguments.runs, seed=seed)
                for curve in CURVES:
                    found[curve][number, seed - 1] = calibrated(test, curve, seed, library, place)
        for curve, numbers in found.items():
            show(f"{curve}, {particles} particles", numbers)


def calibrated(test: gc.TriaxialTest, curve: str, seed: int, library: Path, place: Path) -> NDArray[np.float64]:
    """Of one calibration (2, n + 1): the posterior's means and the error of the answer, and the posterior's standard deviations and the error's."""
    kept = place / f"{curve}.json"
    if kept.exists():
        return np.array(json.loads(kept.read_text()))

    def asked() -> Calibration:
        file, simulated = CURVES[curve]
        reference = gc.Reference.read(
            Path(os.environ["GRAINCAL_REFERENCE_DATA"]) / file, observables=("stress_ratio", "volumetric_strain"), simulated=simulated
        )
        return Calibration(SPACE, [Experiment(curve, test, reference)], filter_options={"packing_scatter": False}, seed=seed)

    result = begin_or_resume(place / curve, asked, [library])
    numbers = [[*result.posterior.mean(), result.answer.mean], [*result.posterior.std(), result.answer.spread]]
    print(
        f"{place.parent.name}, {curve}, seed {seed}: {'settled' if result.settled else 'not settled'} after {result.evaluations} runs, ε {result.answer.mean:.2f} %",
        flush=True,
    )
    kept.write_text(json.dumps(np.array(numbers).tolist()))
    return np.array(numbers)


def show(title: str, numbers: NDArray[np.float64]) -> None:
    """A line for each quantity of numbers (packings, seeds, 2, quantities)."""
    print(f"\n{title}\n{'':12}{'mean':>10}{'between packings':>28}{'between seeds':>28}{'posterior':>12}")
    for column, name in enumerate((*SPACE.names, "ε [%]")):
        values, own = numbers[:, :, 0, column], numbers[:, :, 1, column]
        packings, seeds = deviations(values)
        print(f"{name:12}{values.mean():>10.3f}{said(packings):>28}{said(seeds):>28}{np.sqrt(np.mean(own**2)):>12.3f}")


def deviations(values: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The standard deviation between packings, and between the seeds of one, of values (packings, seeds): estimate, low and high (3,) each."""
    packings, seeds = values.shape
    within_freedom, between_freedom = packings * (seeds - 1), packings - 1
    within = values.var(axis=1, ddof=1).mean()
    between = seeds * values.mean(axis=1).var(ddof=1)
    rng = np.random.default_rng(0)
    of_within = within * within_freedom / rng.chisquare(within_freedom, PIVOTS)
    of_between = np.maximum(0, between * between_freedom / rng.chisquare(between_freedom, PIVOTS) - of_within) / seeds
    estimate = max(0.0, between - within) / seeds
    return tuple(np.sqrt([value, *np.quantile(pivots, (0.025, 0.975))]) for value, pivots in ((estimate, of_between), (within, of_within)))


def said(deviation: NDArray[np.float64]) -> str:
    return f"{deviation[0]:.3f} ({deviation[1]:.3f} to {deviation[2]:.3f})"


if __name__ == "__main__":
    main()
