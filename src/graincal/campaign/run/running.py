"""Beginning a campaign, and going on with one: from Python, and beneath the command line."""

from __future__ import annotations

import json
import shlex
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

from graincal.campaign.asked.calibration import NO_SPACE, POSTERIOR, Calibration
from graincal.campaign.asked.doubt import Doubt
from graincal.campaign.asked.experiment import Experiment
from graincal.campaign.file.doubts import doubts, thinning_notes
from graincal.campaign.found.by_hand import by_hand
from graincal.campaign.found.first_look import first_look_of
from graincal.campaign.found.runs import known_runs
from graincal.campaign.run.breaking_off import said_how_to_go_on
from graincal.campaign.run.campaign import CURVES, Campaign
from graincal.campaign.run.claiming import claim
from graincal.campaign.run.continuing import changed_criteria, changed_keys, changed_since, edited_run, refuse_another_past, with_criteria
from graincal.campaign.run.elsewhere import check_place
from graincal.campaign.run.evaluations import FILES
from graincal.campaign.run.steps import ProgressOption, listening
from graincal.campaign.run.waiting import RunsWait
from graincal.campaign.stored.asked import SPENT
from graincal.campaign.stored.code import look_at_code, refuse_strangers_code
from graincal.campaign.stored.listener import Listener
from graincal.campaign.stored.log import Lines, Log, is_running
from graincal.campaign.stored.provenance import differences, provenance
from graincal.campaign.stored.store import LOOK, Store, holds_campaign
from graincal.campaign.stored.trouble import FolderError
from graincal.data import InputError, ParameterSpace, Reference
from graincal.inference import DEFAULT_METHOD, Stop
from graincal.models import Model
from graincal.result import Result

CALIBRATION_FILE = "campaign.toml"
REPORT = "report.html"
HERE = "workers of this machine"


def calibrate(
    model: Model | Sequence[Experiment],
    reference: Reference | None = None,
    space: ParameterSpace | None = None,
    *,
    method: str = DEFAULT_METHOD,
    seed: int = 1,
    max_evaluations: int | None = None,
    workers: int | Literal["all"] = "all",
    folder: str | Path | None = None,
    stop: Stop = Stop(),
    truth: Mapping[str, float] | None = None,
    first_look: Result | str | Path | None = None,
    runs: Sequence[str | Path] = (),
    expected_seconds: float | None = None,
    progress: ProgressOption = None,
    **filter_options: Any,
) -> Result:
    """Calibrate a model against a reference, or several experiments at once.

    >>> result = calibrate(model, reference, space, seed=1)                                      # doctest: +SKIP
    >>> result = calibrate([Experiment("0.5 MPa", test, reference), ...], space=space)           # doctest: +SKIP

    space: the unknowns; theta is in its order. Those in its `per_experiment` have a value in each experiment: the result's space has a column for each.
    method: "posterior", whose spreads follow from the measurement errors, "iterative-bayesian" (Hartmann, Cheng, Thornton 2022), or "sequential-monte-carlo".
    max_evaluations: the same as in `stop`. workers: evaluations at once; the result does not depend on it. folder: where the campaign is kept; it
    must hold none yet, and `resume` goes on with it. Without, it is kept in memory. truth: the known values of a synthetic reference, {parameter: value},
    for the report to show; with a value in each experiment, by `strength` for all or `strength (0.5 MPa)` for one. filter_options: first_batch, batch,
    ahead, early_stop, thin, correlation_length, discrepancy (see `PosteriorFilter`), packing_scatter (whether what packings differ by is found out); by the other methods alpha, effective_sample_size, scale, covariance, thin
    (see `IterativeBayesianFilter`). first_look: with "posterior", a campaign of cheaper models on the same experiments, or its folder.
    runs: with "posterior", the folders of campaigns and of libraries (`explore`) on the same models, to learn from (`graincal.campaign.found.runs.known_runs`).
    expected_seconds: what one evaluation takes on one core, where the model is not a built-in test: short ones fill the ranges by hundreds first.
    progress: True for a live table in a terminal or a notebook, or a function that is given a `Step` after each evaluation.
    Raises InputError for what cannot be calibrated, FolderError for a folder that cannot be written, RunsWait where runs are to be made by hand (`ByHandModel`).
    """
    if isinstance(model, Sequence):
        experiments = list(model)
        if reference is not None or not all(isinstance(experiment, Experiment) for experiment in experiments):
            raise InputError("calibrate takes one model with its reference, or a list of Experiment(name, model, reference).")
    elif reference is None:
        raise InputError("calibrate needs the reference that the model is compared with.")
    else:
        experiments = [Experiment("experiment", model, reference)]
    if space is None:
        raise InputError(NO_SPACE)
    if max_evaluations is not None:
        stop = replace(stop, max_evaluations=max_evaluations)
    calibration = Calibration(space, experiments, method, filter_options, stop, seed, workers, truth=truth or {}, expected_seconds=expected_seconds)
    if first_look is not None:
        look = first_look if isinstance(first_look, Result) else Result.read(first_look)
        calibration = replace(calibration, first_look=first_look_of(look, calibration, "first_look"))
    if runs:
        calibration = replace(calibration, known=known_runs(runs, calibration))
    with listening(progress) as listeners:
        return begin(calibration, folder, listeners)


