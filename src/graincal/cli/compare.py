"""graincal compare."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from graincal.cli.columns import Column, Compression, Measure, Rows, Sheet, Stage, said_of_file
from graincal.cli.options import SomeWorkers, parse_workers
from graincal.cli.saying import say
from graincal.data import InputError

if TYPE_CHECKING:
    from graincal.campaign.found.comparison import Contender


def compare(
    folders: Annotated[list[Path], typer.Argument(help="The folders of two campaigns or more, on the same references.", metavar="DIR...")],
    against: Annotated[
        Path | None,
        typer.Option(
            help="A test that none of them was calibrated against, to rank them by how they predict it: a laboratory file, read as that of the experiment or by --column, or a calibration file that reads one.",
            metavar="FILE",
        ),
    ] = None,
    column: Column = None,
    strain: Measure = None,
    compression: Compression = None,
    stage: Stage = None,
    rows: Rows = None,
    sheet: Sheet = None,
    confining_pressure: Annotated[float | None, typer.Option(help="Confining pressure of that test, in Pa; that of the experiments by default.")] = None,
    experiment: Annotated[
        str | None,
        typer.Option(
            help="The experiment whose packing, settings and own values of parameters are used for that test; the first one by default.", metavar="NAME"
        ),
    ] = None,
    samples: Annotated[int, typer.Option(min=2, help="Simulations for each campaign, of parameters drawn from its posterior.")] = 30,
    workers: SomeWorkers = "all",
    seed: Annotated[int, typer.Option(help="Seed of the random draws.")] = 1,
) -> None:
    """Rank models by how they predict a test that was held out, or else by the evidence of the references."""
    from graincal.campaign.file.reading import read_before
    from graincal.campaign.found.comparison import compare as compare_campaigns
    from graincal.campaign.found.prediction import predict
    from graincal.cli.comparison import Compared, calibrated_against, driven_as, read_comparison, say_how_it_was_read
    from graincal.cli.predict import chosen_experiment, predicted_test, say_if_few, say_what_runs
    from graincal.result import Result

    at_once, asked = parse_workers(workers), said_of_file("--against", against, column, strain, compression, stage, rows, sheet)
    results = {str(folder): Result.read(folder) for folder in folders}
    if len(results) < len(folders):
        raise InputError("a campaign is named twice.")
    # Refuses what cannot be compared before anything is simulated.
    ranked = compare_campaigns(results)
    if against:
        scores, before = {}, None
        for name, result in results.items():
            chosen = chosen_experiment(result, experiment)
            # The same one of all campaigns: the errors of the test are taken to be its.
            experiment = chosen.name
            if own := result.space.per_experiment:
                say(f'{name} predicts with the {"values" if len(own) > 1 else "value"} of {", ".join(own)} in "{chosen.name}".')
            test = driven_as(against, predicted_test(chosen, None, confining_pressure))
            # Read once for all, as the file of the first campaign that says how: scores are of the same numbers.
            before = before or next((each for other in results.values() if (each := read_before(other.calibration, chosen.name))), None)
            reference = read_comparison(against, Compared.of(test, chosen), chosen, asked=asked, before=before)
            if known := calibrated_against(result, reference):
                raise InputError(f'{against}: a test that was held out was expected, and {name} was calibrated against this one ("{known}").')
            say_what_runs(result, samples, test, name)
            prediction = predict(
                result, test, reference.control, control_name=test.control, samples=samples, seed=seed, workers=at_once, experiment=chosen.name
            )
            scores[name] = prediction.against(reference)
        say_how_it_was_read(against, reference)
        ranked = compare_campaigns(results, scores)
    elif confining_pressure is not None or experiment is not None:
        option = "--experiment" if confining_pressure is None else "--confining-pressure"
        raise InputError(f"{option} is that of the test of --against, which is missing.")
    say("\n".join(_table(ranked)), prose=False)
    if against:
        say("Ranked by the log score of the test, measurement errors included: the larger, the more probable the test was under the prediction.")
        say_if_few(samples)
    else:
        say("Ranked by log evidence, which depends on the ranges of the parameters: a test that was held out (--against) tells more.")
    for doubt in _doubts(ranked):
        say(doubt)


def _table(ranked: list[Contender]) -> list[str]:
    best = max(ranked, key=lambda each: each.log_evidence)
    rows = [("campaign", "log evidence", "below the best")]
    for each in ranked:
        below = "" if each is best else f"{best.log_evidence - each.log_evidence:.2f}"
        rows.append((each.name, f"{each.log_evidence:.2f} ± {each.log_evidence_std:.2f}", below))
    widths = [max(map(len, column)) for column in zip(*rows)]
    lines = ["  ".join(f"{cell:{'>' if k else '<'}{width}}" for k, (cell, width) in enumerate(zip(row, widths))) for row in rows]
    scored = [(k, each.score) for k, each in enumerate(ranked, start=1) if each.score]
    if scored:
        lines[0] += "  log score a value  error %  states in the 90 % band"
        for k, score in scored:
            covered = ", ".join(f"{share:.0%} of {name}" for name, share in score.coverage.items())
            lines[k] += f"  {score.log_score:>17.3f}  {score.error:>7.2f}  {covered}"
    return lines


def _doubts(ranked: list[Contender]) -> list[str]:
    """What keeps evidences from telling."""
    best = max(ranked, key=lambda each: each.log_evidence)
    near = [each.name for each in ranked if each is not best and each.may_be_above(best)]
    unsettled = [each.name for each in ranked if not each.settled]
    doubts = []
    if near:
        doubts.append(
            f"By evidence {best.name} is not better than {' and '.join(near)} for all that is known: the difference is within what they may be off by."
        )
    if unsettled:
        doubts.append(f"Not settled yet, so that evidences and predictions may move: {', '.join(unsettled)}.")
    return doubts
