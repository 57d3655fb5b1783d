"""Evaluations of one sample at a time, for whoever decides at each end what is evaluated next."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from graincal.data import Failure, Response, Samples


def _nothing() -> None:
    pass


@dataclass(frozen=True, eq=False)
class OneByOne:
    """How a model evaluates single samples.

    evaluate: takes one sample and returns its outcome once it is there; it is called from several threads at once. stop: ends what is under way, as far
    as it can be ended; whatever `evaluate` then returns or raises is not looked at. queues: the samples wait in a queue of the model's own, an
    executor's, so that as many may be handed over as there are.
    """

    evaluate: Callable[[Samples], Response | Failure]
    stop: Callable[[], None] = _nothing
    queues: bool = False
