"""Runs on packings like those of a calibration's models, from which it learns what packings differ by."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from graincal.campaign.found.packings import STUDIED, STUDY, TROUBLE, check_study, packings_told, samples_at
from graincal.campaign.run.evaluations import Evaluations
from graincal.campaign.stored.listener import Listener
from graincal.data import InputError
from graincal.inference import PosteriorFilter
from graincal.inference.likelihood.packings import SIBLINGS
from graincal.models import StressPathTest

VOID_RATIO_APART = 0.003
"""From which it is said."""

SAID_EVERY = 5.0
"""Seconds between two words on how many packings are prepared; those that are in the cache take none."""


def study_packings(filter: PosteriorFilter, evaluations: Evaluations) -> None:
    """Run what the filter wants to be run on siblings of each experiment's packing, as far as the store does not hold it, and tell it."""
    calibration, store, listeners = evaluations.calibration, evaluations.store, evaluations.listeners
    assert filter.places is not None, "it waits for what runs at these places give"
    check_study(store)
    samples = samples_at(filter.places, calibration.space)
    store.ask(STUDY, samples, len(calibration.experiments))
    for number, (experiment, siblings) in enumerate(zip(calibration.experiments, filter.siblings)):
        waiting = samples.take(np.isin(samples.ids, store.waiting(STUDY, number, by_itself=True)))
        own_model = experiment.model
        if siblings is None or not isinstance(own_model, StressPathTest) or not len(waiting) or store.meta(TROUBLE.format(number)):
            continue
        for listener in listeners:
            listener.remark(
                f"Learns what packings differ by: prepares {SIBLINGS} packings like that of {experiment.name}, where they are not there yet, and runs {len(waiting)} samples on them."
            )
        try:
            model = own_model.on_siblings(SIBLINGS, calibration.number_of_workers, _say_prepared(listeners))
        except InputError as error:
            store.keep(TROUBLE.format(number), str(error))
            for listener in listeners:
                listener.remark(f"What packings differ by is left out, for none like that of {experiment.name} could be prepared: {error}")
            continue
        own, others = own_model.first_packing.void_ratio, model.first_packing.void_ratio
        if abs(own - others) > VOID_RATIO_APART:
            for listener in listeners:
                listener.remark(
                    f"The packings like that of {experiment.name} have a void ratio of {others:.3f}, and it has {own:.3f}: the nearest that could be prepared."
                )
        evaluations.of_one(STUDY, number, waiting, replace(experiment, model=model))
    store.keep(STUDIED, "yes")
    filter.tell_packings(*packings_told(store, calibration.experiments))


def _say_prepared(listeners: Sequence[Listener]) -> Callable[[int], None]:
    """What tells the listeners now and then how many packings are prepared, if that takes time."""
    said = time.monotonic()

    def prepared(number: int) -> None:
        nonlocal said
        if time.monotonic() - said < SAID_EVERY:
            return
        said = time.monotonic()
        for listener in listeners:
            listener.remark(f"{number} of {SIBLINGS} packings are prepared.")

    return prepared
