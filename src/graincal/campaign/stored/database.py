"""The database beneath a store: its tables and their version, transactions, and what finds damage.

Each row has a checksum of its other columns, kept by triggers, and whoever reads it looks whether it is right: SQLite finds a page that is torn, and no bit that flipped in a number.
"""

from __future__ import annotations

import sqlite3
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar

from graincal.campaign.stored.trouble import FolderError
from graincal.data import InputError
from graincal.execution.interrupts import interrupts_later

NAME = "campaign.db"

VERSION, BEFORE = 5, 4
"""The format of the database, and the one that is brought up to it."""

TABLES = {
    "meta": ("key TEXT PRIMARY KEY", "value TEXT NOT NULL"),
    "sample": ("id INTEGER PRIMARY KEY", "iteration INTEGER NOT NULL", "theta TEXT NOT NULL"),
    "evaluation": (
        "sample INTEGER NOT NULL REFERENCES sample (id)", "experiment INTEGER NOT NULL", "state TEXT NOT NULL CHECK (state IN ('waiting', 'finished', 'failed'))", "attempts INTEGER NOT NULL",
        "ended TEXT", "seconds REAL", "details TEXT", "control BLOB", "response BLOB", "about TEXT", "kind TEXT", "reason TEXT",
    ),
    "iteration": (
        "id INTEGER PRIMARY KEY", "s REAL", "effective_sample_size REAL", "gl_error REAL", "unweighted TEXT NOT NULL", "weights BLOB NOT NULL", "errors BLOB NOT NULL", "observable_errors BLOB NOT NULL",
    ),
    "learnt": ("iteration INTEGER PRIMARY KEY", "figures TEXT NOT NULL"),
    "look": ("evaluations INTEGER PRIMARY KEY", "iteration INTEGER NOT NULL", "found BLOB NOT NULL"),
    "known": ("name TEXT PRIMARY KEY", "array BLOB NOT NULL"),
    "derived": ("name TEXT", "evaluations INTEGER", "array BLOB NOT NULL"),
}  # fmt: skip
"""theta and details are JSON; arrays are .npy (arrays.py). A response is kept on the states of its model, whatever the reference. An evaluation is "waiting" until it is "finished" (a response) or "failed" (a reason). One that
was stopped early is finished, with a response that is shorter, and its details say so. Samples below 0 are those of the study of packings (packings.py), and belong to no iteration."""

KEYS = {"evaluation": "sample, experiment", "derived": "name, evaluations"}
"""The primary keys of several columns."""

Result = TypeVar("Result")


