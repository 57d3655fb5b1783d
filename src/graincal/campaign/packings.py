"""What packings differ by: runs on packings like those of a calibration's models, at a few places that fit, kept beside its own evaluations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from graincal.data import Failure, InputError, Response, Samples
from graincal.inference import PosteriorFilter
from graincal.inference.packings import SIBLINGS

if TYPE_CHECKING:
    from graincal.campaign.evaluations import Evaluations
    from graincal.campaign.experiment import Experiment
    from graincal.campaign.store import Store

STUDY = -1
"""The number under which a store keeps the samples of the study, whose ids are below 0: no iteration's."""

VOID_RATIO_APART = 0.003
"""From which it is said."""

STUDIED = "packings_studied"
"""The key under which a store keeps that all of the study is there."""

TROUBLE = "packings of experiment {}"
"""The key under which a store keeps why packings like that of an experiment (its number) could not be prepared."""


def study_packings(filter: PosteriorFilter, evaluations: Evaluations) -> None:
    """Run what the filter wants to be run on siblings of each experiment's packing, as far as the store does not hold it, and tell it."""
    calibration, store, listeners = evaluations.calibration, evaluations.store, evaluations.listeners
    samples = _samples(filter.places, calibration.space.names)
    store.ask(STUDY, samples, len(calibration.experiments))
    for number, (experiment, siblings) in enumerate(zip(calibration.experiments, filter.siblings)):
        waiting = samples.take(np.isin(samples.ids, store.waiting(STUDY, number, by_itself=True)))
        if siblings is None or not len(waiting) or store.meta(TROUBLE.format(number)):
            continue
        for listener in listeners:
            listener.remark(f"Learns what packings differ by: prepares {SIBLINGS} packings like that of {experiment.name}, where they are not there yet, and runs {len(waiting)} samples on them.")
        try:
            model = experiment.model.on_siblings(SIBLINGS, calibration.number_of_workers)
        except InputError as error:
            store.keep(TROUBLE.format(number), str(error))
            for listener in listeners:
                listener.remark(f"What packings differ by is left out, for none like that of {experiment.name} could be prepared: {error}")
            continue
        own, others = experiment.model.packing.void_ratio, model.packing.void_ratio
        if abs(own - others) > VOID_RATIO_APART:
            for listener in listeners:
                listener.remark(f"The packings like that of {experiment.name} have a void ratio of {others:.3f}, and it has {own:.3f}: the nearest that could be prepared.")
        evaluations.of_one(STUDY, number, waiting, replace(experiment, model=model))
    store.keep(STUDIED, "yes")
    filter.tell_packings(*packings_told(store, calibration.experiments))


def studied(store: Store) -> bool:
    """Whether the store holds all of the study: marked once it is whole."""
    return store.meta(STUDIED) is not None


def packings_told(store: Store, experiments: Sequence[Experiment]) -> tuple[NDArray[np.float64], list[NDArray[np.float64] | None]]:
    """What the store holds of runs on siblings, as a filter is told: places, and responses for each experiment."""
    samples = store.samples(STUDY)
    return samples.theta[::SIBLINGS], [_responses(samples, store, number, experiment) for number, experiment in enumerate(experiments)]


def _samples(places: NDArray[np.float64], names: tuple[str, ...]) -> Samples:
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
