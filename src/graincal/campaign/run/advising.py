"""Which further test would narrow the parameters most: runs at draws from the posterior, and what such data would be expected to tell."""

from __future__ import annotations

import hashlib
import json
import tempfile
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.asked.calibration import POSTERIOR, Calibration
from graincal.campaign.asked.description import describe
from graincal.campaign.asked.experiment import Experiment
from graincal.campaign.asked.file_names import file_name
from graincal.campaign.found.next_command import going_on
from graincal.campaign.found.prediction import drawn_rows
from graincal.campaign.found.run_library import Library
from graincal.campaign.run.advice import FEW_EFFECTIVE, Advice, AdvisedTest
from graincal.campaign.run.candidate_tests import CandidateTest, candidate_test, default_tests
from graincal.campaign.run.exploring import fill, for_library
from graincal.campaign.stored.asked import as_stored
from graincal.campaign.stored.listener import Listener
from graincal.data import Failure, InputError, Reference, Response
from graincal.execution import number_of_workers
from graincal.inference.likelihood.error_model import error_model
from graincal.inference.likelihood.packings import PackingScatter
from graincal.inference.likelihood.packings_elsewhere import packings_elsewhere
from graincal.inference.likelihood.thinning import Thinning
from graincal.inference.posterior.gain import expected_gain
from graincal.inference.sampling.posterior import Posterior
from graincal.inference.sampling.proposal import systematic_resampling
from graincal.models import StressPathTest
from graincal.models.stress_path import unusual
from graincal.notation.words import listed
from graincal.result import Result

ADVICE = "advice"
"""The folder within a campaign's that keeps the runs, one for each test."""

FEWEST = 60
"""Draws: from fewer no emulator of a test is learnt, and no order of tests."""

LEAST = 40
"""Of these: runs that must have given a response for a test to be judged."""

LOST = 0.1
"""The part of its truths of which a test may lose so many without a remark."""

SAMPLES = 2000
"""Of the posterior, that data weigh."""


def advise(
    result: Result,
    tests: Sequence[CandidateTest | str] | None = None,
    *,
    samples: int = 100,
    seed: int = 1,
    workers: int | Literal["all"] = "all",
    folder: str | Path | None = None,
    listeners: Sequence[Listener] = (),
) -> Advice:
    """Which further test would narrow the parameters of a campaign most.

    >>> advise(result, ["undrained", "triaxial 1e6"]).tests[0].name                              # doctest: +SKIP

    tests: `CandidateTest`s, or words (`candidate_test`); by default those of `default_tests`. samples: draws from the posterior that each test is run at. folder: where these runs are kept; by
    default `advice` in the campaign's own, and nowhere for a campaign in memory. The same again goes on with what was broken off. workers: runs at once; the result does not depend on it.
    Raises InputError where there is no posterior by the method "posterior", where the campaign is not at its end, for fewer than sixty draws, and for tests that there are not.
    """
    _check(result, samples)
    number_of_workers(workers)  # raises for what is none
    experiment = _experiment(result)
    candidates = _candidates(result, tests, experiment)
    rng = np.random.default_rng([seed, 0])
    theta = _draws(result, samples, rng)
    posterior = _posterior(result)
    places = posterior.samples[systematic_resampling(posterior.weights, SAMPLES, rng)]
    judged, not_judged = [], {}
    with ExitStack() as stack:
        root = Path(folder) if folder is not None else result.folder / ADVICE if result.folder else Path(stack.enter_context(tempfile.TemporaryDirectory()))
        outcomes = [_run(result, experiment, test, theta, seed, workers, root, listeners) for test in candidates]
    for number, (test, found) in enumerate(zip(candidates, outcomes)):
        failures = tuple(outcome for outcome in found if isinstance(outcome, Failure))
        draws = np.array([row for row, outcome in enumerate(found) if isinstance(outcome, Response)], dtype=np.intp)
        if len(draws) < LEAST:
            why = f", the first because: {failures[0].reason}" if failures else ""
            not_judged[test.name] = f"only {len(draws)} of its {len(theta)} runs gave a response, and {LEAST} are needed{why}"
            continue
        for listener in listeners:
            listener.remark(f"Weighs what {test.name} would tell.")
        judged.append(_judge(result, experiment, test, theta, draws, [found[row] for row in draws], failures, places, np.random.default_rng([seed, 1, number])))
    if not judged:
        raise InputError("no test could be judged: " + "; ".join(f"{name}: {why}" for name, why in not_judged.items()))
    judged.sort(key=lambda each: -each.information)
    remarks = _remarks(result, experiment, judged) + _lost(judged, samples)
    return Advice(result.space, posterior.std(), theta, tuple(judged), not_judged, tuple(remarks))


