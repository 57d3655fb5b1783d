"""The engine's speed in the drained triaxial test, in particle-steps per second; how it is spent, how far it is from what the machine can do; and beside YADE.

    python benchmarks/engine.py [--packing FILE | --particles 1000 2000 ...] [--axial-strain 0.02] [--yade]

Packings are prepared by `graincal pack`'s protocol and kept in its cache; those of more than 2,000 particles are periodic repetitions of a smaller one, eight or
twenty-seven times, for preparation takes half a minute a thousand particles. A copy of a packing beside itself moves like it, but for roundings: the work of
a step is that of a packing of its size, the path of the test that of the smaller one. With one thread one run is timed, with two threads two runs side by side.
With --yade, both programs run the same test in turn, each as a whole process on one thread, from the packing's file to the curve's: `graincal simulate` by its default
accuracy and by the reference's, and YADE, all with the density that the default inertial number means there.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Sequence
from dataclasses import astuple, dataclass
from pathlib import Path

import numpy as np

import graincal as gc
from graincal import _native
from graincal.dem.preparation import prepare
from graincal.models.economy import ACCURACIES, DENSITY, PRECISIONS
from graincal.models.proportion import ENGINE_PRESSURE, for_engine
from graincal.models.yade.model import TRIAXIAL_SCRIPT

THETA = {"log_E": 8.72, "nu": 0.227, "phi": 28.1, "beta_m": 0.079, "eta_m": 0.569}
CONFINING_PRESSURE = 0.5e6
INCREMENT = 0.004
VOID_RATIO = 0.68
LARGEST_PREPARED = 2000
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--packing", action="append", default=[], help="a packing file; may be repeated")
    parser.add_argument("--particles", type=int, nargs="*", default=[1000, 2000, 5000, 10000, 27000], help="packings to make where no file is named")
    parser.add_argument("--axial-strain", type=float, default=0.02, help="the last strain of the test (default: %(default)s)")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--precision", choices=PRECISIONS, nargs="*", default=PRECISIONS)
    parser.add_argument("--yade", action="store_true", help="compare with YADE instead")
    arguments = parser.parse_args()

    at = np.arange(0.0, arguments.axial_strain + 1e-9, INCREMENT)
    print(f"graincal {gc.__version__}, {_native.compiler}, {_native.instruction_set}; drained triaxial test to {at[-1]:.1%} of axial strain, Θ = {THETA}")
    packings = list(_packings(arguments.packing, arguments.particles))
    if arguments.yade:
        print_comparison(packings, at, arguments.repeats)
        return
    print_rates(packings, at, arguments.repeats, arguments.precision)
    print_passes(packings, at, arguments.precision)
    print_limits(packings, at, arguments.precision)


def _packings(files: Sequence[str], sizes: Sequence[int]) -> Iterable[tuple[gc.Packing, str]]:
    """Each packing, and how it was made."""
    if files:
        yield from ((gc.Packing.read(path), "read") for path in files)
        return
    for size in sizes:
        times = next((times for times in (1, 2, 3, 4, 5) if size % times**3 == 0 and size // times**3 <= LARGEST_PREPARED), None)
        if times is None:
            raise SystemExit(
                f"--particles {size}: above {LARGEST_PREPARED}, a multiple of 8, 27, 64 or 125 was expected, for it is repeated from a smaller packing."
            )
        packing = prepare(particles=size // times**3, void_ratio=VOID_RATIO)
        yield (packing, "prepared") if times == 1 else (repeated(packing, times), f"{packing.count} x {times}^3")


def repeated(packing: gc.Packing, times: int) -> gc.Packing:
    """The packing beside itself so many times along each of its edges."""
    offsets = np.stack(np.meshgrid(*[np.arange(times)] * 3, indexing="ij"), axis=-1).reshape(-1, 1, 3) @ packing.edges.T
    return gc.Packing((packing.positions + offsets).reshape(-1, 3), np.tile(packing.radii, times**3), times * packing.edges)


@dataclass(frozen=True)
class Measured:
    """One run as a whole process: its seconds of processor time, those of wall time that the engine alone says it took, and its steps."""

    processor: float
    engine: float
    steps: int


def measure(packing: gc.Packing, at: np.ndarray, precision: str, threads: int = 1) -> tuple[gc.Response, float]:
    """One run a thread: the first one's response, and million particle-steps a second of all together."""
    test = _test(packing, precision)
    start = time.perf_counter()
    outcomes = test.simulate([list(THETA.values())] * threads, at=at, threads=threads)
    seconds = time.perf_counter() - start
    return outcomes[0], sum(outcome.details["particle_steps"] for outcome in outcomes) / seconds / 1e6


