"""graincal predict."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from graincal.cli.columns import Column, Compression, Measure, Rows, Sheet, Stage, said_of_file
from graincal.cli.options import Folder, Quiet, SomeWorkers, parse_workers
from graincal.cli.saying import say
from graincal.data import InputError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from graincal.campaign import Experiment
    from graincal.campaign.found.prediction import Prediction
    from graincal.data import Reference
    from graincal.laboratory.another_file import Before
    from graincal.models import StressPathTest
    from graincal.result import Result


FEW = 20
"""Simulations below which an interval of 90 % has less than one of them beyond either end."""


def predict(
    folder: Folder,
    confining_pressure: Annotated[
        float | None, typer.Option(help="Confining pressure of the predicted test, in Pa; that of the experiment by default.")
    ] = None,
    path: Annotated[
        str | None,
        typer.Option(
            help="The predicted stress path: triaxial, undrained, oedometric, constant-mean-stress; that of the experiment by default.", metavar="NAME"
        ),
    ] = None,
    experiment: Annotated[
        str | None, typer.Option(help="The experiment whose packing, settings and own values of parameters are used; the first one by default.", metavar="NAME")
    ] = None,
    against: Annotated[
        Path | None,
        typer.Option(
            help="A test to compare with, which sets the axial strains: a laboratory file, read as that of the experiment or by --column, or a calibration file that reads one.",
            metavar="FILE",
        ),
    ] = None,
    column: Column = None,
    strain: Measure = None,
    compression: Compression = None,
    stage: Stage = None,
    rows: Rows = None,
    sheet: Sheet = None,
    axial_strain: Annotated[float | None, typer.Option(help="The last axial strain; without it and --against, those of the experiment.")] = None,
    increment: Annotated[float, typer.Option(help="The axial strain between rows.")] = 0.004,
    samples: Annotated[int, typer.Option(min=2, help="Simulations, each of parameters drawn from the posterior.")] = 30,
    workers: SomeWorkers = "all",
    seed: Annotated[int, typer.Option(help="Seed of the random draws.")] = 1,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            help="Means and 90 % intervals of observables and quantities of interest, as CSV: NAME_mean, NAME_5% and NAME_95% of the responses, and NAME_measured_5% and NAME_measured_95% with measurement errors; nothing is overwritten.",
            metavar="FILE",
        ),
    ] = None,
    plot: Annotated[Path | None, typer.Option(help="Draw the bands to this file (.png, .pdf, .svg); nothing is overwritten.", metavar="FILE")] = None,
    quiet: Quiet = False,
) -> None:
    """Predict another test by the posterior of a campaign: at another confining pressure, or along another stress path."""
    from graincal.campaign.file.reading import read_before
    from graincal.campaign.found.prediction import predict as predict_test
    from graincal.cli.comparison import driven_as
    from graincal.cli.figures import draw_prediction
    from graincal.cli.outputs import check_outputs
    from graincal.result import Result

    at_once = parse_workers(workers)
    check_outputs(output, plot)
    asked = said_of_file("--against", against, column, strain, compression, stage, rows, sheet)
    result = Result.read(folder)
    chosen = chosen_experiment(result, experiment)
    test = predicted_test(chosen, path, confining_pressure)
    test = driven_as(against, test) if against else test
    reference = _reference(against, test, chosen, asked, read_before(result.calibration, chosen.name)) if against else None
    at = _control_values(chosen, test, reference, axial_strain, increment)
    if not quiet:
        say_what_runs(result, samples, test)
    prediction = predict_test(result, test, at, control_name=test.control, samples=samples, seed=seed, workers=at_once, experiment=chosen.name)
    if reference is not None:
        prediction = prediction.measured_as(reference)
    if output:
        _write(prediction, output)
    shown = (
        tuple(reference.measured)
        if reference is not None
        else tuple(dict.fromkeys(name for name in ("stress_ratio", "volumetric_strain", *(p.column for p in test.shown)) if name in prediction.values))
    )
    abscissa = test.abscissa(prediction.control)
    shown = tuple(name for name in shown if name != abscissa.name)
    if plot:
        draw_prediction(prediction, shown, reference, plot, abscissa)
    if quiet:
        return
    _say(result, chosen, prediction, test, shown, reference)
    for target in (output, plot):
        if target is not None:
            say(f"Written to {target}.")


def _control_values(chosen: Experiment, test: StressPathTest, reference: Reference | None, axial_strain: float | None, increment: float) -> NDArray[np.float64]:
    """Where the test is predicted (T,): at the rows of what it is compared with, up to an axial strain, or at the experiment's own rows."""
    from graincal.cli.strains import axial_strains

    if reference is not None and axial_strain is not None:
        raise InputError("--against gives the axial strains, so --axial-strain cannot stand beside it.")
    if reference is not None:
        return reference.control
    if axial_strain is not None:
        return axial_strains(axial_strain, increment)
    if chosen.reference.control_name == test.control:
        return _same_rows(chosen, test)
    raise InputError(f"--axial-strain or --against is needed: the experiment's states are of {chosen.reference.control_name}.")


