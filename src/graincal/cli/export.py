"""graincal export."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from graincal.cli.options import Folder
from graincal.cli.saying import say


class Format(str, Enum):
    """What can be exported to."""

    csv = "csv"
    json = "json"


def export(
    folder: Folder,
    to: Annotated[Format, typer.Option(help="Tables as CSV, or one JSON document.")],
    output: Annotated[Path | None, typer.Option("--output", "-o", help="A folder to write to, instead of export in the campaign's; nothing in it is overwritten.", metavar="FOLDER")] = None,
) -> None:
    """Write samples, weights, errors and responses of the complete iterations for other programs."""
    from graincal.campaign.found.export import export_csv, export_json
    from graincal.cli.outputs import check_folder
    from graincal.result import Result

    write = {Format.csv: export_csv, Format.json: export_json}[to]
    result, target = Result.read(folder), output or folder / "export"
    check_folder(target)
    before = set(target.glob("*"))
    written = write(result, target, replace=output is None)
    for path in written:
        say(path)
    if replaced := before.intersection(written):
        say(f"{len(replaced)} of these replaced the files of an earlier export.", err=True)