def _test(packing: gc.Packing, precision: str) -> gc.TriaxialTest:
    """The paper's protocol, whose steps are counted, in either precision."""
    return gc.TriaxialTest(packing, CONFINING_PRESSURE, accuracy="reference", precision=precision)


def print_rates(packings: Sequence[tuple[gc.Packing, str]], at: np.ndarray, repeats: int, precisions: Sequence[str]) -> None:
    """Speed by size, threads and precision."""
    print(f"\nMillion particle-steps a second, all threads together, median of {repeats}")
    print(
        f"{'particles':>10}  {'packing':14}{'precision':>10}{'steps':>9}{'contacts/particle':>19}"
        + "".join(f"{f'{threads} thread(s)':>13}" for threads in (1, 2))
    )
    for packing, made in packings:
        for precision in precisions:
            rates = {}
            for threads in (1, 2):
                runs = [measure(packing, at, precision, threads) for _ in range(repeats)]
                rates[threads] = statistics.median(rate for _, rate in runs)
            response = runs[0][0]
            contacts = response.values["contacts"].mean() / packing.count
            row = f"{packing.count:>10}  {made:14}{precision:>10}{response.details['steps']:>9}{contacts:>19.2f}"
            print(row + "".join(f"{rate:>13.2f}" for rate in rates.values()), flush=True)


def time_passes(packing: gc.Packing, at: np.ndarray, precision: str) -> dict:
    """What `_native.time_passes` says of the test."""
    test = _test(packing, precision)
    modulus, density = (float(for_engine(value, CONFINING_PRESSURE)) for value in (10 ** THETA["log_E"], DENSITY * test.scaling))
    law = _native.LinearLaw(modulus, THETA["nu"], np.tan(np.radians(THETA["phi"])), THETA["beta_m"], THETA["eta_m"])
    held = _native.Packing(packing.positions, packing.radii, packing.edges)
    return _native.time_passes(held, law, density, test.stages(ENGINE_PRESSURE, test.states(at)), precision=precision)


def print_passes(packings: Sequence[tuple[gc.Packing, str]], at: np.ndarray, precisions: Sequence[str]) -> None:
    """Where the time of a run goes: of the processor, so that whatever else the machine does counts by its caches alone."""
    print(
        "\nMillion particle-steps a second of the processor's time, share of it in each pass of the steps, percent, and steps between two rebuilds of each list"
    )
    for n, (packing, precision) in enumerate((packing, precision) for packing, _ in packings for precision in precisions):
        timed = time_passes(packing, at, precision)
        whole = sum(timed["seconds"].values())
        if n == 0:
            print(
                f"{'particles':>10}{'precision':>10}{'Mp.-s./s':>10}"
                + "".join(f"{name:>12}" for name in timed["seconds"])
                + f"{'near every':>12}{'outer every':>13}"
            )
        rate = packing.count * timed["steps"] / whole / 1e6
        row = f"{packing.count:>10}{precision:>10}{rate:>10.1f}" + "".join(f"{100 * seconds / whole:>12.1f}" for seconds in timed["seconds"].values())
        print(row + f"{timed['steps'] / timed['near_rebuilds']:>12.0f}{timed['steps'] / timed['outer_rebuilds']:>13.0f}", flush=True)


