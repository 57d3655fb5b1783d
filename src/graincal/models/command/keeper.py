"""Runs programs for one owner, one at a time, and leaves nothing of them behind: a process of its own, `python -I -S keeper.py`, that knows nothing but Python's own library.

Requests come as lines of JSON from standard input, answers go to standard output: {"started": pid}, then {"ended": how, "code": exit code or minus a signal, "printed": text}; or {"not_started": why}. Whatever a program starts becomes
a child of this process when its parent ends, and is killed when the program has ended. When the owner ends, however it does, standard input is at its end: then all is killed.
"""

from __future__ import annotations

import ctypes
import json
import os
import select
import signal
import subprocess
import sys
import time
from typing import IO, Any

SET_CHILD_SUBREAPER, SET_PDEATHSIG = 36, 1
TAIL = 64 * 1024
"""Bytes of what is printed that are kept."""
LARGEST_PRINTED = 256 * 2**20
"""Bytes of standard output that are kept where it is the declared output; what is more fills no disk."""
GRACE, LOOK = 2.0, 0.05
"""Seconds between being asked to end and being killed, and from one look at the memory to the next."""
PAGE = os.sysconf("SC_PAGE_SIZE")

_prctl = ctypes.CDLL(None, use_errno=True).prctl


class OwnerIsGone(Exception):
    """Nobody wants this program any more."""


class Keeper:
    """One program after the other."""

    def __init__(self) -> None:
        _prctl(SET_CHILD_SUBREAPER, 1, 0, 0, 0)
        self.wake, woken = os.pipe()
        for end in (self.wake, woken):
            os.set_blocking(end, False)
        signal.set_wakeup_fd(woken, warn_on_full_buffer=False)
        self.asked_to_end = False
        signal.signal(signal.SIGCHLD, lambda *_: None)
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
            signal.signal(number, self._asked)
        self.poll = select.poll()
        self.poll.register(0, select.POLLIN)
        self.poll.register(self.wake, select.POLLIN)
        self.buffer = b""

    def _asked(self, *_: object) -> None:
        self.asked_to_end = True

    def serve(self) -> None:
        """Until the owner is gone."""
        try:
            while True:
                self._run(self._request())
        except OwnerIsGone:
            pass

    def _request(self) -> dict[str, Any]:
        while b"\n" not in self.buffer:
            self._wait(None)
        line, _, self.buffer = self.buffer.partition(b"\n")
        return json.loads(line)

    def _wait(self, seconds: float | None) -> None:
        """Wait for something to happen. Raises OwnerIsGone."""
        ready = dict(self.poll.poll(None if seconds is None else max(0, 1000 * seconds)))
        if self.asked_to_end:
            raise OwnerIsGone
        if self.wake in ready:
            while _read(self.wake):
                pass
        if 0 in ready:
            found = os.read(0, 1 << 16)
            if not found:
                raise OwnerIsGone
            self.buffer += found

    def _run(self, request: dict[str, Any]) -> None:
        run = Run(request)
        try:
            pid = run.start()
        except OSError as error:
            _answer({"not_started": error.strerror or str(error), "errno": error.errno})
            return
        _answer({"started": pid})
        for pipe in run.pipes:
            self.poll.register(pipe, select.POLLIN)
        try:
            while not run.has_ended():
                self._wait(run.until_next_look())
                for pipe in list(run.pipes):
                    if not run.take(pipe):
                        self.poll.unregister(pipe)
                        run.close(pipe)
        finally:
            for pipe in run.pipes:
                self.poll.unregister(pipe)
            run.kill_all()
            run.finish()
        _answer({"ended": run.how, "code": run.code, "printed": run.printed.decode("utf-8", "replace")})


