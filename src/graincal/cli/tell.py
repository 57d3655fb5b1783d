"""graincal tell."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from graincal.cli.options import Folder, Quiet
from graincal.cli.saying import say
from graincal.data import InputError


def tell(
    folder: Folder,
    told: Annotated[
        Path,
        typer.Argument(
            help="The folder with <id>.csv or <id>.failed of each run; with several experiments, within a folder of each one's name.", metavar="FOLDER"
        ),
    ],
    quiet: Quiet = False,
) -> None:
    """Take what runs gave that were made by hand, all of them or some. With the last of a batch the campaign goes on, to the next batch or to its end.

    A file that was told before changes nothing, and another one for the same run is refused.
    """
    from graincal import campaign
    from graincal.campaign.run.exploring import go_on_filling, is_library
    from graincal.campaign.run.telling import tell as take
    from graincal.cli.running import fill_and_say, run_and_report

    found = take(folder, told)
    for line in (*found.failures, *found.not_needed) if not quiet else ():
        say(line)
    for sentence in found.refused:
        say(sentence, err=True)
    if not quiet:
        say(
            f"{_counted(found.kept)} kept{f', {found.known} told before' if found.known else ''}{f', {len(found.refused)} refused' if found.refused else ''}; {_counted(found.left, 'run')} still to be made."
        )
    if not quiet and not (found.kept or found.known or found.not_needed or found.refused):
        say(f"{told}: no file <id>.csv or <id>.failed was found in it.")
    if found.whole and is_library(folder):
        fill_and_say(folder, lambda listeners: go_on_filling(folder, listeners=listeners, by_hand=found.by_hand), quiet=quiet)
    elif found.whole:
        run_and_report(folder, lambda listeners: campaign.resume(folder, listeners=listeners, by_hand=found.by_hand), quiet=quiet)
    if found.refused:
        raise InputError(f"{told}: {_counted(len(found.refused), 'file')} could not be taken, as said above.")


def _counted(count: int, what: str = "outcome") -> str:
    return f"{count} {what}{'s' * (count != 1)}"
