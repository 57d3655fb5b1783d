"""graincal resume."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from graincal.cli.options import Folder, Quiet, Workers
from graincal.data import InputError


def _criterion(text: str) -> Any:
    return typer.Option(help=text, metavar="N|false", rich_help_panel="Criteria of stopping, instead of those that it began with; false switches one off")


def resume(
    folder: Folder,
    max_evaluations: Annotated[str | None, _criterion("Most evaluations.")] = None,
    max_iterations: Annotated[str | None, _criterion("Most iterations, or batches.")] = None,
    hours: Annotated[str | None, _criterion("Hours of wall time, in all sittings, after which no further batch begins.")] = None,
    posterior_shift: Annotated[
        str | None, _criterion("By the posterior method: how far what the emulator does not know may move it, in standard deviations.")
    ] = None,
    s: Annotated[str | None, _criterion("By the paper's method: the normalised covariance s at which it ends.")] = None,
    error: Annotated[str | None, _criterion("By the paper's method: the error of the most probable sample at which it ends, in percent.")] = None,
    error_increment: Annotated[str | None, _criterion("By the paper's method: a change of that error, in percentage points, at which it ends.")] = None,
    gl_error_increment: Annotated[str | None, _criterion("By the paper's method: a change of the GL error, in percentage points, at which it ends.")] = None,
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
