"""Figures: where the samples went, and how the iterations converged (Hartmann, Cheng, Thornton 2022, Fig. 5 and 7)."""

from __future__ import annotations

import numpy as np

from graincal.campaign.found.answer import Candidate
from graincal.campaign.found.record import Record
from graincal.drawing.figure import Array, Axis, Figure, Level, Line, Mark, Panel, Points, counting_axis, log_axis
from graincal.drawing.palette import BEST, BLUE, FAILED, LIMIT, MOST_PROBABLE, THRESHOLD, TRUTH, VERMILLION, Style, sequence
from graincal.inference import Iteration, IterativeBayesianFilter, Stop
from graincal.inference.iterative.close_fits import close_fits
from graincal.notation.numbers import count, percent, value
from graincal.notation.quantities import parameters
from graincal.parameter_space import LOG
from graincal.report.answer import answer_of

_COLOURS = 12
"""As many as can be told apart; where there are more iterations, neighbours share one."""


def draw_samples(result: Record) -> Figure | None:
    """Error against each parameter for every sample, coloured by iteration, over the whole of the ranges."""
    if result.best is None:
        return None
    errors = log_axis("error ε [%]", result.errors)
    above = np.max(result.errors[np.isfinite(result.errors)])
    close = close_fits(result.iterations)
    coloured = _coloured(len(result.iterations), *(("batch", "batches") if result.has_posterior else ("iteration", "iterations")))
    panels = []
    for k, shown in enumerate(parameters(result.space)):
        low, high = float(result.space.low[k]), float(result.space.high[k])
        marks: list[Mark] = [Level(low, LIMIT, "range", upright=True), Level(high, LIMIT, upright=True)]
        marks += [_points(iteration, k, style, name) for iteration, (style, name) in zip(result.iterations, coloured)]
        if result.failures:
            marks.append(Points(result.samples[result.failed, k], np.full(result.failures, above), FAILED, "failed, no error known"))
        rings: list[tuple[Candidate | None, Style, str]] = [(result.best, BEST, "best")]
        if result.has_posterior:
            rings = [(answer_of(result), MOST_PROBABLE, "answer"), *rings] if result.answer and len(result.answer.samples) else rings
        else:
            rings = [(result.most_probable, MOST_PROBABLE, "most probable"), *rings]
        for candidate, style, name in rings:
            if candidate:
                ring = Style(style.colour, symbol="ring", size=12 if name == "best" else 16, width=2)
                marks.append(Points(candidate.theta[k : k + 1], np.array([candidate.error]), ring, name))
        if not result.has_posterior and close is not None:
            marks.append(Level(close.limit, THRESHOLD, f"fit about as well: ε up to {percent(close.limit)}"))
        if (truth := result.truth.get(result.space.names[k])) is not None:
            marks.append(Level(truth, TRUTH, "truth", upright=True))
        panels.append(Panel("", _over_range(shown.axis, low, high, result.space.scales[k]), errors, tuple(marks)))
    if result.has_posterior:
        iterations, below = f"{len(result.iterations)} batch{'es' * (len(result.iterations) > 1)}", ""
        if result.failures:
            below += " Crosses are failures, at the parameters that they had."
        if result.stopped.any():
            below += f" Of the {count(int(result.stopped.sum()), 'run')} that were stopped early, ε is the error of the states that they came to."
    else:
        iterations = count(len(result.iterations), "iteration")
        below = " The points below the dotted line fit about as well as the best: across the values that they have, a parameter is open."
    return Figure(
        "samples",
        f"{count(result.evaluations, 'sample')} in {iterations}: errors of {value(result.best.error, 3)} to {value(above, 3)} %.",
        "Each point is one evaluation, with its error ε; darker points are of later ones, and the grey lines are the ends of the range." + below,
        tuple(panels),
    )


def _over_range(label: str, low: float, high: float, scale: str) -> Axis:
    """An axis over the whole range of a parameter, and a little beyond."""
    if scale == LOG:
        beyond = (high / low) ** 0.03
        return log_axis(label, np.array([low, high]), limits=(low / beyond, high * beyond))
    margin = 0.03 * (high - low)
    return Axis(label, (low - margin, high + margin))


