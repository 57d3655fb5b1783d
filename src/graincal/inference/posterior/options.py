"""What the options of the posterior filter must be."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from graincal.data import InputError
from graincal.inference.driving.stop import Stop
from graincal.inference.sampling.samples import MOST_SAMPLES

MOST_AHEAD = 100
"""Batches that are asked for ahead, at most."""


def check_options(batches: Mapping[str, Any], ahead: Any, seed: Any, stop: Stop, at_answer: int) -> None:
    """Raise InputError for what cannot be. batches: "first_batch" and "batch", None where it is not said; at_answer: how many runs end a calibration."""
    for name, value in batches.items():
        if name == "batch" and value is None:
            continue
        if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < 2:
            raise InputError(f"filter.{name} must be a whole number above 1, not {value!r}.")
        if value > MOST_SAMPLES:
            raise InputError(f"filter.{name} is {value}, and at most {MOST_SAMPLES:,} was expected.")
    if isinstance(ahead, bool) or not isinstance(ahead, (int, np.integer)) or ahead < 0:
        raise InputError(f"filter.ahead must be a whole number, not negative, not {ahead!r}.")
    if ahead > MOST_AHEAD:
        raise InputError(f"filter.ahead is {ahead}, and at most {MOST_AHEAD} was expected.")
    if not isinstance(seed, (int, np.integer)) or seed < 0:
        raise InputError(f"seed must be a whole number, not negative, not {seed!r}.")
    least = batches["first_batch"] + at_answer
    if stop.max_evaluations is not False and stop.max_evaluations < least:
        runs = f" and the {at_answer} runs at the answer" if at_answer else ""
        raise InputError(
            f"stop.max_evaluations = {stop.max_evaluations} does not hold the first batch of {batches['first_batch']} samples{runs}: "
            f"at least {least}, or a smaller filter.first_batch, was expected."
        )
