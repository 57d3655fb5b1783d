"""What the states at which a triaxial test rests do to its curve: the additional ones at first, and rows that lie between them.

    GRAINCAL_REFERENCE_DATA=folder python benchmarks/rests.py [--replicates N]

The folder holds the packings of Hartmann, Cheng, Thornton (2022). Means of replicates are compared, whose inertial numbers differ by half a thousandth; a difference is
given with two standard errors. First table: the test with its additional first states (0.05, 0.1, 0.2, 0.3 %) against one that rests every 0.4 % alone, in percent
of the peak, the mean over the states from 0.4 to 20 %. Second table: the curve below 2 % read off the states against a test that rests at every row,
forty of them, in percent of each value: the mean over the rows and the largest.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

import numpy as np

import graincal as gc
from graincal.models.economy import INERTIAL_NUMBER

CASES = {
    "Table 3, 1,000 particles": ("packing_1000.csv", (8.782, 0.161, 30.626, 0.071, 0.885)),
    "synthetic truth, 2,000 particles": ("packing_2000.csv", (8.72, 0.227, 28.1, 0.079, 0.569)),
    "soft and rough, 1,000 particles": ("packing_1000.csv", (7.6, 0.1, 45.0, 0.3, 0.8)),
}
PRESSURE = 0.5e6
EVEN = 0.004 * np.arange(51)
ROWS = 0.0005 * np.arange(41)
OBSERVABLES = ("stress_ratio", "volumetric_strain")


class AtRestAtEveryRow(gc.TriaxialTest):
    """The test as it would be with a rest at every row that is asked for, and nowhere else."""

    def states(self, at):
        return np.asarray(at, dtype=np.float64)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--replicates", type=int, default=12)
    arguments = parser.parse_args()
    if not os.environ.get("GRAINCAL_REFERENCE_DATA"):
        raise SystemExit("GRAINCAL_REFERENCE_DATA must name the folder with the packings.")
    folder, count = Path(os.environ["GRAINCAL_REFERENCE_DATA"]), arguments.replicates
    print(f"With the additional first states against without, {count} replicates each, % of the peak")
    print(f"{'':36}{'stress ratio':>22}{'volumetric strain':>22}{'steps':>8}")
    for case, (file, theta) in CASES.items():
        packing = gc.Packing.read(folder / file)
        (ours, our_steps), (plain, steps) = (replicates(kind, packing, theta, EVEN, count) for kind in (gc.TriaxialTest, AtRestAtEveryRow))
        cells = [difference(ours[name][:, 1:].mean(axis=1), plain[name][:, 1:].mean(axis=1), np.abs(plain[name].mean(axis=0)).max()) for name in OBSERVABLES]
        print(f"{case:36}" + "".join(f"{cell:>22}" for cell in cells) + f"{our_steps / steps:>8.2f}", flush=True)
    print(f"\nRows below 2 % read off the states against a rest at every row, {count} replicates each, stress ratio, % of the ratio")
    print(f"{'':36}{'mean':>22}{'largest':>12}{'steps':>8}")
    for case, (file, theta) in CASES.items():
        packing = gc.Packing.read(folder / file)
        (ours, our_steps), (every, steps) = (replicates(kind, packing, theta, ROWS, count) for kind in (gc.TriaxialTest, AtRestAtEveryRow))
        mean = every["stress_ratio"].mean(axis=0)
        largest = np.abs(ours["stress_ratio"].mean(axis=0) / mean - 1).max()
        cell = difference((ours["stress_ratio"] / mean).mean(axis=1), (every["stress_ratio"] / mean).mean(axis=1), 1.0)
        print(f"{case:36}{cell:>22}{100 * largest:>12.2f}{our_steps / steps:>8.2f}", flush=True)


def replicates(kind: type[gc.TriaxialTest], packing: gc.Packing, theta: tuple[float, ...], at: np.ndarray, count: int) -> tuple[dict[str, np.ndarray], float]:
    """The curves of each observable (count, T), and the mean of the steps."""
    curves, steps = {name: [] for name in OBSERVABLES}, []
    for k in range(count):
        test = kind(packing, PRESSURE, inertial_number=INERTIAL_NUMBER * (1 + 5e-4 * (k - count // 2)))
        (response,) = test.simulate([theta], at=at, threads=1)
        if not isinstance(response, gc.Response):
            raise SystemExit(f"A run gave no curve to compare: {response}")
        for name in OBSERVABLES:
            curves[name].append(response.values[name])
        steps.append(response.details["steps"])
    return {name: np.array(each) for name, each in curves.items()}, float(np.mean(steps))


def difference(one: np.ndarray, other: np.ndarray, unit: float) -> str:
    """Of the means of two samples, in percent of the unit, with two standard errors."""
    error = np.sqrt(one.var(ddof=1) / len(one) + other.var(ddof=1) / len(other))
    return f"{100 * (one.mean() - other.mean()) / unit:.2f} ± {200 * error / unit:.2f}"


if __name__ == "__main__":
    main()