def begin(calibration: Calibration, folder: str | Path | None = None, listeners: Sequence[Listener] = (), accepted: Sequence[Doubt] = ()) -> Result:
    """Run a new campaign, in memory or in a folder that holds none. accepted: problems in spite of which it is run, which are kept and reported."""
    calibration.check().check_names()
    check_place(calibration.place)
    if folder is None and by_hand(calibration):
        raise InputError("runs that are made by hand are told to a campaign that is kept: folder = a folder of its own was expected.")
    if folder is None:
        store, listeners = Store.create(calibration, accepted=accepted), (*listeners, Lines())
        return Campaign(_with_first_look(calibration, store, listeners), store, listeners).run()
    folder = Path(folder)
    with closing(claim(folder, lambda locked: _refuse_campaign(folder, calibration, locked=locked))) as log:
        return _run(calibration, Store.create(calibration, folder, accepted=accepted), log, listeners)


def lay_out(calibration: Calibration, folder: str | Path, accepted: Sequence[Doubt] = ()) -> None:
    """Keep a new campaign in a folder that holds none, and run nothing of it: `resume` does. accepted: as of `begin`."""
    folder = Path(folder)
    calibration.check().check_names()
    with closing(claim(folder, lambda locked: _refuse_campaign(folder, calibration, locked=locked))) as log:
        Store.create(calibration, folder, accepted=accepted).close()
        _keep_source(folder / CALIBRATION_FILE, calibration.source)
        log.write("Is stored, and runs nothing yet.")


def begin_or_resume(
    folder: str | Path,
    asked: Callable[[], Calibration],
    runs: Sequence[str | Path] = (),
    listeners: Sequence[Listener] = (),
    workers: int | Literal["all"] | None = None,
) -> Result:
    """A campaign to its end: begun where its folder holds none, and gone on with where it does.

    asked: called where it is begun. runs: folders of campaigns and libraries that it then learns from (`known_runs`). workers: of one that is gone on with, by default those of its beginning.
    Whether a folder's campaign is the one that is asked for is not compared. Raises InputError as `begin` and `resume`.
    """
    if holds_campaign(Path(folder)):
        return resume(folder, workers=workers, listeners=listeners)
    calibration = asked()
    return begin(replace(calibration, known=known_runs(runs, calibration)) if runs else calibration, folder, listeners)


def resume(
    folder: str | Path,
    model: Model | Sequence[Model] | None = None,
    *,
    workers: int | Literal["all"] | None = None,
    listeners: Sequence[Listener] = (),
    trust: bool = False,
    by_hand: bool = False,
    progress: ProgressOption = None,
    **criteria: Any,
) -> Result:
    """Go on with the campaign of a folder, to the result that it would have had if nothing had stopped it.

    model: needed where a function was handed over in Python; the models in the order of the experiments if there are several.
    workers: by default those of [run] in the folder's campaign.toml, where that was edited, or those of the beginning. criteria: fields of `Stop` that replace those of the beginning, such as max_evaluations=200, or s=False by the paper's method.
    A campaign that is at its end then goes on, bit for bit to what it would have given by these criteria from the start; they are kept.
    trust: go on with a campaign of another user, whose named functions are this user's to run then. by_hand: run nothing here: somebody makes all runs and tells what they gave (`graincal.campaign.run.telling`).
    progress: as of `calibrate`.
    Raises InputError where the folder holds no campaign, or one of another user that runs named functions, or one that another process is running; and for criteria by which it would have ended
    before it did, or would not go on. Raises RunsWait where it cannot go on before runs are made by hand.
    """
    with listening(progress) as shown:
        return _resume(Path(folder), model, workers, (*listeners, *shown), criteria, trust=trust, by_hand=by_hand)


