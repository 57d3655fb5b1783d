"""Which runs wait to be made by hand, and at which parameters."""

from __future__ import annotations

import csv
import io
import shlex
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.asked.calibration import Calibration
from graincal.campaign.found.by_hand import by_hand, left_to_hand, waiting
from graincal.campaign.stored.log import is_running
from graincal.campaign.stored.store import Store
from graincal.data import InputError
from graincal.models.derived import with_derived
from graincal.suggestion import did_you_mean


@dataclass(frozen=True, eq=False)
class Asked:
    """Runs of one experiment that wait: the ids of their samples (N,), increasing, and the parameters as the model sees them, derived ones too, (N, K), by name; what cannot be computed is not finite."""

    experiment: str
    ids: NDArray[np.int64]
    names: tuple[str, ...]
    values: NDArray[np.float64]


def ask(folder: str | Path, experiment: str | None = None) -> list[Asked]:
    """The runs that wait in a campaign's folder: those of one experiment, or of each that is run by hand, or where none is, of all. The same until they are told.

    Raises InputError where a process runs the campaign, where nothing waits, and for an experiment that is not there.
    """
    folder = Path(folder)
    with closing(Store.open(folder)) as store:
        if is_running(folder):
            raise InputError(
                f"{folder}: a process is running this campaign, and makes what waits; `graincal status {shlex.quote(str(folder))}` says how far it is."
            )
        calibration = store.calibration
        found = [_asked(store, calibration, number) for number in _numbers(calibration, folder, experiment)]
        if not any(len(each.ids) for each in found):
            raise InputError(f"{folder}: {_nothing(store, folder, experiment)}")
        return found


def as_csv(asked: Sequence[Asked]) -> str:
    """A table of all of them, numbers with every digit; with a column for the experiment where there are several."""
    names = tuple(dict.fromkeys(name for each in asked for name in each.names))
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["id", *["experiment"] * (len(asked) > 1), *names])
    for each in asked:
        for id, row in zip(each.ids.tolist(), each.values.tolist()):
            values = dict(zip(each.names, map(_number, row)))
            writer.writerow([id, *[each.experiment] * (len(asked) > 1), *(values.get(name, "") for name in names)])
    return text.getvalue()


def as_yade_table(asked: Asked) -> str:
    """A table for yade-batch: the description of each line, `O.tags["description"]` in the script, is the id. Raises InputError for a name or a value that such a table cannot hold."""
    for name in asked.names:
        if not name.isidentifier():
            raise InputError(f'a table of YADE has names such as log_E in its first line, and "{name}" is none; --format csv takes it.')
    if not np.isfinite(asked.values).all():
        raise InputError(
            "a table of YADE has a number in each cell, and some parameters that were computed of others have none; --format csv leaves these cells empty."
        )
    lines = [["description", *asked.names], *([str(id), *map(_number, row)] for id, row in zip(asked.ids.tolist(), asked.values.tolist()))]
    return "".join(" ".join(line) + "\n" for line in lines)


def _number(value: float) -> str:
    return repr(value) if np.isfinite(value) else ""


def _numbers(calibration: Calibration, folder: Path, experiment: str | None) -> list[int]:
    names = [each.name for each in calibration.experiments]
    if experiment is None:
        return by_hand(left_to_hand(calibration))
    if experiment not in names:
        raise InputError(f'{folder}: there is no experiment "{experiment}"{did_you_mean(experiment, names)}, and one of {", ".join(names)} was expected.')
    return [names.index(experiment)]


def _asked(store: Store, calibration: Calibration, number: int) -> Asked:
    ids = waiting(store, number)
    samples = store.all_samples()
    seen = calibration.space.seen_by(number, samples.take(np.isin(samples.ids, ids)))
    experiment = calibration.experiments[number]
    derived = getattr(experiment.model, "derived", {})
    # Of a built-in test it is a function.
    printed = with_derived(seen, derived) if isinstance(derived, Mapping) else seen
    return Asked(experiment.name, printed.ids, printed.names, printed.theta)


def _nothing(store: Store, folder: Path, experiment: str | None) -> str:
    """Why no run waits."""
    if store.meta("stopped_by"):
        return f"no run waits, for the campaign is at its end, by {store.meta('stopped_by')}."
    where = "" if experiment is None else f' in "{experiment}"'
    return f"no run waits{where}; go on with the campaign by: graincal resume {shlex.quote(str(folder))}"