def _check(result: Result, samples: int) -> None:
    """Raise InputError where advice cannot be given, before anything is run."""
    if not result.has_posterior:
        raise InputError(
            f'advice needs to know how sure the parameters are: the campaign\'s method is "{result.calibration.method}", and "{POSTERIOR}" was expected.'
        )
    if result.posterior is None or not result.stopped_by:
        by = f"; go on with it by: {going_on(result.folder)}" if result.folder else "."
        raise InputError(f"advice is by the posterior of a campaign at its end, and this one is not{by}")
    if isinstance(samples, bool) or not isinstance(samples, (int, np.integer)) or samples < FEWEST:
        raise InputError(f"advice needs at least {FEWEST} draws from the posterior, not {samples!r}.")


def _experiment(result: Result) -> Experiment:
    """The first with a built-in test, whose grains are tested further; the first, where there is none."""
    return next((each for each in result.experiments if isinstance(each.model, StressPathTest)), result.experiments[0])


def _candidates(result: Result, tests: Sequence[CandidateTest | str] | None, experiment: Experiment) -> list[CandidateTest]:
    """The tests that are asked for, or the default ones. Raises InputError for what is none."""
    if (tests is None or any(isinstance(test, str) for test in tests)) and not isinstance(experiment.model, StressPathTest):
        raise InputError(
            "the campaign has no experiment with a built-in test: tests of other models are those of a calibration file, by --tests, or are given from Python, as graincal.CandidateTest(name, model, at, observables)."
        )
    if tests is None:
        return default_tests(experiment, result.experiments)
    found = [candidate_test(test, experiment) if isinstance(test, str) else test for test in tests]
    if not found or not all(isinstance(test, CandidateTest) for test in found):
        raise InputError("advice needs a list of tests, each words or a CandidateTest.")
    names = [test.name for test in found]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise InputError(f'two tests are called "{twice}", and each was expected once.')
    return found


def _posterior(result: Result) -> Posterior:
    assert result.posterior is not None, "`_check` refuses a campaign without"
    return result.posterior


