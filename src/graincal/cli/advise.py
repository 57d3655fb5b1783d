"""graincal advise."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from graincal.cli.options import Folder, Quiet, SomeWorkers, parse_workers
from graincal.cli.saying import say
from graincal.data import InputError
from graincal.notation.printable import printable_json

if TYPE_CHECKING:
    from graincal.campaign import Advice


def advise(
    folder: Folder,
    test: Annotated[
        list[str] | None,
        typer.Option(
            help='A test to look at, as often as wanted: a kind, and behind it, if wanted, "extension", a confining pressure in Pa, and "to" the last strain or stress: "triaxial 1e6 to 0.1". Seven usual ones by default.',
            metavar="TEST",
        ),
    ] = None,
    tests: Annotated[
        Path | None, typer.Option(help="A calibration file whose experiments are tests to look at, too; their references may be missing.", metavar="FILE")
    ] = None,
    samples: Annotated[int, typer.Option(help="Draws from the posterior, at which each test is run; 60 or more.")] = 100,
    workers: SomeWorkers = "all",
    seed: Annotated[int, typer.Option(min=0, help="Seed of the random draws.")] = 1,
    as_json: Annotated[bool, typer.Option("--json", help="For programs: every figure, as one JSON document.")] = False,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="The table as CSV; nothing is overwritten.", metavar="FILE")] = None,
    plot: Annotated[Path | None, typer.Option(help="Draw the table to this file (.png, .pdf, .svg); nothing is overwritten.", metavar="FILE")] = None,
    quiet: Quiet = False,
) -> None:
    """Say which further laboratory test would narrow the parameters most, by the posterior of a campaign.

    Each test is run at draws from the posterior, and its runs are kept in the campaign's folder. After Ctrl-C the same command goes on.
    """
    from graincal.campaign.run.advising import ADVICE
    from graincal.campaign.run.advising import advise as advise_tests
    from graincal.campaign.run.progress import Progress
    from graincal.cli.outputs import check_outputs
    from graincal.notation.console import PrintableConsole
    from graincal.result import Result

    at_once = parse_workers(workers)
    check_outputs(output, plot)
    result = Result.read(folder)
    chosen = [*(test or ()), *_of_file(tests)] or None
    # Beside a document for programs, what people read goes elsewhere.
    console = PrintableConsole(stderr=True, highlight=False, markup=False, quiet=quiet)
    try:
        with Progress(console) as progress:
            advice = advise_tests(result, chosen, samples=samples, seed=seed, workers=at_once, listeners=[progress])
    except KeyboardInterrupt:
        if (folder / ADVICE).exists():
            say("Stopped. All that was finished is stored; the same command goes on.", err=True)
        raise
    if output:
        _write(advice, output)
    if plot:
        from graincal.cli.advice_figure import draw_advice

        draw_advice(advice, plot)
    if as_json:
        say(printable_json(advice.as_json(), indent=2), prose=False)
        return
    if quiet:
        return
    _say(advice)
    for target in (output, plot):
        if target is not None:
            say(f"Written to {target}.")


def _of_file(path: Path | None) -> list:
    if path is None:
        return []
    from graincal.campaign.run.candidate_files import candidate_tests

    return candidate_tests(path)


def _say(advice: Advice) -> None:
    """The table, and what to bear in mind."""
    import sys

    from rich.table import Table

    from graincal.notation import numbers, quantities
    from graincal.notation.console import PrintableConsole
    from graincal.notation.markup import to_plain
    from graincal.notation.words import listed

    console = PrintableConsole(highlight=False, markup=False, width=None if sys.stdout.isatty() else 160)
    labels = quantities.parameters(advice.space)
    table = Table("test", "gain [nats]", "failed", *(to_plain(label.axis) for label in labels), box=None, header_style="bold", padding=(0, 2, 0, 0))
    table.add_row("now", "", "", *(numbers.value(sd, 2) for sd in advice.deviations))
    for each in advice.tests:
        narrowed = [f"{numbers.value(sd, 2)} ({share:.0%})" for sd, share in zip(advice.expected_deviations(each), each.shares)]
        table.add_row(each.name, to_plain(numbers.estimate(each.information, each.information_error)), f"{len(each.failures)} of {each.runs}", *narrowed)
    console.print(table)
    console.sentences(
        "Each parameter: its standard deviation, now and as it may be expected after the test, in brackets as a part of that now. The gain is the expected information, ± its standard error."
    )
    for one in advice.tests:
        if others := [other.name for first, other in advice.alike() if first is one]:
            console.sentences(
                f"{one.name} cannot be told apart from {listed(others)}: {'their gains differ' if len(others) == 1 else 'its gain differs from theirs'} by less than two standard errors."
            )
    for name, why in advice.not_judged.items():
        console.sentences(f"{name} was not judged: {why}")
    for remark in advice.remarks:
        console.sentences(remark)


def _write(advice: Advice, path: Path) -> None:
    """A row for each test, and one before them for now."""
    import csv

    from graincal.files import unwritable

    names = [f"{name} [{unit}]" if unit else name for name, unit in zip(advice.space.names, advice.space.units)]
    head = ["test", "gain [nats]", "standard error [nats]", "runs", "failures"]
    head += [
        column for name in names for column in (f"sd of {name}", f"sd of {name.partition(' [')[0]} over now", f"its standard error, {name.partition(' [')[0]}")
    ]
    rows = [["now", "", "", "", "", *(cell for sd in advice.deviations for cell in (f"{sd:.6g}", "1", ""))]]
    for each in advice.tests:
        figures = zip(advice.expected_deviations(each), each.shares, each.share_errors)
        rows.append(
            [
                each.name,
                f"{each.information:.6g}",
                f"{each.information_error:.3g}",
                str(each.runs),
                str(len(each.failures)),
                *(f"{value:.6g}" for figure in figures for value in figure),
            ]
        )
    try:
        with path.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([head, *rows])
    except OSError as error:
        raise InputError(unwritable(path, error)) from None
