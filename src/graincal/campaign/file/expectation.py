"""What a calibration will cost, from one short run in the middle of the ranges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.asked.calibration import Calibration
from graincal.campaign.asked.experiment import Experiment
from graincal.data import Failure, Samples
from graincal.inference.sampling.samples import middle_of
from graincal.models import ByHandModel, CommandModel, StressPathTest
from graincal.models.stress_path import STRAINS

PILOT_SHARE = 0.05
"""The share of a test's strain that is simulated to time it."""

NOT_RUN = "not_run"
"""The kind of the failure of a pilot that is none: nothing was run."""


@dataclass(frozen=True)
class Expectation:
    """What the first iteration will cost in one experiment; later ones cost about as much.

    seconds: of its evaluations one after the other; longest: of the longest of them; pilot: of the middle of the ranges.
    Where the pilot failed these are None, and `failure` says why.
    """

    experiment: str
    seconds: float | None = None
    longest: float | None = None
    pilot: float | None = None
    failure: Failure | None = None


def expect(calibration: Calibration) -> list[Expectation]:
    """Time each experiment in the middle of the ranges: a test that is driven by strain at the beginning of it, others whole."""
    samples, space = calibration.blank_filter().under_way[0], calibration.space
    middle = Samples(np.zeros(1, dtype=np.int64), middle_of(space)[None], space.names)
    return [_expect(experiment, space.seen_by(number, middle), space.seen_by(number, samples)) for number, experiment in enumerate(calibration.experiments)]


def _expect(experiment: Experiment, middle: Samples, samples: Samples) -> Expectation:
    if isinstance(experiment.model, CommandModel):
        return Expectation(
            experiment.name, failure=Failure(NOT_RUN, "a program is not run to see how long it takes; run.expected_seconds says it, where it is known.")
        )
    if isinstance(experiment.model, ByHandModel):
        return Expectation(
            experiment.name, failure=Failure(NOT_RUN, "runs that are made by hand take what they take; run.expected_seconds says it, where it is known.")
        )
    pilot: float | Failure | None
    if isinstance(experiment.model, StressPathTest) and experiment.model.control in STRAINS:
        pilot = _time_beginning(experiment, middle)
    else:
        ((_, outcome),) = experiment.evaluate(middle, workers=1)
        pilot = outcome if isinstance(outcome, Failure) else outcome.details.get("seconds")
    if isinstance(pilot, Failure):
        return Expectation(experiment.name, failure=pilot)
    if pilot is None:
        return Expectation(experiment.name, failure=Failure("untimed", "the model does not say how long it took."))
    seconds = pilot * _relative_lengths(experiment, samples, middle)
    return Expectation(experiment.name, float(seconds.sum()), float(seconds.max()), pilot)


def _time_beginning(experiment: Experiment, middle: Samples) -> float | Failure:
    """The seconds of a whole test, from its consolidation and the beginning of its shearing."""
    last = experiment.reference.control[-1]
    ((_, outcome),) = experiment.model.evaluate(middle, at=[PILOT_SHARE * last], workers=1)
    if isinstance(outcome, Failure):
        return outcome
    steps, share = outcome.values["steps"], outcome.control[-1] / last
    whole = steps[0] + (steps[-1] - steps[0]) / share
    return float(outcome.details["seconds"] * whole / outcome.details["steps"])


def _relative_lengths(experiment: Experiment, samples: Samples, middle: Samples) -> NDArray[np.float64]:
    """How much longer the evaluation of each sample takes than that of the middle: the critical time step falls with the stiffness."""
    if not isinstance(experiment.model, StressPathTest) or "log_E" not in samples.names:
        return np.ones(len(samples))
    stiffness = samples.names.index("log_E")
    return 10 ** (experiment.model.steps_exponent * (samples.theta[:, stiffness] - middle.theta[0, stiffness]))
