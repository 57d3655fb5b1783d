"""Packings like a given one: what a material made of so few grains differs by from one packing to the next."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from graincal.dem.grading import GrainSizes
from graincal.dem.packing import Packing
from graincal.dem.preparation import VOID_RATIO_TOLERANCE, OutOfReach, prepare

MOST_PARTICLES = 1000
"""Of a sibling: a larger packing's are smaller than it is, for the preparation takes half a minute of a core a thousand grains."""

INWARDS = 4 * VOID_RATIO_TOLERANCE
"""So far within what a seed reaches its void ratio is asked for."""


def sibling_particles(packing: Packing) -> int:
    """How many grains its siblings have."""
    return min(packing.count, MOST_PARTICLES)


def siblings(packing: Packing, count: int, threads: int = 1, first_seed: int = 1, prepared: Callable[[int], None] = lambda number: None) -> list[Packing]:
    """`count` packings of the sizes of a packing's own grains, at its void ratio or the nearest that the protocol of `prepare` reaches with all of their seeds, from `first_seed` on.

    They have as many grains as the packing, or MOST_PARTICLES. Prepared once, and then found in the cache of `prepare`. prepared: hears how many there are so far. Raises InputError where none can be prepared.
    """
    sizes, particles, wanted = GrainSizes(2 * packing.radii), sibling_particles(packing), packing.void_ratio
    densest, loosest = -np.inf, np.inf
    while True:
        void_ratio = round(float(np.clip(wanted, densest, loosest)), 4)
        try:
            # One first, that what is out of reach of all is found by one.
            found = [prepare(particles, void_ratio, sizes, first_seed)]
            prepared(1)
            with ThreadPoolExecutor(max(1, threads)) as pool:
                for packing in pool.map(lambda seed: prepare(particles, void_ratio, sizes, seed), range(first_seed + 1, first_seed + count)):
                    found.append(packing)
                    prepared(len(found))
            return found
        except OutOfReach as reach:
            # Each seed has a range of its own, and all are to be at one void ratio.
            densest, loosest = max(densest, reach.densest + INWARDS), min(loosest, reach.loosest - INWARDS)
            if densest > loosest or void_ratio == round(float(np.clip(wanted, densest, loosest)), 4):
                raise
