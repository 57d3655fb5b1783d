"""The engine's speed: particle-steps per second of the drained triaxial test, by number of particles and of threads.

    python benchmarks/engine.py [--packing packing.csv ...] [--yade]

Packings not named are prepared (Toyoura grading, void ratio 0.68) and cached. With --yade, where Debian's package `yade` is installed, the same test
runs in both on one thread each, in turn, three times: the ratio is that of the medians.
"""

from __future__ import annotations

import argparse
import csv
import json
import shutil
import statistics
import subprocess
import tempfile
from pathlib import Path

import numpy as np

import graincal as gc
from graincal import _native
from graincal.dem.preparation import prepare

THETA = {"log_E": 8.72, "nu": 0.227, "phi": 28.1, "beta_m": 0.079, "eta_m": 0.569}
CONFINING_PRESSURE = 0.5e6
INCREMENT = 0.004


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--packing", action="append", default=[], help="a packing file; may be repeated")
    parser.add_argument("--particles", type=int, nargs="*", default=[500, 1000, 2000], help="packings to prepare where no file is named")
    parser.add_argument("--axial-strain", type=float, default=0.02, help="the last strain of the test (default: %(default)s)")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--yade", action="store_true", help="compare with YADE, in turn")
    arguments = parser.parse_args()

    packings = [gc.Packing.read(path) for path in arguments.packing] or [prepare(particles=n, void_ratio=0.68) for n in arguments.particles]
    at = np.arange(0.0, arguments.axial_strain + 1e-9, INCREMENT)
    print(f"graincal {gc.__version__}, {_native.compiler}, {_native.instruction_set}; drained triaxial test to {at[-1]:.1%} of axial strain, Θ = {THETA}")
    print(f"median of {arguments.repeats}, million particle-steps a second and thread")
    print(f"{'particles':>10}{'threads':>9}{'steps':>9}{'contacts/particle':>19}{'graincal':>10}" + ("YADE".rjust(8) + "ratio".rjust(8) if arguments.yade else ""))
    for packing in packings:
        for threads in (1, 2):
            compare = arguments.yade and threads == 1
            ours, theirs = [], []
            for _ in range(arguments.repeats):
                response, rate = measure(packing, at, threads)
                ours.append(rate)
                if compare:
                    theirs.append(measure_yade(packing, at))
            contacts = response.values["contacts"].mean() / packing.count
            row = f"{packing.count:>10}{threads:>9}{response.details['steps']:>9}{contacts:>19.2f}{statistics.median(ours):>10.2f}"
            if compare:
                row += f"{statistics.median(theirs):>8.2f}{statistics.median(ours) / statistics.median(theirs):>8.1f}"
            print(row, flush=True)


def measure(packing: gc.Packing, at: np.ndarray, threads: int) -> tuple[gc.Response, float]:
    """One run a thread: a response, and million particle-steps a second and thread."""
    test = gc.TriaxialTest(packing, CONFINING_PRESSURE)
    outcomes = test.simulate([list(THETA.values())] * threads, at=at, threads=threads)
    rates = [outcome.details["particle_steps"] / outcome.details["seconds"] / 1e6 for outcome in outcomes]
    return outcomes[0], float(np.mean(rates))


def measure_yade(packing: gc.Packing, at: np.ndarray) -> float:
    """Million particle-steps a second of YADE on one thread, in the same test."""
    if shutil.which("yade") is None:
        raise SystemExit("YADE is not installed: 'apt-get install yade' on Debian and Ubuntu.")
    with tempfile.TemporaryDirectory() as folder:
        packing_file, curve_file = Path(folder) / "packing.csv", Path(folder) / "curve.csv"
        packing.write(packing_file)
        command = ["yade", "-n", "-x", "-j1", str(Path(__file__).with_name("yade_triaxial.py")), "--", "--packing", str(packing_file)]
        command += ["--confining-pressure", str(CONFINING_PRESSURE), "--axial-strain", str(at[-1]), "--increment", str(INCREMENT), "-o", str(curve_file)]
        for name, value in THETA.items():
            command += ["-p", f"{name}={value}"]
        ended = subprocess.run(command, capture_output=True, text=True)
        if ended.returncode:
            raise SystemExit(f"YADE ended with {ended.returncode}:\n{ended.stderr}")
        about, *table = curve_file.read_text().splitlines()
    seconds = json.loads(about.removeprefix("#"))["seconds"]
    return packing.count * float(list(csv.DictReader(table))[-1]["steps"]) / seconds / 1e6


if __name__ == "__main__":
    main()
