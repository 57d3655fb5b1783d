"""Figures of the emulated posterior: its responses, its parameters in pairs, and how the emulator did from batch to batch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from graincal.campaign.found.emulated import DRAWN, Emulated
from graincal.campaign.found.record import on_states
from graincal.campaign.found.recorded import in_percent, recorded_of_answer
from graincal.campaign.found.remarks import RIDGE
from graincal.data import ParameterSpace, Response
from graincal.drawing.figure import Array, Axis, Band, Figure, Level, Line, Mark, Panel, Points, counting_axis, log_axis
from graincal.drawing.palette import ANSWER, BAND, BLUE, LIMIT, MEASURED, RANGE, THRESHOLD, VERMILLION, Style
from graincal.drawing.sight import in_sight
from graincal.inference.sampling.posterior import PROBABILITY
from graincal.inference.sampling.samples import halton
from graincal.notation import numbers
from graincal.notation.quantities import parameters, quantity
from graincal.notation.words import listed
from graincal.report.pairs import axis_of_parameter, bare, bars, cell, centres, ends, histogram, in_lines, truth_of_pair, truth_of_parameter
from graincal.report.responses import NOT_FITTED, UNSEEN, bands, control_axis, measured_points, on_axis, prefix, side_by_side

_MOST = f"{100 * PROBABILITY:.0f} %"
ALIKE = 1.15
"""Widths of the two bands, one over the other, up to which they look alike."""
_BINS = 24
OF_PRIOR = 20_000
"""Samples that a prior is drawn by which is not even."""
_SAMPLE = Style(BLUE, size=4, opacity=0.35)
_RING = Style(VERMILLION, symbol="ring", size=14)


def draw_bands(emulated: Emulated) -> Figure:
    """Reference and runs at the answer, with the bands of the mean response and of a measurement, for each observable of each experiment; and what was recorded beside them."""
    result, answer = emulated.result, emulated.answer
    panels = []
    for number, experiment in enumerate(result.experiments):
        axis, x = control_axis(experiment)
        runs = [run for id in answer.samples if isinstance(run := result.response(int(id), number), Response)]
        found = emulated.bands[number]
        states = on_axis(experiment, found.control)
        for place, name in enumerate(experiment.reference.names):
            shown = quantity(name)
            (lowest, highest), (low, high) = (shown.scale * ends[:, :, place] for ends in (found.measurement, found.response))
            marks: list[Mark] = [
                *bands(states, lowest, highest, MEASURED, f"{_MOST} of measurements"),
                *bands(states, low, high, BAND, f"{_MOST} of mean responses"),
            ]
            marks += [Line(on_axis(experiment, run.control), run.values[name] * shown.scale, ANSWER, "runs at the answer") for run in runs]
            marks.append(measured_points(experiment, name, x))
            panels.append(Panel(f"{prefix(result, experiment)}{shown.title}", axis, Axis(shown.axis), tuple(marks)))
        panels += [_recorded_panel(emulated, number, name, runs) for name in experiment.reference.recorded]
    caption = (
        "The narrow band is where the mean response lies, given all that is known of the parameters and of the emulator; the wide one is where a measurement "
        f"of it would, errors included: about nine in ten points of the reference belong there. Each holds {_MOST}, state by state. "
        "The runs at the answer are single runs; where the simulator scatters, one of them may lie outside."
    )
    if result.recorded_names:
        caption += f" {UNSEEN} No emulator knows it: its band is the range of the runs that fit about as well, and responses beyond it may fit, too."
    caption += _on_bands(emulated)
    in_view, cut = in_sight(panels)
    caption += f" {cut}" if cut else ""
    if np.isfinite(answer.mean):
        title = f"The answer's responses are {numbers.repeated(answer.mean, answer.spread)} % from the reference."
    else:
        title = "What the posterior expects of the responses."
    return Figure("responses", title, caption, in_view, columns=side_by_side(result))


def _on_bands(emulated: Emulated) -> str:
    """Sentences on bands that look alike, or of which the wide one is not the wider."""
    alike, swapped = [], []
    for experiment, found in zip(emulated.result.experiments, emulated.bands):
        widths = [np.diff(each, axis=0)[0].T for each in (found.response, found.measurement)]
        for name, of_response, of_measurement in zip(experiment.reference.names, *widths):
            label = f"{prefix(emulated.result, experiment)}{quantity(name).label}"
            if np.median(of_measurement) < ALIKE * np.median(of_response):
                alike.append(label)
            elif np.any(of_measurement < of_response):
                swapped.append(label)
    said = f" In {listed(alike)} the two nearly coincide: errors are small beside what is not known of the mean response." if alike else ""
    return said + (f" In {listed(swapped)} the wide band is the narrower at some states, for its ends are known by {DRAWN} draws." if swapped else "")


def _recorded_panel(emulated: Emulated, number: int, name: str, at_answer: list[Response]) -> Panel:
    """What was recorded of a quantity and not fitted, in the experiment of a number, beside the runs at the answer and the range of those that fit about as well."""
    result, experiment, shown = emulated.result, emulated.result.experiments[number], quantity(name)
    axis, x = control_axis(experiment)
    states = result.states(number)
    responses = [run for id in emulated.likely if isinstance(run := on_states(result.response(int(id), number), states), Response)]
    curves = np.array([run.values[name] for run in responses if np.isfinite(run.values[name]).all()])
    marks: list[Mark] = []
    if len(curves) > 1:
        low, high = shown.scale * curves.min(axis=0), shown.scale * curves.max(axis=0)
        marks += bands(on_axis(experiment, states), low, high, RANGE, "range of the runs that fit about as well")
    marks += [Line(on_axis(experiment, run.control), run.values[name] * shown.scale, ANSWER, "runs at the answer") for run in at_answer]
    marks.append(measured_points(experiment, name, x))
    (error,) = (each for each in recorded_of_answer(result) if (each.experiment, each.name) == (experiment.name, name))
    return Panel(f"{prefix(result, experiment)}{shown.title}{NOT_FITTED}, error {in_percent(error)}", axis, Axis(shown.axis), tuple(marks))


def draw_emulated_pairs(emulated: Emulated) -> Figure:
    """The posterior in pairs of parameters: histograms on the diagonal beside the prior, pairs below it, correlations above."""
    space = emulated.result.space
    axes = [_axis(emulated, k, in_lines(shown.axis)) for k, shown in enumerate(parameters(space))]
    n = len(axes)
    title = f"The posterior, by {DRAWN} of its samples."
    said = f"Histograms are of the probability; the dotted line is the prior{', even over the whole range' if space.is_even else ''}. Axes span the posterior, grey lines are ends of a range."
    if n == 1:
        panel = Panel("", axes[0], Axis("probability [-]"), _histogram(emulated, 0, axes[0]))
        return Figure("posterior", title, said, (panel,))
    correlation = emulated.posterior.correlation()
    panels = tuple(
        cell(float(correlation[row, column]), RIDGE) if column > row else _panel(emulated, axes, row, column) for row in range(n) for column in range(n)
    )
    caption = f"{said} Below the diagonal: samples of equal probability, and the answer. Above it: correlations, coloured from {RIDGE:g} on, up or down, which is a ridge."
    return Figure("posterior", title, caption, panels, columns=n, square=True)


def draw_emulator(emulated: Emulated) -> Figure | None:
    """How far what the emulator does not know may move the posterior after each batch, and how the emulator predicts what it has not seen; None for a single batch."""
    result = emulated.result
    if len(result.iterations) < 2:
        return None
    index = np.array([iteration.index for iteration in result.iterations], dtype=np.float64)
    doubt, held_out, coverage, evidence, spread = (
        np.array([getattr(learnt, name) for learnt in result.learnt]) for name in ("doubt", "held_out_error", "coverage", "log_evidence", "log_evidence_std")
    )
    enough = result.stop.posterior_shift
    level = [Level(enough, THRESHOLD, "enough, or as it should be")] if enough else []
    axis = counting_axis("batch", 0.0, index[-1])
    panels = (
        Panel("Doubt", axis, log_axis("standard deviations", np.append(doubt, enough or np.nan)), (*level, *_course(index, doubt))),
        Panel("Held-out error", axis, log_axis("part of the spread [%]", 100 * held_out), _course(index, 100 * held_out)),
        Panel("Coverage", axis, Axis("within the intervals [%]", (0, 104)), (Level(100 * PROBABILITY, THRESHOLD), *_course(index, 100 * coverage))),
        Panel("Log evidence", axis, Axis("log p(reference)"), (Band(index, evidence - spread, evidence + spread, BAND), *_course(index, evidence))),
    )
    caption = (
        "Doubt: how far what the emulator does not know may move a mean or a spread, in standard deviations, whichever is most. Held-out error: each run as predicted "
        "from all others by an emulator of the same lengths, those near the posterior above all, over the spread of the responses; where their mean predicts no worse, the emulator is "
        f"dropped for the next batch. Coverage: how many of the runs nearest to the reference lie in the emulator's {_MOST} intervals. The last batch are the runs at the answer, once they are done."
    )
    last = held_out[np.isfinite(held_out)]
    return Figure("emulator", f"The emulator misses held-out runs by {100 * last[-1]:.2g} % of the spread of the responses.", caption, panels, columns=2)


def _course(x: Array, y: Array) -> tuple[Mark, Mark]:
    style = Style(BLUE, size=7)
    return Line(x, y, style), Points(x, y, style)


def _axis(emulated: Emulated, k: int, label: str) -> Axis:
    """Over nearly all of the posterior, the answer, and the truth where it is known."""
    space, result = emulated.result.space, emulated.result
    low, high = emulated.posterior.interval(0.998)[:, k]
    values = [low, high, emulated.answer.theta[k], result.truth.get(space.names[k], low)]
    low, high = float(min(values)), float(max(values))
    return axis_of_parameter(space, k, label, low, high)


def _panel(emulated: Emulated, axes: list[Axis], row: int, column: int) -> Panel:
    x = axes[column] if row == len(axes) - 1 else bare(axes[column])
    if column == row:
        return Panel("", x, Axis(ticks=()), _histogram(emulated, row, axes[row]))
    space, theta, answer = emulated.result.space, emulated.theta, emulated.answer.theta
    marks = (
        *ends(space, column, axes[column], upright=True),
        *ends(space, row, axes[row], upright=False),
        Points(theta[:, column], theta[:, row], _SAMPLE, "samples of the posterior"),
        Points(answer[[column]], answer[[row]], _RING, "answer"),
        *centres(emulated.modes, row, column),
        *truth_of_pair(emulated.result, row, column),
    )
    return Panel("", x, axes[row] if column == 0 else bare(axes[row]), marks)


def _prior(space: ParameterSpace, k: int, edges: Array) -> Mark:
    """The prior's probability in the bins of a parameter's histogram."""
    style = replace(LIMIT, dash="dot")
    if space.is_even:
        return Level(float((edges[1] - edges[0]) / (space.high[k] - space.low[k])), style, "prior")
    theta = halton(space, OF_PRIOR, np.random.default_rng(0))
    heights, _ = np.histogram(theta[:, k], bins=edges)
    return Line(np.repeat(edges, 2)[1:-1], np.repeat(heights / OF_PRIOR, 2), style, "prior")


def _histogram(emulated: Emulated, k: int, axis: Axis) -> tuple[Mark, ...]:
    space, posterior = emulated.result.space, emulated.posterior
    heights, edges = histogram(posterior.samples[:, k], posterior.weights, _BINS, axis)
    return (
        bars(edges, heights, replace(_SAMPLE, opacity=0.85), axis),
        _prior(space, k, edges),
        *ends(space, k, axis, upright=True),
        *truth_of_parameter(emulated.result, k, upright=True),
    )