class Database:
    """A connection, in a file or in memory (`path` None)."""

    def __init__(self, path: Path | None, *, create: bool = False) -> None:
        self.path = path
        try:
            if path is None:
                self._connection = sqlite3.connect(":memory:", isolation_level=None, check_same_thread=False)
            else:
                # A reader needs to write too: it may have to roll back what a killed writer left.
                mode = "rwc" if create else "rw"
                self._connection = sqlite3.connect(
                    f"{path.absolute().as_uri()}?mode={mode}", uri=True, timeout=60, isolation_level=None, check_same_thread=False
                )
                self._connection.execute("PRAGMA synchronous = FULL")
        except sqlite3.Error as error:
            raise FolderError.of(path or "memory", error, reading=not create) from error
        self._damaged = ""
        self._connection.create_function("checksum", -1, _checksum, deterministic=True)
        self._connection.create_function("sound", -1, self._sound, deterministic=True)

    def close(self) -> None:
        """Let go of the file."""
        self._connection.close()

    @property
    def version(self) -> int:
        """The format; 0 of an empty one."""
        return self.rows("PRAGMA user_version")[0][0]

    @contextmanager
    def created(self) -> Iterator[sqlite3.Connection]:
        """A transaction that begins with the tables, none of which is there."""
        with self.transaction() as db:
            for table, columns in TABLES.items():
                key = f", PRIMARY KEY ({KEYS[table]})" if table in KEYS else ""
                db.execute(f"CREATE TABLE {table} ({', '.join(columns)}, crc INTEGER{key})")
            db.execute("CREATE INDEX sample_by_iteration ON sample (iteration)")
            self._guard(db)
            yield db

    def bring_up(self) -> None:
        """Bring the format before this one up to it."""
        with self.transaction() as db:
            if db.execute("PRAGMA user_version").fetchone()[0] != BEFORE:
                return  # somebody else did
            for table in TABLES:
                db.execute(f"ALTER TABLE {table} ADD COLUMN crc INTEGER")
                db.execute(f"UPDATE {table} SET crc = checksum({', '.join(columns_of(table))})")
            self._guard(db)

    def rows(self, query: str, *arguments: Any) -> list[tuple]:
        """What a query finds. Raises FolderError where that cannot be read, or is damaged."""
        try:
            # SQLite makes an error of its own of Ctrl-C in a function that it calls.
            with interrupts_later():
                return self._connection.execute(query, arguments).fetchall()
        except sqlite3.Error as error:
            if self._damaged:
                raise damaged(self.path, f"a row of {self._damaged} is not what was written") from error
            raise FolderError.of(self._named, error, reading=True) from error

    @contextmanager
    def transaction(self) -> Iterator[sqlite3.Connection]:
        """All of it, on disk at its end, or nothing."""
        try:
            with interrupts_later():
                self._connection.execute("BEGIN IMMEDIATE")
                yield self._connection
                self._connection.execute("COMMIT")
        except BaseException as error:
            if self._connection.in_transaction:
                self._connection.rollback()
            if isinstance(error, sqlite3.Error):
                raise FolderError.of(self._named, error) from error
            raise

    @property
    def _named(self) -> Path | str:
        return self.path or "the store in memory"

    def _guard(self, db: sqlite3.Connection) -> None:
        for table in TABLES:
            names = columns_of(table)
            key = (KEYS.get(table) or names[0]).split(", ")
            here = " AND ".join(f"{name} = NEW.{name}" for name in key)
            update = f"UPDATE {table} SET crc = checksum({', '.join(names)}) WHERE {here}"
            db.execute(f"CREATE TRIGGER {table}_inserted AFTER INSERT ON {table} BEGIN {update}; END")
            db.execute(f"CREATE TRIGGER {table}_updated AFTER UPDATE OF {', '.join(names)} ON {table} BEGIN {update}; END")
        db.execute(f"PRAGMA user_version = {VERSION}")

    def _sound(self, table: str, crc: int | None, *values: Any) -> int:
        if crc != _checksum(*values):
            self._damaged = table
            raise ValueError
        return 1


def columns_of(table: str) -> tuple[str, ...]:
    """The names of a table's columns, but for the checksum."""
    return tuple(column.split()[0] for column in TABLES[table])


def sound(table: str) -> str:
    """A condition of a query, that holds for rows that are what was written, and breaks it off at one that is not."""
    return f"sound('{table}', {table}.crc, {', '.join(f'{table}.{name}' for name in columns_of(table))})"


def damaged(path: Path | None, what: str) -> FolderError:
    """What to say of a store that does not hold what was written."""
    return FolderError(f"{path}: this store of a campaign is damaged ({what}): take a copy of it that is whole, or calibrate again.")


def damage_is_said(read: Callable[..., Result]) -> Callable[..., Result]:
    """A method of a store that reads: what it cannot make sense of is said in one sentence that names the file."""

    @wraps(read)
    def reading(self: Any, *arguments: Any, **options: Any) -> Result:
        with said_of_damage(self.database.path):
            return read(self, *arguments, **options)

    return reading


@contextmanager
def said_of_damage(path: Path | None) -> Iterator[None]:
    """What no sense can be made of in reading a store is said in one sentence that names its file."""
    try:
        yield
    except InputError:
        raise
    except (ValueError, KeyError, IndexError, TypeError, AttributeError, EOFError, OSError, zlib.error) as error:
        raise damaged(path, f"{type(error).__name__} in reading it") from error


def _checksum(*values: Any) -> int:
    """Of values as SQLite holds them: text, bytes, numbers, and nothing."""
    crc = 0
    for value in values:
        data = value if isinstance(value, bytes) else repr(value).encode("utf-8", "surrogatepass")
        crc = zlib.crc32(data, zlib.crc32(type(value).__name__.encode(), crc))
    return crc
