"""The report's figures of a campaign under way, and the responses of its last runs before and beside them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from graincal.campaign.found.emulated import Emulated
from graincal.campaign.found.record import Record
from graincal.campaign.stored.store import Store
from graincal.data import Response
from graincal.drawing.figure import Axis, Figure, Line, Mark, Panel
from graincal.drawing.palette import BLUE, Style
from graincal.notation.numbers import count
from graincal.notation.quantities import quantity
from graincal.report.emulated_figures import draw_bands, draw_emulator
from graincal.report.page import Page
from graincal.report.responses import control_axis, draw_responses, measured_points, on_axis
from graincal.report.run_times import draw_run_times
from graincal.report.sampling import draw_convergence, draw_samples

MOST_CURVES = 60
"""Runs whose responses are drawn, the last that ended."""

_RUN = Style(BLUE, width=1.0, opacity=0.35)


def figures(folder: Path) -> Iterator[dict[str, Any]]:
    """{name, html, plots: {id: Plotly's description}} of each figure that there is, the quickest first."""
    store = Store.open(folder)
    yield from _described(_latest(store))
    if not store.iterations():
        return
    result = Record(store, store.calibration)
    if result.has_posterior:
        yield from _described(draw_samples(result))
        if emulated := Emulated.of(result):
            yield from _described(draw_bands(emulated))
            yield from _described(draw_emulator(emulated))
    else:
        for draw in (draw_responses, draw_convergence, draw_samples):
            yield from _described(draw(result))
    yield from _described(draw_run_times(result))


def _described(figure: Figure | None) -> Iterator[dict[str, Any]]:
    if figure is not None:
        page = Page("", "")
        page.figure(figure)
        html, plots = page.parts()
        yield {"name": figure.name, "html": html, "plots": plots}


def _latest(store: Store) -> Figure | None:
    """The references, and the responses of the runs that ended last."""
    panels, most = [], 0
    several = len(store.calibration.experiments) > 1
    for number, experiment in enumerate(store.calibration.experiments):
        query = f"SELECT sample FROM evaluation WHERE experiment = ? AND state = 'finished' AND sample >= 0 ORDER BY ended DESC LIMIT {MOST_CURVES}"
        ids = [sample for (sample,) in store.database.rows(query, number)]
        runs = [run for run in store.outcomes(ids, number) if isinstance(run, Response)]
        most = max(most, len(runs))
        axis, x = control_axis(experiment)
        for name in experiment.reference.names:
            shown = quantity(name)
            marks: list[Mark] = [
                Line(on_axis(experiment, run.control), np.asarray(run.values[name]) * shown.scale, _RUN, "last runs") for run in runs if name in run.values
            ]
            marks.append(measured_points(experiment, name, x))
            panels.append(Panel(f"{experiment.name}: {shown.title}" if several else shown.title, axis, Axis(shown.axis), tuple(marks)))
    caption = f"The responses of the runs that ended last, {MOST_CURVES} at most, before they are weighed against each other."
    return Figure("latest", f"The data, and the last {count(most, 'run')}." if most else "The data. No run has ended yet.", caption, tuple(panels))
