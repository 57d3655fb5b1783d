"""graincal resume."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from graincal.cli.options import Folder, Quiet, Workers
from graincal.data import InputError

Criterion = typer.Option(help="Instead of the beginning's: a number, or false for none.", metavar="N|false", rich_help_panel="Criteria of stopping")


def resume(
    folder: Folder,
    max_iterations: Annotated[str | None, Criterion] = None,
    max_evaluations: Annotated[str | None, Criterion] = None,
    s: Annotated[str | None, Criterion] = None,
    gl_error_increment: Annotated[str | None, Criterion] = None,
    error: Annotated[str | None, Criterion] = None,
    error_increment: Annotated[str | None, Criterion] = None,
    posterior_shift: Annotated[str | None, Criterion] = None,
    hours: Annotated[str | None, Criterion] = None,
    workers: Workers = None,
    trust: Annotated[bool, typer.Option("--trust", help="Go on with a campaign of another user, and run the functions that it names.")] = False,
    quiet: Quiet = False,
) -> None:
    """Go on with a campaign that was interrupted, to the result that it would have had if it had not been.

    With other criteria of stopping, one that is at its end goes on too, to what it would have given by them from the start.
    """
    from graincal import campaign
    from graincal.campaign.run.exploring import go_on_filling, is_library
    from graincal.cli.options import parse_criterion, parse_workers
    from graincal.cli.running import fill_and_say, run_and_report

    given = {"max_iterations": max_iterations, "max_evaluations": max_evaluations, "s": s, "error": error}
    given |= {"gl_error_increment": gl_error_increment, "error_increment": error_increment, "posterior_shift": posterior_shift, "hours": hours}
    criteria: dict[str, Any] = {name: parse_criterion(name, text) for name, text in given.items() if text is not None}
    chosen = None if workers is None else parse_workers(workers)
    if is_library(folder):
        if criteria:
            raise InputError(
                f"{folder}: this is a library of runs, which has no criteria of stopping, and --{next(iter(criteria)).replace('_', '-')} was given."
            )
        return fill_and_say(folder, lambda listeners: go_on_filling(folder, workers=chosen, listeners=listeners, trust=trust), quiet=quiet)
    run_and_report(folder, lambda listeners: campaign.resume(folder, workers=chosen, listeners=listeners, trust=trust, **criteria), quiet=quiet)
