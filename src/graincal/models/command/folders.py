"""A folder of its own for each attempt at an evaluation: where it lies, who may look into it, and which of them are kept."""

from __future__ import annotations

import os
import shutil
import tempfile
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from graincal.data import Failure, Response
from graincal.execution.scheduler import RETRIES

Keep = Literal["failed", "all", "none"]

MOST_KEPT = 100
"""Attempts whose folders are kept, the last of them."""

ATTEMPTS = 1 + RETRIES
"""Of one evaluation at the most, in one sitting."""

OUTCOME, PRINTED = "outcome.txt", "printed.txt"
"""What a kept folder says of its attempt, and the last that was printed in it."""


class NoScratch(Exception):
    """There is no place for an evaluation's files. The message says why, as a sentence."""


@dataclass(frozen=True)
class Folders:
    """Where evaluations keep their files: `root`/00042/attempt-0, or somewhere for a while where that is None. keep: which of these stay. scratch: a folder of the machine that an evaluation runs on, with $NAMES of its environment, where it
    runs instead; what its output is declared to be is brought back, where it is to be kept."""

    root: Path | None = None
    keep: Keep = "failed"
    scratch: str | None = None

    def begin(self, id: int) -> Attempt:
        """A folder for an attempt. Raises OSError, and NoScratch."""
        if self.root is not None and self.scratch is None:
            return Attempt(attempt := _attempt(self.root, id), attempt)
        # The machine may not see the campaign's folder, and then what it ran on its own disk leaves nothing.
        kept = _attempt(self.root, id) if self.root is not None and self.keep != "none" and self.root.is_dir() else None
        return Attempt(Path(tempfile.mkdtemp(prefix=f"graincal-{id}-", dir=self._scratch())), kept)

    def _scratch(self) -> Path | None:
        if self.scratch is None:
            return None
        path = os.path.expandvars(self.scratch)
        if "$" in path:
            raise NoScratch(f"scratch is {self.scratch}, and the machine's environment has no such name.")
        if not os.path.isdir(path):
            raise NoScratch(f"scratch is {path}, and there is no such folder on the machine.")
        return Path(path)

    def end(self, attempt: Attempt, outcome: Response | Failure, printed: str, output: Path | None) -> None:
        """Keep the folder of an attempt, or remove it. output: what it wrote, in its folder."""
        kept = attempt.kept if self.keep == "all" or (self.keep == "failed" and isinstance(outcome, Failure)) else None
        # A full disk loses what would be looked at, and no outcome.
        with suppress(OSError):
            if kept is not None:
                if attempt.folder != kept and output is not None and output.is_file():
                    (kept / output.relative_to(attempt.folder)).parent.mkdir(parents=True, exist_ok=True)
                    shutil.copyfile(output, kept / output.relative_to(attempt.folder))
                (kept / PRINTED).write_text(printed, encoding="utf-8", errors="replace")
                (kept / OUTCOME).write_text(f"{outcome.kind}: {outcome.reason}\n" if isinstance(outcome, Failure) else "finished\n", encoding="utf-8")
        if attempt.folder != kept:
            shutil.rmtree(attempt.folder, ignore_errors=True)
        if attempt.kept is not None:
            self._tidy(attempt.kept, keeps=kept is not None)

    def discard(self, attempt: Attempt) -> None:
        """Leave nothing of an attempt that nobody wanted to its end."""
        for folder in {attempt.folder, attempt.kept or attempt.folder}:
            _remove(folder)

    def _tidy(self, kept: Path, keeps: bool) -> None:
        """Remove an attempt that is not kept, or the oldest of too many that are."""
        if not keeps:
            _remove(kept)
        elif self.root is not None and len(os.listdir(self.root)) > MOST_KEPT / ATTEMPTS:
            ended = sorted(self.root.glob(f"*/attempt-*/{OUTCOME}"), key=_age)
            for outcome in ended[: max(0, len(ended) - MOST_KEPT)]:
                _remove(outcome.parent)

    def make_ready(self) -> None:
        """Make `root`, if there is one, or remove what attempts left in it that never came to their ends, for whoever controlled them was killed: only while nothing is under way. Raises OSError."""
        if self.root is None:
            return
        self.root.mkdir(mode=0o700, parents=True, exist_ok=True)
        for attempt in self.root.glob("*/attempt-*"):
            if not (attempt / OUTCOME).exists():
                _remove(attempt)


@dataclass(frozen=True)
class Attempt:
    """The folder that an attempt runs in, and the one that is kept of it; None for none."""

    folder: Path
    kept: Path | None


def _attempt(root: Path, id: int) -> Path:
    """The next that is not there yet: another process may begin one of the same evaluation, which it holds for lost."""
    for folder in (root, evaluation := root / f"{id:05}"):
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    number = 0
    while True:
        try:
            (attempt := evaluation / f"attempt-{number}").mkdir(mode=0o700)
            return attempt
        except FileExistsError:
            number += 1


def _remove(attempt: Path) -> None:
    shutil.rmtree(attempt, ignore_errors=True)
    if attempt.name.startswith("attempt-"):
        with suppress(OSError):
            # Others of the same evaluation may be there.
            attempt.parent.rmdir()


def _age(path: Path) -> float:
    try:
        return path.stat().st_mtime
    # Another process removed it meanwhile.
    except OSError:
        return 0.0
