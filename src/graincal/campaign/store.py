"""DIR/campaign.db: everything a campaign knows, in SQLite. One process writes; any number read meanwhile.

Every change is one transaction on disk before the next thing happens, so that killing the process at any instant loses only what was under way.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from datetime import datetime, timezone
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.arrays import pack_array, pack_columns, unpack_array, unpack_columns
from graincal.campaign.calibration import Calibration, round_of
from graincal.campaign.description import describe, describe_first_look, describe_stop, restore
from graincal.campaign.doubt import Doubt
from graincal.campaign.learnt import Learnt
from graincal.campaign.looks import pack_look, unpack_look
from graincal.campaign.provenance import provenance
from graincal.campaign.trouble import FolderError
from graincal.data import Failure, InputError, Response, Samples
from graincal.inference import Iteration, Stop
from graincal.inference.emulation import Found
from graincal.inference.first_look import FirstLook
from graincal.inference.known_runs import KnownRuns

NAME = "campaign.db"
LIBRARY = "library"
"""The key under which a store of runs for no reference keeps how many there are to be."""

POINTS = "points"
"""The key under which a library keeps the parameters that its runs are to have, where somebody chose them."""

ACCEPTED = "accepted"
"""The key under which a store keeps the problems in spite of which its campaign was begun."""

VERSION = 4

OUT_OF_TIME, SPENT = "out of time", "seconds spent"
"""The keys under which a store keeps the iteration that was the last within the limit in time, and the wall time of all sittings so far."""

# Values that one query takes; SQLite allows more.
AT_ONCE = 500

# theta and details are JSON; arrays are .npy (arrays.py). A response is kept on the states of its model, whatever the reference. An evaluation is "waiting"
# until it is "finished" (a response) or "failed" (a reason). One that was stopped early is finished, with a response that is shorter, and its details say so.
# Samples below 0 are those of the study of packings (packings.py), and belong to no iteration.
_SCHEMA = """
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE sample (id INTEGER PRIMARY KEY, iteration INTEGER NOT NULL, theta TEXT NOT NULL);
CREATE INDEX sample_by_iteration ON sample (iteration);
CREATE TABLE evaluation (
    sample INTEGER NOT NULL REFERENCES sample (id),
    experiment INTEGER NOT NULL,
    state TEXT NOT NULL CHECK (state IN ('waiting', 'finished', 'failed')),
    attempts INTEGER NOT NULL,
    ended TEXT, seconds REAL, details TEXT, control BLOB, response BLOB, about TEXT, kind TEXT, reason TEXT,
    PRIMARY KEY (sample, experiment)
);
CREATE TABLE iteration (
    id INTEGER PRIMARY KEY, s REAL, effective_sample_size REAL, gl_error REAL, unweighted TEXT NOT NULL,
    weights BLOB NOT NULL, errors BLOB NOT NULL, observable_errors BLOB NOT NULL
);
CREATE TABLE learnt (iteration INTEGER PRIMARY KEY, figures TEXT NOT NULL);
CREATE TABLE look (evaluations INTEGER PRIMARY KEY, iteration INTEGER NOT NULL, found BLOB NOT NULL);
CREATE TABLE known (name TEXT PRIMARY KEY, array BLOB NOT NULL) WITHOUT ROWID;
CREATE TABLE derived (name TEXT, evaluations INTEGER, array BLOB NOT NULL, PRIMARY KEY (name, evaluations)) WITHOUT ROWID;
"""


# What a response says of itself beside its numbers; and its turns, where there are some.
_ABOUT = ("control_name", "confining_pressure", "in_pascal")

_STOPPED = "coalesce(json_extract(details, '$.stopped') <> 0, 0)"


class Store:
    """The database of a campaign. `folder` is None for one in memory, which ends with the object."""

    def __init__(self, folder: Path | None, connection: sqlite3.Connection) -> None:
        self.folder = folder
        self._connection = connection

    @classmethod
    def create(cls, calibration: Calibration, folder: Path | None = None, *, library: int | None = None, points: NDArray[np.float64] | None = None, accepted: Sequence[Doubt] = ()) -> Store:
        """A new store for a calibration, in a folder or in memory. The folder must hold no campaign (`holds_campaign`). library: of so many runs for no reference; points (N, n): at these
        parameters. accepted: problems in spite of which it is begun."""
        store = cls(folder, _connect(folder / NAME, create=True) if folder else sqlite3.connect(":memory:", isolation_level=None, check_same_thread=False))
        meta = {
            "description": _as_json(describe(calibration)),
            "workers": json.dumps(calibration.workers),
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
        with store._transaction() as db:
            for statement in _SCHEMA.split(";"):
                db.execute(statement)
            db.executemany("INSERT INTO meta VALUES (?, ?)", meta.items())
            db.executemany("INSERT INTO known VALUES (?, ?)", _known_arrays(calibration.known).items())
            db.execute(f"PRAGMA user_version = {VERSION}")
        return store

    @classmethod
    def open(cls, folder: Path) -> Store:
        """The store of a folder. Raises InputError where the folder holds no campaign, or one that another version of graincal wrote."""
        if not holds_campaign(folder):
            raise InputError(f"{folder}: there is no campaign in this folder (no {NAME}).")
        store = cls(folder, _connect(folder / NAME))
        if store.version() != VERSION:
            by = f"graincal {store.provenance.get('graincal', 'of another version')} in the format {store.version()}"
            raise InputError(f"{folder / NAME}: this campaign was stored by {by}, and graincal {version('graincal')} reads the format {VERSION} alone: calibrate again, in another folder.")
        return store

    def close(self) -> None:
        """Let go of the file."""
        self._connection.close()

    def version(self) -> int:
        """The format of the database; 0 for an empty one."""
        return self._rows("PRAGMA user_version")[0][0]

    # What was asked

    @cached_property
    def description(self) -> dict[str, Any]:
        """The calibration as plain data (description.py)."""
        return json.loads(self.meta("description"))

    @cached_property
    def calibration(self) -> Calibration:
        """The calibration, with models as far as they can be found again."""
        truth = json.loads(self.meta("truth"))
        others = {"workers": json.loads(self.meta("workers")), "source": self.meta("source"), "truth": truth, "file": self.meta("file")}
        return restore(self.description, known=self._known(), **others)

    def _known(self) -> KnownRuns | None:
        """The runs that were made before."""
        if "known" not in self.description:
            return None
        arrays = {name: unpack_array(blob) for name, blob in self._rows("SELECT name, array FROM known")}
        responses = tuple(arrays[f"responses {number}"] for number in range(len(self.description["experiments"])))
        return KnownRuns(arrays["theta"], responses, arrays["infeasible"], arrays["missing"], tuple(self.description["known"]["sources"]))

    def keeps(self, calibration: Calibration) -> bool:
        """Whether this is the store of a calibration; only the workers and the truth may differ, and a look that has been taken since."""
        kept = {key: value for key, value in self.description.items() if key != "first_look" or calibration.look is None}
        return as_stored(describe(calibration)) == kept

    @property
    def provenance(self) -> dict[str, str]:
        """What the campaign was begun with."""
        return json.loads(self.meta("provenance"))

    def meta(self, key: str) -> str | None:
        """A text that is kept once: "started" (time), "source", "stopped_by", "stopped_because"; None if it is not there."""
        rows = self._rows("SELECT value FROM meta WHERE key = ?", key)
        return rows[0][0] if rows else None

    def keep(self, key: str, text: str) -> None:
        """Keep a text once (`meta`)."""
        with self._transaction() as db:
            db.execute("INSERT OR IGNORE INTO meta VALUES (?, ?)", (key, text))

    def spend(self, seconds: float) -> None:
        """Keep how much wall time all sittings have taken."""
        with self._transaction() as db:
            db.execute("INSERT OR REPLACE INTO meta VALUES (?, ?)", (SPENT, f"{seconds:.3f}"))

    @property
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
            db.execute("INSERT OR REPLACE INTO meta VALUES ('description', ?)", (_as_json(description),))
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
            db.executemany("INSERT INTO sample VALUES (?, ?, ?)", [(id, iteration, json.dumps(theta.tolist())) for id, theta in zip(ids, samples.theta)])
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

    def samples(self, iteration: int) -> Samples:
        """The samples of an iteration; none if it has not begun."""
        return self._as_samples(self._rows("SELECT id, theta FROM sample WHERE iteration = ? ORDER BY id", iteration))

    def all_samples(self) -> Samples:
        """Those of all iterations."""
        return self._as_samples(self._rows("SELECT id, theta FROM sample WHERE iteration >= 0 ORDER BY id"))

    def waiting(self, iteration: int, experiment: int, *, by_itself: bool = False) -> NDArray[np.int64]:
        """Ids of the samples that have no outcome in an experiment, and neither failed nor were stopped in another; by_itself: whatever became of them in others."""
        but = "" if by_itself else f" AND sample NOT IN (SELECT sample FROM evaluation WHERE state = 'failed' OR {_STOPPED})"
        query = f"""
            SELECT sample FROM evaluation JOIN sample ON sample.id = sample WHERE iteration = ? AND experiment = ? AND state = 'waiting'{but} ORDER BY sample"""
        return np.array([id for (id,) in self._rows(query, iteration, experiment)], dtype=np.int64)

    def record(self, id: int, experiment: int, outcome: Response | Failure, attempts: int = 1) -> None:
        """Keep the outcome of one evaluation, and how often it was run to come to it."""
        details = {name: float(value) for name, value in outcome.details.items()}
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

    def outcomes(self, ids: Sequence[int], experiment: int) -> list[Response | Failure | None]:
        """Of several samples, in their order."""
        columns = "sample, state, details, control, response, about, kind, reason"
        found: dict[int, Response | Failure | None] = {}
        for few in (ids[begin : begin + AT_ONCE] for begin in range(0, len(ids), AT_ONCE)):
            query = f"SELECT {columns} FROM evaluation WHERE experiment = ? AND sample IN ({','.join('?' * len(few))})"
            found |= {sample: _outcome(*row) for sample, *row in self._rows(query, experiment, *map(int, few))}
        return [found.get(int(id)) for id in ids]

    def counts(self, iteration: int | None = None) -> dict[str, int]:
        """How many samples there are, how many are evaluated in every experiment or failed or were stopped in one, and how many of these failed and were stopped."""
        chosen, arguments = ("WHERE iteration >= 0", ()) if iteration is None else ("WHERE iteration = ?", (iteration,))
        query = f"""
            SELECT count(*), coalesce(sum(failed OR stopped OR NOT waiting), 0), coalesce(sum(failed), 0), coalesce(sum(stopped), 0) FROM (
                SELECT max(state = 'failed') AS failed, max(state = 'waiting') AS waiting, max({_STOPPED}) AS stopped
                FROM evaluation JOIN sample ON sample.id = sample {chosen} GROUP BY sample)"""
        return dict(zip(("samples", "evaluated", "failed", "stopped"), self._rows(query, *arguments)[0]))

    def runs(self) -> list[tuple[int, int, int, float | None]]:
        """(sample, experiment, attempts, seconds) of every evaluation asked for; seconds are None where they are not known."""
        return self._rows("SELECT sample, experiment, attempts, seconds FROM evaluation ORDER BY sample, experiment")

    def failure_kinds(self) -> list[tuple[str, str, int]]:
        """Kinds of failure with one of their reasons and how often each occurred, the most frequent first."""
        return self._rows("SELECT kind, min(reason), count(*) FROM evaluation WHERE state = 'failed' AND sample >= 0 GROUP BY kind ORDER BY count(*) DESC")

    def last_iteration(self) -> int | None:
        """The iteration that was last begun."""
        return self._rows("SELECT max(iteration) FROM sample WHERE iteration >= 0")[0][0]

    def last_ended(self) -> str | None:
        """When the last evaluation ended, ISO 8601."""
        return self._rows("SELECT max(ended) FROM evaluation")[0][0]

    # Iterations and the end

    def complete(self, iteration: Iteration, learnt: Learnt | None = None, looks: Sequence[Found] = ()) -> None:
        """Keep what an iteration found, what was learnt of the posterior by it and what looks at the evaluations found, unless it is kept already."""
        numbers = [float(value) for value in (iteration.s, iteration.effective_sample_size, iteration.gl_error)]
        arrays = [pack_array(array) for array in (iteration.weights, iteration.errors, iteration.observable_errors)]
        with self._transaction() as db:
            # SQLite keeps NaN as NULL.
            db.execute("INSERT OR IGNORE INTO iteration VALUES (?, ?, ?, ?, ?, ?, ?, ?)", (iteration.index, *numbers, iteration.unweighted, *arrays))
            if learnt:
                db.execute("INSERT OR IGNORE INTO learnt VALUES (?, ?)", (iteration.index, json.dumps(learnt.plain())))
            for found in looks:
                db.execute("INSERT OR IGNORE INTO look VALUES (?, ?, ?)", (len(found.weights), iteration.index, pack_look(found)))

    def iterations(self) -> tuple[Iteration, ...]:
        """The iterations that are complete; their proposals are not kept."""
        return tuple(self._iteration(*row) for row in self._rows("SELECT * FROM iteration ORDER BY id"))

    def learnt(self) -> tuple[Learnt, ...]:
        """What was learnt of the posterior by each of the iterations that are complete; nothing by methods without one."""
        return tuple(Learnt.restore(json.loads(figures)) for (figures,) in self._rows("SELECT figures FROM learnt ORDER BY iteration"))

    def look(self, evaluations: int | None = None) -> Found | None:
        """What was found by a look at so many evaluations, or by the last one; None where none was taken."""
        chosen, arguments = ("ORDER BY evaluations DESC LIMIT 1", ()) if evaluations is None else ("WHERE evaluations = ?", (evaluations,))
        rows = self._rows(f"SELECT found FROM look {chosen}", *arguments)
        return unpack_look(rows[0][0], self.calibration.space) if rows else None

    def derived(self, name: str, evaluations: int) -> NDArray | None:
        """Numbers that were computed of what a look at so many evaluations found; None where they were not."""
        rows = self._rows("SELECT array FROM derived WHERE name = ? AND evaluations = ?", name, evaluations)
        return unpack_array(rows[0][0]) if rows else None

    def keep_derived(self, name: str, evaluations: int, array: NDArray) -> None:
        """Keep such numbers, where the store can be written: they can be computed again."""
        with suppress(FolderError), self._transaction() as db:
            db.execute("INSERT OR REPLACE INTO derived VALUES (?, ?, ?)", (name, evaluations, pack_array(array)))

    def stop(self, by: str, because: str) -> None:
        """Keep why the calibration is at its end."""
        with self._transaction() as db:
            db.executemany("INSERT OR REPLACE INTO meta VALUES (?, ?)", [("stopped_by", by), ("stopped_because", because)])

    def go_on(self, stop: Stop, remark: str, iterations: int) -> None:
        """Keep other criteria of stopping, and that the campaign is not at its end, with its first so many iterations.

        A remark says so at the head of the calibration file's text.
        """
        meta = {"description": _as_json(self.description | {"stop": describe_stop(self.description["method"], stop)})}
        if source := self.meta("source"):
            meta["source"] = f"# {remark}\n{source}"
        with self._transaction() as db:
            db.executemany("INSERT OR REPLACE INTO meta VALUES (?, ?)", meta.items())
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
        query = f"SELECT DISTINCT sample FROM evaluation JOIN sample ON sample.id = sample WHERE iteration = ? AND {_STOPPED}"
        stopped = np.isin(samples.ids, [id for (id,) in self._rows(query, index)])
        # Only a failure has no error.
        return Iteration(index, samples, None, np.isnan(errors), observable_errors, errors, weights, s, size, gl_error, unweighted, stopped)

    def _as_samples(self, rows: Sequence[tuple[int, str]]) -> Samples:
        names = self.calibration.space.names
        theta = np.array([json.loads(theta) for _, theta in rows], dtype=np.float64).reshape(-1, len(names))
        return Samples(np.array([id for id, _ in rows], dtype=np.int64), theta, names)

    def _rows(self, query: str, *arguments: Any) -> list[tuple]:
        try:
            return self._connection.execute(query, arguments).fetchall()
        except sqlite3.Error as error:
            raise FolderError.of(self._path, error, reading=True) from error

    @contextmanager
    def _transaction(self) -> Iterator[sqlite3.Connection]:
        try:
            self._connection.execute("BEGIN IMMEDIATE")
            yield self._connection
            self._connection.execute("COMMIT")
        except BaseException as error:
            if self._connection.in_transaction:
                self._connection.rollback()
            if isinstance(error, sqlite3.Error):
                raise FolderError.of(self._path, error) from error
            raise

    @property
    def _path(self) -> Path | str:
        return self.folder / NAME if self.folder else "the store in memory"


def _outcome(
    state: str, details: str | None, control: bytes | None, response: bytes | None, about: str | None, kind: str | None, reason: str | None
) -> Response | Failure | None:
    """What a row of evaluations says."""
    if state == "finished":
        said = json.loads(about)
        control_name, pressure, in_pascal = (said[name] for name in _ABOUT)
        return Response(unpack_array(control), unpack_columns(response), json.loads(details), control_name, pressure, tuple(in_pascal), tuple(said.get("turns", ())))
    return Failure(kind, reason, json.loads(details)) if state == "failed" else None


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
    with closing(Store(folder, _connect(path))) as store:
        return store.version() > 0


def _connect(path: Path, *, create: bool = False) -> sqlite3.Connection:
    uri = path.absolute().as_uri()
    try:
        # A reader needs to write too: it may have to roll back what a killed writer left.
        mode = "rwc" if create else "rw"
        connection = sqlite3.connect(f"{uri}?mode={mode}", uri=True, timeout=60, isolation_level=None, check_same_thread=False)
        connection.execute("PRAGMA synchronous = FULL")
        return connection
    except sqlite3.Error as error:
        raise FolderError.of(path, error, reading=not create) from error


def _as_json(data: Mapping[str, Any]) -> str:
    # What is no plain number is NumPy's.
    return json.dumps(dict(data), default=lambda number: number.item())


def as_stored(data: Mapping[str, Any]) -> dict[str, Any]:
    """Plain data as they come back from a store."""
    return json.loads(_as_json(data))


def _now() -> str:
    return datetime.now(timezone.utc).isoformat(timespec="milliseconds")
