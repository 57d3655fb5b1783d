"""Figure: the posterior in pairs of parameters (Hartmann, Cheng, Thornton 2022, Table 5)."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from graincal.campaign.found.findings import effective_samples, telling_correlation
from graincal.campaign.found.record import Record
from graincal.data import ParameterSpace
from graincal.drawing.figure import Axis, Band, Bars, Figure, Level, Panel, Points, tick_text
from graincal.drawing.palette import BLUE, CENTRE, FAILED, LIMIT, TRUTH, VERMILLION, Style, colours_of, sign_colour
from graincal.inference import Iteration
from graincal.inference.sampling.groups import Group, find_groups
from graincal.notation.numbers import count, percent, short, signed
from graincal.notation.quantities import Quantity, parameters
from graincal.parameter_space import LOG

if TYPE_CHECKING:
    from graincal.campaign.found.emulated import Mode

_BINS = 12
FACTOR = 5.0
"""Between values that a logarithmic axis shows otherwise than a plain one."""
_LABEL = 20
"""Characters of a line of a label: what a cell is wide."""
_SMALLEST, _LARGEST = 4.0, 13.0
_WEIGHTED = Style(BLUE, opacity=0.85)
_RING = Style(VERMILLION, symbol="ring", size=_LARGEST + 4)


def draw_pairs(result: Record) -> Figure | None:
    """The weighted samples of the last iteration with weights: histograms on the diagonal, pairs below it, correlations above."""
    if result.most_probable is None:
        return None
    iteration = result.iterations[result.most_probable.iteration]
    carried = count(round(effective_samples(iteration.posterior)), "sample")
    title = f"The {count(len(iteration.samples), 'sample')} of iteration {iteration.index} carry as much as {carried} of equal weight."
    axes = [_axis(result, iteration, k, shown) for k, shown in enumerate(parameters(result.space))]
    n = len(axes)
    if n == 1:
        panel = Panel("", axes[0], Axis("share of the weight [-]"), _histogram(result, iteration, 0, axes[0]))
        return Figure("posterior", title, "A weighted histogram over the iteration's samples, not over the whole range.", (panel,))
    groups = find_groups(result.space, iteration.posterior)
    caption = (
        f"Axes span the iteration's samples{' and the truth' if result.truth else ''}, not the whole ranges; grey lines are ends of a range. Diagonal: weighted histograms. "
        "Below it: the larger and darker a sample, the more weight it carries. Above it: Pearson correlations under the weights, "
    )
    telling = telling_correlation(iteration.posterior)
    caption += (
        f"coloured from {telling:.2f} on, up or down: less may be chance."
        if telling <= 1
        else "none coloured: on so few samples with weight, any may be chance."
    )
    caption += " These weights grow narrower with every iteration; which values fit about as well, the samples' figure and the table of the parameters show."
    cells = [[cell(float(r), telling) for r in row] for row in iteration.posterior.correlation()]
    panels = tuple(cells[row][column] if column > row else _panel(result, iteration, axes, groups, row, column) for row in range(n) for column in range(n))
    return Figure("posterior", title, caption, panels, columns=n, square=True)


def _panel(result: Record, iteration: Iteration, axes: list[Axis], groups: tuple[Group, ...], row: int, column: int) -> Panel:
    x = axes[column] if row == len(axes) - 1 else bare(axes[column])
    if column == row:
        return Panel("", x, Axis(ticks=()), _histogram(result, iteration, row, axes[row]))
    marks = (*_scatter(result.space, iteration, axes, row, column), *centres(groups, row, column), *truth_of_pair(result, row, column))
    return Panel("", x, axes[row] if column == 0 else bare(axes[row]), marks)


def _axis(result: Record, iteration: Iteration, k: int, shown: Quantity) -> Axis:
    """Over the samples, and the truth where it is known."""
    values = iteration.samples.theta[:, k]
    truth = result.truth.get(result.space.names[k], values[0])
    low, high = float(min(values.min(), truth)), float(max(values.max(), truth))
    return axis_of_parameter(result.space, k, in_lines(shown.axis), low, high)


def axis_of_parameter(space: ParameterSpace, k: int, label: str, low: float, high: float) -> Axis:
    """An axis from one value of a parameter to another, and a little beyond; logarithmic for one whose prior is uniform in the logarithm, where the values are a factor apart that shows it."""
    if space.scales[k] == LOG and high > FACTOR * low:
        beyond = (high / low) ** 0.06
        return Axis(label, (low / beyond, high * beyond), log=True, ticks=few_powers(low / beyond, high * beyond))
    margin = 0.06 * (high - low) or 0.01 * float(space.high[k] - space.low[k])
    return Axis(label, (low - margin, high + margin), ticks=few_ticks(low - margin, high + margin))


def in_lines(label: str) -> str:
    """The label in lines that do not run into the next cell's."""
    return "\n".join(textwrap.wrap(label, _LABEL, break_long_words=False, break_on_hyphens=False))


def bare(axis: Axis) -> Axis:
    """The axis inside the matrix, whose label and ticks stand at its edge."""
    return replace(axis, label="", ticks=())


def few_ticks(low: float, high: float) -> tuple[tuple[float, str], ...]:
    """Two ticks, neither so near a cell's edge that its text would run into the next cell's."""
    edge = 0.1 * (high - low)
    inside: list[float] = []
    bins = 3
    while len(inside) < 2:
        ticks = MaxNLocator(nbins=bins, steps=[1, 2, 5, 10]).tick_values(low, high)
        inside = [float(tick) for tick in ticks if low + edge <= tick <= high - edge]
        bins += 1
    return tuple((tick, short(tick)) for tick in (inside[0], inside[-1]))


