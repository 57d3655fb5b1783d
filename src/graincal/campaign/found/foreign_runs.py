"""Runs that another tool made of a calibration's model, for the calibration to learn from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.asked.calibration import POSTERIOR, Calibration
from graincal.campaign.asked.experiment import Experiment
from graincal.campaign.found.runs import SAME, Gathered, add_run, listed
from graincal.data import Failure, InputError
from graincal.grainlearning import ForeignRun, read_folder
from graincal.inference.driving.known_runs import KnownRuns
from graincal.inference.likelihood.thinning import Thinning
from graincal.laboratory.quantities import STRAINS
from graincal.models import StressPathTest
from graincal.models.output import Column, Output
from graincal.models.output.tables import Unreadable, of_named
from graincal.notation.expression import Expression, NotAnExpression
from graincal.suggestion import did_you_mean

_LEFT_OUT = {"incomplete": "shorter than the reference", "not_finite": "not finite at the reference's rows"}
"""Why a curve says nothing, by the kind of failure that it is."""


FAR_AWAY = 50.0
"""A factor between runs and the reference that no parameters explain; units of strains differ by 100, those of stresses by 1,000."""


def foreign_runs(folder: Path, calibration: Calibration, columns: Mapping[str, Column] | None = None, parameters: Mapping[str, str] | None = None) -> KnownRuns:
    """The runs in a folder of GrainLearning's that a calibration of the same model can learn from.

    columns: quantity -> its column in the runs' files; by default as the model's output is declared, or the column that bears the quantity's name. parameters: parameter -> an expression of the runs' own ones, such as
    {"log_E": "log10(E)"}; by default the one that bears its name. Where the files hold no control, the curves are at the reference's own rows, as GrainLearning has them.

    That the model is the same is taken on trust. Raises InputError for a calibration that cannot learn from them, for what the files do not hold, and for runs that differ in what the calibration does not know.
    """
    experiment = _single(calibration)
    output, said = _output(experiment, columns), []
    found = read_folder(folder)
    theta, constant = _theta(folder, found.runs, calibration, parameters or {})
    if control := _without_control(found.runs[0], output, experiment):
        said.append(f"Its files hold no {control}: the curves are taken to be at the reference's own rows.")
    if constant:
        said.append(f"All its runs have {', '.join(f'{name} = {value:g}' for name, value in constant.items())}.")
    gathered, left_out, thinnings = Gathered(), dict(found.left_out), calibration.blank_filter().thinnings
    for run, values in zip(found.runs, theta):
        reason = _outside(values, run, calibration) or _add(
            gathered, run, np.clip(values, calibration.space.low, calibration.space.high), experiment, output, bool(control), thinnings
        )
        if reason:
            left_out[reason] = left_out.get(reason, 0) + 1
    if not gathered.theta:
        raise InputError(f"{folder}: none of its runs can be learnt from, {listed(left_out)}.")
    said += _far_away(gathered, experiment, thinnings[0])
    but = f"; left out: {listed(left_out)}" if left_out else ""
    sentences = (f"Learns from {len(gathered.theta)} runs of {folder}, made for GrainLearning{but}.", *said, "That its model is the same is taken on trust.")
    return gathered.known_runs(calibration, thinnings, [" ".join(sentences)])


def _far_away(gathered: Gathered, experiment: Experiment, thinning: Thinning) -> list[str]:
    """What is said of observables whose curves are of another size than the reference's, as in another unit."""
    found = [each[0] for each in gathered.responses if np.isfinite(each[0]).all()]
    if not found:
        return []
    sizes = np.median(np.abs(found).max(axis=1), axis=0)
    own = np.abs(thinning.kept.values).max(axis=0)
    return [
        f"The largest {name} of its runs is {size:.3g} on the median, and that of the reference {of_reference:.3g}: another unit may be meant, as by --column {name}=COLUMN:UNIT."
        for name, size, of_reference in zip(experiment.reference.names, sizes, own)
        if of_reference > 0 and not FAR_AWAY**-1 < size / of_reference < FAR_AWAY
    ]


def _single(calibration: Calibration) -> Experiment:
    """The one experiment of a calibration that can learn from foreign runs."""
    if calibration.method != POSTERIOR:
        raise InputError(
            f'filter.method is "{calibration.method}", and "{POSTERIOR}" was expected: runs of another tool teach its emulator, and carry no weight.'
        )
    if len(calibration.experiments) != 1:
        raise InputError(f"there are {len(calibration.experiments)} experiments, and a single one was expected: GrainLearning's runs are of one.")
    if calibration.known is not None:
        raise InputError("filter.runs names runs to learn from too, and those of GrainLearning alone were expected.")
    (experiment,) = calibration.experiments
    if isinstance(experiment.model, StressPathTest):
        raise InputError(
            f'model.kind is "{experiment.model.kind}", whose runs graincal makes itself, and the simulator that made GrainLearning\'s runs was expected: "command", "yade", "python" or "by-hand".'
        )
    return experiment


