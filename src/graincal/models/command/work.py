"""Evaluations of somebody's program."""

from __future__ import annotations

import hashlib
import os
import re
import signal
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from graincal.data import Failure, Response
from graincal.execution import LOST, Watch
from graincal.models.command import program
from graincal.models.command.folders import Folders, NoScratch
from graincal.models.command.inputs import Given, Inputs
from graincal.models.output import STANDARD_OUTPUT, Output

Argument = tuple[int, tuple[float, ...]]
"""A sample: its id, and its parameters (n,)."""

PRINTED_OUTPUT = "standard-output.txt"
"""The file that takes what is printed, where that is the declared output."""

PRINTED_LAST = " It printed last: "
"""What stands before the last line that a program printed, in the reason of its failure."""

COLOURS = re.compile("\x1b\\[[0-9;]*m")
"""What programs print to colour a terminal."""


@dataclass(frozen=True)
class Limits:
    """What a program may take, and what its exit codes mean. time_limit: seconds. memory: bytes, of it and of all that it starts."""

    time_limit: float = 86_400.0
    memory: float | None = None
    success_exit_codes: tuple[int, ...] = (0,)
    retry_exit_codes: tuple[int, ...] = ()
    infeasible_exit_codes: tuple[int, ...] = ()


@dataclass(frozen=True, eq=False)
class CommandWork:
    """A program, the parameters that it is given by their names, and the output that is read at the control values `at` (T,).

    It can be sent to another process, and needs nothing of the one that made it. It waits on a thread, for the program is a process of its own.
    """

    inputs: Inputs
    output: Output
    parameters: tuple[str, ...]
    control: str
    at: NDArray[np.float64]
    limits: Limits = Limits()
    folders: Folders = Folders()
    executor: Executor | None = None
    own_process: bool = field(default=False, init=False)

    @property
    def key(self) -> str:
        """The same for the same work."""
        told = (self.inputs, self.output, self.parameters, self.control, self.at.tolist(), self.limits, self.folders)
        return f"command {hashlib.sha256(repr(told).encode('utf-8', 'surrogatepass')).hexdigest()}"

    @property
    def timeout(self) -> float:
        """Seconds that an evaluation may take."""
        return self.limits.time_limit

    def prepare(self) -> None:
        """Nothing has to be."""

    def __call__(self, argument: Argument) -> Response | Failure:
        return self.run(argument, lambda: False, None)

    def run(self, argument: Argument, stopped: Callable[[], bool], watch: Watch | None) -> Response | Failure:
        """An evaluation: its inputs, the program in a folder of its own, and what it wrote."""
        id, theta = argument
        given = self.given(theta)
        if isinstance(given, Failure):
            return given
        try:
            attempt = self.folders.begin(id)
        except NoScratch as error:
            return Failure("not_started", str(error))
        except OSError as error:
            return Failure(LOST, f"there is no folder for the evaluation ({error}).")
        try:
            given.put(attempt.folder)
            ended = program.run(self._program(given, attempt.folder), stopped)
            outcome, printed = self._outcome(ended, attempt.folder), ended.printed
        except OSError as error:
            outcome, printed = Failure(LOST, f"the files of the evaluation cannot be written or read ({error})."), ""
        except BaseException:
            self.folders.discard(attempt)
            raise
        if stopped():
            self.folders.discard(attempt)
        else:
            self.folders.end(attempt, outcome, printed, self._written(attempt.folder))
        return outcome

    def given(self, theta: tuple[float, ...]) -> Given | Failure:
        """The inputs of a sample."""
        values = self.inputs.values(dict(zip(self.parameters, theta, strict=True)))
        return values if isinstance(values, Failure) else self.inputs.given(values)

    def __getstate__(self) -> dict:
        # An executor stays where it is.
        return {**self.__dict__, "executor": None}

    def _program(self, given: Given, folder: Path) -> program.Program:
        printed = folder / PRINTED_OUTPUT if self.output.file == STANDARD_OUTPUT else None
        return program.Program(given.command, folder, {**os.environ, **given.environment}, self.limits.time_limit, self.limits.memory, printed)

    def _written(self, folder: Path) -> Path:
        return folder / (PRINTED_OUTPUT if self.output.file == STANDARD_OUTPUT else self.output.file)

    def _outcome(self, ended: program.Ended, folder: Path) -> Response | Failure:
        """What a program came to."""
        details = {"seconds": ended.seconds}
        if ended.code is not None:
            details["exit_code"] = float(ended.code)
        failure = self._failure(ended)
        found = failure or self._read(folder)
        if isinstance(found, Failure):
            return Failure(found.kind, f"{found.reason}{_last_line(ended.printed)}", {**details, **found.details})
        return replace(found, details={**details, **found.details})

    def _failure(self, ended: program.Ended) -> Failure | None:
        """Why a program came to nothing; None where it came to its end."""
        code, limits = ended.code, self.limits
        match ended.how:
            case "not_started":
                return Failure("not_started", ended.because)
            case "timed_out":
                return Failure("timed_out", f"the program took longer than the time_limit of {limits.time_limit:g} s.")
            case "out_of_memory":
                return Failure("out_of_memory", f"the program held more than the memory of {limits.memory:g} bytes.")
            case "lost" | "stopped":
                return Failure(LOST, ended.because or "it was broken off.")
        if code == -signal.SIGKILL:
            return Failure(LOST, "the program was killed from outside by SIGKILL, as happens where memory is short.")
        if code is not None and code < 0:
            return Failure("crashed", f"the program was ended by {_signal(-code)}.")
        if code in limits.success_exit_codes:
            return None
        if code in limits.infeasible_exit_codes:
            return Failure("infeasible", f"the program ended with the exit code {code}, which infeasible_exit_codes names.")
        if code in limits.retry_exit_codes:
            return Failure(LOST, f"the program ended with the exit code {code}, which retry_exit_codes names.")
        return Failure("exit_code", f"the program ended with the exit code {code}.")

    def _read(self, folder: Path) -> Response | Failure:
        written = self._written(folder)
        if not written.resolve().is_relative_to(folder.resolve()):
            return Failure("unreadable", f"{self.output.file} leads out of the folder of the evaluation.")
        if self.output.file == STANDARD_OUTPUT:
            return self.output.read(written.read_bytes(), self.control, self.at)
        return self.output.read(written, self.control, self.at)


def _signal(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"the signal {number}"


def _last_line(printed: str) -> str:
    lines = COLOURS.sub("", printed).rstrip().splitlines()
    return f"{PRINTED_LAST}{lines[-1].strip()[:300]}" if lines else ""
