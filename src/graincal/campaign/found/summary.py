"""What a result comes to, in a few lines: a row for each parameter."""

from __future__ import annotations

import html
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from graincal.campaign.asked.calibration import POSTERIOR
from graincal.campaign.found.remarks import WEAKLY
from graincal.campaign.found.trust import has_settled
from graincal.inference.sampling.posterior import PROBABILITY
from graincal.notation import numbers
from graincal.notation.markup import to_html, to_plain
from graincal.notation.quantities import Quantity, parameters, quantity

if TYPE_CHECKING:
    from graincal.campaign.found.emulated import Emulated
    from graincal.campaign.found.record import Record

_LIMITS = {"max_evaluations": "the limit on evaluations", "max_iterations": "the limit on batches", "hours": "the limit on hours"}


@dataclass(frozen=True)
class ParameterSummary:
    """One parameter. answer: of the method "posterior" the answer, else the most probable sample, and the best where there are no weights. interval: 90 %, None without a posterior.

    range: of the prior. informed_by: the observable that narrows it most by itself, "all together" where none does, "not informed" where it was not narrowed, or "not told yet" as long as the posterior has not settled; None where that is not known.
    """

    parameter: str
    answer: float
    interval: tuple[float, float] | None
    unit: str
    range: tuple[float, float]
    informed_by: str | None


@dataclass(frozen=True)
class Row:
    """A row of the table as it is shown, in markup: a parameter, or what a parameter is the logarithm of."""

    quantity: Quantity
    answer: str
    interval: str
    range: str
    informed_by: str

    @property
    def cells(self) -> tuple[str, ...]:
        """Those below `_HEAD`."""
        return self.quantity.label, self.answer, self.interval, self.quantity.unit or "-", self.range, self.informed_by


@dataclass(frozen=True)
class Summary:
    """What a result comes to. state: whether it has settled, and what ended it, in a sentence. error: percent, Eq. 6 (Hartmann, Cheng, Thornton 2022), of the answer; NaN where it was not run. rows: the table as it is shown, without its head; a logarithm of a stiffness has the stiffness in GPa below it."""

    state: str
    evaluations: int
    failures: int
    error: float
    parameters: tuple[ParameterSummary, ...]
    rows: tuple[Row, ...]

    def __getitem__(self, parameter: str) -> ParameterSummary:
        for each in self.parameters:
            if each.parameter == parameter:
                return each
        raise KeyError(parameter)

    def __iter__(self) -> Iterator[ParameterSummary]:
        return iter(self.parameters)

    def __len__(self) -> int:
        return len(self.parameters)

    def __repr__(self) -> str:
        lines = [_HEAD, *(tuple(to_plain(cell) for cell in row.cells) for row in self.rows)]
        widths = [max(map(len, column)) for column in zip(*lines)]
        return "\n".join([self._counted, *("  ".join(f"{cell:{width}}" for cell, width in zip(line, widths)).rstrip() for line in lines)])

    def _repr_html_(self) -> str:
        """What a notebook shows: the same as a table."""
        head = "".join(f"<th>{name}</th>" for name in _HEAD)
        rows = "".join(f"<tr>{''.join(f'<td>{to_html(cell)}</td>' for cell in row.cells)}</tr>" for row in self.rows)
        return f"<div><p>{html.escape(self._counted)}</p><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>"

    @property
    def _counted(self) -> str:
        error = f" Error of the answer: {to_plain(numbers.percent(self.error))}." if np.isfinite(self.error) else ""
        return f"{self.state} {self.evaluations} evaluations, {self.failures} failed.{error}"


_HEAD = ("parameter", "answer", f"{100 * PROBABILITY:.0f} % interval", "unit", "range", "informed by")


def summarise(result: Record, emulated: Emulated | None) -> Summary:
    """The summary of a result. emulated: what its emulators say, where it has some."""
    theta, error = _answer(result)
    interval = result.posterior.interval(PROBABILITY) if result.posterior is not None else None
    informed = _informed_by(emulated) if emulated else None
    space, found, rows = result.space, [], []
    for k, shown in enumerate(parameters(space)):
        ends = None if interval is None else (float(interval[0, k]), float(interval[1, k]))
        span, by = (float(space.low[k]), float(space.high[k])), None if informed is None else informed[k]
        answer = np.nan if theta is None else float(theta[k])
        found.append(ParameterSummary(space.names[k], answer, ends, shown.unit, span, None if by is None else to_plain(by)))
        rows += _rows(shown, answer, ends, span, by or "–")
    return Summary(_state(result), result.evaluations, result.failures, error, tuple(found), tuple(rows))


def _rows(shown: Quantity, answer: float, ends: tuple[float, float] | None, span: tuple[float, float], by: str) -> list[Row]:
    """A parameter, and below it what it is the logarithm of."""
    within = "–" if ends is None else numbers.between(*ends)
    rows = [Row(shown, numbers.within(answer, ends), within, f"{numbers.short(span[0])} to {numbers.short(span[1])}", by)]
    if shown.antilog:
        (raised,) = shown.raised(answer)
        rows += _rows(shown.antilog, raised, None if ends is None else _raised(shown, ends), _raised(shown, span), by)
    return rows


def _raised(shown: Quantity, ends: tuple[float, float]) -> tuple[float, float]:
    low, high = shown.raised(*ends)
    return low, high


def _answer(result: Record) -> tuple[np.ndarray | None, float]:
    """Its parameters (n,), and its error in percent."""
    if answer := result.answer:
        known = answer.errors[np.isfinite(answer.errors)]
        return answer.theta, float(known.mean()) if known.size else np.nan
    candidate = result.best if result.has_posterior else result.most_probable or result.best
    return (candidate.theta, candidate.error) if candidate else (None, np.nan)


def _state(result: Record) -> str:
    if result.stopped_by is None:
        return "Not at its end."
    if result.calibration.method == POSTERIOR:
        return "Settled." if result.settled else f"Not settled: stopped by {_LIMITS.get(result.stopped_by, result.stopped_by)}."
    return f"Stopped by {result.stopped_by}."


def _informed_by(emulated: Emulated) -> tuple[str | None, ...]:
    """For each parameter, in markup."""
    alone, several = emulated.alone, len(emulated.result.experiments) > 1
    found: list[str | None] = []
    for k, left in enumerate(emulated.shrinkage):
        if left > WEAKLY:
            found.append("not informed" if has_settled(emulated.result) else "not told yet")
        elif not alone:
            found.append(None)
        else:
            (number, name), least = min(((pair, by[k]) for pair, by in alone.items()), key=lambda each: each[1])
            of = f"{emulated.result.experiments[number].name}: " if several else ""
            found.append("all together" if least > WEAKLY else f"{of}{quantity(name).label}")
    return tuple(found)
