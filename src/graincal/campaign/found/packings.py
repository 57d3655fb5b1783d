"""What packings differ by, as a store holds it: runs on packings like those of a calibration's models, at a few places that fit, beside its own evaluations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from graincal.data import Failure, InputError, ParameterSpace, Response, Samples
from graincal.inference.likelihood.packings import REPEATED, REPEATS, SIBLINGS
from graincal.inference.sampling.samples import replicates

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
    """What the store holds of runs on siblings, as a filter is told: places, and responses for each experiment. Raises InputError where an earlier version stored them."""
    check_study(store)
    samples = store.samples(STUDY)
    return samples.theta[samples.ids % (REPEATS * SIBLINGS) == 0], [
        _responses(samples, store, number, experiment) for number, experiment in enumerate(experiments)
    ]


def check_study(store: Store) -> None:
    """Raise InputError where an earlier version of graincal, which ran other samples, began the study."""
    ids = store.samples(STUDY).ids
    if not np.array_equal(np.sort(ids), _ids(len(ids) // (SIBLINGS + REPEATED * (REPEATS - 1)))):
        raise InputError(
            f"{store.folder}: an earlier version of graincal found out what packings differ by, in another way; calibrate in another folder with --runs {store.folder} to learn from its runs."
        )


def samples_at(places: NDArray[np.float64], space: ParameterSpace) -> Samples:
    """Each place for each sibling, which a model chooses by the id, and again for those that are repeated."""
    ids = _ids(len(places))
    theta = np.repeat(np.concatenate([replicates(place, REPEATS, space) for place in places]), SIBLINGS, axis=0)
    return Samples(ids, theta[ids], space.names)


def _ids(places: int) -> NDArray[np.int64]:
    """Of the samples at so many places: by place, repeat and sibling, counted up to -1, without the repeats that are not made."""
    ids = np.arange(-places * REPEATS * SIBLINGS, 0, dtype=np.int64)
    repeat, sibling = ids // SIBLINGS % REPEATS, ids % SIBLINGS
    return ids[(repeat == 0) | (sibling < REPEATED)]


def _responses(samples: Samples, store: Store, number: int, experiment: Experiment) -> NDArray[np.float64] | None:
    """What siblings gave at each place, (S, P, R, T, J), NaN where there is no response; None where nothing was run."""
    outcomes = {int(id): store.outcome(int(id), number) for id in samples.ids}
    if not any(isinstance(outcome, (Response, Failure)) for outcome in outcomes.values()):
        return None
    found = np.full((-int(samples.ids.min()), *experiment.reference.values.shape), np.nan)
    for id, outcome in outcomes.items():
        if isinstance(outcome, Response):
            found[id] = experiment.observables(outcome)
    return np.moveaxis(found.reshape(-1, REPEATS, SIBLINGS, *found.shape[1:]), 2, 0)
