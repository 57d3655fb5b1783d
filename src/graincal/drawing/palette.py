"""Colours and strokes. They survive a grey printer and colour blindness: Okabe and Ito's colours, told apart by stroke too, and even colour scales."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import matplotlib
import numpy as np
from matplotlib.colors import to_hex
from numpy.typing import ArrayLike

BLACK, BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, GREY = (
    "#000000", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7a7a7a",
)  # fmt: skip


Dash = Literal["solid", "dash", "dot", "dashdot"]

DASHES: dict[Dash, tuple[int, ...]] = {"solid": (), "dash": (8, 4), "dot": (2, 3), "dashdot": (8, 3, 2, 3)}
"""Lengths of dashes and gaps, CSS pixels."""


@dataclass(frozen=True)
class Style:
    """How a mark looks: a colour, a line's width and dashes or a point's symbol and size (both in CSS pixels), and its opacity."""

    colour: str
    width: float = 2.0
    dash: Dash = "solid"
    symbol: Literal["circle", "ring", "cross", "diamond", "square"] = "circle"
    size: float = 6.0
    opacity: float = 1.0


REFERENCE = Style(BLACK, symbol="ring", size=6)
RECORDED = Style(BLACK, symbol="cross", size=6, width=1.2)
BEST = Style(BLUE)
MOST_PROBABLE = Style(VERMILLION, dash="dash")
MEAN = Style(GREY, width=1.2, dash="dot")
BAND = Style(SKY, opacity=0.5)
RANGE = Style(GREEN, opacity=0.3)
MEASURED = Style(GREY, opacity=0.32)
ANSWER = Style(VERMILLION, width=1.5)
LIKELY = Style(GREEN, width=0.8, opacity=0.45)
FAILED = Style(GREY, symbol="cross", size=6, width=1.2)
TRUTH = Style(BLACK, width=1.5, dash="dash", symbol="diamond", size=9)
CENTRE = Style(VERMILLION, symbol="square", size=8)
LIMIT = Style(GREY, width=1.2)
THRESHOLD = Style("#444444", width=1.5, dash="dot")
PREDICTED = Style(GREEN, width=2.5)


def distinct(number: int) -> Style:
    """A line that differs from those of other numbers in colour and dashes."""
    colours = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY)
    dashes: tuple[Dash, ...] = ("solid", "dash", "dashdot", "dot")
    return Style(colours[number % len(colours)], dash=dashes[number % len(dashes)])


def sequence(count: int) -> list[Style]:
    """Points of a sequence, from light to dark: the last is what matters most."""
    shades = np.linspace(0.12, 1, count) if count > 1 else np.ones(1)
    return [Style(colour, size=5, opacity=0.85) for colour in colours_of(shades)]


def colours_of(shades: ArrayLike) -> Sequence[str]:
    """A colour for each of the values from 0 (light) to 1 (dark)."""
    return [to_hex(colour) for colour in matplotlib.colormaps["viridis_r"](np.asarray(shades, dtype=np.float64))]


def sign_colour(value: float) -> str:
    """The background for a number from -1 (orange) over 0 (white) to 1 (blue), light enough for black text."""
    target = np.array([0x56, 0xB4, 0xE9] if value > 0 else [0xE6, 0x9F, 0x00]) / 255
    return to_hex(1 - min(abs(value), 1.0) * (1 - target))
