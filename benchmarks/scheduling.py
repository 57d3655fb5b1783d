"""What the scheduler and the store cost: evaluations of a function, or of a program, that takes 1 ms, without a filter.

    python benchmarks/scheduling.py [--runs 1000 10000] [--workers 2] [--where threads processes command parsl]

Each line is a library of runs (`graincal explore`) in a process of its own: milliseconds of wall time for each evaluation, from the first outcome that is stored to the last, and the largest resident memory of the process that controls it.
By Parsl: its local provider, with as many cores as workers (pip install '.[cluster]').
"""

from __future__ import annotations

import argparse
import resource
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np

import graincal as gc
from graincal.campaign import Listener
from graincal.campaign.asked.calibration import Calibration
from graincal.campaign.asked.experiment import no_reference
from graincal.campaign.asked.place import Place
from graincal.campaign.run.exploring import fill
from graincal.models.output import Column, Output

AT = np.linspace(0.01, 0.2, 20)
SPACE = gc.ParameterSpace({"a": (0, 1), "b": (0, 1)})


def takes_a_millisecond(theta):
    until = time.perf_counter() + 1e-3
    while time.perf_counter() < until:
        time.sleep(2e-4)
    return {"stress_ratio": 1 + theta[0] * AT, "volumetric_strain": theta[1] * AT}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, nargs="+", default=[1000, 10000])
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--where", nargs="+", choices=("threads", "processes", "command", "parsl"), default=["threads", "processes", "command"])
    arguments = parser.parse_args()
    print(f"{'':12}{'runs':>8}{'ms each':>10}{'MB':>8}")
    for where in arguments.where:
        for runs in arguments.runs:
            with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
                seconds, memory = pool.submit(library, where, runs, arguments.workers).result()
            print(f"{where:12}{runs:>8}{1000 * seconds / (runs - 1):>10.2f}{memory:>8.0f}", flush=True)


class Clock(Listener):
    """When the first and the last outcome were stored."""

    first = last = 0.0

    def evaluated(self, *_):
        self.last = time.perf_counter()
        self.first = self.first or self.last


def a_function(where: str) -> gc.PythonModel:
    if where == "threads":
        return gc.PythonModel(takes_a_millisecond)
    return gc.PythonModel("scheduling:takes_a_millisecond", folder=Path(__file__).parent)


def a_program(folder: Path) -> gc.CommandModel:
    """A shell that sleeps for a millisecond and prints a table of its own, whose numbers are filled in."""
    rows = "".join(f"{strain!r},{{{{ 1 + a * {strain!r} }}}},{{{{ b * {strain!r} }}}}\n" for strain in AT.tolist())
    (folder / "table").write_text(f"axial_strain,stress_ratio,volumetric_strain\n{rows}")
    columns = {name: Column(name) for name in ("axial_strain", "stress_ratio", "volumetric_strain")}
    return gc.CommandModel(("sh", "-c", "sleep 0.001; cat table"), Output(columns), templates={"table": "table"}, folder=folder)


def library(where: str, runs: int, workers: int) -> tuple[float, float]:
    """Wall time, s, and memory, MB."""
    place = Place("parsl", {"provider": "local", "cores_per_node": workers}) if where == "parsl" else None
    clock = Clock()
    with tempfile.TemporaryDirectory() as folder:
        model = a_program(Path(folder)) if where == "command" else a_function(where)
        calibration = Calibration(
            SPACE, [gc.Experiment("experiment", model, no_reference(model, AT, ("stress_ratio", "volumetric_strain")))], workers=workers, place=place
        )
        # Imports and the first processes are not what is measured.
        fill(calibration, Path(folder) / "library", runs, [clock])
        return clock.last - clock.first, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


if __name__ == "__main__":
    sys.exit(main())
