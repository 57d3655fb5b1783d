"""The figure of `graincal advise`: what each test would tell, and how far it would narrow each parameter."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from graincal.campaign import Advice
from graincal.data import InputError
from graincal.drawing.palette import BLACK, GREY, distinct
from graincal.files import unwritable
from graincal.notation.glyphs import missing_glyphs_unsaid
from graincal.notation.markup import to_mathtext
from graincal.notation.quantities import parameters

_MARKERS = ("o", "s", "D", "^", "v", "P", "X")
_SPREAD = 0.5
"""Of the distance of two tests: the parameters of one stand on lines of their own, one below the other."""


def draw_advice(advice: Advice, path: Path) -> None:
    """The expected information gain, and standard deviations after each test over those now, with standard errors; the best test on top."""
    tests, names = advice.tests, parameters(advice.space)
    figure = Figure(figsize=(7.5, 1.3 + 0.55 * len(tests)), layout="constrained")
    gain, narrowing = figure.subplots(1, 2, sharey=True, width_ratios=(1, 1.8))
    places = np.arange(len(tests))
    gain.errorbar([each.information for each in tests], places, xerr=[each.information_error for each in tests], fmt="o", color=BLACK, markersize=4, capsize=2)
    gain.set(xlabel="expected information\ngain [nats]", yticks=places, yticklabels=[to_mathtext(each.name) for each in tests], ylim=(len(tests) - 0.5, -0.5))
    gain.set_xlim(left=min(0.0, gain.get_xlim()[0]))
    for k, name in enumerate(names):
        offset = _SPREAD * ((k + 0.5) / len(names) - 0.5)
        shares, errors = ([float(values[k]) for values in each] for each in ([test.shares for test in tests], [test.share_errors for test in tests]))
        narrowing.errorbar(
            shares,
            places + offset,
            xerr=errors,
            fmt=_MARKERS[k % len(_MARKERS)],
            color=distinct(k).colour,
            markersize=4,
            capsize=2,
            linewidth=1,
            label=to_mathtext(name.label),
        )
    narrowing.axvline(1.0, color=GREY, linewidth=0.8)
    narrowing.set(xlabel="standard deviation\nafter the test / now [-]")
    narrowing.set_xlim(left=0)
    for axes in (gain, narrowing):
        axes.grid(axis="x", linewidth=0.3)
        axes.spines[["top", "right"]].set_visible(False)
    figure.legend(*narrowing.get_legend_handles_labels(), loc="outside upper center", ncols=min(len(names), 6), frameon=False)
    try:
        with missing_glyphs_unsaid():
            figure.savefig(path, dpi=150)
    except OSError as error:
        raise InputError(unwritable(path, error)) from None
