"""Going on with a campaign by other criteria of stopping than it was begun with, and what was changed in its folder's copy of the calibration file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, fields, replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from graincal.campaign.asked.calibration import POSTERIOR, Calibration
from graincal.campaign.file.options import RunSection
from graincal.campaign.file.section import sentences
from graincal.campaign.found.replay import runs_at_answer, tell
from graincal.campaign.stored.asked import SPENT
from graincal.campaign.stored.evaluated import same
from graincal.campaign.stored.store import Store
from graincal.data import InputError
from graincal.inference import Stop
from graincal.notation.toml import read_toml
from graincal.suggestion import did_you_mean

_CRITERIA = tuple(field.name for field in fields(Stop))


def with_criteria(calibration: Calibration, criteria: Mapping[str, Any]) -> Calibration:
    """The calibration with some criteria of `Stop` replaced. Raises InputError for names and values that are none."""
    if unknown := [name for name in criteria if name not in _CRITERIA]:
        raise InputError(f"stop.{unknown[0]} is not a criterion of stopping{did_you_mean(unknown[0], _CRITERIA)}; expected some of {', '.join(_CRITERIA)}.")
    return replace(calibration, stop=replace(calibration.stop, **criteria))


def changed_criteria(before: Stop, now: Stop) -> dict[str, Any]:
    """The criteria that are others now; 0 is not the false that switches one off."""
    return {name: value for name, value in asdict(now).items() if value != getattr(before, name) or (value is False) is not (getattr(before, name) is False)}


def refuse_another_past(store: Store, calibration: Calibration) -> int:
    """Raise InputError where a campaign by the calibration's criteria would have ended before the store's did, or would not go on from its end.

    A filter's decision to stop follows from its complete iterations alone, so it is made again on those that are stored. Then whatever is
    evaluated from here on is what the campaign would have evaluated by these criteria from the start. Returns how many iterations are the same by
    these criteria: all that are begun, or all but the runs at the answer, which come later now.
    """
    ended, because = store.meta("stopped_by"), store.meta("stopped_because")
    stop = calibration.blank_filter().stop
    if ended and (ended not in _CRITERIA or stop.max_iterations != calibration.stop.max_iterations):
        raise InputError(
            f"{store.folder}: this campaign is at its end, by {calibration.method} and {ended}, and no criterion of stopping changes that: {because}"
        )
    if ended == "hours" and stop.hours is not False and float(store.meta(SPENT) or 0) >= 3600 * stop.hours:
        raise InputError(f"{store.folder}: it would still be at its end, by hours ({because}); raise that limit, or switch it off by false.")
    iterations, begun = store.iterations(), store.last_iteration()
    if begun is None:
        return 0
    if calibration.method == POSTERIOR:
        return _same_batches(store, calibration, begun + 1)
    for number in range(1, len(iterations) + 1):
        met = stop.reached(iterations[:number])
        if met and number <= begun:
            raise InputError(f"{store.folder}: it would have ended after {number} of the {begun + 1} iterations that are begun, by {_said(met)}.")
        if met and ended:
            raise InputError(f"{store.folder}: it would still be at its end, by {_said(met)}; raise that limit, or switch it off by false.")
    return begun + 1


def _same_batches(store: Store, calibration: Calibration, begun: int) -> int:
    """How many of the batches that are begun a posterior filter asks for by the calibration's criteria too."""
    filter, space, complete = calibration.new_filter(store.look), calibration.space, len(store.iterations())
    for number in range(begun):
        # Of those that are not complete, some were asked for ahead.
        asked, kept = next(iter(filter.under_way[number - len(filter.iterations) :]), None), store.samples(number)
        if asked is None or (runs_at_answer(asked, space) and not runs_at_answer(kept, space)):
            raise InputError(f"{store.folder}: it would have ended after {number} of the {begun} batches that are begun.")
        if runs_at_answer(kept, space) and not runs_at_answer(asked, space):
            return number
        if not same(asked, kept):
            raise _by_another_shift(store, calibration, number) or store.other_samples(number)
        if number < complete:
            tell(filter, asked, store, calibration.experiments)
    if filter.finished:
        raise InputError(
            f"{store.folder}: it would still be at its end, by {filter.stopped_by} ({filter.stopped_because}); raise that limit, or switch it off by false."
        )
    return begun


