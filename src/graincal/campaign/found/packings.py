"""What packings differ by, as a store holds it: runs on packings like those of a calibration's models, at a few places that fit, beside its own evaluations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from graincal.data import Failure, Response, Samples
from graincal.inference.likelihood.packings import SIBLINGS

if TYPE_CHECKING:
    from graincal.campaign.asked.experiment import Experiment
    from graincal.campaign.stored.store import Store

STUDY = -1
"""The number under which a store keeps the samples of the study, whose ids are below 0: no iteration's."""

STUDIED = "packings_studied"
"""The key under which a store keeps that all of the study is there."""

TROUBLE = "packings of experiment {}"
"""The key under which a store keeps why packings like that of an experiment (its number) could not be prepared."""


def studied(store: Store) -> bool:
    """Whether the store holds all of the study: marked once it is whole."""
    return store.meta(STUDIED) is not None


def packings_told(store: Store, experiments: Sequence[Experiment]) -> tuple[NDArray[np.float64], list[NDArray[np.float64] | None]]:
    """What the store holds of runs on siblings, as a filter is told: places, and responses for each experiment."""
    samples = store.samples(STUDY)
    return samples.theta[::SIBLINGS], [_responses(samples, store, number, experiment) for number, experiment in enumerate(experiments)]


def samples_at(places: NDArray[np.float64], names: tuple[str, ...]) -> Samples:
    """Each place once for each sibling, which a model chooses by the id."""
    return Samples(np.arange(-len(places) * SIBLINGS, 0, dtype=np.int64), np.repeat(places, SIBLINGS, axis=0), names)


def _responses(samples: Samples, store: Store, number: int, experiment: Experiment) -> NDArray[np.float64] | None:
    """What siblings gave at each place, (S, P, T, J), NaN where there is no response; None where nothing was run."""
    outcomes = [store.outcome(int(id), number) for id in samples.ids]
    if not any(isinstance(outcome, (Response, Failure)) for outcome in outcomes):
        return None
    nothing = np.full(experiment.reference.values.shape, np.nan)
    found = np.array([experiment.observables(outcome) if isinstance(outcome, Response) else nothing for outcome in outcomes])
    return np.swapaxes(found.reshape(-1, SIBLINGS, *found.shape[1:]), 0, 1)
