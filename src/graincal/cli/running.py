"""What `calibrate` and `resume` share: a campaign under way on the terminal, and its result in words."""

from __future__ import annotations

import math
import shlex
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from rich.table import Table

from graincal.campaign import Calibration, Listener
from graincal.campaign.asked.doubt import Doubt
from graincal.campaign.file.examination import Examination, examine
from graincal.campaign.found.next_command import going_on, next_command, what_it_does
from graincal.campaign.run.progress import Progress
from graincal.campaign.run.running import REPORT
from graincal.campaign.run.waiting import RunsWait
from graincal.campaign.stored.store import holds_campaign
from graincal.cli.saying import say
from graincal.data import InputError
from graincal.notation.console import PrintableConsole
from graincal.result import Result

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from graincal.campaign.found.answer import Candidate
    from graincal.inference import Posterior
    from graincal.inference.iterative.close_fits import CloseFits


def look_at(file: Path, more_runs: Sequence[Path] = (), *, quiet: bool = False) -> Examination:
    """Examine a calibration file; a terminal says meanwhile what takes so long."""
    with PrintableConsole(stderr=True, quiet=quiet).status(f"reading {file} and what it names; a packing may have to be prepared first"):
        return examine(file, more_runs)


def accepted(file: Path, found: Examination, *, accept: bool) -> tuple[Calibration, tuple[Doubt, ...]]:
    """The calibration of a file that was looked at, and the problems in spite of which it is run. Raises InputError for open questions, and for problems that are not accepted or leave nothing to run."""
    if found.questions:
        raise InputError("\n".join(f"{file}: {question.sentence}" for question in found.questions))
    if found.problems and not (accept and found.calibration):
        are, them = ("is 1 problem", "it") if len(found.problems) == 1 else (f"are {len(found.problems)} problems", "them")
        then = f"correct the file, or go on in spite of {them} by --accept" if found.calibration else "correct the file"
        raise InputError("\n".join([f"{file}: not calibrated, for there {are}; {then}:", *(f"  {problem}" for problem in found.problems)]))
    assert found.calibration is not None, "what keeps it from being calibrated is a problem"
    return found.calibration, found.problems


def run(folder: Path, start: Callable[[Sequence[Listener]], Result], *, quiet: bool) -> Result | None:
    """Start a campaign, show how it goes and what it found, and return that; None where it waits for runs that are made by hand, which is said. Ctrl-C says how to go on with it."""
    console = PrintableConsole(highlight=False, markup=False, quiet=quiet, width=None if sys.stdout.isatty() else 120)
    try:
        with _shown(folder, console) as progress:
            result = start([progress])
    except RunsWait as waits:
        console.sentences(str(waits))
        return None
    show(result, folder, console)
    if result.failed.all():
        again = next_command(folder, result.calibration, "failures")
        raise InputError(
            f"{folder}: every evaluation failed, so nothing was calibrated. Correct what the reasons name, and begin again in a new folder:\n  {again}"
        )
    return result


def fill_and_say(folder: Path, start: Callable[[Sequence[Listener]], Path], *, quiet: bool) -> None:
    """Fill a library, show how it goes and say what there is."""
    from graincal.campaign.found.status import status

    console = PrintableConsole(highlight=False, markup=False, quiet=quiet, width=None if sys.stdout.isatty() else 120)
    try:
        with _shown(folder, console) as progress:
            start([progress])
    except RunsWait as waits:
        console.sentences(str(waits))
        return
    console.sentences(f"{status(folder)['stopped_because']} Stored in {folder}. Calibrate with these runs by:")
    console.print(f"  graincal calibrate CALIBRATION.toml --runs {shlex.quote(str(folder))} -o NEW_FOLDER", soft_wrap=True)


@contextmanager
def _shown(folder: Path, console: PrintableConsole) -> Iterator[Progress]:
    """Show how a campaign goes, and after Ctrl-C the command that goes on with it."""
    progress = Progress(console)
    try:
        with progress:
            yield progress
    except KeyboardInterrupt:
        # The terminal may be gone.
        with suppress(OSError):
            if holds_campaign(folder):
                say(f"Stopped. All that was finished is stored; go on with:\n  {going_on(folder)}", err=True)
        raise


