"""Figures: the reference against what the calibrated model gives, and the fabric behind it."""

from __future__ import annotations

import numpy as np

from graincal.campaign import Candidate, Experiment, Result
from graincal.data import Response
from graincal.report.drawing import Array, Axis, Band, Figure, Line, Mark, Panel, Points
from graincal.report.findings import MOST, PROBABILITY
from graincal.report.palette import BAND, BEST, MEAN, MOST_PROBABLE, REFERENCE, distinct
from graincal.report.quantities import Quantity, quantity

FABRIC = ("coordination_number", "a_c", "a_n", "a_t")


def draw_responses(result: Result) -> Figure | None:
    """Reference, best and most probable response of each observable of each experiment, with the band of the weighted responses."""
    panels = [panel for number in range(len(result.experiments)) for panel in _panels(result, number)]
    if result.best is None:
        return None
    answer = result.most_probable
    title = f"The best response is {result.best.error:.3g} % from the reference"
    if answer:
        same = answer.sample == result.best.sample
        title = f"The most probable response is {answer.error:.3g} % from the reference, " + ("and is the best" if same else f"the best {result.best.error:.3g} %")
    caption = (
        f"The band holds {MOST} of iteration {answer.iteration}'s responses, state by state; the dotted line is their mean."
        if answer
        else "No iteration has weights, so that there is neither a most probable response nor a band."
    )
    return Figure("responses", f"{title}.", f"{caption} Each panel's error (Eq. 5) is that of the {'most probable' if answer else 'best'} response.", tuple(panels), _columns(result))


def draw_fabric(result: Result) -> Figure | None:
    """Coordination number and anisotropies of the best response, where the model returns them."""
    panels = []
    for experiment in result.experiments if result.best else ():
        response = result.response(result.best.sample, experiment.name)
        if isinstance(response, Response):
            panels += _fabric_panels(response, experiment, len(result.experiments) > 1)
    if not panels:
        return None
    return Figure(
        "fabric",
        "The fabric of the best response.",
        "Z is the mean number of contacts of a particle; a_{c}, a_{n} and a_{t} are the anisotropies of the contacts' directions, normal forces and tangential forces.",
        tuple(panels),
        columns=2,
    )


def control_axis(experiment: Experiment) -> tuple[Quantity, Axis, Array]:
    """The control variable of an experiment: what it is, its axis and its values as shown."""
    control = quantity(experiment.reference.control_name)
    return control, Axis(control.axis), experiment.reference.control * control.scale


def _columns(result: Result) -> int:
    """A row for each experiment, where it has two or three observables."""
    observables = {len(experiment.reference.names) for experiment in result.experiments}
    return observables.pop() if observables in ({2}, {3}) else 3


def _panels(result: Result, number: int) -> list[Panel]:
    experiment = result.experiments[number]
    reference = experiment.reference
    _, axis, x = control_axis(experiment)
    answer = result.most_probable
    weighted = result.responses(answer.iteration, number) if answer else {}
    panels = []
    for name in reference.names:
        shown = quantity(name)
        marks: list[Mark] = []
        if answer:
            low, high = result.posterior.interval(PROBABILITY, of=weighted[name]) * shown.scale
            marks.append(Band(x, low, high, BAND, MOST))
            marks.append(Line(x, result.posterior.mean(of=weighted[name]) * shown.scale, MEAN, "weighted mean"))
        marks += _candidate_lines(result, number, name, x, shown)
        marks.append(Points(x, reference.observables[name] * shown.scale, REFERENCE, "reference"))
        panels.append(Panel(_title(result, number, name, shown), axis, Axis(shown.axis), tuple(marks)))
    return panels


def _candidate_lines(result: Result, number: int, name: str, x: Array, shown: Quantity) -> list[Mark]:
    candidates: list[tuple[Candidate | None, str]] = [(result.best, "best"), (result.most_probable, "most probable")]
    if result.best and result.most_probable and result.best.sample == result.most_probable.sample:
        candidates = [(result.best, "best, and most probable")]
    lines: list[Mark] = []
    for candidate, words in candidates:
        response = result.response(candidate.sample, number) if candidate else None
        if isinstance(response, Response):
            lines.append(Line(x, response.values[name] * shown.scale, MOST_PROBABLE if words == "most probable" else BEST, words))
    return lines


def _title(result: Result, number: int, name: str, shown: Quantity) -> str:
    column = sum(len(experiment.reference.names) for experiment in result.experiments[:number]) + result.experiments[number].reference.names.index(name)
    candidate = result.most_probable or result.best
    error = ""
    if candidate:
        error = f", error {result.observable_errors[int(np.searchsorted(result.ids, candidate.sample)), column]:.2g} %"
    return (f"{result.experiments[number].name}: {shown.title}" if len(result.experiments) > 1 else shown.title) + error


def _fabric_panels(response: Response, experiment: Experiment, several: bool) -> list[Panel]:
    _, axis, x = control_axis(experiment)
    prefix = f"{experiment.name}: " if several else ""
    panels = []
    if "coordination_number" in response.values:
        shown = quantity("coordination_number")
        panels.append(Panel(f"{prefix}{shown.title}", axis, Axis(shown.axis), (Line(x, response.values["coordination_number"], BEST),)))
    anisotropies = [name for name in FABRIC[1:] if name in response.values]
    lines = tuple(Line(x, response.values[name], distinct(k), quantity(name).label) for k, name in enumerate(anisotropies))
    if lines:
        panels.append(Panel(f"{prefix}Anisotropies", axis, Axis("anisotropy [-]"), lines))
    return panels
