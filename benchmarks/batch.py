"""How well a batch keeps its threads at work: the first iteration of a calibration over the paper's ranges, 80 samples whose runs differ in length a hundredfold.

    python benchmarks/batch.py [--particles 500] [--samples 80] [--threads 2] [--lengths lengths.csv]

The longest expected run starts first (graincal/models/stress_path.py); the idle share is what the threads wait for the last ones.
"""

from __future__ import annotations

import argparse
import csv
import time

import numpy as np

import graincal as gc
from graincal import demo
from graincal.dem.preparation import prepare
from graincal.models.contact_laws import LAWS
from graincal.models.economy import PRECISIONS
from graincal.models.stress_path import relative_run_lengths

CONFINING_PRESSURE = 0.5e6
STRAINS = 0.004 * np.arange(51)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--particles", type=int, default=500, help="of the packing; 500 is the embedded one, others are prepared (default: %(default)s)")
    parser.add_argument("--samples", type=int, default=80)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--axial-strain", type=float, default=STRAINS[-1])
    parser.add_argument("--precision", choices=PRECISIONS, default=PRECISIONS[0])
    parser.add_argument("--law", choices=LAWS, default="linear")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--lengths", help="write each sample's theta, steps and seconds to this file")
    arguments = parser.parse_args()

    packing = demo.packing() if arguments.particles == 500 else prepare(particles=arguments.particles, void_ratio=0.68)
    at = STRAINS[STRAINS <= arguments.axial_strain + 1e-9]
    samples = ask(arguments.samples, arguments.seed)
    test = gc.TriaxialTest(packing, CONFINING_PRESSURE, precision=arguments.precision, law=arguments.law)
    start = time.perf_counter()
    outcomes = dict(test.evaluate(samples, at, workers=arguments.threads))
    wall = time.perf_counter() - start

    outcomes = [outcomes[row] for row in range(len(samples))]
    seconds, steps = (np.array([outcome.details[name] for outcome in outcomes]) for name in ("seconds", "steps"))
    failures = sum(isinstance(outcome, gc.Failure) for outcome in outcomes)
    flagged = sum(outcome.details["flagged"] for outcome in outcomes)
    expected = relative_run_lengths(test.steps_exponent, test.arrange(samples))
    off = np.log(steps / expected)[steps > 0]
    print(f"{len(samples)} samples of {packing.count} particles to {at[-1]:.0%} of axial strain, {arguments.precision}, {arguments.threads} threads")
    print(f"wall {wall:.1f} s, busy {seconds.sum():.1f} s, {packing.count * steps.sum() / seconds.sum() / 1e6:.2f} million particle-steps a second and thread")
    print(f"idle share {1 - seconds.sum() / (arguments.threads * wall):.1%}, the longest run {seconds.max() / wall:.1%} of the wall time")
    print(
        f"steps {steps.min():,} to {steps.max():,}; off from what was expected by a factor of {np.exp(off.std()):.2f}; {failures} failures, {flagged} flagged states"
    )
    if arguments.lengths:
        with open(arguments.lengths, "w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow([*LAWS["linear"].names, "steps", "seconds", "expected"])
            writer.writerows([*theta, *row] for theta, *row in zip(test.arrange(samples).tolist(), steps, seconds, expected))


def ask(count: int, seed: int) -> gc.Samples:
    """The first samples of a calibration: a scrambled Halton sequence over the paper's ranges."""
    space = gc.ParameterSpace.paper()
    reference = gc.Reference(control=STRAINS, observables={"stress_ratio": 1 + STRAINS, "volumetric_strain": STRAINS})  # nothing is compared with it here
    samples = gc.IterativeBayesianFilter(space, reference, alpha=10, seed=seed).ask()
    if count > len(samples):
        raise SystemExit(f"--samples {count}: at most the {len(samples)} of an iteration were expected.")
    return samples.take(np.arange(count))


if __name__ == "__main__":
    main()
