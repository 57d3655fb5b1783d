"""What is to be seen of a campaign at this moment: written by those who follow it, read by the streams."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from graincal.notation.printable import printable_json

MOST_STREAMS = 16
"""Pages that follow at once."""


class Full(Exception):
    """As many pages follow as may."""


class Board:
    """The latest of each kind of news, as JSON."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._news: dict[str, tuple[int, str]] = {}
        self._version = self._streams = 0
        self.ended = False

    def put(self, kind: str, value: Any) -> None:
        """Put news in the place of the last of their kind."""
        text = printable_json(value, separators=(",", ":"))
        with self._changed:
            if self._news.get(kind, (0, ""))[1] != text:
                self._version += 1
                self._news[kind] = (self._version, text)
                self._changed.notify_all()

    def forget(self, kind: str) -> None:
        """Take away all news of kinds that begin so: they are of something else than what is to be seen now."""
        with self._changed:
            self._news = {each: news for each, news in self._news.items() if not each.startswith(kind)}

    def since(self, version: int, timeout: float) -> tuple[int, list[tuple[str, str]]]:
        """(version, [(kind, JSON)]): what is newer than a version, waited for so many seconds at most."""
        with self._changed:
            self._changed.wait_for(lambda: self._version > version or self.ended, timeout)
            return self._version, [(kind, text) for kind, (at, text) in self._news.items() if at > version]

    @contextmanager
    def stream(self) -> Iterator[None]:
        """A page follows meanwhile. Raises Full."""
        with self._changed:
            if self._streams >= MOST_STREAMS:
                raise Full
            self._streams += 1
            self._changed.notify_all()
        try:
            yield
        finally:
            with self._changed:
                self._streams -= 1

    def wait_for_streams(self) -> None:
        """Return when a page follows, or at the end: while nobody looks, nothing is to be read or drawn."""
        with self._changed:
            self._changed.wait_for(lambda: self._streams > 0 or self.ended)

    def end(self) -> None:
        """Let all who wait go."""
        with self._changed:
            self.ended = True
            self._changed.notify_all()
