"""graincal report."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from graincal.cli.options import Folder


def report(
    folder: Folder,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Instead of report.html in the folder.", metavar="FILE")] = None,
) -> None:
    """Write the report of a campaign's complete iterations: one HTML file."""
    from graincal.campaign import Result
    from graincal.campaign.running import REPORT

    typer.echo(Result.read(folder).report(output or folder / REPORT))
