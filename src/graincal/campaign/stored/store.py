"""DIR/campaign.db: everything a campaign knows, in SQLite. One process writes; any number read meanwhile.

Every change is one transaction on disk before the next thing happens, so that killing the process at any instant loses only what was under way.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from contextlib import closing, suppress
from importlib.metadata import version
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.asked.calibration import Calibration
from graincal.campaign.asked.description import describe, describe_stop
from graincal.campaign.asked.doubt import Doubt
from graincal.campaign.stored.arrays import pack_array, unpack_array
from graincal.campaign.stored.asked import ACCEPTED, LIBRARY, OUT_OF_TIME, POINTS, as_json_text, known_arrays, now
from graincal.campaign.stored.database import BEFORE, NAME, VERSION, Database, columns_of, damage_is_said, sound
from graincal.campaign.stored.evaluated import STOPPED, StoredEvaluations
from graincal.campaign.stored.learnt import Learnt
from graincal.campaign.stored.log import is_running
from graincal.campaign.stored.looks import pack_look, unpack_look
from graincal.campaign.stored.provenance import provenance
from graincal.campaign.stored.trouble import FolderError
from graincal.data import InputError
from graincal.inference import Iteration, Stop
from graincal.inference.posterior.emulation import Found

LOOK = "first_look"
"""The folder within a campaign's that holds the campaign of its first look."""


class Store(StoredEvaluations):
    """The database of a campaign. `folder` is None for one in memory, which ends with the object."""

    @classmethod
    def create(
        cls,
        calibration: Calibration,
        folder: Path | None = None,
        *,
        library: int | None = None,
        points: NDArray[np.float64] | None = None,
        accepted: Sequence[Doubt] = (),
    ) -> Store:
        """A new store for a calibration, in a folder or in memory. The folder must hold no campaign (`holds_campaign`). library: of so many runs for no reference; points (N, n): at these
        parameters. accepted: problems in spite of which it is begun."""
        store = cls(folder, Database(folder / NAME if folder else None, create=True))
        meta = {
            "description": as_json_text(describe(calibration)),
            "workers": json.dumps(calibration.workers),
            "place": json.dumps(calibration.place and calibration.place.as_json()),
            "source": calibration.source,
            "file": calibration.file,
            "truth": as_json_text(calibration.truth),
            "provenance": json.dumps(provenance()),
            "started": now(),
        } | ({} if library is None else {LIBRARY: str(library)})
        if points is not None:
            meta[POINTS] = json.dumps(points.tolist())
        if accepted:
            meta[ACCEPTED] = json.dumps([doubt.as_json() for doubt in accepted], ensure_ascii=False)
        with store.database.created() as db:
            db.executemany("INSERT INTO meta (key, value) VALUES (?, ?)", meta.items())
            db.executemany("INSERT INTO known (name, array) VALUES (?, ?)", known_arrays(calibration.known).items())
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
                raise InputError(
                    f"{folder / NAME}: this campaign was stored by {by}, and graincal {version('graincal')} reads formats up to {VERSION}: a later version of graincal was expected to read it."
                )
            raise InputError(
                f"{folder / NAME}: this campaign was stored by {by}, and graincal {version('graincal')} reads the formats {BEFORE} and {VERSION} alone: calibrate again, in another folder."
            )
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

    def complete(self, iteration: Iteration, learnt: Learnt | None = None, looks: Sequence[Found] = ()) -> None:
        """Keep what an iteration found, what was learnt of the posterior by it and what looks at the evaluations found, unless it is kept already."""
        numbers = [float(value) for value in (iteration.s, iteration.effective_sample_size, iteration.gl_error)]
        arrays = [pack_array(array) for array in (iteration.weights, iteration.errors, iteration.observable_errors)]
        with self._transaction() as db:
            # SQLite keeps NaN as NULL.
            db.execute(
                f"INSERT OR IGNORE INTO iteration ({', '.join(columns_of('iteration'))}) VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
                (iteration.index, *numbers, iteration.unweighted, *arrays),
            )
            if learnt:
                db.execute("INSERT OR IGNORE INTO learnt (iteration, figures) VALUES (?, ?)", (iteration.index, json.dumps(learnt.plain())))
            for found in looks:
                db.execute(
                    "INSERT OR IGNORE INTO look (evaluations, iteration, found) VALUES (?, ?, ?)", (len(found.weights), iteration.index, pack_look(found))
                )

    @damage_is_said
    def iterations(self) -> tuple[Iteration, ...]:
        """The iterations that are complete; their proposals are not kept."""
        return tuple(
            self._iteration(*row) for row in self._rows(f"SELECT {', '.join(columns_of('iteration'))} FROM iteration WHERE {sound('iteration')} ORDER BY id")
        )

    @damage_is_said
    def learnt(self) -> tuple[Learnt, ...]:
        """What was learnt of the posterior by each of the iterations that are complete; nothing by methods without one."""
        return tuple(Learnt.restore(json.loads(figures)) for (figures,) in self._rows(f"SELECT figures FROM learnt WHERE {sound('learnt')} ORDER BY iteration"))

    @damage_is_said
    def look(self, evaluations: int | None = None) -> Found | None:
        """What was found by a look at so many evaluations, or by the last one; None where none was taken."""
        chosen, arguments = (
            (f"WHERE {sound('look')} ORDER BY evaluations DESC LIMIT 1", ())
            if evaluations is None
            else (f"WHERE evaluations = ? AND {sound('look')}", (evaluations,))
        )
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
        meta = {"description": as_json_text(self.description | {"stop": describe_stop(self.description["method"], stop)})}
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

    def _iteration(self, index: int, s: float, size: float, gl_error: float, unweighted: str, *blobs: bytes) -> Iteration:
        weights, errors, observable_errors = map(unpack_array, blobs)
        s, size, gl_error = (np.nan if value is None else value for value in (s, size, gl_error))
        samples = self.samples(index)
        if not isinstance(unweighted, str) or any(count != len(samples) for count in (weights.shape[-1], len(errors), len(observable_errors))):
            raise ValueError("an iteration has other samples than figures")
        query = f"SELECT DISTINCT sample FROM evaluation JOIN sample ON sample.id = sample WHERE iteration = ? AND {STOPPED}"
        stopped = np.isin(samples.ids, [id for (id,) in self._rows(query, index)])
        # Only a failure has no error.
        return Iteration(index, samples, None, np.isnan(errors), observable_errors, errors, weights, s, size, gl_error, unweighted, stopped)


def holds_campaign(folder: Path) -> bool:
    """Whether there is a campaign in a folder; what is left of a beginning that was cut short is none."""
    path = folder / NAME
    if not path.is_file():
        return False
    with closing(Database(path)) as database:
        return database.version > 0
