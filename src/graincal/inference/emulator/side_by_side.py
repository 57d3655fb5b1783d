"""Work on an emulator's components side by side: each by one thread alone, so that its digits do not depend on how many there are."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar
from functools import lru_cache
from typing import TypeVar

from graincal.execution.cores import available_cores

# An emulator has hardly more components than this.
MOST_THREADS = 8

# Numbers in a component's largest matrix from which on a thread's start costs less than it saves.
WORTH_A_THREAD = 2**15

_allowed: ContextVar[int] = ContextVar("threads of a look", default=MOST_THREADS)

Item = TypeVar("Item")
Outcome = TypeVar("Outcome")


@contextmanager
def by_at_most(threads: int) -> Iterator[None]:
    """Use no more threads than these within; without it as many as there are cores."""
    token = _allowed.set(threads)
    try:
        yield
    finally:
        _allowed.reset(token)


def side_by_side(function: Callable[[Item], Outcome], items: Sequence[Item], numbers: int) -> list[Outcome]:
    """What a function makes of each of several items, in their order. numbers: how many are in an item's largest matrix."""
    threads = min(_allowed.get(), MOST_THREADS, available_cores())
    if threads < 2 or len(items) < 2 or numbers < WORTH_A_THREAD:
        return [function(each) for each in items]
    return list(_pool(threads).map(function, items))


@lru_cache(maxsize=1)
def _pool(threads: int) -> ThreadPoolExecutor:
    """Threads that wait for work: to start them for each piece would take as long as a small piece does."""
    return ThreadPoolExecutor(threads, thread_name_prefix="graincal look")


if hasattr(os, "register_at_fork"):
    # A fork has none of them.
    os.register_at_fork(after_in_child=_pool.cache_clear)
