"""DIR/campaign.db: everything a campaign knows, in SQLite. One process writes; any number read meanwhile.

Every change is one transaction on disk before the next thing happens, so that killing the process at any instant loses only what was under way.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager, closing, suppress
from datetime import datetime, timezone
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.asked.calibration import Calibration, round_of
from graincal.campaign.asked.description import describe, describe_first_look, describe_stop, restore
from graincal.campaign.asked.doubt import Doubt
from graincal.campaign.asked.place import Place
from graincal.campaign.stored.arrays import pack_array, pack_columns, unpack_array, unpack_columns
from graincal.campaign.stored.database import BEFORE, NAME, VERSION, Database, columns_of, damage_is_said, sound
from graincal.campaign.stored.learnt import Learnt
from graincal.campaign.stored.log import is_running
from graincal.campaign.stored.looks import pack_look, unpack_look
from graincal.campaign.stored.provenance import provenance
from graincal.campaign.stored.trouble import FolderError
from graincal.data import Failure, InputError, Response, Samples
from graincal.inference import Iteration, Stop
from graincal.inference.driving.known_runs import KnownRuns
from graincal.inference.posterior.emulation import Found
from graincal.inference.posterior.first_look import FirstLook

LIBRARY = "library"
"""The key under which a store of runs for no reference keeps how many there are to be."""

LOOK = "first_look"
"""The folder within a campaign's that holds the campaign of its first look."""

POINTS = "points"
"""The key under which a library keeps the parameters that its runs are to have, where somebody chose them."""

ACCEPTED = "accepted"
"""The key under which a store keeps the problems in spite of which its campaign was begun."""

OUT_OF_TIME, SPENT = "out of time", "seconds spent"
"""The keys under which a store keeps the iteration that was the last within the limit in time, and the wall time of all sittings so far."""

# Values that one query takes; SQLite allows more.
AT_ONCE = 500

# What a response says of itself beside its numbers; and its turns, where there are some.
_ABOUT = ("control_name", "confining_pressure", "in_pascal")

_STOPPED = "CASE WHEN json_valid(details) THEN coalesce(json_extract(details, '$.stopped') <> 0, 0) ELSE 0 END"


