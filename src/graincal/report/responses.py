"""Figures: the reference against what the calibrated model gives, and the fabric behind it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from graincal.campaign import Experiment
from graincal.campaign.found.answer import Candidate
from graincal.campaign.found.findings import MOST
from graincal.campaign.found.record import Record
from graincal.data import Response
from graincal.drawing.figure import Array, Axis, Band, Figure, Line, Mark, Panel, Points, log_axis
from graincal.drawing.palette import BAND, BEST, MEAN, MOST_PROBABLE, RECORDED, REFERENCE, Style, distinct
from graincal.drawing.sight import in_sight
from graincal.inference.sampling.posterior import PROBABILITY, Posterior
from graincal.notation.numbers import percent
from graincal.notation.quantities import quantity
from graincal.positions import legs
from graincal.report.answer import answer_of, errors_of, recorded_errors_of

MANY_POINTS = 100
"""Points of a reference, from which they are drawn smaller."""
NOT_FITTED = ", not fitted"
UNSEEN = "What is not fitted was measured in the same test, and the calibration did not see it."
_ANISOTROPIES = ("a_c", "a_n", "a_t")
_COORDINATION = distinct(len(_ANISOTROPIES))


def draw_responses(result: Record) -> Figure | None:
    """Reference, best and most probable response of each observable of each experiment, and of what was recorded beside them, with the band of the weighted responses."""
    best, most_probable = result.best, result.most_probable
    if best is None:
        return None
    if most_probable is None:
        title = f"The best response is {percent(best.error)} from the reference."
        caption = "No iteration has weights, so that there is neither a most probable response nor a band. Errors (Eq. 5) are those of the best response."
    else:
        compared = "and is the best" if best.sample == most_probable.sample else f"the best {percent(best.error)}"
        title = f"The most probable response is {percent(most_probable.error)} from the reference, {compared}."
        caption = (
            f"The band holds {MOST} of iteration {most_probable.iteration}'s responses, state by state; the dotted line is their mean. "
            "Errors (Eq. 5) are those of the most probable response."
        )
    panels = tuple(panel for number in range(len(result.experiments)) for panel in _panels(result, number))
    caption += f" {UNSEEN}" if result.recorded_names else ""
    panels, cut = in_sight(panels)
    caption += f" {cut}" if cut else ""
    return Figure("responses", title, caption, panels, columns=side_by_side(result))


def side_by_side(result: Record) -> int:
    """How many panels of responses: a row for each experiment, where it has two or three."""
    measured = {len(experiment.reference.measured) for experiment in result.experiments}
    return measured.pop() if measured in ({2}, {3}) else 3


def measured_points(experiment: Experiment, name: str, x: Array) -> Points:
    """What was measured of a quantity, over x (T,): the reference, or what was recorded beside it."""
    style, words = (RECORDED, "recorded, not fitted") if name in experiment.reference.recorded else (REFERENCE, "reference")
    if len(x) > MANY_POINTS:
        # Rings of the usual size would hide what is drawn below them.
        style = replace(style, size=style.size / 2)
    return Points(x, experiment.reference.measured[name] * quantity(name).scale, style, words)


def draw_fabric(result: Record) -> Figure | None:
    """Coordination number and anisotropies of the answer's or else of the best response, where the model returns them."""
    best = result.best
    panels = [panel for experiment in result.experiments for panel in _fabric_panels(result, best, experiment)] if best else []
    if not panels:
        return None
    caption = (
        "Z is the mean number of contacts of a particle; a_{c}, a_{n} and a_{t} are the anisotropies of the contacts' directions, of their normal "
        "forces and of their tangential forces. At the start a_{c} may be slightly negative: it is near 0 then, and a few hundred contacts scatter about it."
    )
    of = "answer" if result.has_posterior and result.answer and len(result.answer.samples) else "best response"
    return Figure("fabric", f"The fabric of the {of}.", caption, tuple(panels), columns=2)


def control_axis(experiment: Experiment) -> tuple[Axis, Array]:
    """The axis that an experiment's curves are drawn over, and the reference's values on it."""
    name, values, logarithmic = experiment.abscissa(experiment.reference.control)
    shown = quantity(name)
    return log_axis(shown.axis, values * shown.scale) if logarithmic else Axis(shown.axis), values * shown.scale


