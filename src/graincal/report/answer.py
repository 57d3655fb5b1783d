"""The sample that a result is taken to be."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from graincal.campaign import Experiment
from graincal.campaign.found.answer import Candidate
from graincal.campaign.found.record import Record
from graincal.data import Samples


def answer_of(result: Record) -> Candidate | None:
    """The most probable sample, or the best where there are no weights; None if all failed. By the posterior: the middle one of the runs at the answer."""
    answer = result.answer
    if answer and np.isfinite(answer.errors).any():
        middle = np.argsort(answer.errors)[(np.isfinite(answer.errors).sum() - 1) // 2]
        return Candidate(int(answer.samples[middle]), result.iterations[-1].index, answer.theta, float(answer.errors[middle]))
    return result.best if result.has_posterior else result.most_probable or result.best


def name_of_answer(result: Record) -> str:
    """What the sample that `answer_of` gives is called."""
    if result.has_posterior:
        return "answer" if result.answer and np.isfinite(result.answer.errors).any() else "best sample"
    return "most probable sample" if result.most_probable else "best sample"


def as_samples(result: Record, candidate: Candidate, experiment: Experiment) -> Samples:
    """A candidate as a sample to be evaluated in an experiment."""
    sample = Samples(np.array([candidate.sample]), candidate.theta[None], result.space.names)
    return result.space.seen_by(result.number(experiment.name), sample)


def recorded_errors_of(result: Record, candidate: Candidate) -> tuple[Mapping[str, float], ...]:
    """Its errors in what was recorded and not fitted, likewise."""
    row = iter(result.recorded_errors_of([candidate.sample])[0])
    return tuple({name: float(next(row)) for name in experiment.reference.recorded} for experiment in result.experiments)


def errors_of(result: Record, candidate: Candidate) -> tuple[Mapping[str, float], ...]:
    """The errors (Eq. 5, percent) of a candidate: for each experiment, by the name of the observable."""
    row = iter(result.observable_errors[int(np.searchsorted(result.ids, candidate.sample))])
    return tuple({name: float(next(row)) for name in experiment.reference.names} for experiment in result.experiments)
