"""How many evaluations may run at once."""

from __future__ import annotations

import os
from numbers import Integral
from typing import Literal

from graincal.data import InputError
from graincal.notation.printable import printable

MOST_WORKERS = 10_000
"""Evaluations at once, each of which has a thread at the least."""


def available_cores() -> int:
    """The cores that this process may use, which a cluster's scheduler or a container can make fewer than the machine has."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def number_of_workers(workers: int | Literal["all"]) -> int:
    """The evaluations that may run at once; "all" is one a core. Raises InputError for what is no such number."""
    if workers == "all":
        return available_cores()
    if isinstance(workers, bool) or not isinstance(workers, Integral) or workers < 1:
        raise InputError(f'workers must be a whole number above 0 or "all", not {workers!r}.')
    if workers > MOST_WORKERS:
        raise InputError(f"workers is {printable(workers, 30)}, and at most {MOST_WORKERS:,} was expected.")
    return int(workers)
