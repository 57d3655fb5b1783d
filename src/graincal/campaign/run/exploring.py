"""Libraries: runs that fill the ranges of parameters, for no reference, kept for calibrations of the same models to learn from."""

from __future__ import annotations

import json
from collections.abc import Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graincal.campaign.asked.calibration import POSTERIOR, Calibration
from graincal.campaign.asked.experiment import Experiment, no_reference
from graincal.campaign.asked.points import checked_points
from graincal.campaign.run.breaking_off import said_how_to_go_on
from graincal.campaign.run.campaign import Campaign
from graincal.campaign.run.claiming import claim
from graincal.campaign.run.elsewhere import check_place
from graincal.campaign.run.steps import ProgressOption, listening
from graincal.campaign.stored.asked import LIBRARY, POINTS
from graincal.campaign.stored.code import look_at_code, refuse_strangers_code
from graincal.campaign.stored.database import NAME
from graincal.campaign.stored.listener import Listener
from graincal.campaign.stored.log import NAME as LOG
from graincal.campaign.stored.log import Log
from graincal.campaign.stored.store import Store, holds_campaign
from graincal.data import InputError, ParameterSpace, Samples
from graincal.inference import PosteriorFilter, Stop
from graincal.inference.sampling.defensive import DefensiveMixture
from graincal.models import Model


def explore(
    model: Model | Sequence[Experiment],
    space: ParameterSpace,
    to: float | ArrayLike | None = None,
    *,
    folder: str | Path,
    observables: Sequence[str] = ("stress_ratio", "volumetric_strain"),
    runs: int | None = None,
    points: ArrayLike | None = None,
    seed: int = 1,
    workers: int | Literal["all"] = "all",
    listeners: Sequence[Listener] = (),
    progress: ProgressOption = None,
) -> Path:
    """Fill the ranges of parameters with runs, for no reference, and keep them in a folder; its path. The same again goes on with what was broken off.

    >>> explore(test, ParameterSpace.paper(), to=0.25, folder="library", runs=500)               # doctest: +SKIP
    >>> calibrate(test, reference, ParameterSpace.paper(), runs=["library"])                     # doctest: +SKIP

    to: the last control value that runs come to, or all of them (T,) for a function that knows no others. model: may be a list of experiments, whose references then say that. observables: what a model must
    return. runs: how many; by default as many as a calibration fills the ranges with first. points (N, n): parameters to run instead, in the order of the space, within its ranges. progress: as of `calibrate`. Raises InputError as `calibrate`, and for a folder that holds something else.
    """
    if isinstance(model, Sequence):
        experiments = list(model)
        if to is not None or not all(isinstance(each, Experiment) for each in experiments):
            raise InputError(
                "explore takes one model with to, the last control value, or a list of Experiment(name, model, reference), whose references say how far runs go."
            )
    elif to is None:
        raise InputError("explore needs to know how far runs go: to = the last control value was expected.")
    else:
        experiments = [Experiment("experiment", model, no_reference(model, to, observables, getattr(model, "control", None)))]
    with listening(progress) as shown:
        return fill(Calibration(space, experiments, seed=seed, workers=workers), folder, runs, (*listeners, *shown), points)


def fill(calibration: Calibration, folder: str | Path, runs: int | None = None, listeners: Sequence[Listener] = (), points: ArrayLike | None = None) -> Path:
    """Make a library of runs for calibrations like this one: that fill its ranges, or at points of somebody's own (N, n)."""
    folder = Path(folder)
    calibration = for_library(calibration).check()
    calibration.check_names()
    check_place(calibration.place)
    if points is not None and runs is not None:
        raise InputError("explore: runs and points are both given, and one of them was expected.")
    if points is not None:
        points = checked_points(points, calibration.space)
        count = len(points)
    else:
        count = _filling(calibration) if runs is None else runs
        if isinstance(count, bool) or not isinstance(count, (int, np.integer)) or count < 2:
            raise InputError(f"explore: runs must be a whole number above 1, not {runs!r}.")
    if is_library(folder):
        with closing(Store.open(folder)) as store:
            if not store.keeps(calibration) or store.meta(LIBRARY) != str(count) or not _same_points(points_of(store), points):
                raise InputError(f"{folder}: this folder holds another library, and a new one needs a folder of its own.")
        return go_on_filling(folder, [each.model for each in calibration.experiments], calibration.workers, listeners)
    with closing(claim(folder, lambda _: _refuse_anything(folder))) as log:
        return _fill(calibration, Store.create(calibration, folder, library=count, points=points), (*listeners, log))


