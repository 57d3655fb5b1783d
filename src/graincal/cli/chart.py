"""Curves drawn with characters, to compare two at a glance on a terminal."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

WIDTH, HEIGHT = 60, 12
_MARKS = "·o"


def chart(control: NDArray[np.float64], curves: Mapping[str, NDArray[np.float64]], *, title: str) -> str:
    """Up to two curves on the same control, the later one drawn over the earlier, with a legend above and the range of both axes."""
    values = [np.asarray(curve, dtype=np.float64) for curve in curves.values()]
    low, high = min(curve.min() for curve in values), max(curve.max() for curve in values)
    height = high - low if high > low else 1.0
    field = [[" "] * WIDTH for _ in range(HEIGHT)]
    where = np.linspace(control[0], control[-1], WIDTH)
    for mark, curve in zip(_MARKS, values):
        levels = np.round((np.interp(where, control, curve) - low) / height * (HEIGHT - 1)).astype(int)
        for column, level in enumerate(levels):
            field[HEIGHT - 1 - level][column] = mark
    margin = 8
    legend = "   ".join(f"{mark} {name}" for mark, name in zip(_MARKS, curves))
    labels = [f"{high:.3g}"] + [""] * (HEIGHT - 2) + [f"{low:.3g}"]
    rows = [f"{label:>{margin}} │{''.join(line).rstrip()}" for label, line in zip(labels, field)]
    axis = f"{'':>{margin}} └{'─' * WIDTH}"
    ends = f"{'':>{margin + 2}}{control[0]:<{WIDTH // 2}.3g}{control[-1]:>{WIDTH // 2}.3g}"
    return "\n".join([f"{'':>{margin + 2}}{title}     {legend}", *rows, axis, ends])