def draw_convergence(result: Record) -> Figure | None:
    """GL error, error of the most probable sample, s and effective sample size by iteration; None for a single iteration."""
    if len(result.iterations) < 2:
        return None
    index = np.array([iteration.index for iteration in result.iterations], dtype=np.float64)
    filter = result.calibration.blank_filter()
    assert isinstance(filter, IterativeBayesianFilter), "of the paper's method"
    stop, target = result.stop, filter.effective_sample_size
    gl_errors, errors, s, sizes = (
        np.array([getattr(iteration, name) for iteration in result.iterations]) for name in ("gl_error", "error", "s", "effective_sample_size")
    )
    panels = (
        _course("Errors", "error [%]", index, {"GL error ε_{GL}": gl_errors, "most probable sample's ε": errors}, stop.error),
        _course("Covariance coefficient", "s [-]", index, {"s": s}, stop.s),
        Panel(
            "Effective sample size",
            counting_axis("iteration", index[0], index[-1]),
            Axis("effective part [-]", (0, 1)),
            (Level(target, THRESHOLD), *_line(index, sizes, BLUE)),
        ),
    )
    weighted = [iteration for iteration in result.iterations if not iteration.unweighted]
    title = "No iteration has weights."
    if weighted:
        first, last = weighted[0], weighted[-1]
        title = f"The GL error went from {percent(first.gl_error)} in iteration {first.index} to {percent(last.gl_error)} in iteration {last.index}."
    caption = (
        "ε_{GL} is the mean error of the samples under their weights (Eq. 7). s says how far responses may be from the reference at a state and still count: "
        f"it is a relative variance, {Stop.s:g} a deviation of {100 * Stop.s**0.5:.0f} %. It is not chosen but solved for, so that the part of the samples that is asked for carries the weight, and "
        "falls as they come to fit better. Each further state adds its misfit to the sum that decides, so that the same fit gives a larger s where there are more "
        f"states: the paper's threshold of {Stop.s:g} is for about 50, and here there are {len(result.iterations[-1].weights)}. Divided by their number, as in the column s / states of the table below, it can be "
        "compared between tests. "
        "Dotted: the limits of the error and of s where these criteria are switched on, and the target of the effective part."
    )
    return Figure("convergence", title, caption, panels)


def _coloured(iterations: int, one: str, several: str) -> list[tuple[Style, str]]:
    """The style of each iteration, and what it is called in the key: every one stands there, alone or with those that share its colour."""
    groups = np.array_split(np.arange(iterations), min(_COLOURS, iterations))
    names = [f"{one} {group[0]}" if len(group) == 1 else f"{several} {group[0]} to {group[-1]}" for group in groups]
    return [(style, name) for style, name, group in zip(sequence(len(groups)), names, groups) for _ in group]


def _points(iteration: Iteration, k: int, style: Style, name: str) -> Points:
    usable = ~iteration.failed
    ids, errors = iteration.samples.ids[usable], iteration.errors[usable]
    stopped = np.zeros(len(ids), dtype=bool) if iteration.stopped is None else iteration.stopped[usable]
    notes = tuple(
        f"sample {id}, iteration {iteration.index}: ε = {percent(error)}{' as far as it was run' if early else ''}"
        for id, error, early in zip(ids, errors, stopped)
    )
    return Points(iteration.samples.theta[usable, k], errors, style, name, notes=notes)


def _course(title: str, label: str, index: Array, courses: dict[str, Array], threshold: float | bool) -> Panel:
    marks: list[Mark] = []
    values = np.concatenate(list(courses.values()))
    if threshold:
        marks.append(Level(threshold, THRESHOLD))
        values = np.append(values, threshold)
    for (name, values_of), colour in zip(courses.items(), (BLUE, VERMILLION)):
        marks += _line(index, values_of, colour, name if len(courses) > 1 else "")
    return Panel(title, counting_axis("iteration", index[0], index[-1]), log_axis(label, values), tuple(marks))


def _line(index: Array, values: Array, colour: str, name: str = "") -> tuple[Mark, Mark]:
    style = Style(colour, dash="dash" if colour == VERMILLION else "solid", symbol="diamond" if colour == VERMILLION else "circle", size=7)
    return Line(index, values, style, name), Points(index, values, style)
