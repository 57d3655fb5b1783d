"""What the calibrated triaxial test gives at another confining pressure: a prediction, which no test was compared with."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from graincal.campaign import Experiment
from graincal.campaign.found.answer import Candidate
from graincal.campaign.found.prediction import Prediction, draw, predict
from graincal.campaign.found.record import Record
from graincal.data import Failure, InputError, Response
from graincal.drawing.figure import Array, Axis, Figure, Line, Mark, Panel, Points
from graincal.drawing.palette import BEST, PREDICTED, REFERENCE
from graincal.drawing.sight import in_sight
from graincal.execution import number_of_workers
from graincal.inference.sampling.posterior import PROBABILITY
from graincal.models import StressPathTest, TriaxialTest
from graincal.notation import numbers
from graincal.notation.quantities import quantity
from graincal.report.answer import answer_of, as_samples
from graincal.report.predicted import predicted_marks
from graincal.report.responses import NOT_FITTED, control_axis

LONGEST = 120.0
"""Seconds that the same sample's evaluation may have taken for a report to simulate it once more."""
DRAWS = 20
"""Parameter sets of the posterior that are simulated: of fewer, an interval of 90 % has less than one beyond either end."""
LONGEST_DRAWS = 30.0
"""Seconds that all of these may be expected to take."""
CONTROL, THETA = "control of the prediction", "parameters of the prediction"
_MORE_STEPS = 3
"""How many times the steps that are expected the longest simulation may take."""


@dataclass(frozen=True, eq=False)
class OtherPressure:
    """A calibrated test of an experiment at another confining pressure: `test`.

    drawn: what draws from the posterior gave there. response: what the answer gave, where there are no draws. without_band: a sentence that says why there are none. missing: one that says why there is neither.
    """

    experiment: Experiment
    calibrated_test: TriaxialTest
    test: TriaxialTest
    candidate: Candidate
    calibrated: Response
    drawn: Prediction | None = None
    response: Response | None = None
    without_band: str = ""
    missing: str = ""


def predict_response(result: Record, factor: float | None) -> OtherPressure | None:
    """Simulate the triaxial experiment of the highest pressure at `factor` times its confining pressure: DRAWS parameter sets of the posterior, by the method "posterior", where they are expected to take
    LONGEST_DRAWS at most; else the answer, or most probable sample, once, unless it took longer than LONGEST.

    None without a factor or a triaxial experiment.
    """
    candidate = answer_of(result)
    tests = [(experiment, experiment.model) for experiment in result.experiments if isinstance(experiment.model, TriaxialTest)]
    if not (factor and tests and candidate):
        return None
    experiment, calibrated_test = max(tests, key=lambda each: each[1].confining_pressure)
    calibrated = result.response(candidate.sample, experiment.name)
    assert isinstance(calibrated, Response), "a sample with an error has a response"
    test = replace(calibrated_test, confining_pressure=factor * calibrated_test.confining_pressure)
    found = OtherPressure(experiment, calibrated_test, test, candidate, calibrated)
    costs = _costs(result, found)
    without_band = _without_band(result, found, costs)
    if without_band:
        return _once(result, replace(found, without_band=without_band))
    drawn = _drawn(result, found, _MORE_STEPS * max(1.0, costs.max()))
    if isinstance(drawn, str):
        return _once(result, replace(found, without_band=f"It is one run and has no band: {drawn}"))
    return replace(found, drawn=drawn)


def _costs(result: Record, found: OtherPressure) -> Array:
    """What simulations of the draws (DRAWS,) are expected to cost, as multiples of what the answer's cost in the calibration; none without a posterior in the strict sense."""
    if not result.has_posterior or result.posterior is None:
        return np.empty(0)
    number, at = result.number(found.experiment.name), found.experiment.reference.control
    costs = found.test.expected_particle_steps(result.space.seen_by(number, draw(result.posterior, DRAWS)), at)
    return costs / found.calibrated_test.expected_particle_steps(as_samples(result, found.candidate, found.experiment), at)


def _without_band(result: Record, found: OtherPressure, costs: Array) -> str:
    """Why a report does not simulate the draws; empty where it does."""
    if not len(costs):
        lacks = "a posterior, and there is none yet" if result.has_posterior else 'the method "posterior"'
        return f"It is one run and has no band, which needs {lacks}."
    seconds = found.calibrated.details.get("seconds")
    if seconds is None:
        return "It is one run and has no band, for it is not known how long runs take. graincal predict makes one of several runs."
    workers = min(_workers(result), DRAWS)
    expected = seconds * max(costs.sum() / workers, costs.max())
    if expected <= LONGEST_DRAWS:
        return ""
    return (
        f"It is one run and has no band: {DRAWS} runs would take about {numbers.duration(expected)} on {numbers.count(workers, 'core')}, and a report waits {LONGEST_DRAWS:g} s at most. "
        "graincal predict makes them."
    )


def _workers(result: Record) -> int:
    """No more than there are cores, and than the calibration may use."""
    return min(number_of_workers("all"), result.calibration.number_of_workers)


def _drawn(result: Record, found: OtherPressure, times_steps: float) -> Prediction | str:
    """What the draws gave, by runs of so many times the answer's steps at most, or as it is kept; or why they gave nothing."""
    experiment, test = found.experiment, found.test
    steps = found.calibrated.details.get("steps", test.step_limit)
    bounded = replace(test, step_limit=int(min(test.step_limit, times_steps * steps)))
    failed = []

    def table() -> NDArray | None:
        try:
            made = predict(result, bounded, experiment.reference.control, samples=DRAWS, workers=_workers(result), experiment=experiment.name)
        except InputError as error:
            failed.append(str(error))
            return None
        return _as_table({THETA: made.theta, **made.values})

    rows = result.derived(f"prediction by {DRAWS} draws at {test.confining_pressure!r}", table)
    if rows is None:
        return failed[0]
    values = {name: rows[name] for name in rows.dtype.names or () if name != THETA}
    reference = experiment.reference
    return Prediction(reference.control_name, reference.control, rows[THETA], values, error_options=result.calibration.error_options, measured_like=reference)


