"""What each option that takes fewer steps costs in accuracy: triaxial tests to 20 % against YADE's, means of replicates against means.

    GRAINCAL_REFERENCE_DATA=folder python benchmarks/fewer_steps.py [--replicates N] [--cases CASE ...]

The folder holds the packings of Hartmann, Cheng, Thornton (2022) and YADE's curves on them. Steps are shares of YADE's for the same test. Errors are those of
the paper's Eq. 5, in percent; ε is the mean over stress ratio and volumetric strain. Replicates differ by a thousandth of their density scaling.
The last column is ε from the mean of graincal's own replicates by the paper's protocol.
"""

from __future__ import annotations

import argparse
import itertools
import json
import os
from pathlib import Path

import numpy as np

import graincal as gc
from graincal.models.economy import inertial_number

CASES = ("truth2000", "table3_1000_p0.5", "soft_rough_1000")
PRESSURE = 0.5e6
COMPARED = ("stress_ratio", "volumetric_strain", "coordination_number", "a_c")
YADE_COLUMNS = dict(zip(COMPARED, ("s1_over_s3", "e_v", "Z", "a_c")))
PAPERS = {"accuracy": "reference"}
BOTH = PAPERS | {"time_step_bound": "contact", "mass_exponent": 1.0}
OPTIONS = {
    "the paper's protocol": PAPERS,
    "time_step_bound contact": PAPERS | {"time_step_bound": "contact"},
    "mass_exponent 2": PAPERS | {"mass_exponent": 2.0},
    "mass_exponent 1": PAPERS | {"mass_exponent": 1.0},
    "inertia_factor 2": PAPERS | {"inertia_factor": 2.0},
    "settling_damping 0.4": PAPERS | {"settling_damping": 0.4},
    "settling_damping 0.7": PAPERS | {"settling_damping": 0.7},
    "strain_ramp 0.1": PAPERS | {"strain_ramp": 0.1},
    "strain_ramp 0.3": PAPERS | {"strain_ramp": 0.3},
    "contact, mass 1": BOTH,
    "standard: with float32 too": {},
    "contact, mass 1, settling 0.4": BOTH | {"settling_damping": 0.4},
    "density_scaling 100": PAPERS | {"density_scaling": 100.0},
    "density_scaling 100, contact, mass 1": BOTH | {"density_scaling": 100.0},
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--replicates", type=int, default=5)
    parser.add_argument("--cases", nargs="+", default=CASES, choices=CASES)
    parser.add_argument(
        "--options", nargs="+", default=list(OPTIONS), choices=list(OPTIONS), metavar="OPTION", help="of the program's list; the paper's protocol comes first"
    )
    arguments = parser.parse_args()
    if not os.environ.get("GRAINCAL_REFERENCE_DATA"):
        raise SystemExit("GRAINCAL_REFERENCE_DATA must name the folder with the packings and YADE's curves.")
    data = Path(os.environ["GRAINCAL_REFERENCE_DATA"])
    for case in arguments.cases:
        compare(data, case, arguments.replicates, arguments.options)


def compare(data: Path, case: str, replicates: int, chosen: list[str]) -> None:
    files = [data / "yade" / f"{case}_{scaling}.csv" for scaling in (999, 1000, 1001)]
    about = json.loads(files[0].read_text().splitlines()[0].removeprefix("#"))
    tables = [np.genfromtxt(file, delimiter=",", names=True, skip_header=1) for file in files]
    yade = [{name: table[column] for name, column in YADE_COLUMNS.items()} for table in tables]
    yades_steps = np.mean([table["iter"][-1] for table in tables])
    theta = [np.log10(about["E"]), about["nu"], about["phi"], about["beta_m"], about["eta_m"]]
    packing = gc.Packing.read(data / about["packing"])
    strains = about["dstrain"] * np.arange(len(tables[0]))
    inertial = inertial_number(packing, PRESSURE, 1e3)
    print(f"\n{case}: {yades_steps:,.0f} steps of YADE's, inertial number {inertial:.2e} at a density scaling of 1000", flush=True)
    print(f"{'':38}{'steps':>9}{'of YADE':>9}{'ε':>7}{'stress ratio':>14}{'vol. strain':>13}{'Z':>7}{'a_c':>7}{'flagged':>9}{'ε, own':>8}")
    show("between YADE's replicates", yades_steps, yades_steps, floor(yade))
    own = None
    for label, options in ((label, OPTIONS[label]) for label in chosen):
        curves = [run(packing, theta, strains, k - replicates // 2, options) for k in range(replicates)]
        steps = np.mean([curve["steps"][-1] for curve in curves])
        flagged = sum(int(curve["flagged"].sum()) for curve in curves)
        own = own or mean(curves)
        show(label, steps, yades_steps, (mean(yade), mean(curves)), flagged, f"{np.mean(errors(own, mean(curves))[:2]):8.2f}")
        if options is PAPERS:
            show("between its replicates", steps, yades_steps, floor(curves))


def run(packing: gc.Packing, theta: list[float], strains: np.ndarray, thousandths: int, options: dict) -> dict[str, np.ndarray]:
    scaling = options.get("density_scaling", 1e3) * (1 + 1e-3 * thousandths)
    test = gc.TriaxialTest(packing, PRESSURE, largest_flagged_share=1.0, **(options | {"density_scaling": scaling}))
    (response,) = test.simulate([theta], at=strains, threads=1)
    if not isinstance(response, gc.Response):
        raise SystemExit(f"A run gave no curve to compare: {response}")
    return {name: response.values[name] for name in (*COMPARED, "steps", "flagged")}


def mean(curves: list[dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    return {name: np.mean([curve[name] for curve in curves], axis=0) for name in COMPARED}


def errors(reference: dict[str, np.ndarray], curve: dict[str, np.ndarray]) -> list[float]:
    return [100 * np.abs(reference[name] - curve[name]).sum() / np.abs(reference[name]).sum() for name in COMPARED]


def floor(curves: list[dict[str, np.ndarray]]) -> tuple[dict[str, np.ndarray], ...]:
    """All pairs, laid end to end: their error is the mean over pairs."""
    pairs = list(itertools.permutations(curves, 2))
    return tuple({name: np.concatenate([pair[side][name] for pair in pairs]) for name in COMPARED} for side in (0, 1))


def show(label: str, steps: float, yades_steps: float, compared: tuple[dict[str, np.ndarray], ...], flagged: int = 0, own: str = "") -> None:
    found = errors(*compared)
    cells = "".join(f"{error:>{width}.2f}" for error, width in zip(found, (14, 13, 7, 7)))
    print(f"{label:38}{steps:>9,.0f}{steps / yades_steps:>9.2f}{np.mean(found[:2]):>7.2f}{cells}{flagged:>9}{own}", flush=True)


if __name__ == "__main__":
    main()
