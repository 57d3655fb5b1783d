"""A campaign as it goes, in a terminal or a notebook: a live table, or plain lines where there is neither."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from rich.console import Group
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from graincal.campaign.asked.calibration import POSTERIOR, Calibration, round_of
from graincal.campaign.run.outlook import Outlook
from graincal.campaign.stored.learnt import Learnt
from graincal.campaign.stored.listener import Listener
from graincal.data import Failure, Response
from graincal.inference import Iteration
from graincal.notation.console import PrintableConsole
from graincal.notation.text import duration, sparkline

PAUSE = 5.0
"""Where there is no terminal, a line says how far an iteration is at most every so many seconds."""


class Progress(Listener):
    """Counts what the campaign does, and shows it."""

    def __init__(self, console: PrintableConsole) -> None:
        self._console = console
        self._of = self._limit = self._heading = ""
        self._iterations: list[Iteration] = []
        self._learnt: list[Learnt | None] = []
        self._done = self._total = self._failed = self._stopped = 0
        self._began = self._said = time.monotonic()
        self._looks = self._is_look = False
        self._live = Live(console=console, get_renderable=self._picture, refresh_per_second=4) if console.is_terminal or console.is_jupyter else None

    def __enter__(self) -> Progress:
        if self._live:
            self._live.__enter__()
        return self

    def __exit__(self, *exception: Any) -> None:
        if self._live:
            self._live.__exit__(*exception)

    def begins(self, calibration: Calibration) -> None:
        # What the method calls the samples of one round; batches have other limits than their number.
        self._of, most = round_of(calibration.method), calibration.method != POSTERIOR and calibration.stop.most_iterations
        self._limit = f" (of at most {most})" if most else ""
        self._iterations, self._learnt, self._heading = [], [], ""
        self._done = self._total = self._failed = self._stopped = 0
        self._outlook = Outlook(calibration)
        self._is_look, self._looks = self._looks, False

    def looks_first(self) -> None:
        self._looks = True

    def expects(self, evaluations: int | None, at_most: int | None, seconds: float | None) -> None:
        # Of the campaign that a look is for nothing is known yet.
        if not self._is_look:
            self._outlook.expects(evaluations, at_most, seconds)

    def remark(self, text: str) -> None:
        self._console.sentences(text)

    def experiment_begins(self, iteration: int, experiment: str, waiting: int, samples: int) -> None:
        # Runs of several experiments are counted together.
        self._heading = f"{self._of} {iteration}{self._limit}"
        # Beside what is left of a batch before it, which this one was asked for ahead of.
        self._done, self._total, self._failed, self._stopped, self._began = 0, self._total - self._done + waiting, 0, 0, time.monotonic()
        self._outlook.asks(iteration, samples)
        self._line(f"{self._heading}, {experiment}: {waiting} of {samples} samples to evaluate")

    def evaluates_beside(self, waiting: int) -> None:
        self._total += waiting

    def evaluated(self, sample: int, experiment: str, outcome: Response | Failure) -> None:
        self._done += 1
        self._outlook.evaluated()
        self._failed += isinstance(outcome, Failure)
        self._stopped += isinstance(outcome, Response) and outcome.stopped
        if time.monotonic() - self._said > PAUSE:
            self._line(f"{self._heading}: {self._counts()}")

    def iteration_ends(self, iteration: Iteration, replayed: bool, learnt: Learnt | None) -> None:
        self._iterations.append(iteration)
        self._learnt.append(learnt)
        self._outlook.holds(iteration.index, len(iteration.samples))
        if self._done >= self._total:
            self._heading = ""
        self._line("; ".join(f"{name} {value}" for name, value in zip(self._columns(), self._row(iteration))))

    def _line(self, text: str) -> None:
        self._said = time.monotonic()
        if not self._live:
            self._console.sentences(text)

    def _counts(self) -> str:
        elapsed, waiting = time.monotonic() - self._began, self._total - self._done
        of_round = elapsed / self._done * waiting if self._done else 0.0
        left = f", {duration(of_round)} left in this {self._of}" if of_round else ""
        left += f", {words}" if (words := self._outlook.words(waiting, of_round)) else ""
        stopped = f", {self._stopped} stopped early" if self._stopped else ""
        return f"{self._done} of {self._total} runs, {self._failed} failed{stopped}{left}"

    def _columns(self) -> tuple[str, ...]:
        """What the figures of an iteration are."""
        return _COLUMNS if self._learnt[-1] is None else _COLUMNS_OF_POSTERIOR

    def _row(self, iteration: Iteration) -> list[str]:
        """The figures of an iteration in the order of the columns."""
        best = np.fmin.reduce([each.smallest_error for each in self._iterations[: iteration.index + 1]])
        learnt = self._learnt[iteration.index]
        figures = [iteration.s, iteration.effective_sample_size, iteration.gl_error, iteration.error, best]
        if learnt:
            figures = [learnt.doubt, 100 * learnt.held_out_error, best]
        formats = (".2f", ".2g", ".2f") if learnt else (".3g", ".2f", ".2f", ".2f", ".2f")
        shown = [format(value, spec) if np.isfinite(value) else "-" for value, spec in zip(figures, formats)]
        return [str(iteration.index), f"{len(iteration.samples)}", f"{iteration.failed.sum()}", *shown]

    def _picture(self) -> Group:
        parts: list[Any] = []
        if self._iterations:
            table = Table(*self._columns(), box=None, header_style="bold", padding=(0, 2, 0, 0))
            for iteration in self._iterations:
                table.add_row(*self._row(iteration))
            parts = [table]
        if len(self._iterations) > 1 and self._learnt[-1] is None:
            parts.append(Text(f"ε by iteration  {sparkline([iteration.error for iteration in self._iterations], low=0.0)}"))
        if self._heading:
            parts += [Text(f"{self._heading}: {self._counts()}"), ProgressBar(total=self._total, completed=self._done, width=60)]
        return Group(*parts)


_COLUMNS = ("iteration", "evaluated", "failed", "s", "ESS", "ε_GL %", "ε %", "best ε so far %")
_COLUMNS_OF_POSTERIOR = ("batch", "evaluated", "failed", "doubt sd", "held-out error of the emulator %", "best ε so far %")
