"""A program that is run to its end, by a keeper: a small process that ends it, and all that it starts, however this process ends."""

from __future__ import annotations

import atexit
import errno
import json
import os
import select
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

_KEEPER = Path(__file__).with_name("keeper.py")

HEARS = 0.2
"""Seconds within which a run is stopped."""
PATIENCE = 12.0
"""Seconds that a keeper has to end all that it keeps."""


@dataclass(frozen=True)
class Program:
    """What is run: `command` with the environment `environment`, in `folder`. output: the file that takes what it prints, None for keeping the last of it. time_limit: seconds. memory: bytes that it and all that it starts may hold."""

    command: Sequence[str]
    folder: Path
    environment: Mapping[str, str]
    time_limit: float
    memory: float | None = None
    output: Path | None = None


@dataclass(frozen=True)
class Ended:
    """How a program ended. code: of its exit, or minus the signal that ended it. printed: the last 64 KiB, without what `output` took. because: why it was not started."""

    how: Literal["exit", "timed_out", "out_of_memory", "not_started", "lost", "stopped"]
    code: int | None = None
    printed: str = ""
    because: str = ""
    seconds: float = 0.0


def run(program: Program, stopped: Callable[[], bool] = lambda: False) -> Ended:
    """Run a program, and kill what is left of it when it has ended. stopped: asked several times a second whether to end it at once."""
    begun, keeper = time.monotonic(), _borrowed()
    try:
        keeper.ask(program)
        while (answer := keeper.answer(HEARS)) is None:
            if stopped():
                keeper.end()
                return Ended("stopped", seconds=time.monotonic() - begun)
    except (OSError, EOFError):
        # The keeper was killed: it takes its program along, and here ends what that started.
        keeper.end()
        return Ended("lost", because="the process that kept the program was killed", seconds=time.monotonic() - begun)
    except BaseException:
        keeper.end()
        raise
    _give_back(keeper)
    seconds = time.monotonic() - begun
    if "not_started" in answer:
        return Ended("not_started", because=_why(program, answer), seconds=seconds)
    return Ended(answer["ended"], answer["code"], answer["printed"], seconds=seconds)


def _why(program: Program, answer: Mapping[str, Any]) -> str:
    """Why a program could not be started, as a sentence."""
    name, path = program.command[0], program.environment.get("PATH", os.defpath)
    if answer["errno"] != errno.ENOENT:
        return f"the program {name} could not be started ({answer['not_started']}); PATH is {path}."
    if name.startswith("/"):
        return f"there is no program {name}, or the one that its first line names is missing."
    if "/" in name:
        return f"there is no program {name} in the evaluation's folder, or the one that its first line names is missing: link puts a file there."
    return f"there is no program {name} in PATH, which is {path}."


class _Keeper:
    """A keeper, from its owner's side."""

    def __init__(self) -> None:
        # A session of its own: a terminal's signals are its owner's affair.
        self._process = subprocess.Popen(
            [sys.executable, "-I", "-S", str(_KEEPER)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
            bufsize=0,
        )
        self._group: int | None = None
        self._buffer = b""
        self._poll = select.poll()
        assert self._process.stdin is not None and self._process.stdout is not None, "both are pipes"
        self._in, self._out = self._process.stdin, self._process.stdout
        self._poll.register(self._out, select.POLLIN)

    def ask(self, program: Program) -> None:
        """Have a program run. Raises OSError where the keeper is gone."""
        request = {
            "command": list(program.command),
            "folder": str(program.folder),
            "environment": dict(program.environment),
            "time_limit": program.time_limit,
            "memory": program.memory,
            "output": None if program.output is None else str(program.output),
        }
        line = json.dumps(request).encode() + b"\n"
        while line:
            line = line[os.write(self._in.fileno(), line) :]

    def answer(self, seconds: float) -> dict[str, Any] | None:
        """How a program ended; None where it has not yet. Raises EOFError where the keeper is gone."""
        until = time.monotonic() + seconds
        while True:
            line, found, rest = self._buffer.partition(b"\n")
            if found:
                self._buffer = rest
                answer = json.loads(line)
                if "started" not in answer:
                    self._group = None
                    return answer
                self._group = answer["started"]
            elif not self._poll.poll(max(0.0, 1000 * (until - time.monotonic()))):
                return None
            elif more := os.read(self._out.fileno(), 1 << 16):
                self._buffer += more
            else:
                raise EOFError

    def end(self) -> None:
        """End the keeper, which ends all that it keeps."""
        with suppress(OSError):
            self._in.close()
        try:
            self._process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        if self._group is not None and self._process.returncode != 0:
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self._group, signal.SIGKILL)
        self._out.close()
        with _lock:
            _all.discard(self)

    def forget(self) -> None:
        """In a fork: the keeper is another's, and ends with that one alone."""
        for stream in (self._in, self._out):
            with suppress(OSError):
                os.close(stream.fileno())


_lock = threading.Lock()
_idle: list[_Keeper] = []
_all: set[_Keeper] = set()
"""The keepers of this process: to start one takes some hundredths of a second."""


def _borrowed() -> _Keeper:
    with _lock:
        if _idle:
            return _idle.pop()
    keeper = _Keeper()
    with _lock:
        _all.add(keeper)
    return keeper


def _give_back(keeper: _Keeper) -> None:
    with _lock:
        _idle.append(keeper)


@atexit.register
def _end_idle() -> None:
    with _lock:
        idle, _idle[:] = list(_idle), []
    for keeper in idle:
        keeper.end()


def _forget_all() -> None:
    global _lock
    _lock = threading.Lock()
    for keeper in _all:
        keeper.forget()
    _all.clear()
    _idle.clear()


os.register_at_fork(after_in_child=_forget_all)
