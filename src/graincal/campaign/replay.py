"""A filter is a function of what it is told: told again what a store holds, it is the one that ran."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Sequence

import numpy as np

from graincal.campaign.calibration import Calibration, Filter
from graincal.campaign.experiment import Experiment
from graincal.campaign.packings import studied, tell_packings
from graincal.campaign.store import Store, same
from graincal.data import ParameterSpace, Response, Samples
from graincal.inference import PosteriorFilter, Stop
from graincal.inference.posterior_filter import APART, REPLICATES

INFEASIBLE = "infeasible"
"""The kind of a `Failure` by which a model says that a sample's parameters are impossible; other kinds say nothing of them."""


def tell(filter: Filter, samples: Samples, store: Store, experiments: Sequence[Experiment]) -> None:
    """Tell a filter the outcomes of samples, all of which the store holds; and those of the study of packings, if it waits for that and the store holds all of it, or never will: then its first
    batch is complete."""
    failed, infeasible, stopped = np.zeros((3, len(samples)), dtype=bool)
    responses = [np.full((len(samples), *experiment.reference.values.shape), np.nan) for experiment in experiments]
    for row, id in enumerate(samples.ids):
        for number, experiment in enumerate(experiments):
            outcome = store.outcome(id, number)
            if isinstance(outcome, Response):
                responses[number][row] = experiment.observables(outcome)
                stopped[row] |= outcome.stopped
            elif not stopped[row]:
                failed[row] = True
                infeasible[row] |= outcome is not None and outcome.kind == INFEASIBLE
    filter.tell(samples, responses, failed, infeasible, stopped)
    if isinstance(filter, PosteriorFilter) and filter.places is not None and (studied(store) or store.iterations()):
        tell_packings(filter, store, experiments)


def replay(store: Store, calibration: Calibration) -> Filter:
    """The filter after the iterations that are complete. Raises InputError where it asks for other samples than the store holds."""
    filter = calibration.new_filter()
    for index, iteration in enumerate(store.iterations()):
        # A filter at its end asks for nothing more.
        asked = next(iter(filter.under_way), filter.ask())
        if not same(asked, iteration.samples):
            raise store.other_samples(index)
        tell(filter, asked, store, calibration.experiments)
    return filter


def learn_again(store: Store, calibration: Calibration) -> Filter:
    """A posterior filter that has learnt from the iterations that are complete, whatever samples it would have asked for itself: what another build can
    say of a campaign. The evaluations carry no weight."""
    never = Stop(posterior_shift=False, max_iterations=sys.maxsize, max_evaluations=sys.maxsize)
    filter = dataclasses.replace(calibration, stop=never).new_filter()
    for iteration in store.iterations():
        filter.ask_instead(iteration.samples)
        tell(filter, iteration.samples, store, calibration.experiments)
    filter.look()
    return filter


def runs_at_answer(samples: Samples, space: ParameterSpace) -> bool:
    """Whether they are the runs at one point, but for some millionths of the ranges, with which the method "posterior" ends."""
    return len(samples) > 1 and bool(np.all(np.ptp(space.to_unit(samples.theta), axis=0) < REPLICATES * APART))
