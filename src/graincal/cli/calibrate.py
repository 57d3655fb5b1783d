"""graincal calibrate."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from graincal.cli.options import Quiet, Workers


def calibrate(
    file: Annotated[Path, typer.Argument(help="The calibration file.", metavar="calibration.toml")],
    output: Annotated[Path, typer.Option("--output", "-o", help="The campaign's folder; it must hold none yet.", metavar="DIR")],
    workers: Workers = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Seed of the random draws, instead of that in the file.")] = None,
    max_evaluations: Annotated[
        str | None, typer.Option(help="Most evaluations, instead of the limit in the file: a number, or false for none.", metavar="N|false")
    ] = None,
    runs: Annotated[
        list[Path] | None,
        typer.Option(help="A campaign or a library of the same models to learn from, beside those in the file; may be repeated.", metavar="DIR"),
    ] = None,
    accept: Annotated[bool, typer.Option("--accept", help="Go on in spite of problems that graincal check finds; the report says so.")] = False,
    quiet: Quiet = False,
) -> None:
    """Calibrate: run a calibration file to its end, in a folder of its own.

    A file with open questions is refused, and one with problems unless they are accepted: graincal check says which there are.
    Ctrl-C stops it, and graincal resume goes on with it.
    """
    from dataclasses import replace

    from graincal.campaign import begin
    from graincal.campaign.run.continuing import with_criteria
    from graincal.cli.options import parse_criterion, parse_workers
    from graincal.cli.running import accepted, look_at, run_and_report

    calibration, problems = accepted(file, look_at(file, runs or (), quiet=quiet), accept=accept)
    if runs:
        calibration = replace(
            calibration, source=f"# Begun with {' '.join(f'--runs {each}' for each in runs)}, beside what stands below.\n{calibration.source}"
        )
    if workers is not None:
        calibration = replace(calibration, workers=parse_workers(workers))
    if seed is not None:
        look = replace(calibration.look, seed=seed) if calibration.look else None
        calibration = replace(calibration, seed=seed, look=look, source=f"# Begun with --seed {seed}, instead of the seed below.\n{calibration.source}")
    if max_evaluations is not None:
        calibration = with_criteria(calibration, {"max_evaluations": parse_criterion("max_evaluations", max_evaluations)})
        calibration = replace(calibration, source=f"# Begun with --max-evaluations {max_evaluations}, instead of the limit below.\n{calibration.source}")
    run_and_report(output, lambda listeners: begin(calibration, output, listeners, problems), quiet=quiet)
