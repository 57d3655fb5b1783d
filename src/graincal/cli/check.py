"""graincal check."""

from __future__ import annotations

import math
import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from graincal.cli.saying import say
from graincal.data import Failure, InputError, Response
from graincal.notation.printable import printable, printable_json

if TYPE_CHECKING:
    from graincal.campaign import Calibration, Experiment
    from graincal.campaign.asked.limits import Limits
    from graincal.campaign.file.examination import Examination, Examined
    from graincal.campaign.file.questions import OpenQuestion
    from graincal.data import Reference

UNANSWERED = 2
"""The exit code where there are questions or problems."""


def check(
    file: Annotated[Path, typer.Argument(help="The calibration file.", metavar="calibration.toml")],
    plot: Annotated[Path | None, typer.Option(help="Draw the references to this file (.png, .pdf, .svg); nothing is overwritten.", metavar="FILE")] = None,
    run: Annotated[
        bool,
        typer.Option(
            "--run",
            help="Where a model is a program or a function of Python: run the first sample, and draw what it gave beside the reference, in FILE of --plot too. Without it no program is run.",
        ),
    ] = False,
    as_json: Annotated[
        bool,
        typer.Option("--json", help="For programs: what was found, as one JSON document; no evaluation is run for it, but a packing may have to be prepared."),
    ] = False,
) -> None:
    """Read a calibration file and all that it names, draw what was read, say what speaks against it and how long the calibration will take.

    One short evaluation in the middle of the ranges is run for that, but no program, of which the first sample's inputs are shown. The exit code is 0 where nothing has to be answered, 1 where the file cannot be read, and 2 where
    there are questions or problems, or the run of --run failed.
    """
    from graincal.cli.outputs import check_figure
    from graincal.cli.running import look_at

    try:
        if plot is not None:
            check_figure(plot)
        if run and as_json:
            raise InputError("--run shows curves to a person, and --json is for programs: one of them was expected.")
        found = look_at(file, quiet=as_json)
    except InputError as error:
        if as_json:
            say(printable_json({"error": str(error)}), prose=False)
        raise
    if as_json:
        say(printable_json(found.as_json(), indent=2, allow_nan=False), prose=False)
    else:
        _say(found)
    outcomes = _run_first(found, run=run) if not as_json else {}
    responses = {number: each for number, each in outcomes.items() if not isinstance(each, Failure)}
    if plot is not None:
        _draw(found, plot, responses, quiet=as_json)
    if not as_json and found.calibration:
        _say_expectation(found.calibration, _of_programs(found.calibration, responses) if len(responses) == len(outcomes) else 0.0)
    if not found.is_clear or len(responses) < len(outcomes):
        raise typer.Exit(UNANSWERED)


def _of_programs(calibration: Calibration, responses: Mapping[int, Response]) -> float:
    """Seconds that the first sample took in programs, which are not timed otherwise."""
    from graincal.models import CommandModel

    return sum(each.details.get("seconds", 0.0) for number, each in responses.items() if isinstance(calibration.experiments[number].model, CommandModel))


def _run_first(found: Examination, *, run: bool) -> Mapping[int, Response | Failure]:
    """Show what programs are given, and run them where that is asked for: what they came to, by the numbers of their experiments."""
    from graincal.cli.first_run import run_first, say_inputs

    if not found.calibration:
        if run:
            say("No sample was run, for the file cannot be calibrated yet.", err=True)
        return {}
    say_inputs(found.calibration)
    return run_first(found.calibration) if run else {}


def _say(found: Examination) -> None:
    calibration = found.calibration
    if calibration:
        _say_calibration(calibration)
    else:
        for experiment in found.experiments:
            say("\n".join(_describe_so_far(experiment)))
    sections = {
        "Decided": [f'Experiment "{each.experiment}": {each}' if each.experiment else str(each) for each in found.decided],
        "Questions": [_question(each) for each in found.questions],
        "Problems": list(map(str, found.problems)),
        # How files were read stands with their experiments.
        "Notes": [str(each) for each in found.notes if each.sentence not in _said_with_experiments(found)],
    }
    for title, lines in sections.items():
        if lines:
            say("\n".join([f"{title}:", *(f"  {line}" for line in lines)]))


def _said_with_experiments(found: Examination) -> set[str]:
    return {note for experiment in found.experiments for note in experiment.reference.notes}


def _question(question: OpenQuestion) -> str:
    proposed = f' "{question.proposed}" is likely.' if question.proposed else ""
    return f"{question.sentence}{proposed}"


