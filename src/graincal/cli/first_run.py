"""What a program is given for the first sample of a calibration, and what it makes of it: where most mistakes are found."""

from __future__ import annotations

import shlex
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from graincal.campaign import Calibration, Experiment
from graincal.campaign.file.run_doubts import doubts_of_run
from graincal.cli.saying import say
from graincal.data import Failure, Reference, Response, Samples
from graincal.interpolation import interpolate
from graincal.models import CommandModel, PythonModel
from graincal.models.command.folders import PRINTED
from graincal.models.command.work import COLOURS, PRINTED_LAST
from graincal.notation.printable import printable
from graincal.notation.text import duration, resample, sparkline

LINES, WIDTH = 30, 160
"""Lines of a file that are shown, and characters of a line."""


def say_inputs(calibration: Calibration) -> None:
    """Show the inputs of the first sample; nothing is run."""
    for number, (experiment, program) in _programs(calibration).items():
        sample = _first(calibration, number)
        (given,) = program.given(sample, experiment.reference.control)
        lines = [f'Inputs of the first sample in "{experiment.name}":', f"  {_parameters(sample)}"]
        if isinstance(given, Failure):
            say("\n".join([*lines, f"  cannot be made: {given.reason}"]))
            continue
        lines.append(f"  {printable(shlex.join(given.command))}")
        lines += [f"  {printable(f'{name}={text}')}" for name, text in given.environment.items()]
        lines += [f"  {name} is a link to {source}" for name, source in given.links.items()]
        for name, text in given.files.items():
            lines += [f"  {name}:", *_shown(text)]
        say("\n".join(lines), prose=False)


def run_first(calibration: Calibration) -> Mapping[int, Response | Failure]:
    """Run the first sample, and show what was read beside the reference. What the runs came to, by the numbers of their experiments."""
    found: dict[int, Response | Failure] = dict(_run_functions(calibration))
    for number, (experiment, program) in _programs(calibration).items():
        folder = Path(tempfile.mkdtemp(prefix="graincal-check-"))
        model = replace(program, folders=replace(program.folders, root=folder, keep="all"))
        sample = _first(calibration, number)
        ((_, outcome),) = replace(experiment, model=model).evaluate(sample, workers=1)
        outcome = _met(experiment, outcome)
        took = duration(outcome.details["seconds"]) if "seconds" in outcome.details else "no time"
        lines = [f'The first sample in "{experiment.name}" took {took}; its folder: {next(folder.glob("*/attempt-*"), folder)}']
        found[number] = outcome
        if isinstance(outcome, Failure):
            printed = _printed(folder)
            # All of the last lines are shown below it.
            reason = outcome.reason.partition(PRINTED_LAST)[0] if printed else outcome.reason
            lines += [f"  failed, {outcome.kind}: {reason}", *printed]
        else:
            lines += _beside(experiment.reference, outcome)
        say("\n".join(lines), prose=False)
        _say_doubts(experiment, outcome)
    return found


def _run_functions(calibration: Calibration) -> Iterator[tuple[int, Response | Failure]]:
    """The first sample by each function of Python, and what it came to."""
    for number, experiment in enumerate(calibration.experiments):
        if isinstance(experiment.model, PythonModel):
            sample = _first(calibration, number)
            ((_, outcome),) = experiment.evaluate(sample, workers=1)
            outcome = _met(experiment, outcome)
            failed = isinstance(outcome, Failure)
            beside = [f"  failed, {outcome.kind}: {outcome.reason}"] if isinstance(outcome, Failure) else _beside(experiment.reference, outcome)
            took = f" took {duration(outcome.details['seconds'])}" if "seconds" in outcome.details else ""
            say("\n".join([f'The first sample in "{experiment.name}"{took}: {_parameters(sample)}', *beside]), prose=failed)
            _say_doubts(experiment, outcome)
            yield number, outcome


def _met(experiment: Experiment, outcome: Response | Failure) -> Response | Failure:
    """What was run, at the rows of the reference: a function may have states of its own."""
    if isinstance(outcome, Failure):
        return outcome
    met = interpolate(outcome, experiment.reference.control)
    return met if isinstance(met, Failure) else replace(met, details=outcome.details)


def _say_doubts(experiment: Experiment, outcome: Response | Failure) -> None:
    if not isinstance(outcome, Failure) and (said := doubts_of_run(experiment, outcome)):
        say("\n".join(["Notes:", *(f"  {sentence}" for sentence in said)]))


def _programs(calibration: Calibration) -> dict[int, tuple[Experiment, CommandModel]]:
    """The experiments, by their numbers, whose models are programs, and these."""
    return {number: (each, each.model) for number, each in enumerate(calibration.experiments) if isinstance(each.model, CommandModel)}


def _first(calibration: Calibration, number: int) -> Samples:
    samples = calibration.blank_filter().under_way[0].take([0])
    return calibration.space.seen_by(number, samples)


def _parameters(sample: Samples) -> str:
    return ", ".join(f"{name} = {value:.6g}" for name, value in zip(sample.names, sample.theta[0]))


def _shown(text: str) -> list[str]:
    lines = text.splitlines()
    more = [f"    ... and {len(lines) - LINES} lines more"] if len(lines) > LINES else []
    return [f"    {printable(line, WIDTH)}" for line in lines[:LINES]] + more


def _printed(folder: Path) -> list[str]:
    for file in folder.glob(f"*/attempt-*/{PRINTED}"):
        if lines := COLOURS.sub("", file.read_text(encoding="utf-8")).splitlines()[-LINES:]:
            return ["  It printed last:", *(f"    {printable(line, WIDTH)}" for line in lines)]
    return []


def _beside(reference: Reference, response: Response) -> list[str]:
    """Each observable of the response, and below it that of the reference, drawn alike."""
    lines = []
    for name, measured in reference.measured.items():
        values = response.values[name]
        low, high = float(min(values.min(), measured.min())), float(max(values.max(), measured.max()))
        for called, curve in ((name, values), ("  reference", measured)):
            lines.append(f"    {called:20} {sparkline(resample(reference.control, curve), low, high)}  {curve.min():.4g} to {curve.max():.4g}")
    if left_out := response.details.get("rows_left_out"):
        lines.append(f"    {left_out:g} rows of its output were left out, where {reference.control_name} fell back or stood still")
    return lines