class Run:
    """One program under way."""

    def __init__(self, request: dict[str, Any]) -> None:
        self.request = request
        self.how, self.printed = "exit", b""
        self.code: int | None = None
        self.pipes: dict[int, IO[bytes]] = {}
        self.written = 0
        self.killed_at: float | None = None
        self.file: IO[bytes] | None = None
        self.process: subprocess.Popen[bytes]

    def start(self) -> int:
        """Begin, and return the process's number. Raises OSError."""
        request = self.request
        declared = request["output"] is not None
        if declared:
            self.file = open(request["output"], "wb")
        try:
            self.process = subprocess.Popen(
                request["command"], cwd=request["folder"], env=request["environment"], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                stderr=subprocess.PIPE if declared else subprocess.STDOUT, process_group=0, preexec_fn=_end_with_parent,
            )  # fmt: skip
        except BaseException:
            if self.file is not None:
                self.file.close()
            raise
        self.begun = time.monotonic()
        self.deadline = self.begun + request["time_limit"]
        self.pid = self.process.pid
        for stream in filter(None, (self.process.stdout, self.process.stderr)):
            os.set_blocking(stream.fileno(), False)
            self.pipes[stream.fileno()] = stream
        return self.pid

    def has_ended(self) -> bool:
        """Whether the program itself has; what it takes too much of ends it."""
        now = time.monotonic()
        if self.killed_at is None and now >= self.deadline:
            self.how, self.killed_at = "timed_out", now + GRACE
            self._signal(signal.SIGTERM)
        elif self.killed_at is not None and now >= self.killed_at:
            self.killed_at = float("inf")
            self.kill_all(wait=False)
        elif self.request["memory"] and self.killed_at is None and resident() > self.request["memory"]:
            self.how, self.killed_at = "out_of_memory", float("inf")
            self.kill_all(wait=False)
        self._reap()
        return self.code is not None

    def until_next_look(self) -> float | None:
        """Seconds, None for no need to look."""
        next_time = self.deadline if self.killed_at is None else self.killed_at
        if self.request["memory"]:
            next_time = min(next_time, time.monotonic() + LOOK)
        return None if next_time == float("inf") else max(0.0, next_time - time.monotonic())

    def take(self, pipe: int) -> bool:
        """Take what was printed; whether there may be more."""
        found = _read(pipe)
        if found is None:
            return True
        if self.file is not None and self.pipes[pipe] is self.process.stdout:
            self.file.write(found[: max(0, LARGEST_PRINTED + 1 - self.written)])
            self.written += len(found)
        else:
            self.printed = (self.printed + found)[-TAIL:]
        return bool(found)

    def close(self, pipe: int) -> None:
        self.pipes.pop(pipe).close()

    def finish(self) -> None:
        """Take what is left in the pipes."""
        for pipe in list(self.pipes):
            # What was killed prints no more: what is there ends.
            while _waits(pipe) and self.take(pipe):
                pass
            self.close(pipe)
        if self.file is not None:
            self.file.close()

    def kill_all(self, wait: bool = True) -> None:
        """Kill whatever is left of the program, its group first, which is one call however fast it forks."""
        end = time.monotonic() + 10
        self._signal(signal.SIGKILL)
        while True:
            for pid in descendants(os.getpid()):
                try:
                    os.kill(pid, signal.SIGKILL)
                except ProcessLookupError:
                    pass
            if self._reap() or not wait or time.monotonic() > end:
                return
            time.sleep(0.001)

    def _signal(self, number: int) -> None:
        # The group's number may be another's, once the program and all of its group are gone.
        if self.code is None:
            try:
                os.killpg(self.pid, number)
            except (ProcessLookupError, PermissionError):
                pass

    def _reap(self) -> bool:
        """Note who has ended; whether nobody is left."""
        try:
            while (found := os.waitpid(-1, os.WNOHANG))[0]:
                if found[0] == self.pid:
                    self.code = self.process.returncode = os.waitstatus_to_exitcode(found[1])
        except ChildProcessError:
            return True
        return False


def descendants(pid: int) -> list[int]:
    """All processes beneath one."""
    found: list[int] = []
    waiting = [pid]
    while waiting:
        beneath = children(waiting.pop())
        found += beneath
        waiting += beneath
    return found


def children(pid: int) -> list[int]:
    """Those of all threads of a process."""
    found: list[int] = []
    try:
        for thread in os.listdir(f"/proc/{pid}/task"):
            with open(f"/proc/{pid}/task/{thread}/children") as file:
                found += map(int, file.read().split())
    except FileNotFoundError:
        if not os.path.exists(f"/proc/{os.getpid()}/task/{os.getpid()}/children"):
            return _children_by_parents(pid)
    except (OSError, ProcessLookupError):
        pass
    return found


def _children_by_parents(pid: int) -> list[int]:
    """As `children`, for kernels that keep no lists of them."""
    found = []
    for name in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{name}/stat") as file:
                if int(file.read().rpartition(")")[2].split()[1]) == pid:
                    found.append(int(name))
        except OSError:
            pass
    return found


def resident() -> int:
    """Bytes of memory that all programs beneath this process hold."""
    total = 0
    for pid in descendants(os.getpid()):
        try:
            with open(f"/proc/{pid}/statm") as file:
                total += PAGE * int(file.read().split()[1])
        except (OSError, IndexError):
            pass
    return total


def _end_with_parent() -> None:
    _prctl(SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)


def _read(pipe: int) -> bytes | None:
    """What is there; None for nothing yet, b"" at the end."""
    try:
        return os.read(pipe, 1 << 20)
    except BlockingIOError:
        return None


def _waits(pipe: int) -> bool:
    poll = select.poll()
    poll.register(pipe, select.POLLIN)
    return any(event & select.POLLIN for _, event in poll.poll(0))


def _answer(said: dict[str, Any]) -> None:
    try:
        sys.stdout.write(json.dumps(said) + "\n")
        sys.stdout.flush()
    except OSError:
        raise OwnerIsGone from None


if __name__ == "__main__":
    Keeper().serve()
