"""What density scaling costs: one drained triaxial test at several scalings, several replicates of each.

    python benchmarks/density_scaling.py [--packing FILE] [--scalings 1000 100 10 1] [--replicates N] [--strain LAST] [--plot FILE]

The test is that of Hartmann, Cheng, Thornton (2022), Table 3, at 0.5 MPa. Without --packing one of 1,000 particles is prepared. A shear is chaotic: replicates
have density scalings that differ by a thousandth, and means of them are compared. A mean's standard error is that of its replicates over the root of their
number; a difference below two of it is not there. The inertial number is ε̇ d sqrt(ρ/p), d the mean diameter.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import graincal as gc
from graincal.dem.preparation import prepare
from graincal.models.economy import inertial_number

THETA = [8.782, 0.161, 30.626, 0.071, 0.885]
PRESSURE = 0.5e6
COMPARED = ("stress_ratio", "volumetric_strain", "coordination_number", "a_c")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--packing", type=Path, help="a packing file (default: a packing of 1,000 particles is prepared)")
    parser.add_argument("--scalings", type=float, nargs="+", default=[1000.0, 100.0, 10.0, 1.0])
    parser.add_argument("--replicates", type=int, default=5, help="runs at each scaling")
    parser.add_argument("--strain", type=float, default=0.20, help="the last axial strain")
    parser.add_argument("--plot", type=Path, help="draw the curves to this file")
    arguments = parser.parse_args()
    packing = gc.Packing.read(arguments.packing) if arguments.packing else prepare(1000, 0.68)
    strains = np.append(np.arange(0, arguments.strain - 1e-9, 0.004), arguments.strain)
    runs = {}
    print(f"{'density scaling':>15}{'inertial number':>17}{'steps':>11}{'largest stress ratio':>23}{'the last one':>17}{'last vol. strain, %':>21}", flush=True)
    for scaling in arguments.scalings:
        runs[scaling] = replicates(packing, strains, scaling, arguments.replicates)
        show(scaling, inertial_number(packing, PRESSURE, scaling), runs[scaling])
    print("\nDistance from the curve of the smallest scaling, means against means (Eq. 5, %), and between the replicates of each")
    print(f"{'density scaling':>15}{'stress ratio':>24}{'volumetric strain':>24}{'Z':>24}{'a_c':>24}")
    smallest = runs[min(runs)]
    for scaling, curves in runs.items():
        cells = [f"{error(mean(smallest, name), mean(curves, name)):.2f} ({floor(curves, name):.2f})" for name in COMPARED]
        print(f"{scaling:>15g}" + "".join(f"{cell:>24}" for cell in cells))
    if arguments.plot:
        draw(strains, runs, arguments.plot)


def replicates(packing: gc.Packing, strains: np.ndarray, scaling: float, count: int) -> list[dict[str, np.ndarray]]:
    curves = []
    for k in range(count):
        test = gc.TriaxialTest(packing, PRESSURE, accuracy="reference", density_scaling=scaling * (1 + 1e-3 * (k - count // 2)), step_limit=200_000_000)
        (response,) = test.simulate([THETA], at=strains, threads=1)
        if not isinstance(response, gc.Response) or response.details["flagged"]:
            raise SystemExit(f"A run gave no curve to compare: {response}")
        curves.append({name: response.values[name] for name in (*COMPARED, "steps")})
    return curves


def mean(curves: list[dict[str, np.ndarray]], name: str) -> np.ndarray:
    return np.mean([curve[name] for curve in curves], axis=0)


def error(reference: np.ndarray, curve: np.ndarray) -> float:
    """Eq. 5 of the paper, in percent."""
    return 100 * np.abs(reference - curve).sum() / np.abs(reference).sum()


def floor(curves: list[dict[str, np.ndarray]], name: str) -> float:
    """The mean over all pairs of replicates."""
    errors = [error(one[name], other[name]) for one in curves for other in curves if one is not other]
    return float(np.mean(errors)) if errors else np.nan


def show(scaling: float, inertial: float, curves: list[dict[str, np.ndarray]]) -> None:
    def with_error(values: list[float], digits: int) -> str:
        spread = np.std(values, ddof=1) / np.sqrt(len(values)) if len(values) > 1 else np.nan
        return f"{np.mean(values):.{digits}f} ± {spread:.{digits}f}"

    largest = with_error([curve["stress_ratio"].max() for curve in curves], 3)
    last = with_error([curve["stress_ratio"][-1] for curve in curves], 3)
    volume = with_error([100 * curve["volumetric_strain"][-1] for curve in curves], 2)
    steps = np.mean([curve["steps"][-1] for curve in curves])
    print(f"{scaling:>15g}{inertial:>17.2e}{steps:>11,.0f}{largest:>23}{last:>17}{volume:>21}", flush=True)


def draw(strains: np.ndarray, runs: dict[float, list[dict[str, np.ndarray]]], path: Path) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained")
    colours = plt.get_cmap("viridis")(np.linspace(0, 0.85, len(runs)))
    for panel, name, label, factor in zip(panels, COMPARED, ("stress ratio", "volumetric strain, %"), (1, 100)):
        for (scaling, curves), colour in zip(runs.items(), colours):
            values = factor * np.array([curve[name] for curve in curves])
            panel.fill_between(100 * strains, values.min(axis=0), values.max(axis=0), color=colour, alpha=0.2, linewidth=0)
            panel.plot(100 * strains, values.mean(axis=0), color=colour, label=f"{scaling:g}")
        panel.set_xlabel("axial strain, %")
        panel.set_ylabel(label)
        panel.grid(alpha=0.3)
    panels[0].legend(title="density scaling")
    figure.suptitle(f"One triaxial test at several density scalings: mean and range of {len(next(iter(runs.values())))} replicates", fontsize=10)
    figure.savefig(path, dpi=120)


if __name__ == "__main__":
    main()
