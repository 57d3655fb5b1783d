"""Whether the default accuracy has the curves of the reference accuracy: means of many replicates, at YADE's parameters, three pressures and corners of the ranges.

    GRAINCAL_REFERENCE_DATA=folder python benchmarks/accuracy.py [--replicates N] [--cases CASE ...] [-o runs.csv]

The folder holds the packings of Hartmann, Cheng, Thornton (2022). A shear is chaotic: replicates have inertial numbers that differ by half a thousandth. For each
curve its mean over the states and its largest value are taken, in percent of the peak of the reference accuracy's mean curve; for the difference of two means of
replicates the 95 % interval is given (Welch 1947). Beside it stands how far two replicates are apart, the mean over states and pairs, and the steps. Runs are appended to
runs.csv, so that the program can be stopped and goes on.
"""

from __future__ import annotations

import argparse
import os
from itertools import combinations
from pathlib import Path

import numpy as np
from kept_rows import append_row, read_rows
from scipy.stats import t as student

import graincal as gc
from graincal.models.economy import ACCURACIES, INERTIAL_NUMBER

STRAINS = 0.004 * np.arange(51)
OBSERVABLES = ("stress_ratio", "volumetric_strain")
TABLE_3, TRUTH, SOFT_ROUGH = (8.782, 0.161, 30.626, 0.071, 0.885), (8.72, 0.227, 28.1, 0.079, 0.569), (7.6, 0.1, 45.0, 0.3, 0.8)
CASES = {
    **{f"Table 3, {pressure / 1e6:g} MPa": ("packing_1000.csv", TABLE_3, pressure) for pressure in (0.2e6, 0.5e6, 1.0e6)},
    **{f"soft and rough, {pressure / 1e6:g} MPa": ("packing_1000.csv", SOFT_ROUGH, pressure) for pressure in (0.2e6, 0.5e6, 1.0e6)},
    **{f"synthetic truth, 2,000 particles, {pressure / 1e6:g} MPa": ("packing_2000.csv", TRUTH, pressure) for pressure in (0.2e6, 0.5e6, 1.0e6)},
    "corner log E 7, φ 60°, ν 0.5, β 1, η 1": ("packing_1000.csv", (7.0, 0.5, 60.0, 1.0, 1.0), 0.5e6),
    "corner log E 7, φ 60°, ν 0.5, β 0, η 0": ("packing_1000.csv", (7.0, 0.5, 60.0, 0.0, 0.0), 0.5e6),
    "corner log E 7, φ 60°, ν 0.5, β 1, η 0": ("packing_1000.csv", (7.0, 0.5, 60.0, 1.0, 0.0), 0.5e6),
    "corner log E 11, φ 60°, ν 0.5, β 1, η 1": ("packing_1000.csv", (11.0, 0.5, 60.0, 1.0, 1.0), 0.5e6),
    "corner log E 11, φ 60°, ν 0.5, β 0, η 0": ("packing_1000.csv", (11.0, 0.5, 60.0, 0.0, 0.0), 0.5e6),
}
COLUMNS = [f"{name} {state}" for name in OBSERVABLES for state in range(len(STRAINS))]
FIELDS = ["case", "accuracy", "replicate", "steps", "flagged", *COLUMNS]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--replicates", type=int, default=20, help="runs of each accuracy")
    parser.add_argument("--cases", nargs="+", default=list(CASES), choices=list(CASES), metavar="CASE")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("-o", "--output", type=Path, help="where runs are kept, to go on from")
    arguments = parser.parse_args()
    if not os.environ.get("GRAINCAL_REFERENCE_DATA"):
        raise SystemExit("GRAINCAL_REFERENCE_DATA must name the folder with the packings.")
    rows = read_rows(arguments.output)
    print(
        f"{'case':44}{'quantity':20}{'difference of the means, % of the peak: curve':>46}{'largest value':>24}{'two replicates apart':>24}{'steps':>8}  within 1 % / 3 % or half of that"
    )
    for case in arguments.cases:
        rows = run_missing(case, arguments, rows)
        show(case, [row for row in rows if row["case"] == case and int(row["replicate"]) < arguments.replicates])


def run_missing(case: str, arguments: argparse.Namespace, rows: list[dict[str, str]]) -> list[dict[str, str]]:
    """The rows with those of a case that were not there yet."""
    file, theta, pressure = CASES[case]
    packing = gc.Packing.read(Path(os.environ["GRAINCAL_REFERENCE_DATA"]) / file)
    for replicate in range(arguments.replicates):
        for accuracy in ACCURACIES:
            if any((row["case"], row["accuracy"], row["replicate"]) == (case, accuracy, str(replicate)) for row in rows):
                continue
            inertial = INERTIAL_NUMBER * (1 + 5e-4 * (replicate - arguments.replicates // 2))
            test = gc.TriaxialTest(packing, pressure, accuracy=accuracy, inertial_number=inertial, largest_flagged_share=1.0)
            (response,) = test.simulate([theta], at=STRAINS, threads=arguments.threads)
            if not isinstance(response, gc.Response):
                raise SystemExit(f"{case}: a run gave no curve to compare: {response}")
            values = np.concatenate([response.values[name] for name in OBSERVABLES])
            row = {
                "case": case,
                "accuracy": accuracy,
                "replicate": str(replicate),
                "steps": str(response.details["steps"]),
                "flagged": str(response.details["flagged"]),
            }
            rows = [*rows, row | {name: repr(float(value)) for name, value in zip(COLUMNS, values)}]
            append_row(arguments.output, rows[-1], FIELDS)
    return rows


def show(case: str, rows: list[dict[str, str]]) -> None:
    """A line for each observable."""
    steps = {accuracy: np.mean([int(row["steps"]) for row in rows if row["accuracy"] == accuracy]) for accuracy in ACCURACIES}
    for name, limit in zip(OBSERVABLES, (1.0, 3.0)):
        curves = {
            accuracy: np.array([[float(row[f"{name} {state}"]) for state in range(len(STRAINS))] for row in rows if row["accuracy"] == accuracy])
            for accuracy in ACCURACIES
        }
        peak = np.abs(curves["reference"].mean(axis=0)).max() / 100
        of_curve = interval(curves["standard"].mean(axis=1) / peak, curves["reference"].mean(axis=1) / peak)
        of_largest = interval(*(np.abs(curves[accuracy]).max(axis=1) / peak for accuracy in ("standard", "reference")))
        apart = np.mean([np.abs(one - other).mean() for one, other in combinations(curves["reference"], 2)]) / peak
        allowed = max(limit, apart / 2)
        within = np.abs(of_curve[0]) + of_curve[1] <= allowed
        print(
            f"{case:44}{name:20}{of_curve[0]:>36.2f} ± {of_curve[1]:<7.2f}{of_largest[0]:>14.2f} ± {of_largest[1]:<7.2f}{apart:>24.2f}{steps['standard'] / steps['reference']:>8.2f}"
            f"  {'yes' if within else 'no'} ({allowed:.2f})",
            flush=True,
        )


def interval(one: np.ndarray, other: np.ndarray) -> tuple[float, float]:
    """The difference of the means of two samples, and half its 95 % interval."""
    parts = [sample.var(ddof=1) / len(sample) for sample in (one, other)]
    freedom = sum(parts) ** 2 / sum(part**2 / (len(sample) - 1) for part, sample in zip(parts, (one, other))) if sum(parts) else 1.0
    return float(one.mean() - other.mean()), float(student.ppf(0.975, freedom) * np.sqrt(sum(parts)))


if __name__ == "__main__":
    main()