# Counted by hand from native/graincal/forces.hpp, linear_law.hpp, contact.hpp, motion.hpp and native/cpu/serial_team.hpp, in a cell that stretches along its axes:
# the two passes of every step, forces and motion; the look at the bound on the stiffnesses is timed with the estimates of the time step. Additions,
# multiplications, divisions, roots and roundings count as one operation each; comparisons, minima and maxima are not counted. Bytes are those of loads and
# stores of arrays that outlast the pass, whichever cache they come from.
#
# A pair: branch and overlap 20, relative velocity and normal 19, stiffness and normal force 8, the three memories carried, advanced and capped 200, force and
# moments 45, stiffnesses in translation and rotation 9, sums 19. A particle: two damped accelerations 42, position 18, speed 5.
OPERATIONS_PER_PAIR, OPERATIONS_PER_PARTICLE = 320, 65


def bytes_per_pair(size: int) -> int:
    """Two indices, two particles' lines, the contact's overlap and four vectors in and out, two records of eight numbers in and out."""
    return 8 + 2 * (32 + 8 * size) + 2 * 13 * size + 2 * 2 * 8 * size


def bytes_per_particle(size: int) -> int:
    """A line written from fractional coordinates, radius and motion; a record cleared; load, motion and masses in, motion and coordinates in and out, speeds in."""
    return (32 + 6 * size) + (32 + 8 * size) + 8 * size + (8 + 2 + 6) * size + 24 + 6 * size + 24 + 3 * size


def print_limits(packings: Sequence[tuple[gc.Packing, str]], at: np.ndarray, precisions: Sequence[str]) -> None:
    """What a step moves and computes in a second, against what the machine can: one thread."""
    far = _native.triad_rate(400_000_000)
    print("\nThe two passes of every step, forces and motion, against the machine's limits, one thread")
    print(
        f"memory: {far / 1e9:.1f} GB/s (triad over 400 MB); computing: " + ", ".join(f"{_native.arithmetic_rate(p) / 1e9:.1f} G/s in {p}" for p in precisions)
    )
    print("(independent multiplications and additions, not contracted, in the widest vectors of the instruction set)")
    print(
        f"{'particles':>10}{'precision':>10}{'pairs/part.':>12}{'bytes/p.-step':>15}{'GB/s':>8}{'held, MB':>10}{'triad there':>13}{'share':>7}"
        f"{'flops/p.-step':>15}{'Gflop/s':>9}{'share':>7}"
    )
    for packing, precision in ((packing, precision) for packing, _ in packings for precision in precisions):
        timed = time_passes(packing, at, precision)
        size = np.dtype(precision).itemsize
        pairs = timed["near_pairs"] / packing.count
        per_second = packing.count * timed["steps"] / (timed["seconds"]["forces"] + timed["seconds"]["motion"])
        moved = bytes_per_particle(size) + pairs * bytes_per_pair(size)
        done = OPERATIONS_PER_PARTICLE + pairs * OPERATIONS_PER_PAIR
        # What both passes touch, each array once: coordinates and radius, motion and masses, record, line; indices and contacts.
        held = packing.count * (32 + 8 * size + 8 * size + (32 + 8 * size) + pairs * (8 + 13 * size))
        near = _native.triad_rate(int(held))
        print(
            f"{packing.count:>10}{precision:>10}{pairs:>12.2f}{moved:>15.0f}{moved * per_second / 1e9:>8.1f}{held / 1e6:>10.2f}{near / 1e9:>13.1f}"
            f"{moved * per_second / near:>7.0%}{done:>15.0f}{done * per_second / 1e9:>9.1f}{done * per_second / _native.arithmetic_rate(precision):>7.0%}",
            flush=True,
        )


def measure_process(command: Sequence[str | Path]) -> float:
    """The seconds of processor time that a program takes on one thread."""
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=os.environ | dict.fromkeys(THREADS, "1"))
    said = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise SystemExit(f"{command[0]} ended with {os.waitstatus_to_exitcode(status)}:\n{said}")
    return usage.ru_utime + usage.ru_stime