def for_library(calibration: Calibration) -> Calibration:
    """A calibration as a library of its runs is asked for: without a method, and with no end but its runs."""
    return replace(calibration, method=POSTERIOR, filter_options={}, stop=Stop(), first_look=None, look=None, known=None)


def _refuse_anything(folder: Path) -> None:
    """Raise InputError where something is in the folder already; a log is what a beginning that was cut short leaves."""
    if folder.exists() and (not folder.is_dir() or holds_campaign(folder) or any(each.name not in (LOG, NAME) for each in folder.iterdir())):
        raise InputError(f"{folder}: this is there already, and a library needs a folder of its own.")


def go_on_filling(
    folder: Path,
    models: Sequence[Model] | None = None,
    workers: int | Literal["all"] | None = None,
    listeners: Sequence[Listener] = (),
    *,
    trust: bool = False,
    by_hand: bool = False,
) -> Path:
    """Make the runs of a library that are not there yet. trust, by_hand: as in `resume`."""
    with closing(Log(folder)) as log:
        store = Store.open(folder)
        if not trust and not by_hand and models is None:
            refuse_strangers_code(store)
        calibration = replace(store.calibration, by_hand=by_hand)
        if models is not None:
            calibration = replace(calibration, experiments=[replace(each, model=model) for each, model in zip(calibration.experiments, models)])
        if workers is not None:
            calibration = replace(calibration, workers=workers)
        check_place(calibration.place)
        return _fill(calibration.check(), store, (*listeners, log))


def is_library(folder: Path) -> bool:
    """Whether a folder holds a library, and no campaign with a result."""
    if not holds_campaign(folder):
        return False
    with closing(Store.open(folder)) as store:
        return store.is_library


def _filling(calibration: Calibration) -> int:
    """How many runs fill its ranges."""
    filter = calibration.blank_filter()
    assert isinstance(filter, PosteriorFilter), "`for_library` sets the method"
    return filter.first_batch


def _fill(calibration: Calibration, store: Store, listeners: Sequence[Listener]) -> Path:
    with said_how_to_go_on(store.folder):
        return _filled(calibration, store, listeners)


def _filled(calibration: Calibration, store: Store, listeners: Sequence[Listener]) -> Path:
    asked = store.meta(LIBRARY)
    assert store.folder is not None and asked is not None, "a library lies in a folder, and says how many runs it is to hold"
    count, space = int(asked), calibration.space
    for listener in listeners:
        listener.begins(calibration)
    if changed := look_at_code(store, calibration):
        for listener in listeners:
            listener.remark(changed)
    points = points_of(store)
    theta = DefensiveMixture(space).draw(count, np.random.default_rng([calibration.seed, 0])) if points is None else points
    samples = Samples(np.arange(count, dtype=np.int64), theta, space.names)
    Campaign(calibration, store, listeners).fill(samples)
    counts = store.counts()
    store.stop("runs", f"All {count} runs have been made, and {counts['failed']} of them failed.")
    return store.folder


def points_of(store: Store) -> NDArray[np.float64] | None:
    """The parameters that somebody chose for a library's runs, (N, n); None where they fill the ranges."""
    text = store.meta(POINTS)
    return None if text is None else np.array(json.loads(text), dtype=np.float64)


def _same_points(one: NDArray[np.float64] | None, other: NDArray[np.float64] | None) -> bool:
    return one is other if one is None or other is None else np.array_equal(one, other)