def few_powers(low: float, high: float) -> tuple[tuple[float, str], ...]:
    """Two ticks of a logarithmic axis, at round numbers, neither so near a cell's edge that its text would run into the next cell's."""
    edge = (high / low) ** 0.1
    for steps in ((1.0,), (1.0, 2.0, 5.0), tuple(np.arange(1.0, 10.0))):
        ticks = [step * 10.0**power for power in range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1) for step in steps]
        inside = [tick for tick in ticks if low * edge <= tick <= high / edge]
        if len(inside) > 1:
            break
    return tuple((tick, tick_text(tick)) for tick in (inside[0], inside[-1]))


def histogram(samples: NDArray[np.float64], weights: NDArray[np.float64], bins: int, axis: Axis) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The weight in each of so many bins along an axis, (B,), and the edges of these, (B + 1,)."""
    low, high = _limits(axis)
    if not axis.log:
        return np.histogram(samples, bins=bins, range=(low, high), weights=weights)
    return np.histogram(samples, bins=np.geomspace(low, high, bins + 1), weights=weights)


def _limits(axis: Axis) -> tuple[float, float]:
    assert axis.limits is not None, "the axis of a parameter has limits"
    return axis.limits


def bars(edges: NDArray[np.float64], heights: NDArray[np.float64], style: Style, axis: Axis) -> Bars | Band:
    """A histogram on an axis; on a logarithmic one by its outline, for there bars have no width of their own."""
    if not axis.log:
        return Bars(edges, heights, style)
    outline = np.repeat(heights, 2)
    return Band(np.repeat(edges, 2)[1:-1], np.zeros_like(outline), outline, style)


def ends(space: ParameterSpace, k: int, axis: Axis, *, upright: bool) -> list[Level]:
    """The ends of the range, where they are in sight."""
    low, high = _limits(axis)
    return [Level(float(end), LIMIT, upright=upright) for end in (space.low[k], space.high[k]) if low < end < high]


def truth_of_parameter(result: Record, k: int, *, upright: bool) -> list[Level]:
    """The known value of a parameter, where there is one."""
    truth = result.truth.get(result.space.names[k])
    return [] if truth is None else [Level(truth, TRUTH, "truth", upright=upright)]


def truth_of_pair(result: Record, row: int, column: int) -> tuple[Level | Points, ...]:
    """Lines through the known values of a pair, and a point where both are."""
    levels = [*truth_of_parameter(result, column, upright=True), *truth_of_parameter(result, row, upright=False)]
    point = [Points(np.array([levels[0].at]), np.array([levels[1].at]), TRUTH)] if len(levels) == 2 else []
    return (*levels, *point)


def centres(groups: Sequence[Group | Mode], row: int, column: int) -> tuple[Points, ...]:
    """Where the separate groups have their centres, if there are several."""
    if not groups:
        return ()
    x, y = (np.array([group.centre[k] for group in groups]) for k in (column, row))
    return (Points(x, y, CENTRE, "centre of a group", notes=tuple(f"centre of a group with {100 * group.share:.0f} % of the weight" for group in groups)),)


def _histogram(result: Record, iteration: Iteration, k: int, axis: Axis) -> tuple[Bars | Band | Level, ...]:
    heights, edges = histogram(iteration.samples.theta[:, k], iteration.final_weights, _BINS, axis)
    return (bars(edges, heights, _WEIGHTED, axis), *ends(result.space, k, axis, upright=True), *truth_of_parameter(result, k, upright=True))


def _scatter(space: ParameterSpace, iteration: Iteration, axes: list[Axis], row: int, column: int) -> tuple[Level | Points, ...]:
    x, y = iteration.samples.theta[:, column], iteration.samples.theta[:, row]
    weights, top = iteration.final_weights, iteration.most_probable
    assert top is not None, "an iteration with weights has a heaviest sample"
    # The heaviest on top.
    order = [i for i in np.argsort(weights, kind="stable") if not iteration.failed[i]]
    relative = weights[order] / weights.max()
    notes = tuple(f"sample {iteration.samples.ids[i]}: weight {weights[i]:.2g}, ε = {percent(iteration.errors[i])}" for i in order)
    colours, sizes = colours_of(0.08 + 0.92 * relative), _SMALLEST + (_LARGEST - _SMALLEST) * np.sqrt(relative)
    failed = iteration.failed
    return (
        *ends(space, column, axes[column], upright=True),
        *ends(space, row, axes[row], upright=False),
        *_samples_of_key(),
        Points(x[order], y[order], _WEIGHTED, colours=tuple(colours), sizes=tuple(sizes), notes=notes),
        *([Points(x[failed], y[failed], FAILED, "failed")] if failed.any() else []),
        Points(x[[top]], y[[top]], _RING, "most probable"),
    )


def _samples_of_key() -> tuple[Points, ...]:
    """Points that stand in the key alone."""
    light, dark = colours_of([0.08, 1.0])
    nothing = np.zeros(0)
    return (
        Points(nothing, nothing, replace(_WEIGHTED, colour=light, size=_SMALLEST), "little weight"),
        Points(nothing, nothing, replace(_WEIGHTED, colour=dark, size=_LARGEST), "the largest weight"),
    )


def cell(r: float, telling: float) -> Panel:
    """A correlation, coloured from `telling` on, up or down."""
    return Panel(cell=(signed(r) if np.isfinite(r) else "–", sign_colour(r) if abs(r) >= telling else "#ffffff"))
