"""graincal explore."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from graincal.cli.options import Quiet, Workers


def explore(
    file: Annotated[Path, typer.Argument(help="A calibration file; its references may be missing, with --to.", metavar="calibration.toml")],
    output: Annotated[Path, typer.Option("--output", "-o", help="The library's folder; it must hold nothing yet.", metavar="LIBRARY")],
    runs: Annotated[
        int | None, typer.Option(min=2, help="How many runs; by default as many as a calibration fills the ranges with first.", metavar="N")
    ] = None,
    points: Annotated[Path | None, typer.Option(help="A CSV file of parameters to run instead, with a column for each by its name.", metavar="FILE")] = None,
    to: Annotated[
        float | None,
        typer.Option(help="The last control value that runs go to, such as the axial strain 0.25; by default that of each reference.", metavar="VALUE"),
    ] = None,
    workers: Workers = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Seed of the random draws, instead of that in the file.")] = None,
    quiet: Quiet = False,
) -> None:
    """Fill the ranges of parameters with runs, for no reference, or run parameters of your own: calibrations of the same models learn from them.

    Ctrl-C stops it, and graincal resume goes on with it.
    """
    from dataclasses import replace

    from graincal.campaign.asked.points import read_points
    from graincal.campaign.file.config import read_calibration
    from graincal.campaign.run.exploring import fill
    from graincal.cli.options import parse_workers
    from graincal.cli.running import fill_and_say
    from graincal.notation.console import PrintableConsole

    with PrintableConsole(stderr=True, quiet=quiet).status(f"reading {file} and what it names; a packing may have to be prepared first"):
        calibration = read_calibration(file, exploring=True, to=to)
    if workers is not None:
        calibration = replace(calibration, workers=parse_workers(workers))
    if seed is not None:
        calibration = replace(calibration, seed=seed)
    chosen = None if points is None else read_points(points, calibration.space)
    fill_and_say(output, lambda listeners: fill(calibration, output, runs, listeners, chosen), quiet=quiet)