def _say(result: Result, chosen: Experiment, prediction: Prediction, test: StressPathTest, shown: tuple[str, ...], reference: Reference | None) -> None:
    """What was predicted, and what to bear in mind of it."""
    from graincal.cli.comparison import calibrated_against

    if reference is not None and (known := calibrated_against(result, reference)):
        say(f'The campaign was calibrated against this test ("{known}"): what follows says how it fits, not how it predicts.')
    if own := result.space.per_experiment:
        say(f'Predicts with the {"values" if len(own) > 1 else "value"} of {", ".join(own)} in "{chosen.name}".')
    say("\n".join(_describe(prediction, test, shown, reference)))
    say_if_few(len(prediction.theta) + len(prediction.failures))
    if result.has_posterior and not result.settled:
        say("The posterior has not settled: what it predicts may yet move, too.")


def say_what_runs(result: Result, samples: int, test: StressPathTest, name: str = "") -> None:
    """What a command will be busy with, in the minute before it has anything to show."""
    opening = f"{name}: the" if name else "The"
    say(f"{opening} posterior of {result.evaluations} evaluations, and then {samples} simulations of {_named(test)} ...", err=True)


def _named(test: StressPathTest) -> str:
    at = "" if test.confining_pressure is None else f" at {test.confining_pressure / 1e3:g} kPa"
    return f"{test.name_with_article}{at}"


def say_if_few(samples: int) -> None:
    """A remark where an interval of 90 % is no such thing."""
    if samples < FEW:
        say(f"Of {samples} simulations the interval is little more than the range; --samples {FEW} or more make it one of 90 %.")


def chosen_experiment(result: Result, name: str | None) -> Experiment:
    """The experiment of that name, or the first one, with a built-in test."""
    from graincal.models import StressPathTest

    built_in = [each for each in result.experiments if isinstance(each.model, StressPathTest)]
    if not built_in:
        raise InputError(
            "the campaign has no experiment with a built-in test, and models of one's own are predicted with from Python: graincal.predict(result, model, at)."
        )
    if name is None:
        return built_in[0]
    found = [each for each in built_in if each.name == name]
    if not found:
        raise InputError(f'--experiment: there is no "{name}" with a built-in test; there are {", ".join(each.name for each in built_in)}.')
    return found[0]


def predicted_test(experiment: Experiment, path: str | None, confining_pressure: float | None) -> StressPathTest:
    """The experiment's test along another path, or at another pressure, its packing and settings the same."""
    from dataclasses import replace

    from graincal.models import TESTS
    from graincal.models.another_test import another_test
    from graincal.suggestion import did_you_mean

    test = _test_of(experiment)
    changes: dict[str, Any] = {} if confining_pressure is None else {"confining_pressure": confining_pressure}
    if path is None or path == test.kind:
        _refuse_other_way(experiment.name, test, confining_pressure)
        return replace(test, **changes)
    known = [kind for kind, other in TESTS.items() if "axial_strain" in other.controls]
    if path not in known:
        raise InputError(f"--path must be one of {', '.join(known)}, not {path!r}{did_you_mean(path, known)}.")
    return another_test(test, path, **changes)


def _test_of(experiment: Experiment) -> StressPathTest:
    from graincal.models import StressPathTest

    assert isinstance(experiment.model, StressPathTest), "`chosen_experiment` gives one with a built-in test"
    return experiment.model


