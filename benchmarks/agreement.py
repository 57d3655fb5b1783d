"""How far graincal's triaxial curves are from YADE's, from the published reference, and from packing to packing.

    GRAINCAL_REFERENCE_DATA=folder python benchmarks/agreement.py [--packings N]

The folder holds the packings and the reference of Hartmann, Cheng, Thornton (2022) and YADE's curves on those packings. Errors are those of the paper's
Eq. 5, in percent; ε is the mean over stress ratio and volumetric strain (Eq. 6, equal shares). Both accuracies are compared. Two runs of the same test differ: replicates have the
density scalings 999, 1000, ..., and means of replicates are compared. With --packings, N packings of 1,000 particles are prepared as well.
"""

from __future__ import annotations

import argparse
import itertools
import json
import os
from pathlib import Path

import numpy as np

import graincal as gc
from graincal.dem.preparation import prepare
from graincal.models.economy import ACCURACIES

COMPARED = ("stress_ratio", "volumetric_strain", "coordination_number", "a_c")
YADE_COLUMNS = dict(zip(COMPARED, ("s1_over_s3", "e_v", "Z", "a_c")))
HEADER = f"{'':40}{'ε':>7}{'stress ratio':>14}{'vol. strain':>13}{'Z':>7}{'a_c':>7}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--packings", type=int, default=0, help="packings of 1,000 particles to prepare and to compare with the paper's")
    arguments = parser.parse_args()
    if not os.environ.get("GRAINCAL_REFERENCE_DATA"):
        raise SystemExit("GRAINCAL_REFERENCE_DATA must name the folder with the packings, the reference and YADE's curves.")
    data = Path(os.environ["GRAINCAL_REFERENCE_DATA"])
    print(HEADER)
    for case in ("truth2000", "table3_1000_p0.5", "soft_rough_1000"):
        compare_with_yade(data, case)
    compare_with_paper(data)
    if arguments.packings:
        compare_packings(data, arguments.packings)


def compare_with_yade(data: Path, case: str) -> None:
    files = [data / "yade" / f"{case}_{scaling}.csv" for scaling in (999, 1000, 1001)]
    about = json.loads(files[0].read_text().splitlines()[0].removeprefix("#"))
    tables = [np.genfromtxt(file, delimiter=",", names=True, skip_header=1) for file in files]
    yade = [{name: table[column] for name, column in YADE_COLUMNS.items()} for table in tables]
    theta = [np.log10(about["E"]), about["nu"], about["phi"], about["beta_m"], about["eta_m"]]
    packing = gc.Packing.read(data / about["packing"])
    show(f"{case}: between YADE's replicates", *floor(yade))
    for accuracy in ACCURACIES:
        ours = replicates(packing, theta, about["dstrain"] * np.arange(len(tables[0])), (999, 1000, 1001), accuracy)
        show(f"{accuracy}: between graincal's replicates", *floor(ours))
        show(f"{accuracy}: mean of three, against YADE's", mean(yade), mean(ours))


def compare_with_paper(data: Path) -> None:
    path = data / "synthetic_reference.csv"
    reference = gc.Reference.read(path)
    theta = [float(item.split()[1]) for item in path.read_text().splitlines()[0].split("; ")[1].split(", ")]
    for accuracy in ACCURACIES:
        ours = replicates(gc.Packing.read(data / "packing_2000.csv"), theta, reference.control, (998, 999, 1000, 1001, 1002), accuracy)
        for number, curve in enumerate(ours, 1):
            show(f"{accuracy}: paper's reference: run {number}", dict(reference.observables), curve)
        show(f"{accuracy}: paper's reference: mean of five", dict(reference.observables), mean(ours))


def compare_packings(data: Path, count: int) -> None:
    theta, strains = [8.782, 0.161, 30.626, 0.071, 0.885], 0.004 * np.arange(51)
    published = mean(replicates(gc.Packing.read(data / "packing_1000.csv"), theta, strains, (999, 1000, 1001)))
    larger = mean(replicates(gc.Packing.read(data / "packing_2000.csv"), theta, strains, (999, 1000, 1001)))
    show("packing_1000 against packing_2000", published, larger)
    prepared = []
    for seed in range(1, count + 1):
        prepared.append(mean(replicates(prepare(1000, 0.68, seed=seed), theta, strains, (999, 1000, 1001))))
        show(f"packing_1000 against prepared, seed {seed}", published, prepared[-1])
    if count > 1:
        show(f"between the {count} prepared", *floor(prepared))
        show(f"packing_1000 against the mean of {count}", published, mean(prepared))
        show(f"packing_2000 against the mean of {count}", larger, mean(prepared))


def replicates(
    packing: gc.Packing, theta: list[float], strains: np.ndarray, scalings: tuple[int, ...], accuracy: str = "standard"
) -> list[dict[str, np.ndarray]]:
    curves = []
    for scaling in scalings:
        response = gc.TriaxialTest(packing, 0.5e6, density_scaling=scaling, accuracy=accuracy).simulate([theta], at=strains)[0]
        if not isinstance(response, gc.Response) or response.details["flagged"]:
            raise SystemExit(f"A run gave no curve to compare: {response}")
        curves.append({name: response.values[name] for name in COMPARED})
    return curves


def mean(curves: list[dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    return {name: np.mean([curve[name] for curve in curves], axis=0) for name in COMPARED}


def floor(curves: list[dict[str, np.ndarray]]):
    """All pairs, laid end to end: their error is the mean over pairs."""
    pairs = list(itertools.permutations(curves, 2))
    return tuple({name: np.concatenate([pair[side][name] for pair in pairs]) for name in COMPARED} for side in (0, 1))


def show(label: str, reference: dict[str, np.ndarray], curve: dict[str, np.ndarray]) -> None:
    errors = [100 * np.abs(reference[name] - curve[name]).sum() / np.abs(reference[name]).sum() if name in reference else np.nan for name in COMPARED]
    cells = [f"{np.mean(errors[:2]):>7.2f}", *(f"{'' if np.isnan(error) else format(error, '.2f'):>{width}}" for error, width in zip(errors, (14, 13, 7, 7)))]
    print(f"{label:40}{''.join(cells)}", flush=True)


if __name__ == "__main__":
    main()