def _resume(
    folder: Path,
    model: Model | Sequence[Model] | None,
    workers: int | Literal["all"] | None,
    listeners: Sequence[Listener],
    criteria: Mapping[str, Any],
    *,
    trust: bool,
    by_hand: bool,
) -> Result:
    store = Store.open(folder)
    run = edited_run(folder / CALIBRATION_FILE, store)
    if not trust and not by_hand and model is None:
        refuse_strangers_code(store, run.get("place"))
    if store.is_library:
        raise InputError(f"{folder}: this is a library of runs for no reference; explore, with the same arguments, goes on with it.")
    calibration = replace(with_criteria(store.calibration, criteria), by_hand=by_hand)
    if model is not None:
        calibration = replace(calibration, experiments=_with_models(calibration.experiments, model))
    if workers is None:
        workers = run.get("workers")
    if workers is not None:
        calibration = replace(calibration, workers=workers)
    # What somebody makes by hand runs nowhere.
    calibration = replace(calibration, place=None if by_hand else run.get("place", calibration.place))
    changes = changed_criteria(store.calibration.stop, calibration.stop)
    if edited := changed_keys(folder / CALIBRATION_FILE, store):
        for listener in listeners:
            listener.remark(f"{folder / CALIBRATION_FILE} was changed in {edited}; what the store holds is used, and resume's options change when it stops.")
    if since := changed_since(store):
        for listener in listeners:
            listener.remark(
                f"{since[0]} was changed in {since[1]} since this campaign was begun by it; what the store holds is used, and a new campaign would take the file as it is."
            )
    if store.meta("stopped_by") and not changes:
        return Result(store, calibration)
    calibration.check()
    check_place(calibration.place)
    with closing(Log(folder)) as log:
        if calibration.workers != store.calibration.workers:
            log.write(f"Goes on with workers = {json.dumps(calibration.workers)}, where it was begun with {json.dumps(store.calibration.workers)}.")
        if not by_hand and calibration.place != store.calibration.place:
            log.write(f"Goes on by {calibration.place or HERE}, where it was begun by {store.calibration.place or HERE}.")
        if "expected_seconds" in run:
            log.write("run.expected_seconds was changed: it says how a campaign begins, and changes nothing of one that was begun.")
        if changes:
            kept = refuse_another_past(store, calibration)
            said = ", ".join(f"{name} = {json.dumps(value)}" for name, value in changes.items())
            if not edited and not run:
                # First: a copy that is missing is written again, and one that is older than the store would be taken for edited.
                _discard_source(folder / CALIBRATION_FILE)
            store.go_on(calibration.stop, f"Continued with {said}, instead of what stands below.", kept)
            calibration = replace(calibration, source=store.meta("source") or "")
            log.write(f"Goes on with {said}.")
        return _run(calibration, store, log, listeners)


def _run(calibration: Calibration, store: Store, log: Log, listeners: Sequence[Listener]) -> Result:
    now = provenance()
    log.write(
        "Runs with "
        + ", ".join(f"{name} {value}" for name, value in now.items())
        + f", {calibration.number_of_workers} workers{'' if calibration.place is None else f', by {calibration.place}'}."
    )
    if store.folder is not None:
        _keep_source(store.folder / CALIBRATION_FILE, calibration.source)
    listeners = (*listeners, log)
    sources = calibration.known.sources if calibration.known else ()
    for remark in (*sources, *(f"{doubt.level.capitalize()}: {doubt}" for doubt in [*thinning_notes(calibration), *doubts(calibration)])):
        for listener in listeners:
            listener.remark(remark)
    if others := differences(store.provenance, now):
        for listener in listeners:
            listener.remark(f"This campaign goes on with {others}; its figures may differ in the last digits from those of an uninterrupted run.")
    if changed := look_at_code(store, calibration):
        for listener in listeners:
            listener.remark(changed)
    try:
        with said_how_to_go_on(store.folder):
            return Campaign(_with_first_look(calibration, store, listeners), store, listeners).run()
    except RunsWait as waits:
        log.write(str(waits).partition("\n")[0])
        raise
    except BaseException as error:
        with suppress(FolderError):
            log.write(f"Breaks off: {str(error) or type(error).__name__}")
        raise