def _refuse_other_way(experiment: str, test: StressPathTest, confining_pressure: float | None) -> None:
    """Refuse a pressure from which a path would go the other way to its first turn."""
    from graincal.models.compression import CompressionTest
    from graincal.positions import first_way

    before, turns = test.confining_pressure, test.turns if isinstance(test, CompressionTest) else ()
    if confining_pressure is None or not turns or (way := first_way(before, turns)) * (turns[0] - confining_pressure) > 0:
        return
    beyond = "below" if way > 0 else "above"
    raise InputError(
        f'--confining-pressure: {beyond} {turns[0]:g} Pa was expected, to which the path of "{experiment}" goes first, before it turns around, and not {confining_pressure:g} Pa.'
    )


def _same_rows(experiment: Experiment, test: StressPathTest) -> NDArray[np.float64]:
    """The experiment's rows as control values of a test at another pressure: of a path along positions, whose turns stay, those at the same stresses."""
    import numpy as np

    from graincal.models.compression import CompressionTest
    from graincal.positions import POSITION, first_way

    control, before = experiment.reference.control, _test_of(experiment).confining_pressure
    if test.control != POSITION or not isinstance(test, CompressionTest) or test.confining_pressure == before:
        return control
    moved = control + first_way(before, test.turns) * np.log(before / test.confining_pressure)
    # The path begins where it now does.
    rows = moved[moved >= 0]
    if not rows.size:
        raise InputError(f'--confining-pressure: no row of "{experiment.name}" lies on the path from {test.confining_pressure:g} Pa.')
    return rows


def _reference(against: Path, test: StressPathTest, experiment: Experiment, asked: dict[str, Any], before: Before | None) -> Reference:
    from graincal.cli.comparison import Compared, read_comparison, say_how_it_was_read

    reference = read_comparison(against, Compared.of(test, experiment), experiment, asked=asked, before=before)
    say_how_it_was_read(against, reference)
    return reference


def _write(prediction: Prediction, path: Path) -> None:
    import numpy as np

    from graincal.files import unwritable

    columns = {prediction.control_name: prediction.control}
    for name in prediction.values:
        low, high = prediction.interval(name)
        columns |= {f"{name}_mean": prediction.mean(name), f"{name}_5%": low, f"{name}_95%": high}
        if name in prediction.with_errors:
            low, high = prediction.measured_interval(name)
            columns |= {f"{name}_measured_5%": low, f"{name}_measured_95%": high}
    try:
        np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="", fmt="%.9g")
    except OSError as error:
        raise InputError(unwritable(path, error)) from None


def _describe(prediction: Prediction, test: StressPathTest, shown: tuple[str, ...], reference: Reference | None) -> list[str]:
    from graincal.inference import curve_error
    from graincal.notation.markup import to_plain
    from graincal.report.prediction import of_packings

    lines = [
        f"Predicted {_named(test)} from {len(prediction.theta)} samples of the posterior"
        + (f"; {len(prediction.failures)} more failed ({prediction.failures[0].kind})" if prediction.failures else "")
        + ". Means and 90 % bands at the last state:"
    ]
    extra = tuple(name for name in ("coordination_number", "a_c") if name in prediction.values and name not in shown)
    lines += [_at_the_end(prediction, name) for name in (*shown, *extra)]
    lines.append(to_plain(f"{prediction.band_in_words((*shown, *extra))}{of_packings(test)}"))
    if reference is not None:
        found = prediction.against(reference)
        covered = ", ".join(f"{100 * share:.0f} % of {name}" for name, share in found.coverage.items())
        lines.append(
            f"Against the test: the {100 * found.probability:.0f} % band, measurement errors included, holds {covered}; log score {found.log_score:.2f} a value; "
            f"the error ε of the mean curve is {found.error:.2f} % of the test."
        )
        lines += [
            f"Not fitted: the mean's error in {name} is {curve_error(prediction.mean(name), values):.2f} %." for name, values in reference.recorded.items()
        ]
    return lines


def _at_the_end(prediction: Prediction, name: str) -> str:
    import numpy as np

    from graincal.notation import numbers
    from graincal.notation.markup import to_plain
    from graincal.notation.quantities import quantity

    known = quantity(name)
    mean, low, high = (float(known.scale * curve[-1]) for curve in (prediction.mean(name), *prediction.measured_interval(name)))
    shown = (numbers.within(mean, (low, high)), numbers.between(low, high)) if np.isfinite([mean, low, high]).all() else (numbers.value(np.nan), "")
    at, ends = map(to_plain, shown)
    return f"  {to_plain(known.axis):34} {at:>9}   {ends}".rstrip()