def _say_calibration(calibration: Calibration) -> None:
    """Parameters, experiments, and what was known before."""
    from graincal.campaign.asked.prior import beside_ranges
    from graincal.inference import IterativeBayesianFilter, sample_size_advice

    space = calibration.space
    for name, low, high, unit in zip(space.names, space.low, space.high, space.units):
        say(f"parameter {name}: {low:g} to {high:g} {unit}".rstrip())
    for sentence in beside_ranges(space):
        say(sentence)
    for experiment in calibration.experiments:
        say("\n".join(_describe(experiment, calibration.method)))
    for source in calibration.known.sources if calibration.known else ():
        say(source)
    if look := calibration.first_look:
        say(f"first look: {len(look.theta)} evaluations of another campaign, of the same parameters and experiments")
    if calibration.look:
        say("first look, by cheaper models:")
        for experiment in calibration.look.experiments:
            say("\n".join(_describe_model(experiment)))
    filter = calibration.blank_filter()
    if isinstance(filter, IterativeBayesianFilter) and (advice := sample_size_advice(space, filter.alpha)):
        say(advice)


def _say_expectation(calibration: Calibration, seconds: float) -> None:
    """seconds: what the runs of the first sample took together, 0 where there were none."""
    if calibration.look:
        say("First look: " + "\n".join(_expectation(calibration.look)))
    say("\n".join(_expectation(calibration, seconds)))


def _draw(found: Examination, plot: Path, responses: Mapping[int, Response], *, quiet: bool) -> None:
    from graincal.cli.figures import draw_references

    if not found.experiments:
        say(f"{plot}: nothing was drawn, for no reference can be read before the questions are answered.", err=True)
        return
    draw_references(found.calibration.experiments if found.calibration else found.experiments, plot, responses)
    if not quiet:
        say(f"References{' and the run of the first sample' if any(isinstance(each, Response) for each in responses.values()) else ''} drawn to {plot}.")


def _describe_so_far(experiment: Examined) -> list[str]:
    """An experiment whose model cannot be made yet."""
    asked = f" (open: {', '.join(experiment.questions)})" if experiment.questions else ""
    reference, kind = experiment.reference, experiment.entry.model.kind or "of a kind that is open"
    return [f'experiment "{experiment.name}", {kind}{asked}', *_describe_reference(reference), *(f"  {note}" for note in reference.notes)]


def _describe(experiment: Experiment, method: str) -> list[str]:
    from graincal.campaign.asked.calibration import POSTERIOR
    from graincal.campaign.asked.errors import describe_errors

    reference, lines = experiment.reference, _describe_model(experiment)
    lines += _describe_reference(reference)
    if method == POSTERIOR:
        lines += [f"    {sentence}" for sentence in describe_errors(reference)]
    return lines + [f"  {note}" for note in reference.notes]


def _describe_reference(reference: Reference) -> list[str]:
    from graincal.notation.text import resample, sparkline

    lines = [f"  reference: {len(reference.control)} rows, {reference.control_name} {reference.control[0]:g} to {reference.control[-1]:g}"]
    for name, values in reference.measured.items():
        curve = sparkline(resample(reference.control, values))
        counts = "not fitted" if name in reference.recorded else f"variance share {reference.variance_shares[name]:g}"
        lines.append(f"    {name:20} {curve}  {values.min():.4g} to {values.max():.4g}, {counts}")
    return lines


def _describe_model(experiment: Experiment) -> list[str]:
    from graincal.models import ByHandModel, CommandModel, StressPathTest
    from graincal.models.contact_laws import DEFAULT_LAW

    model, lines = experiment.model, [f'experiment "{experiment.name}"']
    if isinstance(model, StressPathTest):
        packing = model.first_packing
        at = f" at {model.confining_pressure:g} Pa" if model.confining_pressure is not None else ""
        every = f", every {model.strain_between_rests:.4g} of axial strain" if model.strain_between_rests else ""
        several = f", the first of {len(model.packings)} packings" if len(model.packings) > 1 else ""
        lines.append(f"  {model.title}{at}, {packing.count} particles, void ratio {packing.void_ratio:.3f}{several}")
        lines += [f"  {model.turns_in_words}"] if model.turns_in_words else []
        lines += [] if model.law == DEFAULT_LAW else [f"  contact law: {model.law}"]
        lines.append(f"  {len(model.states(experiment.reference.control))} states at rest{every}; rows between them are interpolated")
        lines.append(f"  {', '.join([model.density_in_words, *(f'{name} {value}' for name, value in model.economies.items())])}")
        lines += [f"  fixed: {name} = {value:g}" for name, value in model.fixed.items()]
    elif isinstance(model, CommandModel):
        lines.append(f"  command: {printable(shlex.join(model.command))}")
    elif isinstance(model, ByHandModel):
        derived = f", derived: {', '.join(model.derived)}" if model.derived else ""
        lines.append(
            f"  runs are made by hand{derived}; a file of each holds {', '.join(model.returned) if model.returned else 'columns by the names of the quantities'}"
        )
    else:
        lines.append(f"  model: {getattr(model, 'function', model)}")
    return lines


