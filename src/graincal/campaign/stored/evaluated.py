"""Samples and what became of them, as a store keeps it."""

from __future__ import annotations

import json
from collections.abc import Sequence
from datetime import datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.asked.calibration import round_of
from graincal.campaign.stored.arrays import pack_array, pack_columns, unpack_array, unpack_columns
from graincal.campaign.stored.asked import StoredCalibration, now
from graincal.campaign.stored.database import damage_is_said, sound
from graincal.data import Failure, InputError, Response, Samples

# Values that one query takes; SQLite allows more.
AT_ONCE = 500

# What a response says of itself beside its numbers; and its turns, where there are some.
_ABOUT = ("control_name", "confining_pressure", "in_pascal")

STOPPED = "CASE WHEN json_valid(details) THEN coalesce(json_extract(details, '$.stopped') <> 0, 0) ELSE 0 END"


class StoredEvaluations(StoredCalibration):
    """The part of a store that holds samples and their evaluations."""

    def ask(self, iteration: int, samples: Samples, experiments: int) -> None:
        """Keep the samples of an iteration, to be evaluated in each experiment. Raises InputError if it holds others under their ids."""
        kept = self.samples(iteration)
        if len(kept):
            if not same(kept, samples):
                raise self.other_samples(iteration)
            return
        ids = [int(id) for id in samples.ids]
        with self._transaction() as db:
            db.executemany(
                "INSERT INTO sample (id, iteration, theta) VALUES (?, ?, ?)",
                [(id, iteration, json.dumps(theta.tolist())) for id, theta in zip(ids, samples.theta)],
            )
            db.executemany(
                "INSERT INTO evaluation (sample, experiment, state, attempts) VALUES (?, ?, 'waiting', 0)",
                [(id, experiment) for id in ids for experiment in range(experiments)],
            )

    def other_samples(self, iteration: int) -> InputError:
        """What to say where an iteration comes out with other samples than are stored."""
        return InputError(
            f"{self.folder}: {round_of(self.description['method'])} {iteration} comes out with other samples than are stored, so this campaign can only go on with what "
            "it was begun with: " + ", ".join(f"{name} {value}" for name, value in self.provenance.items()) + "."
        )

    @damage_is_said
    def samples(self, iteration: int) -> Samples:
        """The samples of an iteration; none if it has not begun."""
        return self._as_samples(self._rows(f"SELECT id, theta FROM sample WHERE iteration = ? AND {sound('sample')} ORDER BY id", iteration))

    @damage_is_said
    def all_samples(self) -> Samples:
        """Those of all iterations."""
        return self._as_samples(self._rows(f"SELECT id, theta FROM sample WHERE iteration >= 0 AND {sound('sample')} ORDER BY id"))

    @damage_is_said
    def waiting(self, iteration: int, experiment: int, *, by_itself: bool = False) -> NDArray[np.int64]:
        """Ids of the samples that have no outcome in an experiment, and neither failed nor were stopped in another; by_itself: whatever became of them in others."""
        but = "" if by_itself else f" AND sample NOT IN (SELECT sample FROM evaluation WHERE state = 'failed' OR {STOPPED})"
        query = f"""
            SELECT sample FROM evaluation JOIN sample ON sample.id = sample WHERE iteration = ? AND experiment = ? AND state = 'waiting'{but} ORDER BY sample"""
        return np.array([id for (id,) in self._rows(query, iteration, experiment)], dtype=np.int64)

    def record(self, id: int, experiment: int, outcome: Response | Failure, attempts: int = 1) -> None:
        """Keep the outcome of one evaluation, and how often it was run to come to it."""
        # JSON has no word for what is not finite.
        details = {name: float(value) if np.isfinite(value) else None for name, value in outcome.details.items()}
        if isinstance(outcome, Response):
            turns = {"turns": outcome.turns} if outcome.turns else {}
            about = json.dumps({name: getattr(outcome, name) for name in _ABOUT} | turns)
            found: tuple[str | bytes | None, ...] = ("finished", pack_array(outcome.control), pack_columns(outcome.values), about, None, None)
        else:
            found = ("failed", None, None, None, outcome.kind, outcome.reason)
        with self._transaction() as db:
            db.execute(
                """UPDATE evaluation SET state = ?, control = ?, response = ?, about = ?, kind = ?, reason = ?, ended = ?, seconds = ?, details = ?, attempts = attempts + ?
                   WHERE sample = ? AND experiment = ?""",
                (*found, now(), details.get("seconds"), json.dumps(details), attempts, int(id), experiment),
            )

    def outcome(self, id: int, experiment: int) -> Response | Failure | None:
        """What the evaluation of a sample gave in an experiment; None if it has not ended."""
        return self.outcomes([id], experiment)[0]

    @damage_is_said
    def outcomes(self, ids: Sequence[int] | NDArray[np.int64], experiment: int) -> list[Response | Failure | None]:
        """Of several samples, in their order."""
        columns = "sample, state, details, control, response, about, kind, reason"
        found: dict[int, Response | Failure | None] = {}
        for few in (ids[begin : begin + AT_ONCE] for begin in range(0, len(ids), AT_ONCE)):
            query = f"SELECT {columns} FROM evaluation WHERE experiment = ? AND sample IN ({','.join('?' * len(few))}) AND {sound('evaluation')}"
            found |= {sample: _outcome(*row) for sample, *row in self._rows(query, experiment, *map(int, few))}
        return [found.get(int(id)) for id in ids]

    @damage_is_said
    def counts(self, iteration: int | None = None) -> dict[str, int]:
        """How many samples there are, how many are evaluated in every experiment or failed or were stopped in one, and how many of these failed and were stopped."""
        chosen, arguments = ("WHERE iteration >= 0", ()) if iteration is None else ("WHERE iteration = ?", (iteration,))
        query = f"""
            SELECT count(*), coalesce(sum(failed OR stopped OR NOT waiting), 0), coalesce(sum(failed), 0), coalesce(sum(stopped), 0) FROM (
                SELECT max(state = 'failed') AS failed, max(state = 'waiting') AS waiting, max({STOPPED}) AS stopped
                FROM evaluation JOIN sample ON sample.id = sample {chosen} GROUP BY sample)"""
        return dict(zip(("samples", "evaluated", "failed", "stopped"), self._rows(query, *arguments)[0]))

    @damage_is_said
    def runs(self) -> list[tuple[int, int, int, float | None]]:
        """(sample, experiment, attempts, seconds) of every evaluation asked for; seconds are None where they are not known."""
        rows = self._rows("SELECT sample, experiment, attempts, seconds FROM evaluation ORDER BY sample, experiment")
        return [(int(sample), int(experiment), int(attempts), None if seconds is None else float(seconds)) for sample, experiment, attempts, seconds in rows]

    @damage_is_said
    def took(self) -> tuple[int, float]:
        """How many evaluations say how long they took, and how many seconds these took together."""
        count, seconds = self._rows("SELECT count(seconds), total(seconds) FROM evaluation")[0]
        return int(count), float(seconds)

    @damage_is_said
    def detail(self, name: str, experiment: int) -> dict[int, float | None]:
        """A detail of the evaluations in an experiment, by sample, such as "steps"; None where it is not known."""
        return dict(
            self._rows(
                "SELECT sample, CASE WHEN json_valid(details) THEN json_extract(details, '$.' || ?) END FROM evaluation WHERE experiment = ?", name, experiment
            )
        )

    @damage_is_said
    def failure_kinds(self) -> list[tuple[str, str, int]]:
        """Kinds of failure with one of their reasons and how often each occurred, the most frequent first."""
        rows = self._rows("SELECT kind, min(reason), count(*) FROM evaluation WHERE state = 'failed' AND sample >= 0 GROUP BY kind ORDER BY count(*) DESC")
        return [(str(kind), str(reason), count) for kind, reason, count in rows]

    @damage_is_said
    def last_iteration(self) -> int | None:
        """The iteration that was last begun."""
        last = self._rows("SELECT max(iteration) FROM sample WHERE iteration >= 0")[0][0]
        return None if last is None else int(last)

    @damage_is_said
    def last_ended(self) -> str | None:
        """When the last evaluation ended, ISO 8601."""
        last = self._rows("SELECT max(ended) FROM evaluation")[0][0]
        return None if last is None else datetime.fromisoformat(last).isoformat(timespec="milliseconds")

    @damage_is_said
    def rounds(self) -> tuple[list[int], int]:
        """(samples of each round that was begun, evaluations of them that wait)."""
        sizes = [count for (count,) in self._rows("SELECT count(*) FROM sample WHERE iteration >= 0 GROUP BY iteration ORDER BY iteration")]
        query = f"""
            SELECT count(*) FROM evaluation JOIN sample ON sample.id = sample
            WHERE iteration >= 0 AND state = 'waiting' AND sample NOT IN (SELECT sample FROM evaluation WHERE state = 'failed' OR {STOPPED})"""
        return sizes, self._rows(query)[0][0]

    @damage_is_said
    def ended_since(self, time: str) -> tuple[float | None, int]:
        """(s since 1970 when the first of them began, how many): the evaluations that ended since a time in ISO 8601; None where there is none."""
        query = "SELECT min((julianday(ended) - 2440587.5) * 86400 - coalesce(seconds, 0)), count(*) FROM evaluation WHERE ended >= ?"
        return self._rows(query, time)[0]

    def _as_samples(self, rows: Sequence[tuple[int, str]]) -> Samples:
        names = self.calibration.space.names
        theta = np.array([json.loads(theta) for _, theta in rows], dtype=np.float64).reshape(-1, len(names))
        return Samples(np.array([id for id, _ in rows], dtype=np.int64), theta, names)


def _outcome(state: str, details: Any, control: Any, response: Any, about: Any, kind: Any, reason: Any) -> Response | Failure | None:
    """What a row of evaluations says, whose columns are NULL where the state needs none; whatever a damaged one holds is said by whoever reads it (`damage_is_said`)."""
    if state == "finished":
        said = json.loads(about)
        control_name, pressure, in_pascal = (said[name] for name in _ABOUT)
        return Response(
            unpack_array(control), unpack_columns(response), _numbers(details), control_name, pressure, tuple(in_pascal), tuple(said.get("turns", ()))
        )
    return Failure(kind, reason, _numbers(details)) if state == "failed" else None


def _numbers(details: str) -> dict[str, float]:
    """The details of an outcome. Before they were null, those that are not finite stood there as words."""
    return {name: np.nan if value is None else float(value) for name, value in json.loads(details).items()}


def same(one: Samples, other: Samples) -> bool:
    """Whether they are the same, to within what a table of numbers loses."""
    return np.array_equal(one.ids, other.ids) and np.allclose(one.theta, other.theta, rtol=1e-9, atol=1e-12)
