"""What a calibration predicts for a test that it was not compared with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graincal.campaign.asked.experiment import not_finite
from graincal.campaign.found.record import Record
from graincal.data import Failure, InputError, Reference, Response, Samples
from graincal.execution import number_of_workers
from graincal.inference.likelihood.error_model import DISCREPANCIES, USUAL_ERROR, discrepancies
from graincal.inference.likelihood.measured_band import central_interval, measured_deviations
from graincal.inference.likelihood.scoring import Score, score
from graincal.inference.sampling.posterior import Posterior
from graincal.inference.sampling.proposal import systematic_resampling
from graincal.interpolation import interpolate
from graincal.models import Model
from graincal.notation.numbers import count
from graincal.notation.quantities import quantity
from graincal.notation.words import listed


@dataclass(frozen=True, eq=False)
class Prediction:
    """Responses of K parameters drawn from the posterior, equally probable.

    control (T,); theta (K, n); values: observables and quantities of interest, each (K, T). failures: what the other samples ended with. error_options:
    what the calibration took for granted of errors, as options of `score`. measured_like: the reference whose measurement errors a test of these observables would have; None where none is known.
    """

    control_name: str
    control: NDArray[np.float64]
    theta: NDArray[np.float64]
    values: Mapping[str, NDArray[np.float64]]
    failures: tuple[Failure, ...] = field(default=())
    error_options: Mapping[str, Any] = field(default_factory=dict)
    measured_like: Reference | None = None

    def __repr__(self) -> str:
        failed = f", {len(self.failures)} more failed" if self.failures else ""
        return f"Prediction({len(self.theta)} responses{failed} at {len(self.control)} values of {self.control_name}: {', '.join(self.values)})"

    def mean(self, name: str) -> NDArray[np.float64]:
        """The mean response, (T,)."""
        return self._values(name).mean(axis=0)

    def interval(self, name: str, probability: float = 0.9) -> NDArray[np.float64]:
        """The central interval of the responses at each state, (2, T); measurement errors are not in it."""
        # As `central_interval` has it without errors.
        return np.quantile(self._values(name), [(1 - probability) / 2, (1 + probability) / 2], axis=0, method="averaged_inverted_cdf")

    def measured_interval(self, name: str, probability: float = 0.9) -> NDArray[np.float64]:
        """The central interval of what a test would measure at each state, (2, T): of the responses, each with its measurement error. That of the responses alone for a name without an error (`with_errors`).

        It is by the distribution function of their mixture. The errors are those that the calibration states, 1 % of the mean's peak where it states none of an observable, and what the model cannot
        reproduce where the reference was measured. Raises InputError for control values that do not increase.
        """
        return central_interval(self._values(name), self._deviations[name], probability) if name in self.with_errors else self.interval(name, probability)

    @property
    def with_errors(self) -> tuple[str, ...]:
        """The names whose measurement errors are known: the observables of the reference that they are taken from."""
        return tuple(name for name in self.measured_like.names if name in self.values) if self.measured_like else ()

    def measured_as(self, reference: Reference) -> Prediction:
        """With the measurement errors of another reference, such as that of a test that the prediction is compared with."""
        return replace(self, measured_like=reference)

    def band_in_words(self, names: Sequence[str], probability: float = 0.9) -> str:
        """What the bands of some names hold (`measured_interval`): a sentence on those with errors, and one on those without."""
        drawn, share = f"{count(len(self.theta), 'parameter set')} drawn from the posterior", f"{100 * probability:g} %"
        measured, bare = ([name for name in names if (name in self.with_errors) is known] for known in (True, False))
        if not measured:
            return (
                f"The band holds {share} of the responses of {drawn}, state by state; measurement errors are not in it, for none are stated of what is shown."
            )
        said = f"The band holds {share} of what a test would measure, state by state: the responses of {drawn}, with {self._errors_in_words(measured)}."
        if bare:
            said += f" No error is stated of {listed([quantity(name).label for name in bare])}: the band there holds {share} of the responses alone."
        return said

    def _errors_in_words(self, names: Sequence[str]) -> str:
        reference = self.measured_like
        assert reference is not None
        usual = [quantity(name).label for name in names if name not in reference.measurement_errors]
        parts = ["the measurement errors that are stated"] if len(usual) < len(names) else []
        parts += [f"a measurement error of about {100 * USUAL_ERROR:g} % of the peak of {listed(usual)}, for which none is stated"] if usual else []
        if any(discrepancies(reference, self.error_options.get("discrepancy"))[0]):
            low, high = (f"{100 * end:g}" for end in (DISCREPANCIES[0], DISCREPANCIES[-1]))
            parts.append(f"the {low} to {high} % of the peak that the model may be unable to reproduce")
        return listed(parts)

    def against(self, reference: Reference, probability: float = 0.9) -> Score:
        """Compare with a test. Raises InputError where the prediction lacks an observable of it, or is at other control values."""
        if reference.control_name != self.control_name or len(reference.control) != len(self.control) or not np.allclose(reference.control, self.control):
            raise InputError(f"the prediction is to be made at the reference's own {reference.control_name}.")
        return score(np.stack([self._values(name) for name in reference.names], axis=2), reference, probability, **self.error_options)

    @cached_property
    def _deviations(self) -> dict[str, NDArray[np.float64]]:
        """Of what would be measured of each response, (K, T) by name."""
        assert self.measured_like is not None
        return measured_deviations(self.control, self.values, self.measured_like, self.control_name, self.error_options.get("discrepancy"))

    def _values(self, name: str) -> NDArray[np.float64]:
        if name not in self.values:
            raise InputError(f"the prediction holds {', '.join(self.values)}, and not {name}.")
        return self.values[name]


def draw(posterior: Posterior, count: int, seed: int = 1) -> Samples:
    """So many draws, equally probable and spread evenly over the posterior's weights."""
    return Samples(np.arange(count), posterior.samples[drawn_rows(posterior, count, np.random.default_rng(seed))], posterior.names)