def run_and_report(folder: Path, start: Callable[[Sequence[Listener]], Result], *, quiet: bool) -> None:
    """Run a campaign and write its report into its folder, unless it waits for runs that are made by hand."""
    result = run(folder, start, quiet=quiet)
    if result is None:
        return
    path = result.report(folder / REPORT)
    if not quiet:
        say(f"Report: {path}")
        if command := next_command(folder, result.calibration, result.stopped_by):
            say(f"{what_it_does(result.stopped_by).capitalize()}:\n  {command}")


def show(result: Result, folder: Path, console: PrintableConsole) -> None:
    """The result in words and a table of the parameters."""
    from graincal.campaign.found.recorded import in_words, recorded_of_answer
    from graincal.inference.iterative.close_fits import MARGIN, close_fits
    from graincal.notation import numbers
    from graincal.notation.markup import to_plain
    from graincal.report import summarise

    # What is said of a posterior ends with the reason.
    console.sentences(f"Stopped by {result.stopped_by}." if result.has_posterior else f"Stopped by {result.stopped_by}: {result.stopped_because}")
    stopped = f", {result.stopped.sum()} stopped early, for they could not matter any more" if result.stopped.any() else ""
    console.sentences(f"{result.evaluations} evaluations, {result.failures} failed{stopped}.")
    for kind, reason, count in result.failure_kinds():
        console.sentences(f"  {count} × {kind}: {reason}")
    if result.has_posterior:
        console.sentences(summarise(result))
    elif (posterior := result.posterior) and (answer := result.most_probable) and (best := result.best) and (close := close_fits(result.iterations)):
        console.print(_table(result, posterior, answer, best, close))
        told = (
            "Values that fit about as well:"
            if close.enough
            else f"The interval holds 90 % of the weight; only {numbers.count(close.count, 'sample')} fit about as well, too few to outline a range:"
        )
        console.sentences(f"{told} ε at most {numbers.percent(close.limit)}, {MARGIN:g} percentage points above the smallest.")
        console.sentences("± is the spread of the last iteration's weighted samples: it shrinks with every iteration, whatever the noise of the data.")
        console.print(f"Error of the most probable sample {answer.error:.2f} %, of the best {best.error:.2f} %.")
        if said := in_words(recorded_of_answer(result)):
            console.sentences(to_plain(said))
    if result.grade:
        console.sentences(f"Grade: {result.grade.word}. {' '.join(result.grade.reasons)}")
    console.sentences(f"Stored in {folder}.")


def _table(result: Result, posterior: Posterior, answer: Candidate, best: Candidate, close: CloseFits) -> Table:
    """A row for each parameter, and below it what it is the logarithm of."""
    from graincal.notation import numbers
    from graincal.notation.markup import to_plain
    from graincal.notation.quantities import parameters

    points: dict[str, Sequence[float] | NDArray[np.float64]] = {"most probable": answer.theta}
    if result.truth:
        points = {"truth": [result.truth.get(name, math.nan) for name in result.space.names], **points}
    if best.sample != answer.sample:
        points["best"] = best.theta
    low, high = (close.low, close.high) if close.enough else posterior.interval(0.9)
    table = Table(
        "parameter", *points, "fit about as well" if close.enough else "90 % interval", "mean ± sd", box=None, header_style="bold", padding=(0, 2, 0, 0)
    )

    def add(title: str, values: Iterable[float], ends: Sequence[float], moments: str) -> None:
        table.add_row(title, *("-" if math.isnan(value) else f"{value:.4g}" for value in values), to_plain(numbers.between(ends[0], ends[1])), moments)

    mean, spread = posterior.mean(), posterior.std()
    for k, (name, unit, shown) in enumerate(zip(result.space.names, result.space.units, parameters(result.space))):
        values, ends = [each[k] for each in points.values()], (low[k], high[k])
        add(f"{name} [{unit}]" if unit else name, values, ends, to_plain(numbers.estimate(mean[k], spread[k])))
        if shown.antilog:
            add(to_plain(shown.antilog.axis), shown.raised(*values), shown.raised(*ends), "")
    return table