def on_axis(experiment: Experiment, control: Array) -> Array:
    """Control values (S,) as they are on that axis."""
    name, values, _ = experiment.abscissa(control)
    return values * quantity(name).scale


def bands(x: Array, low: Array, high: Array, style: Style, name: str) -> list[Mark]:
    """The area between low and high; of a path that turns around each leg by itself, for an area that folds over would have holes."""
    return [Band(x[leg], low[leg], high[leg], style, name) for leg in legs(x)]


def _panels(result: Record, number: int) -> list[Panel]:
    experiment = result.experiments[number]
    answer, recorded = answer_of(result), experiment.reference.recorded
    assert answer is not None, "there is a best sample"
    errors = {**errors_of(result, answer)[number], **recorded_errors_of(result, answer)[number]}
    axis, x = control_axis(experiment)
    curves = _weighted_and_candidates(result, number)
    panels = []
    for name in experiment.reference.measured:
        shown = quantity(name)
        title = f"{prefix(result, experiment)}{shown.title}{NOT_FITTED * (name in recorded)}, error {percent(errors[name], 2)}"
        panels.append(Panel(title, axis, Axis(shown.axis), (*curves[name], measured_points(experiment, name, x))))
    return panels


def _weighted_and_candidates(result: Record, number: int) -> dict[str, list[Mark]]:
    """By observable: the band and the mean of the weighted responses, the best and the most probable one."""
    experiment = result.experiments[number]
    names = tuple(experiment.reference.measured)
    best, most_probable = result.best, result.most_probable
    marks: dict[str, list[Mark]] = {name: [] for name in names}
    posterior = result.posterior
    if most_probable and posterior is not None:
        weighted, x = result.responses(most_probable.iteration, number), on_axis(experiment, result.states(number))
        for name in names:
            if carried := _of_whole_curves(posterior, weighted[name]):
                low, high = carried.interval(PROBABILITY, of=weighted[name]) * quantity(name).scale
                marks[name] += bands(x, low, high, BAND, MOST)
                marks[name].append(Line(x, carried.mean(of=weighted[name]) * quantity(name).scale, MEAN, "weighted mean"))
    lines = [(best, BEST, "best"), (most_probable, MOST_PROBABLE, "most probable")]
    if most_probable and best and best.sample == most_probable.sample:
        lines = [(best, BEST, "best, and most probable")]
    for candidate, style, words in lines:
        if candidate:
            response = result.response(candidate.sample, number)
            assert isinstance(response, Response), "one with an error has a response"
            for name in names:
                marks[name].append(Line(on_axis(experiment, response.control), response.values[name] * quantity(name).scale, style, words))
    return marks


def _of_whole_curves(posterior: Posterior, curves: Array) -> Posterior | None:
    """The samples whose curves (N, S) are finite throughout, as what was recorded need not be; None where none of them carries weight."""
    without = ~np.isfinite(curves).all(axis=1) & (posterior.weights > 0)
    if not without.any():
        return posterior
    weights = np.where(without, 0, posterior.weights)
    return replace(posterior, weights=weights / weights.sum()) if weights.any() else None


def _fabric_panels(result: Record, best: Candidate, experiment: Experiment) -> list[Panel]:
    mean = result.mean_response(result.answer, experiment.name) if result.answer else None
    response = mean or result.response(best.sample, experiment.name)
    assert isinstance(response, Response), "the best sample has a response"
    values, (axis, _) = response.values, control_axis(experiment)
    x = on_axis(experiment, response.control)
    panels = []
    if "coordination_number" in values:
        shown = quantity("coordination_number")
        panels.append(
            Panel(f"{prefix(result, experiment)}{shown.title}", axis, Axis(shown.axis), (Line(x, values["coordination_number"], _COORDINATION, "Z"),))
        )
    lines = tuple(Line(x, values[name], distinct(k), quantity(name).label) for k, name in enumerate(_ANISOTROPIES) if name in values)
    if lines:
        panels.append(Panel(f"{prefix(result, experiment)}Anisotropies", axis, Axis("anisotropy [-]"), lines))
    return panels


def prefix(result: Record, experiment: Experiment) -> str:
    """The experiment's name before a panel's title, where there are several."""
    return f"{experiment.name}: " if len(result.experiments) > 1 else ""
