"""graincal report."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from graincal.cli.options import Folder
from graincal.cli.saying import say


def report(
    folder: Folder,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="The file to write, instead of report.html in the folder; nothing else is overwritten.", metavar="FILE"),
    ] = None,
    figures: Annotated[
        list[str] | None,
        typer.Option(
            help="Write its figures too, into DIR/figures, in this format: png, pdf, svg; may be repeated. Those of an earlier report are replaced.",
            metavar="FORMAT",
        ),
    ] = None,
    prediction: Annotated[
        bool,
        typer.Option(
            "--prediction/--no-prediction",
            help="Simulate the triaxial test at twice the confining pressure: 20 draws from the posterior if they take 30 s at most, else the answer, or most probable sample, once.",
        ),
    ] = True,
) -> None:
    """Write the report of a campaign's complete iterations: one HTML file."""
    from graincal.campaign.run.running import REPORT
    from graincal.cli.outputs import check_file
    from graincal.report import write_figures, write_report
    from graincal.report.write import PREDICTED
    from graincal.result import Result

    if output:
        check_file(output)
    result = Result.read(folder)
    predict = PREDICTED if prediction else None
    # Figures first: a format that cannot be written is said before anything is.
    paths = write_figures(result, folder / "figures", figures, predict=predict) if figures else []
    for path in (write_report(result, output or folder / REPORT, predict=predict), *paths):
        say(path)
