"""What was asked, as a store keeps it."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Mapping
from contextlib import AbstractContextManager
from datetime import UTC, datetime
from functools import cached_property
from pathlib import Path
from typing import Any

from graincal.campaign.asked.calibration import Calibration
from graincal.campaign.asked.description import describe, describe_first_look, restore
from graincal.campaign.asked.doubt import Doubt
from graincal.campaign.asked.place import Place
from graincal.campaign.stored.arrays import pack_array, unpack_array
from graincal.campaign.stored.database import Database, damage_is_said, sound
from graincal.inference.driving.known_runs import KnownRuns
from graincal.inference.posterior.first_look import FirstLook

LIBRARY = "library"
"""The key under which a store of runs for no reference keeps how many there are to be."""

POINTS = "points"
"""The key under which a library keeps the parameters that its runs are to have, where somebody chose them."""

ACCEPTED = "accepted"
"""The key under which a store keeps the problems in spite of which its campaign was begun."""

OUT_OF_TIME, SPENT = "out of time", "seconds spent"
"""The keys under which a store keeps the iteration that was the last within the limit in time, and the wall time of all sittings so far."""

SITTING = "sitting"
"""The key under which a store keeps when its last sitting began, and what was expected then."""


class StoredCalibration:
    """The part of a store that says what was asked, and texts that are kept once."""

    def __init__(self, folder: Path | None, database: Database) -> None:
        self.folder = folder
        self.database = database

    def close(self) -> None:
        """Let go of the file."""
        self.database.close()

    @cached_property
    @damage_is_said
    def description(self) -> dict[str, Any]:
        """The calibration as plain data (description.py)."""
        return json.loads(self._begun_with("description"))

    @cached_property
    @damage_is_said
    def calibration(self) -> Calibration:
        """The calibration, with models as far as they can be found again."""
        truth = json.loads(self._begun_with("truth"))
        # A store of a version before says none.
        place = json.loads(self.meta("place") or "null")
        others = {
            "workers": json.loads(self._begun_with("workers")),
            "place": place and Place(**place),
            "source": self.meta("source"),
            "truth": truth,
            "file": self.meta("file"),
        }
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
        return json.loads(self._begun_with("provenance"))

    def meta(self, key: str) -> str | None:
        """A text that is kept once: "started" (time), "source", "stopped_by", "stopped_because"; None if it is not there."""
        rows = self._rows(f"SELECT value FROM meta WHERE key = ? AND {sound('meta')}", key)
        return rows[0][0] if rows else None

    def _begun_with(self, key: str) -> str:
        """A text that is kept from the beginning. Raises KeyError for a store without it, which is damaged."""
        if (text := self.meta(key)) is None:
            raise KeyError(key)
        return text

    def keep(self, key: str, text: str) -> None:
        """Keep a text once (`meta`)."""
        with self._transaction() as db:
            db.execute("INSERT OR IGNORE INTO meta (key, value) VALUES (?, ?)", (key, text))

    def spend(self, seconds: float) -> None:
        """Keep how much wall time all sittings have taken."""
        with self._transaction() as db:
            db.execute("INSERT OR REPLACE INTO meta (key, value) VALUES (?, ?)", (SPENT, f"{seconds:.3f}"))

    def expect(self, evaluations: int | None, at_most: int | None, seconds: float | None) -> None:
        """Keep what a sitting that begins now is expected to come to, in the place of the last (`Listener.expects`)."""
        text = json.dumps({"began": now(), "evaluations": evaluations, "at_most": at_most, "seconds": seconds})
        with self._transaction() as db:
            db.execute("INSERT OR REPLACE INTO meta (key, value) VALUES (?, ?)", (SITTING, text))

    def sitting(self) -> dict[str, Any] | None:
        """{began (ISO 8601), evaluations, at_most, seconds} of the last sitting (`expect`); None where a version before did not keep it."""
        text = self.meta(SITTING)
        return None if text is None else json.loads(text)

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
            db.execute("INSERT OR REPLACE INTO meta (key, value) VALUES ('description', ?)", (as_json_text(description),))
        self._forget()

    def _forget(self) -> None:
        """Read again what was asked for."""
        for known in ("description", "calibration"):
            self.__dict__.pop(known, None)

    def _rows(self, query: str, *arguments: Any) -> list[tuple]:
        return self.database.rows(query, *arguments)

    def _transaction(self) -> AbstractContextManager[sqlite3.Connection]:
        return self.database.transaction()


def known_arrays(runs: KnownRuns | None) -> dict[str, bytes]:
    """What a store keeps of runs that were made before."""
    if runs is None:
        return {}
    arrays = {"theta": runs.theta, "infeasible": runs.infeasible, "missing": runs.missing} | {
        f"responses {number}": responses for number, responses in enumerate(runs.responses)
    }
    return {name: pack_array(array) for name, array in arrays.items()}


def _without_sources(description: dict[str, Any]) -> dict[str, Any]:
    """A description without what is said of the runs that were known before, which are known by their numbers."""
    if "known" not in description:
        return description
    return description | {"known": {key: value for key, value in description["known"].items() if key != "sources"}}


def as_json_text(data: Mapping[str, Any]) -> str:
    # What is no plain number is NumPy's.
    return json.dumps(dict(data), default=lambda number: number.item())


def as_stored(data: Mapping[str, Any]) -> dict[str, Any]:
    """Plain data as they come back from a store."""
    return json.loads(as_json_text(data))


def now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")