def drawn_rows(posterior: Posterior, count: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """The rows (count,) of a posterior's samples that are drawn: a heavy one more than once."""
    order = np.argsort(posterior.samples[:, 0], kind="stable")
    return order[systematic_resampling(posterior.weights[order], count, rng)]


def predict(
    result: Record,
    model: Model,
    at: ArrayLike,
    *,
    control_name: str = "axial_strain",
    samples: int = 30,
    seed: int = 1,
    workers: int | Literal["all"] = "all",
    experiment: int | str | None = None,
) -> Prediction:
    """Evaluate a model, another test of the same material, at parameters drawn from a result's posterior.

    at (T,): the control values. The draws are spread evenly over the posterior's weights. Each is one run: its scatter is part of the prediction.
    workers: evaluations at once, "all" for one a core.
    experiment: the number or name of the one whose values the parameters have, of which only some campaigns have several (`ParameterSpace.per_experiment`).
    Raises InputError where there is no posterior, where several experiments could be meant, and where fewer than two evaluations give a response.
    """
    posterior = result.posterior
    if posterior is None:
        raise InputError("a prediction needs a posterior, and the campaign has none yet.")
    if experiment is None and result.space.per_experiment:
        listed = ", ".join(f'"{each.name}"' for each in result.experiments)
        raise InputError(
            f"a prediction needs to know whose value of {', '.join(result.space.per_experiment)} is meant: experiment = one of {listed} was expected."
        )
    at_once = number_of_workers(workers)
    if samples < 2:
        raise InputError(f"a prediction needs at least two samples of the posterior, not {samples}.")
    drawn = draw(posterior, samples, seed)
    control = np.asarray(at, dtype=np.float64)
    number = result.number(0 if experiment is None else experiment)
    reference = result.experiments[number].reference
    fitted = reference.names

    def met(outcome: Response | Failure) -> Response | Failure:
        at_states = outcome if isinstance(outcome, Failure) else interpolate(outcome, control)
        if isinstance(at_states, Failure):
            return at_states
        return not_finite(at_states, [name for name in fitted if name in at_states.values], control_name) or at_states

    outcomes = {row: met(outcome) for row, outcome in model.evaluate(result.space.seen_by(number, drawn), control, workers=at_once)}
    responses = {row: outcome for row, outcome in sorted(outcomes.items()) if isinstance(outcome, Response)}
    failures = tuple(outcome for outcome in outcomes.values() if isinstance(outcome, Failure))
    if len(responses) < 2:
        gave = f"only one of the {samples} simulations" if responses else f"none of the {samples} simulations"
        raise InputError(f"a prediction needs two responses, and {gave} gave one; the first that failed did so because: {failures[0].reason}")
    names = next(iter(responses.values())).values
    values = {name: np.array([response.values[name] for response in responses.values()]) for name in names if name != control_name}
    return Prediction(control_name, control, drawn.theta[list(responses)], values, failures, result.calibration.error_options, reference)