class Store:
    """The database of a campaign. `folder` is None for one in memory, which ends with the object."""

    def __init__(self, folder: Path | None, database: Database) -> None:
        self.folder = folder
        self.database = database

    @classmethod
    def create(cls, calibration: Calibration, folder: Path | None = None, *, library: int | None = None, points: NDArray[np.float64] | None = None, accepted: Sequence[Doubt] = ()) -> Store:
        """A new store for a calibration, in a folder or in memory. The folder must hold no campaign (`holds_campaign`). library: of so many runs for no reference; points (N, n): at these
        parameters. accepted: problems in spite of which it is begun."""
        store = cls(folder, Database(folder / NAME if folder else None, create=True))
        meta = {
            "description": _as_json(describe(calibration)),
            "workers": json.dumps(calibration.workers),
            "place": json.dumps(calibration.place and calibration.place.as_json()),
            "source": calibration.source,
            "file": calibration.file,
            "truth": _as_json(calibration.truth),
            "provenance": json.dumps(provenance()),
            "started": _now(),
        } | ({} if library is None else {LIBRARY: str(library)})
        if points is not None:
            meta[POINTS] = json.dumps(points.tolist())
        if accepted:
            meta[ACCEPTED] = json.dumps([doubt.as_json() for doubt in accepted], ensure_ascii=False)
        with store.database.created() as db:
            db.executemany("INSERT INTO meta (key, value) VALUES (?, ?)", meta.items())
            db.executemany("INSERT INTO known (name, array) VALUES (?, ?)", _known_arrays(calibration.known).items())
        return store

    @classmethod
    def open(cls, folder: Path) -> Store:
        """The store of a folder; one of the format before is brought up to this one. Raises InputError where the folder holds no campaign, or one of another format."""
        if not holds_campaign(folder):
            raise InputError(f"{folder}: there is no campaign in this folder (no {NAME}).")
        store = cls(folder, Database(folder / NAME))
        found = store.database.version
        if found not in (BEFORE, VERSION):
            by = f"graincal {store._begun_by()} in the format {found}"
            if found > VERSION:
                raise InputError(f"{folder / NAME}: this campaign was stored by {by}, and graincal {version('graincal')} reads formats up to {VERSION}: a later version of graincal was expected to read it.")
            raise InputError(f"{folder / NAME}: this campaign was stored by {by}, and graincal {version('graincal')} reads the formats {BEFORE} and {VERSION} alone: calibrate again, in another folder.")
        if found == BEFORE:
            if is_running(folder):
                raise InputError(f"{folder}: a version of graincal before this one is running this campaign; wait for its end.")
            store.database.bring_up()
        return store

    def _begun_by(self) -> str:
        """The version that began a campaign of another format, as far as it can be read."""
        try:
            return json.loads(self.database.rows("SELECT value FROM meta WHERE key = 'provenance'")[0][0]).get("graincal", "of another version")
        except (ValueError, IndexError, TypeError, AttributeError):
            return "of another version"

    def close(self) -> None:
        """Let go of the file."""
        self.database.close()

    # What was asked

    @cached_property
    @damage_is_said
    def description(self) -> dict[str, Any]:
        """The calibration as plain data (description.py)."""
        return json.loads(self.meta("description"))

    @cached_property
    @damage_is_said
    def calibration(self) -> Calibration:
        """The calibration, with models as far as they can be found again."""
        truth = json.loads(self.meta("truth"))
        # A store of a version before says none.
        place = json.loads(self.meta("place") or "null")
        others = {"workers": json.loads(self.meta("workers")), "place": place and Place(**place), "source": self.meta("source"), "truth": truth, "file": self.meta("file")}
        return restore(self.description, known=self._known(), **others)

    @damage_is_said
    def _known(self) -> KnownRuns | None:
        """The runs that were made before."""
        if "known" not in self.description:
            return None
        arrays = {name: unpack_array(blob) for name, blob in self._rows(f"SELECT name, array FROM known WHERE {sound('known')}")}
        responses = tuple(arrays[f"responses {number}"] for number in range(len(self.description["experiments"])))
        return KnownRuns(arrays["theta"], responses, arrays["infeasible"], arrays["missing"], tuple(self.description["known"]["sources"]))

    def keeps(self, calibration: Calibration) -> bool:
        """Whether this is the store of a calibration; only the workers and the truth may differ, a look that has been taken since, and where the folders of runs that were known before are now."""
        kept = {key: value for key, value in self.description.items() if key != "first_look" or calibration.look is None}
        return _without_sources(as_stored(describe(calibration))) == _without_sources(kept)

    @property
    @damage_is_said
    def provenance(self) -> dict[str, str]:
        """What the campaign was begun with."""
        return json.loads(self.meta("provenance"))

    def meta(self, key: str) -> str | None:
        """A text that is kept once: "started" (time), "source", "stopped_by", "stopped_because"; None if it is not there."""
        rows = self._rows(f"SELECT value FROM meta WHERE key = ? AND {sound('meta')}", key)
        return rows[0][0] if rows else None

    def keep(self, key: str, text: str) -> None:
        """Keep a text once (`meta`)."""
        with self._transaction() as db:
            db.execute("INSERT OR IGNORE INTO meta (key, value) VALUES (?, ?)", (key, text))

    def spend(self, seconds: float) -> None:
        """Keep how much wall time all sittings have taken."""
        with self._transaction() as db:
            db.execute("INSERT OR REPLACE INTO meta (key, value) VALUES (?, ?)", (SPENT, f"{seconds:.3f}"))

    @property
    @damage_is_said
    def accepted(self) -> tuple[Doubt, ...]:
        """The problems in spite of which the campaign was begun."""
        return tuple(Doubt(**each) for each in json.loads(self.meta(ACCEPTED) or "[]"))

    @property
    def is_library(self) -> bool:
        """Whether it holds runs for no reference, which have no result."""
        return self.meta(LIBRARY) is not None

    def keep_first_look(self, look: FirstLook) -> None:
        """Keep what the look brought that the calibration begins with."""
        description = self.description | {"first_look": describe_first_look(look)}
        with self._transaction() as db:
            db.execute("INSERT OR REPLACE INTO meta (key, value) VALUES ('description', ?)", (_as_json(description),))
        self._forget()

    # Samples and their evaluations

    def ask(self, iteration: int, samples: Samples, experiments: int) -> None:
        """Keep the samples of an iteration, to be evaluated in each experiment. Raises InputError if it holds others under their ids."""
        kept = self.samples(iteration)
        if len(kept):
            if not same(kept, samples):
                raise self.other_samples(iteration)
            return
        ids = [int(id) for id in samples.ids]
        with self._transaction() as db:
            db.executemany("INSERT INTO sample (id, iteration, theta) VALUES (?, ?, ?)", [(id, iteration, json.dumps(theta.tolist())) for id, theta in zip(ids, samples.theta)])
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
        but = "" if by_itself else f" AND sample NOT IN (SELECT sample FROM evaluation WHERE state = 'failed' OR {_STOPPED})"
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
            found = ("finished", pack_array(outcome.control), pack_columns(outcome.values), about, None, None)
        else:
            found = ("failed", None, None, None, outcome.kind, outcome.reason)
        with self._transaction() as db:
            db.execute(
                """UPDATE evaluation SET state = ?, control = ?, response = ?, about = ?, kind = ?, reason = ?, ended = ?, seconds = ?, details = ?, attempts = attempts + ?
                   WHERE sample = ? AND experiment = ?""",
                (*found, _now(), details.get("seconds"), json.dumps(details), attempts, int(id), experiment),
            )

    def outcome(self, id: int, experiment: int) -> Response | Failure | None:
        """What the evaluation of a sample gave in an experiment; None if it has not ended."""
        return self.outcomes([id], experiment)[0]

    @damage_is_said
    def outcomes(self, ids: Sequence[int], experiment: int) -> list[Response | Failure | None]:
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
                SELECT max(state = 'failed') AS failed, max(state = 'waiting') AS waiting, max({_STOPPED}) AS stopped
                FROM evaluation JOIN sample ON sample.id = sample {chosen} GROUP BY sample)"""
        return dict(zip(("samples", "evaluated", "failed", "stopped"), self._rows(query, *arguments)[0]))

    @damage_is_said
    def runs(self) -> list[tuple[int, int, int, float | None]]:
        """(sample, experiment, attempts, seconds) of every evaluation asked for; seconds are None where they are not known."""
        rows = self._rows("SELECT sample, experiment, attempts, seconds FROM evaluation ORDER BY sample, experiment")
        return [(int(sample), int(experiment), int(attempts), None if seconds is None else float(seconds)) for sample, experiment, attempts, seconds in rows]

    @damage_is_said
    def detail(self, name: str, experiment: int) -> dict[int, float | None]:
        """A detail of the evaluations in an experiment, by sample, such as "steps"; None where it is not known."""
        return dict(self._rows("SELECT sample, CASE WHEN json_valid(details) THEN json_extract(details, '$.' || ?) END FROM evaluation WHERE experiment = ?", name, experiment))

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

    # Iterations and the end

    def complete(self, iteration: Iteration, learnt: Learnt | None = None, looks: Sequence[Found] = ()) -> None:
        """Keep what an iteration found, what was learnt of the posterior by it and what looks at the evaluations found, unless it is kept already."""
        numbers = [float(value) for value in (iteration.s, iteration.effective_sample_size, iteration.gl_error)]
        arrays = [pack_array(array) for array in (iteration.weights, iteration.errors, iteration.observable_errors)]
        with self._transaction() as db:
            # SQLite keeps NaN as NULL.
            db.execute(f"INSERT OR IGNORE INTO iteration ({', '.join(columns_of('iteration'))}) VALUES (?, ?, ?, ?, ?, ?, ?, ?)", (iteration.index, *numbers, iteration.unweighted, *arrays))
            if learnt:
                db.execute("INSERT OR IGNORE INTO learnt (iteration, figures) VALUES (?, ?)", (iteration.index, json.dumps(learnt.plain())))
            for found in looks:
                db.execute("INSERT OR IGNORE INTO look (evaluations, iteration, found) VALUES (?, ?, ?)", (len(found.weights), iteration.index, pack_look(found)))

    @damage_is_said
    def iterations(self) -> tuple[Iteration, ...]:
        """The iterations that are complete; their proposals are not kept."""
        return tuple(self._iteration(*row) for row in self._rows(f"SELECT {', '.join(columns_of('iteration'))} FROM iteration WHERE {sound('iteration')} ORDER BY id"))

    @damage_is_said
    def learnt(self) -> tuple[Learnt, ...]:
        """What was learnt of the posterior by each of the iterations that are complete; nothing by methods without one."""
        return tuple(Learnt.restore(json.loads(figures)) for (figures,) in self._rows(f"SELECT figures FROM learnt WHERE {sound('learnt')} ORDER BY iteration"))

    @damage_is_said
    def look(self, evaluations: int | None = None) -> Found | None:
        """What was found by a look at so many evaluations, or by the last one; None where none was taken."""
        chosen, arguments = (f"WHERE {sound('look')} ORDER BY evaluations DESC LIMIT 1", ()) if evaluations is None else (f"WHERE evaluations = ? AND {sound('look')}", (evaluations,))
        rows = self._rows(f"SELECT found FROM look {chosen}", *arguments)
        return unpack_look(rows[0][0], self.calibration.space) if rows else None

    @damage_is_said
    def derived(self, name: str, evaluations: int) -> NDArray | None:
        """Numbers that were computed of what a look at so many evaluations found; None where they were not."""
        rows = self._rows(f"SELECT array FROM derived WHERE name = ? AND evaluations = ? AND {sound('derived')}", name, evaluations)
        return unpack_array(rows[0][0]) if rows else None

    def keep_derived(self, name: str, evaluations: int, array: NDArray) -> None:
        """Keep such numbers, where the store can be written: they can be computed again."""
        with suppress(FolderError), self._transaction() as db:
            db.execute("INSERT OR REPLACE INTO derived (name, evaluations, array) VALUES (?, ?, ?)", (name, evaluations, pack_array(array)))

    def stop(self, by: str, because: str) -> None:
        """Keep why the calibration is at its end."""
        with self._transaction() as db:
            db.executemany("INSERT OR REPLACE INTO meta (key, value) VALUES (?, ?)", [("stopped_by", by), ("stopped_because", because)])

    def go_on(self, stop: Stop, remark: str, iterations: int) -> None:
        """Keep other criteria of stopping, and that the campaign is not at its end, with its first so many iterations.

        A remark says so at the head of the calibration file's text.
        """
        meta = {"description": _as_json(self.description | {"stop": describe_stop(self.description["method"], stop)})}
        if source := self.meta("source"):
            meta["source"] = f"# {remark}\n{source}"
        with self._transaction() as db:
            db.executemany("INSERT OR REPLACE INTO meta (key, value) VALUES (?, ?)", meta.items())
            db.execute("DELETE FROM meta WHERE key IN ('stopped_by', 'stopped_because', ?)", (OUT_OF_TIME,))
            db.execute("DELETE FROM evaluation WHERE sample IN (SELECT id FROM sample WHERE iteration >= ?)", (iterations,))
            db.execute("DELETE FROM derived WHERE evaluations IN (SELECT evaluations FROM look WHERE iteration >= ?)", (iterations,))
            for table, column in {"sample": "iteration", "iteration": "id", "learnt": "iteration", "look": "iteration"}.items():
                db.execute(f"DELETE FROM {table} WHERE {column} >= ?", (iterations,))
        self._forget()

    def _forget(self) -> None:
        """Read again what was asked for."""
        for known in ("description", "calibration"):
            self.__dict__.pop(known, None)

    def _iteration(self, index: int, s: float, size: float, gl_error: float, unweighted: str, *blobs: bytes) -> Iteration:
        weights, errors, observable_errors = map(unpack_array, blobs)
        s, size, gl_error = (np.nan if value is None else value for value in (s, size, gl_error))
        samples = self.samples(index)
        if not isinstance(unweighted, str) or any(count != len(samples) for count in (weights.shape[-1], len(errors), len(observable_errors))):
            raise ValueError("an iteration has other samples than figures")
        query = f"SELECT DISTINCT sample FROM evaluation JOIN sample ON sample.id = sample WHERE iteration = ? AND {_STOPPED}"
        stopped = np.isin(samples.ids, [id for (id,) in self._rows(query, index)])
        # Only a failure has no error.
        return Iteration(index, samples, None, np.isnan(errors), observable_errors, errors, weights, s, size, gl_error, unweighted, stopped)

    def _as_samples(self, rows: Sequence[tuple[int, str]]) -> Samples:
        names = self.calibration.space.names
        theta = np.array([json.loads(theta) for _, theta in rows], dtype=np.float64).reshape(-1, len(names))
        return Samples(np.array([id for id, _ in rows], dtype=np.int64), theta, names)

    def _rows(self, query: str, *arguments: Any) -> list[tuple]:
        return self.database.rows(query, *arguments)

    def _transaction(self) -> AbstractContextManager[sqlite3.Connection]:
        return self.database.transaction()


def _outcome(
    state: str, details: str | None, control: bytes | None, response: bytes | None, about: str | None, kind: str | None, reason: str | None
) -> Response | Failure | None:
    """What a row of evaluations says."""
    if state == "finished":
        said = json.loads(about)
        control_name, pressure, in_pascal = (said[name] for name in _ABOUT)
        return Response(unpack_array(control), unpack_columns(response), _numbers(details), control_name, pressure, tuple(in_pascal), tuple(said.get("turns", ())))
    return Failure(kind, reason, _numbers(details)) if state == "failed" else None


def _numbers(details: str) -> dict[str, float]:
    """The details of an outcome. Before they were null, those that are not finite stood there as words."""
    return {name: np.nan if value is None else float(value) for name, value in json.loads(details).items()}


def _known_arrays(runs: KnownRuns | None) -> dict[str, bytes]:
    """What a store keeps of runs that were made before."""
    if runs is None:
        return {}
    arrays = {"theta": runs.theta, "infeasible": runs.infeasible, "missing": runs.missing} | {f"responses {number}": responses for number, responses in enumerate(runs.responses)}
    return {name: pack_array(array) for name, array in arrays.items()}


def same(one: Samples, other: Samples) -> bool:
    """Whether they are the same, to within what a table of numbers loses."""
    return np.array_equal(one.ids, other.ids) and np.allclose(one.theta, other.theta, rtol=1e-9, atol=1e-12)


def holds_campaign(folder: Path) -> bool:
    """Whether there is a campaign in a folder; what is left of a beginning that was cut short is none."""
    path = folder / NAME
    if not path.is_file():
        return False
    with closing(Database(path)) as database:
        return database.version > 0


def _as_json(data: Mapping[str, Any]) -> str:
    # What is no plain number is NumPy's.
    return json.dumps(dict(data), default=lambda number: number.item())


def _without_sources(description: dict[str, Any]) -> dict[str, Any]:
    """A description without what is said of the runs that were known before, which are known by their numbers."""
    if "known" not in description:
        return description
    return description | {"known": {key: value for key, value in description["known"].items() if key != "sources"}}


def as_stored(data: Mapping[str, Any]) -> dict[str, Any]:
    """Plain data as they come back from a store."""
    return json.loads(_as_json(data))


def _now() -> str:
    return datetime.now(timezone.utc).isoformat(timespec="milliseconds")