def _draws(result: Result, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """From the posterior, (K, n), spread evenly over its weights, all different: one that is drawn twice is one truth."""
    posterior = _posterior(result)
    drawn = posterior.samples[np.unique(drawn_rows(posterior, count, rng))]
    if len(drawn) < FEWEST:
        raise InputError(f"the posterior is held by so few of its samples that {count} draws are {len(drawn)} different ones, and {FEWEST} were expected.")
    return drawn


def _run(
    result: Result,
    like: Experiment,
    test: CandidateTest,
    theta: NDArray[np.float64],
    seed: int,
    workers: int | Literal["all"],
    root: Path,
    listeners: Sequence[Listener],
) -> list[Response | Failure | None]:
    """The outcomes of a test at the draws (K, n), by the values that parameters have in the experiment that it is like; a response is at the test's own rows."""
    number = result.number(like.name)
    space, points = result.space.of_experiment(number), theta[:, result.space.columns(number)]
    # Runs do not depend on measurement errors, and serve whichever the test has.
    experiment = Experiment(test.name, test.model, replace(test, measurement_errors={}).reference(np.ones((len(test.at), len(test.observables)))))
    asked = Calibration(space, [experiment], seed=seed, workers=workers)
    # Of other draws, as after a campaign has gone on, and of another model there is another library.
    described = json.dumps(as_stored(describe(for_library(asked))), sort_keys=True)
    digest = hashlib.sha256(np.ascontiguousarray(points).tobytes() + described.encode()).hexdigest()[:8]
    kept = fill(asked, root / f"{file_name(test.name)}-{digest}", listeners=listeners, points=points)
    (outcomes,) = Library.read(kept).outcomes
    return [_at_rows(outcome, experiment) if isinstance(outcome, Response) else outcome for outcome in outcomes]


def _at_rows(response: Response, experiment: Experiment) -> Response:
    rows = experiment.observables(response)
    return Response(experiment.reference.control, dict(zip(experiment.reference.names, rows.T)))


def _judge(
    result: Result,
    experiment: Experiment,
    test: CandidateTest,
    theta: NDArray[np.float64],
    draws: NDArray[np.intp],
    responses: Sequence[Response],
    failures: tuple[Failure, ...],
    places: NDArray[np.float64],
    rng: np.random.Generator,
) -> AdvisedTest:
    """What a test is expected to tell, from the responses at some of the draws."""
    number = result.number(experiment.name)
    curves = np.stack([response.observables(tuple(test.observables)) for response in responses])
    whole = Thinning.of(test.reference(curves.mean(axis=0), simulated=experiment.reference.simulated))
    packings, counted = _packings(result, number, test, whole.kept)
    errors = error_model(whole, **result.calibration.error_options, packings=packings, counted=counted)
    gain = expected_gain(theta[draws], whole.reduce(curves), places, whole.kept, errors, rng, result.space.columns(number))
    not_studied = None if packings is None else tuple(name for name in test.observables if name not in experiment.reference.names)
    return AdvisedTest(test, len(theta), failures, draws, gain, not_studied)


def _packings(result: Result, number: int, test: CandidateTest, reference: Reference) -> tuple[PackingScatter | None, float]:
    """What packings differ by in a test whose mean response is the reference, and how often that counts; None where the campaign does not know."""
    known = result.knowledge
    scatter, siblings, before = known.packings[number], known.siblings[number], known.kept[number]
    if scatter is None or siblings is None or not isinstance(test.model, StressPathTest):
        return None, 0.0
    # In a joint calibration the test would be one more on the same packing.
    return packings_elsewhere(scatter, before, _along(before), reference, _along(reference)), known.counted(number) + 1 / siblings.own


def _along(reference: Reference) -> NDArray[np.float64]:
    """How far along a test its rows are, from 0 at its beginning to 1, (T,): over the logarithm of a stress."""
    control = reference.control
    if reference.control_name.endswith("stress"):
        control = np.log(control / control[0])
    return control / control[-1] if control[-1] > 0 else np.linspace(0, 1, len(control))


def _remarks(result: Result, experiment: Experiment, judged: Sequence[AdvisedTest]) -> list[str]:
    """What was taken for granted, and what to bear in mind."""
    said = []
    stated = sorted({name for each in judged for name in each.test.measurement_errors})
    usual = sorted({name for each in judged for name in each.test.observables} - set(stated))
    if stated:
        said.append(f"Measurement errors of {_listed(stated)} are those that the campaign states.")
    if usual:
        said.append(f"Measurement errors of {_listed(usual)} are 1 % of the peak.")
    if any(each.not_studied is not None for each in judged):
        others = list(dict.fromkeys(name for each in judged for name in each.not_studied or ()))
        but = f"; of {_listed(others)}, which {'were' if len(others) > 1 else 'was'} not studied, the mean of its observables" if others else ""
        said.append(f'What packings differ by is that of "{experiment.name}", as a part of the peaks{but}.')
    if left_out := [each.name for each in judged if each.not_studied is None]:
        said.append(f"What packings differ by is not known, and left out{'' if len(left_out) == len(judged) else f' of {listed(left_out)}'}.")
    if own := result.space.per_experiment:
        said.append(f'{listed(own)} {"have the values" if len(own) > 1 else "has the value"} of "{experiment.name}".')
    if experiment.reference.simulated:
        said.append("The tests are taken for simulations, as the campaign's reference is one: nothing is counted that the model cannot reproduce.")
    elif result.calibration.error_options["discrepancy"] is not False:
        said.append("What the model cannot reproduce of a test is 1, 2 or 4 % of the peaks.")
    said.append("What runs scatter by is counted.")
    if not result.settled:
        said.append("The posterior has not settled: what it says of tests may yet move, too.")
    for each in judged:
        if (left := np.median(each.gain.effective_samples)) < FEW_EFFECTIVE:
            said.append(
                f"{each.name} tells so much that {left:.0f} samples of the posterior are left, in the median: "
                f"its deviations come out too small by about {75 / left:.0f} %, and its gain too large by about {0.5 / left:.2g} nats."
            )
        said += [f"{each.name}: {doubt}" for doubt in (unusual(each.test.model) if isinstance(each.test.model, StressPathTest) else ())]
    return said


def _lost(judged: Sequence[AdvisedTest], samples: int) -> list[str]:
    """Which truths do not count as often as the posterior has them. samples: the draws that were asked for."""
    said = []
    if (different := judged[0].runs) < samples:
        said.append(
            f"{samples} draws from the posterior are {different} different ones: one that was drawn more than once counts once, so that probable values count less than they ought to."
        )
    for each in judged:
        if len(each.failures) > LOST * each.runs:
            said.append(
                f"{each.name}: {len(each.failures)} of its {each.runs} runs gave no response, and it is judged by the other truths, which need not be like those."
            )
    return said


def _listed(names: Sequence[str]) -> str:
    """Names as words of a sentence."""
    return listed([name.replace("_", " ") for name in names])