def _by_another_shift(store: Store, calibration: Calibration, number: int) -> InputError | None:
    """What to say where a batch is another by the shift that is enough now; None where that is the one of before. Fresh runs are asked for by it."""
    wanted, before = (str(each.stop.posterior_shift).lower() for each in (calibration, store.calibration))
    if wanted == before:
        return None
    return InputError(
        f"{store.folder}: by posterior_shift = {wanted} its batch {number} would have had other samples than by {before}; calibrate in another folder with --runs {store.folder} to learn from its runs."
    )


def changed_keys(path: Path, store: Store) -> str | None:
    """The keys in which a campaign's copy of the calibration file says something else than the store; None for none, or where there is no copy."""
    source = store.meta("source") or ""
    try:
        text = path.read_text(encoding="utf-8-sig")
        if text == source:
            return None
        before, now = _flat(read_toml(source)), _flat(read_toml(text))
    except FileNotFoundError:
        return None
    except (OSError, ValueError):
        return "a way that cannot be read"
    defaults = {f"stop.{name}": value for name, value in asdict(Stop()).items()}
    before, now = defaults | before, defaults | now
    # The criteria may have been changed since, by an earlier resume: the copy may say these, or still those of before.
    in_effect = {f"stop.{name}": value for name, value in asdict(store.calibration.stop).items()}
    return _differing(before, {key: before.get(key) if key in in_effect and value == in_effect[key] else value for key, value in now.items()}) or None


def edited_run(path: Path, store: Store) -> dict[str, Any]:
    """What [run] of a campaign's copy of the calibration file says of where it runs, and did not say when it was begun, its executor as `place`; {} where there is no copy that can be read. Raises InputError for what it cannot
    say."""
    try:
        before, now = (read_toml(text).get("run", {}) for text in (store.meta("source") or "", path.read_text(encoding="utf-8-sig")))
    except (OSError, ValueError):
        return {}
    if not isinstance(now, dict) or now == before:
        return {}
    try:
        run = RunSection.model_validate(now)
    except ValidationError as error:
        raise InputError("\n".join(f"{path}: run.{sentence}" for sentence in sentences(error, now))) from None
    # A function is found where it was when the campaign was begun.
    place = run.place(Path(store.meta("file") or path).parent)
    changed = {key: value for key, value in run.given("seed", "executor", "parsl").items() if value != before.get(key)}
    return changed if place == store.calibration.place else changed | {"place": place}


def changed_since(store: Store) -> tuple[Path, str] | None:
    """The calibration file that a campaign was begun with, and the keys in which it says something else now; None where it does not, or is gone."""
    file, source = store.meta("file"), store.meta("source")
    if not file or not source:
        return None
    try:
        before, now = _flat(read_toml(source)), _flat(read_toml(Path(file).read_text(encoding="utf-8-sig")))
    except (OSError, ValueError):
        return None
    keys = _differing(before, now)
    return (Path(file), keys) if keys else None


def _differing(before: Mapping[str, Any], now: Mapping[str, Any]) -> str:
    """The keys that say something else now, but for those of where it runs, which is no part of what was asked."""
    return ", ".join(sorted(key for key in {*before, *now} if before.get(key) != now.get(key) and (key == "run.seed" or not key.startswith("run."))))


def _flat(value: Any, key: str = "") -> dict[str, Any]:
    """The plain values of a document, each by the keys on the way to it; elements of a list of tables are counted from 1."""
    if isinstance(value, dict):
        inner = {f"{key}.{name}" if key else name: each for name, each in value.items()}
    elif isinstance(value, list) and any(isinstance(each, dict) for each in value):
        inner = {f"{key} {number}": each for number, each in enumerate(value, 1)}
    else:
        return {key: value}
    return {path: plain for name, each in inner.items() for path, plain in _flat(each, name).items()}


def _said(met: Mapping[str, str]) -> str:
    return "; ".join(f"{name} ({clause})" for name, clause in met.items())
