"""What rows cost: memory and time of `graincal check` and of a calibration, and the time of a run, by the rows of the reference.

    python benchmarks/rows.py [--rows 100 1000 10000 40000] [--run-rows 10 50 500 2000] [--evaluations 60]

The reference is a drained triaxial test in closed form with two observables; the model is the built-in one on 300 particles that are prepared. `check` and `calibrate` (one worker) run as whole processes: seconds of wall time, and the largest resident memory. A run is timed by itself, with as many rows.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import graincal as gc
from graincal.dem.preparation import prepare

CALIBRATION = """
[parameters]
log_E = {{ range = [7.5, 9], unit = "log10 Pa" }}
phi   = {{ range = [15, 45], unit = "deg" }}
[[experiment]]
name        = "dense rows"
observables = {{ stress_ratio = {{ relative_error = 0.02, step = 0.01 }}, volumetric_strain = {{ measurement_error = 0.001, step = 0.0001 }} }}
reference   = {{ file = "rows.csv", strain = "logarithmic" }}
model       = {{ kind = "triaxial", particles = 300, void_ratio = 0.68, confining_pressure = 200e3, fixed = {{ nu = 0.2, beta_m = 0.1, eta_m = 0.3 }} }}
[stop]
posterior_shift = false
max_evaluations = {evaluations}
[run]
workers = 1
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=int, nargs="+", default=[100, 1000, 10_000, 40_000])
    parser.add_argument("--run-rows", type=int, nargs="+", default=[10, 50, 500, 2000])
    parser.add_argument("--evaluations", type=int, default=60)
    arguments = parser.parse_args()
    packing = prepare(300, 0.68)
    print(f"{'rows':>8}{'check: s':>12}{'MB':>8}{'calibration: s':>18}{'MB':>8}")
    for rows in arguments.rows:
        with tempfile.TemporaryDirectory() as folder:
            write_reference(Path(folder) / "rows.csv", rows)
            (Path(folder) / "calibration.toml").write_text(CALIBRATION.format(evaluations=arguments.evaluations))
            checked = measured(["check", "calibration.toml"], folder)
            calibrated = measured(["calibrate", "calibration.toml", "-o", "campaign", "--quiet"], folder)
        print(f"{rows:>8}{checked[0]:>12.1f}{checked[1]:>8.0f}{calibrated[0]:>18.1f}{calibrated[1]:>8.0f}", flush=True)
    print(f"\n{'rows':>8}{'a run: s':>12}{'steps':>10}")
    test = gc.TriaxialTest(packing, 200e3)
    for rows in arguments.run_rows:
        times = []
        for _ in range(5):
            start = time.perf_counter()
            (response,) = test.simulate([[8.2, 0.2, 30, 0.1, 0.3]], at=np.linspace(0, 0.2, rows), threads=1)
            times.append(time.perf_counter() - start)
        print(f"{rows:>8}{sorted(times)[2]:>12.2f}{response.details['steps']:>10}", flush=True)


def write_reference(path: Path, rows: int) -> None:
    strain = np.linspace(0, 0.2, rows)
    ratio = 1 + 2.8 * strain / (0.008 + strain) - 3 * strain**2 / (0.1 + strain)
    volume = 0.2 * strain / (1 + 40 * strain) - 0.5 * strain**2 / (0.05 + strain)
    rng = np.random.default_rng(1)
    columns = np.column_stack([strain, ratio + 0.01 * rng.standard_normal(rows) * (strain > 0), volume + 1e-4 * rng.standard_normal(rows)])
    np.savetxt(path, columns, delimiter=",", header="axial_strain [-],stress_ratio [-],volumetric_strain [-]", comments="", fmt="%.7g")


def measured(words: list[str], folder: str) -> tuple[float, float]:
    """Wall time in s, and the largest resident memory in MB."""
    start = time.perf_counter()
    process = subprocess.Popen([Path(sys.executable).with_name("graincal"), *words], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    said = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise SystemExit(f"graincal {' '.join(words)} ended with {os.waitstatus_to_exitcode(status)}:\n{said}")
    return time.perf_counter() - start, usage.ru_maxrss / (1024**2 if sys.platform == "darwin" else 1024)


if __name__ == "__main__":
    main()
