"""The table that programs on ranks of truths print: how far they are from uniform, and how often intervals hold the truth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from graincal.inference.sampling.ranks import UniformBand

FAMILYWISE = 0.05
LEVELS = (0.5, 0.9)


def show(title: str, ranks: Mapping[str, NDArray[np.int64]], draws: int, judged: Sequence[str]) -> bool:
    """Print it, for ranks (count,) from 0 to draws of each quantity; whether all that are judged stay within a band that any of them would leave by chance in one case of twenty."""
    band = UniformBand.of(len(next(iter(ranks.values()))), draws, 1 - FAMILYWISE / len(judged), np.random.default_rng(1))
    print(f"\n{title}")
    print(f"{'':18}{'furthest':>10}{'p-value':>9}{'band':>9}{'in 50 %':>10}{'in 90 %':>10}")
    for name, many in ranks.items():
        difference = band.distribution(many) - band.below
        furthest = difference[np.argmax(np.abs(difference))]
        held = [f"{np.mean(inside(many, draws, level)):>10.2f}" for level in LEVELS]
        print(f"{name:18}{furthest:>+10.3f}{band.probability(many):>9.4f}{'within' if band.holds(many) else 'left':>9}{''.join(held)}")
    uniform = all(band.holds(ranks[name]) for name in judged)
    print("uniform ranks, as far as one can tell" if uniform else "refused")
    return uniform


def inside(ranks: NDArray[np.int64], draws: int, level: float) -> NDArray[np.bool_]:
    """Which central intervals of this probability hold the truth."""
    return np.abs(ranks - draws / 2) < level * (draws + 1) / 2
