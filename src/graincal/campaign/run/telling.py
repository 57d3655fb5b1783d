"""Taking what runs gave that somebody made by hand."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from graincal.campaign.asked.calibration import Calibration
from graincal.campaign.asked.file_names import file_name
from graincal.campaign.found.by_hand import by_hand, left_to_hand, waiting
from graincal.campaign.run.told_files import FAILED, ToldFile, files_of_experiment, holds_runs, read_outcome, told_in
from graincal.campaign.stored.listener import Listener
from graincal.campaign.stored.log import Log
from graincal.campaign.stored.store import Store
from graincal.data import Failure, InputError, Response


@dataclass
class Told:
    """What became of the files of a folder. kept: how many outcomes are new; failures: which of them are failures, a sentence each. known: how many were told before. not_needed: files of samples that failed, or
    were stopped, in another experiment. refused: what cannot be taken, a sentence each. left: how many runs wait still; whole: whether the campaign can go on; by_hand: whether it then goes on without any model."""

    kept: int = 0
    failures: list[str] = field(default_factory=list)
    known: int = 0
    not_needed: list[str] = field(default_factory=list)
    refused: list[str] = field(default_factory=list)
    left: int = 0
    whole: bool = False
    by_hand: bool = True


def tell(folder: str | Path, told: str | Path, listeners: Sequence[Listener] = ()) -> Told:
    """Keep what the files in the folder `told` say of runs that wait in the campaign of a folder: `<id>.csv`, or `<id>.failed` with a reason; with several experiments, those of each in a folder of its name.

    Each file is taken by itself, in any order: one that cannot be taken is said in `refused`, and the others are kept. One that was told before changes nothing, and another one for the same run is refused.
    Raises InputError where a process runs the campaign, and where there is no such folder.
    """
    folder, told = Path(folder), Path(told)
    if not told.is_dir():
        raise InputError(f"{told}: a folder with files <id>.csv or <id>.failed was expected.")
    with closing(Store.open(folder)) as store, closing(Log(folder)) as log:
        calibration = left_to_hand(store.calibration)
        found = Told(by_hand=calibration.by_hand)
        for number, file in _files(told, calibration, found):
            _take(store, calibration, number, file, found, (*listeners, log))
        log.write(
            f"Was told of {told}: {found.kept} outcomes kept, {found.known} known before, {len(found.not_needed)} not needed, {len(found.refused)} refused."
        )
        found.left = sum(len(waiting(store, number)) for number in by_hand(calibration))
        found.whole = not store.meta("stopped_by") and _whole(store, calibration)
        return found


def _files(told: Path, calibration: Calibration, found: Told) -> Iterator[tuple[int, ToldFile]]:
    """The files of each experiment, by its number, in the order of their samples; what is none is refused."""
    if len(calibration.experiments) == 1:
        folders = {0: [told]}
    else:
        names = [file_name(experiment.name) for experiment in calibration.experiments]
        inner = sorted(each for each in told.iterdir() if each.is_dir())
        folders = {number: [each for each in inner if file_name(each.name) == name] for number, name in enumerate(names)}
        found.refused += [
            f"{path}: the files of an experiment lie in a folder of its name, and one of {', '.join(names)} was expected."
            for path in told_in(told, calibration.experiments[0])
        ]
        strange = [each for each in inner if file_name(each.name) not in names and holds_runs(each, calibration.experiments[0])]
        found.refused += [f"{each}: there is no experiment of this name, and one of {', '.join(names)} was expected." for each in strange]
    for number, each in folders.items():
        for file in files_of_experiment(each, calibration.experiments[number], found.refused):
            yield number, file


def _take(store: Store, calibration: Calibration, number: int, file: ToldFile, found: Told, listeners: Sequence[Listener]) -> None:
    """Keep what one file says, or say why not."""
    experiment = calibration.experiments[number]
    asked = store.all_samples().ids
    if file.id not in asked:
        found.refused.append(f"{file.path}: there is no sample {file.id} in this campaign; graincal ask prints the ids of those that wait.")
        return
    try:
        outcome = read_outcome(file, experiment)
    except InputError as error:
        found.refused.append(str(error))
        return
    before = store.outcome(file.id, number)
    if before is not None:
        if _same(before, outcome):
            found.known += 1
        else:
            found.refused.append(
                f'{file.path}: something else was told of sample {file.id} in "{experiment.name}" before, or graincal ran it; what is stored stays.'
            )
        return
    if file.id not in waiting(store, number):
        found.not_needed.append(f"{file.path}: not needed, for sample {file.id} has failed in another experiment.")
        return
    store.record(file.id, number, outcome)
    found.kept += 1
    if isinstance(outcome, Failure) and file.path.suffix != FAILED:
        found.failures.append(f"{file.path}: kept as a failure ({outcome.kind}): {outcome.reason}")
    for listener in listeners:
        listener.evaluated(file.id, experiment.name, outcome)


def _whole(store: Store, calibration: Calibration) -> bool:
    """Whether the batch that comes next is begun, and nothing of it waits to be made by hand."""
    next_batch, last = len(store.iterations()), store.last_iteration()
    return last is not None and next_batch <= last and not any(len(store.waiting(next_batch, number)) for number in by_hand(calibration))


def _same(one: Response | Failure, other: Response | Failure) -> bool:
    """Whether two outcomes say the same."""
    if isinstance(one, Failure) or isinstance(other, Failure):
        return isinstance(one, Failure) and isinstance(other, Failure) and (one.kind, one.reason) == (other.kind, other.reason)
    if not np.array_equal(one.control, other.control) or one.values.keys() != other.values.keys():
        return False
    return all(np.array_equal(values, other.values[name], equal_nan=True) for name, values in one.values.items())
