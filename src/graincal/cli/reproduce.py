"""graincal reproduce."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from graincal.cli.options import Quiet, Workers
from graincal.cli.saying import say

PUBLICATIONS = ("hartmann2022",)


def reproduce(
    publication: Annotated[str, typer.Argument(help="hartmann2022: Hartmann, Cheng, Thornton (2022), Computers and Geotechnics 141.", metavar="PUBLICATION")],
    output: Annotated[Path, typer.Option("--output", "-o", help="The folder for all that is run, the tables, the figures and the page.", metavar="DIR")],
    study: Annotated[list[str] | None, typer.Option(help="One of the studies, by its name; may be repeated. All of them by default.", metavar="NAME")] = None,
    data: Annotated[
        Path, typer.Option(help="The folder of packings and measured curves, packing_2000.csv, synthetic_reference.csv, ...", metavar="DIR")
    ] = Path(),
    seeds: Annotated[int, typer.Option(min=1, help="Seeds of calibrations in studies that take at most an hour a seed.", metavar="N")] = 3,
    seeds_of_long: Annotated[int, typer.Option("--seeds-of-long", min=1, help="Seeds of calibrations in the other studies.", metavar="N")] = 1,
    workers: Workers = None,
    large: Annotated[bool, typer.Option("--large", help="Run the packing of 27,000 particles too, which takes half a day.")] = False,
    quick: Annotated[
        bool, typer.Option("--quick", help="A rehearsal on a packing of 200 spheres, with few samples: minutes, and no number that compares with the paper's.")
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Repeat the studies of a publication, and show the results beside the printed ones.

    The page of results is DIR/index.html. Ctrl-C stops it, and the same command goes on with it. Whatever needs a file that the data folder lacks is skipped, and the page says so.
    """
    import sys

    from graincal.campaign.run.progress import Progress
    from graincal.cli.options import parse_workers
    from graincal.data import InputError
    from graincal.notation.console import PrintableConsole
    from graincal.studies.hartmann2022 import STUDIES, TITLE
    from graincal.studies.running import Reproduction
    from graincal.studies.settings import PAPER, QUICK, Setup
    from graincal.suggestion import did_you_mean

    if publication not in PUBLICATIONS:
        raise InputError(
            f"{publication} is not among the publications that can be repeated, {', '.join(PUBLICATIONS)}{did_you_mean(publication, PUBLICATIONS)}."
        )
    for name in study or ():
        if name not in STUDIES:
            raise InputError(f"--study {name} is none of the studies{did_you_mean(name, tuple(STUDIES))}; expected some of {', '.join(STUDIES)}.")
    if not data.is_dir():
        raise InputError(f"--data {data}: there is no such folder.")
    chosen = [each for name, each in STUDIES.items() if not study or name in study]
    setup = Setup(data, seeds, seeds_of_long, large, QUICK if quick else PAPER, parse_workers(workers) if workers else "all")
    console = PrintableConsole(highlight=False, markup=False, quiet=quiet, width=None if sys.stdout.isatty() else 120)
    try:
        with Progress(console) as progress:
            # Without a terminal each iteration would be a line, of thousands.
            reproduction = Reproduction(chosen, setup, output, TITLE, console.sentences, [progress] if console.is_terminal else [])
            reproduction.run()
    except KeyboardInterrupt:
        say(f"Stopped. All that was finished is stored; the same command goes on with it, in {shlex.quote(str(output))}.", err=True)
        raise
    console.print(f"Written: {output / 'index.html'}", soft_wrap=True)
    if reproduction.broken:
        raise typer.Exit(1)
