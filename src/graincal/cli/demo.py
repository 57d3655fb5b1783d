"""graincal demo."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Annotated

import typer

from graincal.cli.options import Quiet, SomeWorkers

_FOLDER = "graincal-demo"


def demo(
    output: Annotated[Path | None, typer.Option("--output", "-o", help="The campaign's folder; graincal-demo, or the next free name.", metavar="DIR")] = None,
    workers: SomeWorkers = "all",
    quiet: Quiet = False,
) -> None:
    """A whole calibration on an embedded default, with its report: about two minutes on two cores.

    A synthetic triaxial test at known parameters, on another packing, is calibrated as if it were measured: 500 particles, all five parameters over their full ranges.
    """
    from graincal import demo as example
    from graincal.campaign import begin
    from graincal.campaign.run.running import REPORT
    from graincal.cli.chart import chart
    from graincal.cli.options import parse_workers
    from graincal.cli.running import run
    from graincal.notation.console import PrintableConsole

    console = PrintableConsole(highlight=False, markup=False, quiet=quiet)
    number = parse_workers(workers)
    folder = output or _free_folder()
    if output is None and folder.name != _FOLDER:
        console.print(f"{_FOLDER} is there already, so this demo goes into {folder}.")
    grains = example.packing()
    reference = example.reference(example.sibling())
    calibration = example.calibration(grains, reference, workers=number)
    console.print(f"A triaxial test of {grains.count} particles at {example.CONFINING_PRESSURE / 1e6:g} MPa, and one simulation in the middle of the ranges:\n")
    guess = example.first_curve(grains)
    for name, title in (("stress_ratio", "stress ratio [-]"), ("volumetric_strain", "volumetric strain [%]")):
        scale = 100 if name == "volumetric_strain" else 1
        curves = {"reference": scale * reference.observables[name], "simulation": scale * guess.values[name]}
        console.print(chart(100 * reference.control, curves, title=title))
    console.print(f"{'axial strain [%]':>40}\n")
    result = run(folder, lambda listeners: begin(calibration, folder, listeners), quiet=quiet)
    assert result is not None, "no run of a demo waits for somebody"
    console.print("The truth is what the reference was simulated with: a curve is fitted by more than one set of parameters.")
    console.print(f"Report: {result.report(folder / REPORT)}")


def _free_folder() -> Path:
    names = itertools.chain([_FOLDER], (f"{_FOLDER}-{number}" for number in itertools.count(2)))
    return next(path for path in map(Path, names) if not path.exists())