def _as_table(columns: Mapping[str, NDArray]) -> NDArray:
    """Columns (K, ...) as one structured array (K,), as the store keeps it."""
    table = np.empty(len(next(iter(columns.values()))), dtype=[(name, "<f8", values.shape[1:]) for name, values in columns.items()])
    for name, values in columns.items():
        table[name] = values
    return table


def _once(result: Record, found: OtherPressure) -> OtherPressure:
    """With one simulation of the answer."""
    test, candidate = found.test, found.candidate
    seconds, steps = found.calibrated.details.get("seconds", 0.0), found.calibrated.details.get("steps", test.step_limit)
    if seconds > LONGEST:
        return replace(
            found,
            missing=f"It was not simulated: the same sample took {numbers.duration(seconds)} in the calibration, and a report waits {LONGEST:g} s at most.",
        )
    bounded = replace(test, step_limit=min(test.step_limit, int(_MORE_STEPS * steps)))
    outcome = _kept(
        result, f"prediction of {candidate.sample} at {bounded.confining_pressure!r}", lambda: _simulate(result, bounded, candidate, found.experiment)
    )
    if isinstance(outcome, Response):
        return replace(found, response=outcome)
    return replace(found, missing=f"It could not be simulated: {outcome.reason}")


def _simulate(result: Record, test: TriaxialTest, candidate: Candidate, experiment: Experiment) -> Response | Failure:
    [(_, outcome)] = test.evaluate(as_samples(result, candidate, experiment), experiment.reference.control, workers=1)
    return outcome


def _kept(result: Record, name: str, simulate: Callable[[], Response | Failure]) -> Response | Failure:
    """What is simulated, kept with what the last look found, so that another report does not run it again."""
    if not result.has_posterior or result.found is None:
        return simulate()
    failures = []

    def table() -> NDArray | None:
        """The response's control and values as columns."""
        outcome = simulate()
        if isinstance(outcome, Failure):
            failures.append(outcome)
            return None
        return _as_table({CONTROL: outcome.control, **outcome.values})

    rows = result.derived(name, table)
    return failures[0] if rows is None else Response(rows[CONTROL], {name: rows[name] for name in rows.dtype.names or () if name != CONTROL})


def draw_other_pressure(prediction: OtherPressure | None) -> Figure | None:
    """The observables at the other pressure, beside those of the calibration."""
    if prediction is None or (prediction.response is None and prediction.drawn is None):
        return None
    experiment = prediction.experiment
    predicted, calibrated = (numbers.pressure(pressure) for pressure in (prediction.test.confining_pressure, prediction.calibrated_test.confining_pressure))
    axis, x = control_axis(experiment)
    scale = quantity(experiment.reference.control_name).scale
    panels = []
    for name, values in experiment.reference.measured.items():
        shown = quantity(name)
        title = f"{shown.title}{NOT_FITTED * (name in experiment.reference.recorded)}"
        marks = (
            *_predicted(prediction, name, scale, predicted),
            Line(
                scale * prediction.calibrated.control,
                prediction.calibrated.values[name] * shown.scale,
                replace(BEST, dash="dash"),
                f"calibrated at {calibrated}",
            ),
            Points(x, values * shown.scale, REFERENCE, f"reference at {calibrated}"),
        )
        panels.append(Panel(title, axis, Axis(shown.axis), marks))
    in_view, cut = in_sight(panels)
    caption = f"{_caption(prediction, predicted)} {cut}".strip()
    return Figure(
        "prediction", f"Predicted, not confirmed, at {predicted}, beside the test at {calibrated}.", caption, in_view, columns=min(3, max(2, len(panels)))
    )


def _predicted(prediction: OtherPressure, name: str, scale: float, pressure: str) -> list[Mark]:
    if drawn := prediction.drawn:
        return predicted_marks(drawn, name, scale * drawn.control, f"predicted mean at {pressure}")
    response = prediction.response
    assert response is not None
    return [Line(scale * response.control, response.values[name] * quantity(name).scale, PREDICTED, f"predicted at {pressure}")]


def _caption(prediction: OtherPressure, pressure: str) -> str:
    name = prediction.experiment.name
    confirmed = "No test at this pressure was compared with it"
    if drawn := prediction.drawn:
        failed = DRAWS - len(drawn.theta)
        lost = f" {numbers.count(failed, 'more run')} failed." if failed else ""
        return (
            f"A prediction, not a confirmation: simulations at {pressure}, everything else as in {name}. {confirmed}. "
            f"{drawn.band_in_words(tuple(prediction.experiment.reference.measured), PROBABILITY)}{of_packings(prediction.test)}{lost}"
        )
    return (
        f"A prediction, not a confirmation: one simulation of sample {prediction.candidate.sample} at {pressure}, everything else as in {name}. "
        f"{confirmed}, and another run of the same parameters would differ by the scatter of runs. {prediction.without_band}"
    )


def of_packings(test: StressPathTest) -> str:
    """What of packings is not in a band, as a sentence after others; nothing where the runs are on several."""
    return " What other packings of the same soil would add is not in it." if len(test.packings) == 1 else ""
