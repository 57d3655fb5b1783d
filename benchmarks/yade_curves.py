"""Make what tests/physics compare the engine with: packings by `graincal pack`, and YADE's steps and curves on them. Half a minute on one core.

    python benchmarks/yade_curves.py [--folder tests/data/yade] [--packings]

Needs an installed `yade`. Packings that are there are kept, unless --packings asks for new ones: preparation is chaotic in roundings, and a record belongs to its packing.
about.json has YADE's version, the checksums of the packings, and what was run.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import subprocess
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
SCRIPT = ROOT / "src" / "graincal" / "models" / "yade" / "triaxial_script.py"
STEPS = ROOT / "benchmarks" / "yade_steps.py"

PACKINGS = {"packing_200.csv": 200, "packing_300.csv": 300}
VOID_RATIO, SEED = 0.68, 3
RECORDS = {"steps_prescribed.npz": "prescribed", "steps_isotropic.npz": "isotropic"}
SCALINGS = (998, 999, 1000, 1001, 1002)
"""Of the density: replicates of one test that a chaotic shear leads apart."""

CURVES = {
    "low_pressure": (0.1e6, {"log_E": 8.72, "nu": 0.227, "phi": 28.1, "beta_m": 0.079, "eta_m": 0.569}),
    "high_pressure": (2e6, {"log_E": 9.2, "nu": 0.3, "phi": 20, "beta_m": 0.02, "eta_m": 0.2}),
}
"""Case -> confining pressure in Pa, and parameters."""

LAST, INCREMENT = 0.1, 0.004


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, default=ROOT / "tests" / "data" / "yade")
    parser.add_argument("--packings", action="store_true", help="new ones, where there are some")
    arguments = parser.parse_args()
    folder = arguments.folder
    folder.mkdir(parents=True, exist_ok=True)
    for name, particles in PACKINGS.items():
        if arguments.packings or not (folder / name).exists():
            (folder / name).unlink(missing_ok=True)
            run("graincal", "pack", "--particles", particles, "--void-ratio", VOID_RATIO, "--seed", SEED, "-o", folder / name)
    for name, kind in RECORDS.items():
        yade(STEPS, kind, folder / "packing_200.csv", folder / name)
    for case, (pressure, theta) in CURVES.items():
        for scaling in SCALINGS:
            parameters = [text for name, value in theta.items() for text in ("-p", f"{name}={value}")]
            test = [
                "--packing",
                folder / "packing_300.csv",
                "--confining-pressure",
                pressure,
                "--axial-strain",
                LAST,
                "--increment",
                INCREMENT,
                "--density-scaling",
                scaling,
                "--cell-inertia",
                "graincal",
            ]
            yade(SCRIPT, *test, *parameters, "-o", folder / f"{case}_{scaling}.csv")
    write_about(folder)


def yade(script: Path, *arguments: object) -> None:
    run("yade", "-n", "-x", "-j1", script, "--", *arguments)


def run(*command: object) -> None:
    subprocess.run([str(word) for word in command], check=True)


def write_about(folder: Path) -> None:
    with np.load(folder / "steps_prescribed.npz") as record:
        version = str(record["yade_version"])
    checksums = {name: hashlib.sha256((folder / name).read_bytes()).hexdigest() for name in PACKINGS}
    packings = {"grading": "toyoura", "void_ratio": VOID_RATIO, "seed": SEED, "sha256": checksums}
    curves = {case: {"confining_pressure": pressure, **theta} for case, (pressure, theta) in CURVES.items()}
    (folder / "about.json").write_text(
        json.dumps(
            {"program": f"YADE {version}", "made_by": "benchmarks/yade_curves.py", "packings": packings, "density_scalings": SCALINGS, "curves": curves},
            indent=2,
        )
        + "\n"
    )


if __name__ == "__main__":
    main()
