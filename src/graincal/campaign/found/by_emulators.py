"""What emulators know of a posterior, beside it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ByEmulators:
    """What it takes emulators to know, or some seconds.

    unsure: the part of the probability that lies where the emulators do not know whether the parameters fit. expected_error: the error ε, percent, that measurement errors,
    and the scatter of runs where it counts, lead to on average. shares: of the probability, in each of several separate groups of values; () where there is a single one.
    """

    unsure: float
    expected_error: float
    shares: tuple[float, ...] = ()
