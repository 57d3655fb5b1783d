"""Runs of a campaign that wait to be made by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.asked.calibration import Calibration
from graincal.campaign.stored.store import Store


def left_to_hand(calibration: Calibration) -> Calibration:
    """The calibration as it goes on by hand: where no experiment is run by hand by itself, all of them are."""
    return replace(calibration, by_hand=not by_hand(calibration))


def by_hand(calibration: Calibration) -> list[int]:
    """The numbers of the experiments whose runs are made by hand."""
    return [number for number in range(len(calibration.experiments)) if calibration.is_by_hand(number)]


def waiting(store: Store, experiment: int) -> NDArray[np.int64]:
    """Ids of the samples that wait in an experiment, of all batches that are begun."""
    last = store.last_iteration()
    batches = [store.waiting(iteration, experiment) for iteration in range(len(store.iterations()), 0 if last is None else last + 1)]
    return np.concatenate([np.zeros(0, dtype=np.int64), *batches])
