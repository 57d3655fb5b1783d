"""A campaign on the terminal as it goes: a live table, or plain lines where there is no terminal."""

from __future__ import annotations

import time

import numpy as np
from rich.console import Console, Group
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from graincal.campaign import Listener
from graincal.cli.text import duration, sparkline
from graincal.data import Failure, Response
from graincal.inference import Iteration, Stop

PAUSE = 5.0
"""Where there is no terminal, a line says how far an iteration is at most every so many seconds."""


class Progress(Listener):
    """Counts what the campaign does, and shows it."""

    def __init__(self, stop: Stop, console: Console) -> None:
        self._console = console
        self._limit = f" (of at most {stop.max_iterations})" if stop.max_iterations else ""
        self._iterations: list[Iteration] = []
        self._heading = ""
        self._done = self._total = self._failed = 0
        self._began = self._said = time.monotonic()
        self._live = Live(console=console, get_renderable=self._picture, refresh_per_second=4) if console.is_terminal else None

    def __enter__(self) -> Progress:
        if self._live:
            self._live.__enter__()
        return self

    def __exit__(self, *exception) -> None:
        if self._live:
            self._live.__exit__(*exception)

    def remark(self, text: str) -> None:
        self._console.print(text)

    def experiment_begins(self, iteration: int, experiment: str, waiting: int, samples: int) -> None:
        self._heading = f"iteration {iteration}{self._limit}, {experiment}"
        self._done, self._total, self._failed, self._began = 0, waiting, 0, time.monotonic()
        self._line(f"{self._heading}: {waiting} of {samples} samples to evaluate")

    def evaluated(self, sample: int, experiment: str, outcome: Response | Failure) -> None:
        self._done += 1
        self._failed += isinstance(outcome, Failure)
        if time.monotonic() - self._said > PAUSE:
            self._line(f"{self._heading}: {self._counts()}")

    def iteration_ends(self, iteration: Iteration, replayed: bool) -> None:
        self._iterations.append(iteration)
        self._heading = ""
        self._line("; ".join(f"{name} {value}" for name, value in zip(_COLUMNS, self._row(iteration))))

    def _line(self, text: str) -> None:
        self._said = time.monotonic()
        if not self._live:
            self._console.print(text, soft_wrap=True)

    def _counts(self) -> str:
        elapsed = time.monotonic() - self._began
        left = f", {duration(elapsed / self._done * (self._total - self._done))} left" if self._done else ""
        return f"{self._done} of {self._total} evaluated, {self._failed} failed{left}"

    def _row(self, iteration: Iteration) -> list[str]:
        """The figures of an iteration in the order of _COLUMNS."""
        best = np.fmin.reduce([each.smallest_error for each in self._iterations[: iteration.index + 1]])
        figures = [iteration.s, iteration.effective_sample_size, iteration.gl_error, iteration.error, best]
        shown = [format(value, spec) if np.isfinite(value) else "-" for value, spec in zip(figures, (".3g", ".2f", ".2f", ".2f", ".2f"))]
        return [str(iteration.index), f"{len(iteration.samples)}", f"{iteration.failed.sum()}", *shown]

    def _picture(self) -> Group:
        table = Table(*_COLUMNS, box=None, header_style="bold", padding=(0, 2, 0, 0))
        for iteration in self._iterations:
            table.add_row(*self._row(iteration))
        parts = [table] if self._iterations else []
        if len(self._iterations) > 1:
            parts.append(Text(f"ε by iteration  {sparkline([iteration.error for iteration in self._iterations], low=0.0)}"))
        if self._heading:
            parts += [Text(f"{self._heading}: {self._counts()}"), ProgressBar(total=self._total, completed=self._done, width=60)]
        return Group(*parts)


_COLUMNS = ("iteration", "evaluated", "failed", "s", "ESS", "ε_GL %", "ε %", "best ε so far %")