def _expectation(calibration: Calibration, took: float = 0.0) -> list[str]:
    """How many evaluations there will be, and how long they take as far as that is known. took: seconds of the first sample's runs, 0 where there were none."""
    from graincal.campaign.asked.limits import Limits
    from graincal.execution import available_cores
    from graincal.inference import PosteriorFilter

    filter, workers = calibration.blank_filter(), calibration.number_of_workers
    # More workers than cores share them.
    at_once = workers if calibration.place else min(workers, available_cores())
    lines, first_round, pilots = _timed(calibration, at_once, took)
    samples, limits = len(filter.under_way[0]), Limits.of(calibration, filter)
    shared = f" on {at_once} core{'s' * (at_once > 1)}" if at_once < workers else ""
    begin = f"{{}}{_about(first_round)} with {workers} worker{'s' * (workers > 1)}{shared}"
    if isinstance(filter, PosteriorFilter):
        if any(filter.siblings):
            lines.append(_on_siblings(pilots / at_once))
        known = f" beside the {len(calibration.known)} that are known" if calibration.known else ""
        return [*lines, f"Expect {begin.format(f'{samples} evaluations that fill the ranges{known}')}. {_course(calibration, limits, samples, first_round)}"]
    rounds = limits.rounds
    most = f"; at most {limits.evaluations} evaluations in {rounds} iteration{'s' * (rounds > 1)}{_about(rounds * first_round)}" if rounds else ""
    return [*lines, f"Expect {begin.format(f'{samples} evaluations an iteration')}{most}."]


def _timed(calibration: Calibration, at_once: int, took: float) -> tuple[list[str], float, float]:
    """What is known of the times, in sentences; the seconds of the first round, so many at once; and those of one run of each experiment. NaN for what is not known."""
    from graincal.campaign.file.expectation import NOT_RUN, expect
    from graincal.notation.text import duration

    samples, each = len(calibration.blank_filter().under_way[0]), calibration.expected_seconds
    if each:
        beside = f", and the first sample took {duration(took)}" if took else ""
        return [f"about {duration(each)} for an evaluation, as expected_seconds says{beside}"], each * math.ceil(samples / at_once), each
    lines, seconds, pilots = [], 0.0, 0.0
    for expected in expect(calibration):
        if expected.failure is None:
            assert expected.pilot is not None and expected.seconds is not None and expected.longest is not None, "they are known where it has not failed"
            lines.append(
                f'"{expected.experiment}": about {duration(expected.pilot)} for an evaluation in the middle of the ranges, {duration(expected.longest)} for the longest'
            )
            seconds += max(expected.seconds / at_once, expected.longest)
            pilots += expected.pilot
        elif expected.failure.kind == NOT_RUN and took:
            # What its first sample took is known, that of all programs together.
            continue
        elif expected.failure.kind == NOT_RUN:
            return [*lines, f'experiment "{expected.experiment}": {expected.failure.reason}'], math.nan, math.nan
        else:
            said = f'experiment "{expected.experiment}" cannot be timed, its pilot in the middle of the ranges failed: {expected.failure.reason}'
            return [*lines, said], math.nan, math.nan
    if took:
        each = took + pilots
        said = f"The first sample took {duration(took)}. expected_seconds = {each:.2g} under [run] says how long one evaluation takes in all experiments, where others take about as long: more runs then fill the ranges of what takes seconds."
        lines.append(said)
    return lines, seconds + took * math.ceil(samples / at_once), pilots


def _course(calibration: Calibration, limits: Limits, samples: int, first_round: float) -> str:
    """Where a calibration by the method "posterior" ends as most do, and at the latest. first_round: the seconds of its samples."""
    from graincal.campaign.file.forecast import Forecast

    forecast = Forecast.of(samples, len(calibration.known) if calibration.known else 0, limits.evaluations)
    most, a_sample = forecast.at_most, first_round / samples
    if most is not None and forecast.evaluations >= most:
        course = f"The limit ends it after {most}{_about(a_sample * most)}, where most calibrations have not settled"
    else:
        limit = f", and ends after {most} at the most{_about(a_sample * most)}" if most else ""
        course = f"As most do, a calibration settles after some {forecast.evaluations}{_about(a_sample * forecast.evaluations)}{limit}"
    hours = f" It begins no further batch after {calibration.stop.hours:g} hours." if calibration.stop.hours else ""
    return f"{course}; the filter itself takes some seconds more after each batch.{hours}"


def _on_siblings(seconds: float) -> str:
    """What runs on packings like each one cost. seconds: of one place."""
    from graincal.inference.likelihood.packings import PLACES, REPEATED, REPEATS, SIBLINGS

    runs = PLACES * (SIBLINGS + REPEATED * (REPEATS - 1))
    return f"{runs} runs more on {SIBLINGS} packings like each one say what packings differ by{_about(seconds * runs)}; to prepare these once takes minutes."


def _about(seconds: float) -> str:
    """A time behind what takes it; nothing where it is not known."""
    from graincal.notation.text import duration

    return f" (about {duration(seconds)})" if math.isfinite(seconds) else ""
