"""Packings like a given one: what a material made of so few grains differs by from one packing to the next."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

from graincal.dem.grading import GrainSizes
from graincal.dem.packing import Packing
from graincal.dem.preparation import VOID_RATIO_TOLERANCE, OutOfReach, prepare

MOST_PARTICLES = 1000
"""Of a sibling: a larger packing's are smaller than it is, for the preparation takes half a minute of a core a thousand grains."""


def sibling_particles(packing: Packing) -> int:
    """How many grains its siblings have."""
    return min(packing.count, MOST_PARTICLES)


def siblings(packing: Packing, count: int, threads: int = 1, first_seed: int = 1) -> list[Packing]:
    """`count` packings of the sizes of a packing's own grains, at its void ratio or the nearest that the protocol of `prepare` reaches, by the seeds from `first_seed` on.

    They have as many grains as the packing, or MOST_PARTICLES. Prepared once, and then found in the cache of `prepare`. Raises InputError where none can be prepared.
    """
    sizes, particles, void_ratio = GrainSizes(2 * packing.radii), sibling_particles(packing), round(packing.void_ratio, 4)
    try:
        first = prepare(particles, void_ratio, sizes, first_seed)
    except OutOfReach as range:
        inwards = 4 * VOID_RATIO_TOLERANCE
        void_ratio = round(min(max(void_ratio, range.densest + inwards), range.loosest - inwards), 4)
        first = prepare(particles, void_ratio, sizes, first_seed)
    with ThreadPoolExecutor(max(1, threads)) as pool:
        return [first, *pool.map(lambda seed: prepare(particles, void_ratio, sizes, seed), _seeds(first_seed, count)[1:])]


def _seeds(first: int, count: int) -> Sequence[int]:
    return range(first, first + count)
