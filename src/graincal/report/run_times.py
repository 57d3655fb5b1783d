"""How long evaluations took, which failed, and where."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.stats import ks_2samp

from graincal.campaign.found.record import Record
from graincal.data import Failure, Response
from graincal.drawing.figure import Axis, Bars, Figure, Panel, Points, counting_axis, log_axis
from graincal.drawing.palette import BLUE, GREY, Style, distinct
from graincal.notation import numbers
from graincal.notation.quantities import parameters

_SYMBOLS: tuple[Literal["circle", "diamond", "square"], ...] = ("circle", "diamond", "square")
_CHANCE = 0.01
"""How probable failures anywhere would be to look so different from the other samples, for a parameter to be named."""


@dataclass(frozen=True)
class FailureKind:
    """The failures of one kind in one experiment: how many, and the reason that one of them gave."""

    experiment: str
    kind: str
    number: int
    example: str


def failure_kinds(result: Record) -> tuple[FailureKind, ...]:
    """The failures by experiment and kind, the most frequent first."""
    numbers_of: Counter[tuple[str, str]] = Counter()
    examples: dict[tuple[str, str], str] = {}
    for id in result.ids[result.failed]:
        for experiment in result.experiments:
            outcome = result.response(int(id), experiment.name)
            if isinstance(outcome, Failure):
                key = (experiment.name, outcome.kind)
                numbers_of[key] += 1
                examples.setdefault(key, outcome.reason)
    return tuple(FailureKind(*key, number, examples[key]) for key, number in numbers_of.most_common())


def where_failed(result: Record) -> str:
    """A sentence on the parameters that set the failures apart from the other samples (by the test of Kolmogorov and Smirnov)."""
    usable = ~result.failed
    if not usable.any() or not result.failures:
        return ""
    parts = []
    for k, shown in enumerate(parameters(result.space)):
        failed, others = result.samples[result.failed, k], result.samples[usable, k]
        if ks_2samp(failed, others).pvalue < _CHANCE:
            parts.append(f"{shown.label} (from {_middle(failed)}; the others from {_middle(others)})")
    return f"They stand apart from the other samples in {', '.join(parts)}." if parts else "No parameter sets them apart from the other samples."


def _middle(values: np.ndarray) -> str:
    return numbers.between(*np.quantile(values, [0.05, 0.95]))


def time_sentence(result: Record) -> str:
    """What the evaluations took, in a sentence; empty where no times are known."""
    seconds = result.seconds[np.isfinite(result.seconds)]
    if not seconds.size:
        return ""
    return (
        f"The evaluations took {numbers.duration(seconds.sum())} in all, summed over workers: "
        f"{numbers.duration(float(np.median(seconds)))} in the median, {numbers.duration(seconds.max())} at most."
    )


def stopped_sentence(result: Record) -> str:
    """How many runs were stopped early, how far they had come, and what they hold of the posterior, in a sentence; empty where none was."""
    if not result.stopped.any():
        return ""
    came_to, whole = [], [len(result.states(experiment.name)) for experiment in result.experiments]
    for id in result.ids[result.stopped]:
        outcomes = [result.response(int(id), experiment.name) for experiment in result.experiments]
        states = sum(len(outcome.control) for outcome in outcomes if isinstance(outcome, Response))
        came_to.append(states / sum(whole))
    dropped = result.learnt[-1].dropped
    part = "less than 0.001 %" if dropped < 1e-5 else f"at most {100 * dropped:.1g} %"
    held = f"; together they hold {part} of the posterior's probability" if np.isfinite(dropped) else ""
    return (
        f"{numbers.count(len(came_to), 'run')} {'was' if len(came_to) == 1 else 'were'} stopped early, after {100 * np.median(came_to):.0f} % of the states in the "
        f"median, because whatever they had given from there on they could not have mattered{held}."
    )


def draw_run_times(result: Record) -> Figure | None:
    """The run time of each evaluation by iteration, and how many failed."""
    panels = []
    times = time_sentence(result)
    if times:
        panels.append(_times(result))
    if result.failures:
        panels.append(_counts(result))
    if not panels:
        return None
    return Figure("run_times", f"{numbers.count(result.evaluations, 'sample')} evaluated, {result.failures or 'none'} failed.", times, tuple(panels), columns=2)


def _times(result: Record) -> Panel:
    several = len(result.experiments) > 1
    # Spread within an iteration in the order asked, so that points do not hide each other.
    x = result.iteration + 0.7 * (_rank_within(result.iteration) - 0.5)
    marks = []
    for number, experiment in enumerate(result.experiments):
        known = np.isfinite(result.seconds[:, number])
        notes = tuple(f"sample {id}: {numbers.duration(t)}" for id, t in zip(result.ids[known], result.seconds[known, number]))
        style = Style(distinct(number).colour, symbol=_SYMBOLS[number % 3], size=4, opacity=0.8)
        marks.append(Points(x[known], result.seconds[known, number], style, experiment.name if several else "", notes=notes))
    return Panel("Run time of each evaluation", _by_iteration(result), log_axis("run time [s]", result.seconds[np.isfinite(result.seconds)]), tuple(marks))


def _counts(result: Record) -> Panel:
    edges = np.arange(len(result.iterations) + 1, dtype=np.float64) - 0.5
    failed = np.array([iteration.failed.sum() for iteration in result.iterations], dtype=np.float64)
    usable = np.array([(~iteration.failed).sum() for iteration in result.iterations], dtype=np.float64)
    marks = (Bars(edges, usable, Style(BLUE, opacity=0.35), "usable"), Bars(edges, failed, Style(GREY), "failed", base=usable))
    return Panel("Evaluations that failed", _by_iteration(result), Axis("samples"), marks)


def _by_iteration(result: Record) -> Axis:
    return counting_axis("batch" if result.has_posterior else "iteration", 0, len(result.iterations) - 1, margin=0.6)


def _rank_within(iteration: np.ndarray) -> np.ndarray:
    ranks = np.empty(len(iteration))
    for index in np.unique(iteration):
        rows = iteration == index
        ranks[rows] = (np.arange(rows.sum()) + 0.5) / rows.sum()
    return ranks