def _with_first_look(calibration: Calibration, store: Store, listeners: Sequence[Listener]) -> Calibration:
    """The calibration with what its look brings, which is run to its end first if it was not: a campaign in a folder of its own within this one's."""
    if calibration.look is None or calibration.first_look is not None:
        return calibration
    look = replace(calibration.look, workers=calibration.workers, place=calibration.place)
    # Its own log says what happens in it.
    others = [listener for listener in listeners if not isinstance(listener, Lines)]
    for listener in listeners:
        listener.remark("Takes a first look by cheaper models.")
        listener.looks_first()
    folder, began = store.folder / LOOK if store.folder else None, time.monotonic()
    if folder and holds_campaign(folder):
        result = resume(folder, workers=calibration.workers, listeners=others, trust=True)
    else:
        result = begin(look, folder, others)
    found = first_look_of(result, calibration, str(folder or "first_look"))
    store.keep_first_look(found)
    store.spend(float(store.meta(SPENT) or 0) + time.monotonic() - began)
    for listener in listeners:
        listener.remark(f"Begins with {len(found.theta)} evaluations of the first look.")
    return replace(calibration, first_look=found)


def _refuse_campaign(folder: Path, calibration: Calibration, *, locked: bool = False) -> None:
    """Raise InputError where a folder holds a campaign, a library, or files that belong to one. locked: whether this process holds the folder already."""
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder}: this is a file, and a folder was expected.")
    if holds_campaign(folder):
        with closing(Store.open(folder)) as store:
            if store.is_library:
                raise InputError(
                    f"{folder}: this folder holds a library of runs, and a campaign needs a folder of its own; the calibration learns from it by runs under [filter] or by --runs."
                )
            if not locked and is_running(folder):
                raise InputError(
                    f"{folder}: another process is running a campaign in this folder; `graincal status {shlex.quote(str(folder))}` says how far it is."
                )
            if store.keeps(_decided_as(calibration, store)):
                raise InputError(f"{folder}: this calibration was begun here before, go on with it by: graincal resume {shlex.quote(str(folder))}")
        raise InputError(f"{folder}: this folder holds another campaign, and a new one needs a folder of its own.")
    for name in (CALIBRATION_FILE, REPORT, CURVES, FILES):
        if (folder / name).exists():
            raise InputError(f"{folder}: {name} is there already and belongs to no campaign, and a new one needs a folder of its own.")


def _decided_as(calibration: Calibration, store: Store) -> Calibration:
    """The calibration with as many runs that fill the ranges as were decided when the store's was begun, where the file does not say how many: what a run takes is no part of what is asked."""
    decided = store.description["filter"].get("first_batch")
    if decided is None or "first_batch" in calibration.filter_options or calibration.method != POSTERIOR:
        return calibration
    return replace(calibration, filter_options={**calibration.filter_options, "first_batch": decided})


def _keep_source(path: Path, source: str) -> None:
    """A copy of the calibration file beside the store, for people; the store itself holds all that is needed."""
    try:
        if source and not path.exists():
            path.write_text(source, encoding="utf-8")
    except OSError as error:
        raise FolderError.of(path, error) from error


def _discard_source(path: Path) -> None:
    """Make way for a newer copy."""
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        raise FolderError.of(path, error) from error


def _with_models(experiments: Sequence[Experiment], model: Model | Sequence[Model]) -> list[Experiment]:
    models = list(model) if isinstance(model, Sequence) else [model]
    if len(models) != len(experiments):
        raise InputError(f"resume needs a model for each of the {len(experiments)} experiments, and {len(models)} were given.")
    return [replace(experiment, model=model) for experiment, model in zip(experiments, models)]