def _output(experiment: Experiment, columns: Mapping[str, Column] | None) -> Output:
    """What the runs' files hold, as far as it is compared."""
    names = (experiment.reference.control_name, *experiment.reference.measured)
    declared = getattr(experiment.model, "output", None) or Output({name: Column(name) for name in names})
    if unknown := sorted(set(columns or ()) - set(names)):
        raise InputError(f"--column names {unknown[0]}{did_you_mean(unknown[0], names)}, and some of {', '.join(names)} were expected.")
    return replace(declared, columns={**declared.columns, **(columns or {})})


def _theta(folder: Path, runs: Sequence[ForeignRun], calibration: Calibration, parameters: Mapping[str, str]) -> tuple[NDArray[np.float64], dict[str, float]]:
    """The runs' parameters as the calibration has them, (N, n), and those that it does not have and all runs share."""
    names = calibration.space.names
    if unknown := sorted(set(parameters) - set(names)):
        raise InputError(f"--parameter names {unknown[0]}{did_you_mean(unknown[0], names)}, and some of {', '.join(names)} were expected.")
    expressions = {name: _expression(name, parameters.get(name)) for name in names}
    needed = dict.fromkeys(each for expression in expressions.values() for each in (expression.names if isinstance(expression, Expression) else (expression,)))
    theirs = dict.fromkeys(name for run in runs for name in run.parameters)
    for run in runs:
        if missing := [name for name in needed if name not in run.parameters]:
            raise InputError(
                f"{run.path}: it has no parameter {missing[0]}{did_you_mean(missing[0], theirs)}, and holds {', '.join(run.parameters)}; --parameter NAME=EXPRESSION says what one of the calibration's is in these."
            )
    values = {name: np.array([run.parameters.get(name, np.nan) for run in runs]) for name in theirs}
    others = {name: each for name, each in values.items() if name not in needed}
    if varying := [name for name, each in others.items() if name not in calibration.space.fixed and not np.all(each == each[0])]:
        raise InputError(
            f"{folder}: its runs differ in {', '.join(varying)}, which the calibration does not have among {', '.join(names)}, and runs that differ in these alone were expected."
        )
    theta = [expression(values) if isinstance(expression, Expression) else values[expression] for expression in expressions.values()]
    return np.stack([np.broadcast_to(np.asarray(each, dtype=np.float64), (len(runs),)) for each in theta], axis=1), {
        name: float(each[0]) for name, each in others.items() if name not in calibration.space.fixed
    }


def _expression(name: str, text: str | None) -> Expression | str:
    """What a parameter is in those of the runs: an expression, or the name of one."""
    try:
        return name if text is None else Expression(text)
    except NotAnExpression as error:
        raise InputError(f'--parameter {name} is "{text}", and an expression of parameters such as log10(E) was expected: {error}.') from None


def _outside(theta: NDArray[np.float64], run: ForeignRun, calibration: Calibration) -> str:
    """Why a run's parameters are none of the calibration's, "" where they are."""
    space = calibration.space
    # As far as values that differ by less than SAME are the same.
    lowest, highest = space.moved(space.low, np.full(space.size, -SAME)), space.moved(space.high, np.full(space.size, SAME))
    for name, value, low, high, least, most in zip(space.names, theta, space.low, space.high, lowest, highest):
        if not least <= value <= most:
            return f"at {name} outside {low:g} to {high:g}"
    for name, value in space.fixed.items():
        if name in run.parameters and not np.isclose(run.parameters[name], value, rtol=SAME, atol=0):
            return f"at {name} other than {value:g}"
    return "" if space.contains(np.clip(theta, space.low, space.high))[0] else "where a constraint does not hold"


def _without_control(run: ForeignRun, output: Output, experiment: Experiment) -> str:
    """The name of the control's column, where a run's file has none; "" where it has."""
    column = output.columns[experiment.reference.control_name].column
    names = Expression(column).names if isinstance(column, str) and not of_named(run.columns, "").has(column) and _is_expression(column) else (column,)
    return "" if any(of_named(run.columns, "").has(name) for name in names) else str(column)


def _is_expression(text: str) -> bool:
    try:
        return bool(Expression(text).names)
    except NotAnExpression:
        return False


def _add(
    gathered: Gathered,
    run: ForeignRun,
    theta: NDArray[np.float64],
    experiment: Experiment,
    output: Output,
    without_control: bool,
    thinnings: Sequence[Thinning],
) -> str | None:
    """Add one run; or why it says nothing."""
    reference, columns = experiment.reference, dict(run.columns)
    if without_control:
        output = _at_reference_rows(output, reference.control_name)
        columns[reference.control_name] = reference.control
    try:
        outcome = output.taken(of_named(columns, str(run.path)), reference.control_name, reference.control)
    except Unreadable as error:
        raise InputError(f"{str(error).rstrip('.')}; --column QUANTITY=COLUMN says which column is which quantity.") from None
    if isinstance(outcome, Failure):
        return _LEFT_OUT.get(outcome.kind, outcome.kind)
    return add_run(gathered, theta, [outcome], [experiment], thinnings, [False])


def _at_reference_rows(output: Output, control: str) -> Output:
    """The output with the control as the reference has it, to which nothing that is declared of it applies."""
    strain = output.strain if not isinstance(output.strain, str) else {name: output.strain for name in output.columns if name in STRAINS}
    return replace(
        output,
        columns={**output.columns, control: Column(control)},
        zero=tuple(name for name in output.zero if name != control),
        strain={name: word for name, word in strain.items() if name != control},
    )
