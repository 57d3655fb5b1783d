"""What a store holds, told again: to a filter, which is a function of what it is told and then the one that ran, or as what is known."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.asked.calibration import Calibration, Filter
from graincal.campaign.asked.experiment import Experiment
from graincal.campaign.found.packings import packings_told, studied
from graincal.campaign.stored.store import Store
from graincal.data import ParameterSpace, Response, Samples
from graincal.inference import PosteriorFilter
from graincal.inference.driving.batch import Batch, Batches
from graincal.inference.posterior.knowledge import Knowledge
from graincal.inference.posterior.posterior_filter import REPLICATES
from graincal.inference.sampling.defensive import DefensiveMixture
from graincal.inference.sampling.samples import APART

INFEASIBLE = "infeasible"
"""The kind of a `Failure` by which a model says that a sample's parameters are impossible; other kinds say nothing of them."""


Outcomes = tuple[list[NDArray[np.float64]], NDArray[np.bool_], NDArray[np.bool_], NDArray[np.bool_]]


def outcomes(samples: Samples, store: Store, experiments: Sequence[Experiment]) -> Outcomes:
    """What became of samples (N,), all of which the store holds, as filters are told: responses at the rows of each reference, (N, T, J), NaN where there is none; which failed, which of these are
    infeasible, and which were stopped."""
    failed, infeasible, stopped = np.zeros((3, len(samples)), dtype=bool)
    responses = [np.full((len(samples), *experiment.reference.values.shape), np.nan) for experiment in experiments]
    for number, experiment in enumerate(experiments):
        found = store.outcomes(samples.ids, number)
        given = {row: outcome for row, outcome in enumerate(found) if isinstance(outcome, Response)}
        responses[number][list(given)] = experiment.observables_of(list(given.values()))
        for row, outcome in enumerate(found):
            if isinstance(outcome, Response):
                stopped[row] |= outcome.stopped
            elif not stopped[row]:
                failed[row] = True
                infeasible[row] |= outcome is not None and outcome.kind == INFEASIBLE
    return responses, failed, infeasible, stopped


def tell(filter: Filter, samples: Samples, store: Store, experiments: Sequence[Experiment]) -> None:
    """Tell a filter the outcomes of samples; and those of the study of packings, if it waits for that and the store holds all of it, or never will: then its first batch is complete."""
    filter.tell(samples, *outcomes(samples, store, experiments))
    if isinstance(filter, PosteriorFilter) and filter.places is not None and (studied(store) or store.iterations()):
        filter.tell_packings(*packings_told(store, experiments))


def knowledge(store: Store, calibration: Calibration) -> Knowledge:
    """What is known by the iterations that are complete, by the method "posterior"."""
    known, iterations = calibration.new_knowledge(), store.iterations()
    asked = [iteration.samples for iteration in iterations]
    samples = Samples(np.concatenate([each.ids for each in asked]), np.concatenate([each.theta for each in asked]), calibration.space.names)
    batches = Batches()
    batches.add(Batch(samples, known.thinnings, calibration.space))
    batches.tell(samples, *outcomes(samples, store, calibration.experiments))
    # Where each was drawn from is in the weights that a look found.
    whole = batches.take_complete()
    assert whole is not None, "all of it was told"
    known.add(whole, DefensiveMixture(calibration.space), 0)
    if studied(store):
        known.tell_packings(*packings_told(store, calibration.experiments))
    return known


def runs_at_answer(samples: Samples, space: ParameterSpace) -> bool:
    """Whether they are the runs at one point, but for some millionths of the ranges, with which the method "posterior" ends."""
    return len(samples) > 1 and bool(np.all(np.ptp(space.to_unit(samples.theta), axis=0) < REPLICATES * APART))