def measure_yade(packing: Path, scaling: float, at: np.ndarray) -> Measured:
    """The same test by YADE."""
    if shutil.which("yade") is None:
        raise SystemExit("YADE is not installed: 'apt-get install yade' on Debian and Ubuntu.")
    curve = packing.with_name("yade.csv")
    command = ["yade", "-n", "-x", "-j1", str(TRIAXIAL_SCRIPT), "--", "--packing", str(packing), "--cell-inertia", "graincal"]
    command += ["--confining-pressure", str(CONFINING_PRESSURE), "--axial-strain", str(at[-1]), "--increment", str(INCREMENT)]
    command += ["--density-scaling", str(scaling), "-o", str(curve), *_parameters()]
    seconds = measure_process(command)
    about, *table = curve.read_text().splitlines()
    return Measured(seconds, json.loads(about.removeprefix("#"))["seconds"], int(float(list(csv.DictReader(table))[-1]["steps"])))


def measure_graincal(packing: Path, accuracy: str, at: np.ndarray) -> Measured:
    """`graincal simulate`, and once more from Python what the engine alone takes."""
    curve = packing.with_name("graincal.csv")
    curve.unlink(missing_ok=True)
    command = [
        Path(sys.executable).with_name("graincal"),
        "simulate",
        "triaxial",
        "--packing",
        packing,
        "--confining-pressure",
        str(CONFINING_PRESSURE),
        "--accuracy",
        accuracy,
    ]
    command += ["--axial-strain", str(at[-1]), "--increment", str(INCREMENT), "--quiet", "-o", curve, *_parameters()]
    seconds = measure_process(command)
    test = gc.TriaxialTest(gc.Packing.read(packing), CONFINING_PRESSURE, accuracy=accuracy)
    (response,) = test.simulate([list(THETA.values())], at=at, threads=1)
    return Measured(seconds, response.details["seconds"], response.details["steps"])


def _parameters() -> list[str]:
    return [word for name, value in THETA.items() for word in ("-p", f"{name}={value}")]


def print_comparison(packings: Sequence[tuple[gc.Packing, str]], at: np.ndarray, repeats: int) -> None:
    """graincal and YADE in turn, on one thread each."""
    print(
        f"\ngraincal and YADE in turn, {repeats} times, one thread each: medians, of whole processes in s of the processor, of the engines alone in s, and of steps"
    )
    print(f"{'particles':>10}{'accuracy':>12}{'process':>10}{'YADE':>9}{'times':>8}{'engine':>10}{'YADE':>9}{'times':>8}{'steps':>9}{'YADE':>9}{'share':>7}")
    for packing, _ in packings:
        ours = {accuracy: [] for accuracy in ACCURACIES}
        theirs = []
        scaling = gc.TriaxialTest(packing, CONFINING_PRESSURE).scaling
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "packing.csv"
            packing.write(file)
            for _ in range(repeats):
                for accuracy in ACCURACIES:
                    ours[accuracy].append(measure_graincal(file, accuracy, at))
                theirs.append(measure_yade(file, scaling, at))
        for accuracy in ACCURACIES:
            (process, engine, steps), (yade_process, yade_engine, yade_steps) = (_medians(runs) for runs in (ours[accuracy], theirs))
            print(
                f"{packing.count:>10}{accuracy:>12}{process:>10.2f}{yade_process:>9.1f}{yade_process / process:>8.1f}{engine:>10.2f}{yade_engine:>9.1f}{yade_engine / engine:>8.1f}"
                f"{steps:>9.0f}{yade_steps:>9.0f}{steps / yade_steps:>7.2f}",
                flush=True,
            )


def _medians(runs: Sequence[Measured]) -> tuple[float, float, float]:
    """Processor time of the process, time of the engine, and steps."""
    return tuple(statistics.median(values) for values in zip(*map(astuple, runs)))


if __name__ == "__main__":
    main()
