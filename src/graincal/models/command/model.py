"""Anybody's program as a model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path, PurePosixPath
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from graincal.data import Failure, InputError, Samples
from graincal.execution import Limit, Task
from graincal.files import unreadable
from graincal.models.command.folders import OUTCOME, PRINTED, Folders
from graincal.models.command.inputs import BRACES, Given, Inputs
from graincal.models.command.work import PRINTED_OUTPUT, CommandWork, Limits
from graincal.models.model import Model
from graincal.models.output import STANDARD_OUTPUT, Output

_RUNNING = ("cores", "max_at_once")

OWN = (OUTCOME, PRINTED, PRINTED_OUTPUT)
"""The files that graincal itself writes in the folder of an evaluation."""


@dataclass(frozen=True, eq=False)
class CommandModel(Model):
    """A program that is run for each sample, in a folder of its own and never through a shell, and the output that it writes there.

    command: the program and its arguments, in which `{{ name }}` stands for a parameter or a derived value; so it does in the values of `environment`, which are added to the environment.
    output: what it writes. control: the quantity of `output.columns` that responses are over.
    derived: name -> expression of parameters. link: files and folders beside the calibration file that the evaluation's folder sees under their last names. templates: name in the folder -> file that is written there with its
    names filled in, between `delimiters`. parameters_file: a file with all values, .json, .csv, or else a table of one row.
    folder: where `link` and `templates` are looked for. limits: time, memory and the meanings of exit codes. cores: how many workers' places an evaluation takes. max_at_once: how many run at once at the most.
    folders: where evaluations keep their files.
    """

    kind: ClassVar[str] = "command"

    command: tuple[str, ...]
    output: Output
    control: str = "axial_strain"
    derived: Mapping[str, str] = field(default_factory=dict)
    link: tuple[str, ...] = ()
    templates: Mapping[str, str] = field(default_factory=dict)
    delimiters: tuple[str, str] = BRACES
    environment: Mapping[str, str] = field(default_factory=dict)
    parameters_file: str | None = None
    limits: Limits = Limits()
    cores: int = 1
    max_at_once: int | None = None
    folders: Folders = Folders()
    folder: Path = Path()

    def __post_init__(self) -> None:
        if not self.command or not self.command[0]:
            raise InputError("command must name a program, such as ['python3', 'simulate.py', '{{ E }}'].")
        self.output.check(self.control)
        _check_names([*self.links], self._written)

    @property
    def _written(self) -> list[str]:
        """The names in the folder of an evaluation that files are written under, by graincal and by the program."""
        named = [self.parameters_file, None if self.output.file == STANDARD_OUTPUT else self.output.file]
        return [*self.templates, *filter(None, named)]

    @property
    def returned(self) -> tuple[str, ...]:
        """The quantities that a response has."""
        return self.output.returned(self.control)

    @property
    def links(self) -> dict[str, Path]:
        """What the evaluation's folder sees, by its names there."""
        return {PurePosixPath(name).name: (self.folder / name).absolute() for name in self.link}

    @property
    def files(self) -> dict[str, Path]:
        """The user's files that an evaluation is made of, by their names beside the calibration file."""
        named = (*self.link, *self.templates.values())
        return {name: path for name in named if (path := self.folder / name).is_file()}

    def tasks(self, samples: Samples, at: ArrayLike) -> list[Task]:
        """A run of the program for each sample, whose response is at the control values `at` (T,). Raises InputError for names in templates that are not known, and for files that are not there."""
        work = self._work(samples.names, at)
        limit = None if self.max_at_once is None else Limit(self.command[0], self.max_at_once)
        return [Task(work, (int(id), tuple(map(float, theta))), cores=self.cores, limit=limit) for id, theta in zip(samples.ids, samples.theta)]

    def given(self, samples: Samples, at: ArrayLike) -> list[Given | Failure]:
        """The inputs of each sample, or what making them came to; nothing is run."""
        work = self._work(samples.names, at)
        return [work.given(tuple(map(float, theta))) for theta in samples.theta]

    def unread(self, parameters: Sequence[str], at: ArrayLike) -> list[str]:
        """The parameters that the program is not told: neither by an argument nor by a file or the environment."""
        return self._work(parameters, at).inputs.unread(parameters)

    @property
    def not_linked(self) -> list[str]:
        """The arguments that are files in the model's folder, and that an evaluation's folder does not see."""
        seen = {PurePosixPath(name).name for name in (*self.link, *self.templates)}
        return [
            word for word in self.command if word and PurePosixPath(word).name not in seen and not Path(word).is_absolute() and (self.folder / word).is_file()
        ]

    def in_folder(self, folder: Path) -> CommandModel:
        """The same, whose evaluations keep their files there; what a killed process left of some is removed. Raises OSError."""
        folders = replace(self.folders, root=folder)
        folders.make_ready()
        return replace(self, folders=folders)

    def _work(self, parameters: Sequence[str], at: ArrayLike) -> CommandWork:
        texts = {name: _text(self.folder / source) for name, source in self.templates.items()}
        inputs = Inputs(self.command, self.environment, self.derived, texts, self.delimiters, self.links, self.parameters_file)
        inputs.check(parameters)
        return CommandWork(inputs, self.output, tuple(parameters), self.control, np.array(at, dtype=np.float64), self.limits, self.folders)

    def described(self) -> dict[str, Any]:
        """It as plain data (what JSON holds)."""
        plain = {key: value for key, value in self.__dict__.items() if key not in ("folders", "folder", "output", "limits", *_RUNNING)}
        # What its runs do not depend on: others with the same of everything else are the same.
        running = {key: getattr(self, key) for key in _RUNNING} | {"keep": self.folders.keep, "scratch": self.folders.scratch}
        limits = asdict(self.limits)
        running |= {key: limits.pop(key) for key in ("time_limit", "memory")}
        return {"kind": "command", **plain, "folder": str(self.folder.absolute()), "output": asdict(self.output), "exit_codes": limits, "running": running}

    @classmethod
    def restored(cls, described: Mapping[str, Any]) -> CommandModel:
        """The model that was described."""
        given = {key: value for key, value in described.items() if key not in ("kind", "output", "exit_codes", "running")}
        running, codes = dict(described["running"]), {key: tuple(value) for key, value in described["exit_codes"].items()}
        given |= {key: tuple(given[key]) for key in ("command", "link", "delimiters")}
        return cls(
            **given | {"folder": Path(given["folder"])},
            **{key: running[key] for key in _RUNNING},
            output=Output.restored(described["output"]),
            limits=Limits(running["time_limit"], running["memory"], **codes),
            folders=Folders(keep=running["keep"], scratch=running["scratch"]),
        )


def _check_names(links: Sequence[str], written: Sequence[str]) -> None:
    """Raise InputError for names that lead out of the folder of an evaluation, and for those of which one would be written over another, or through a link into what it leads to."""
    for name in written:
        if PurePosixPath(name).is_absolute() or ".." in PurePosixPath(name).parts:
            raise InputError(f"{name} leads out of the folder of an evaluation, and the name of a file within it was expected.")
    paths = [PurePosixPath(name) for name in (*links, *written)]
    for path in paths:
        if paths.count(path) > 1:
            raise InputError(
                f"{path} is the name of two files in the folder of an evaluation, of link, templates, parameters_file and output, and different names were expected."
            )
        if str(path) in OWN:
            raise InputError(
                f"{path} is the name of a file that graincal writes in the folder of an evaluation, and another name in link, templates, parameters_file and output was expected."
            )
        if within := [each for each in path.parents if each in paths]:
            raise InputError(
                f"{path} lies within {within[0]}, which is a name in the folder of an evaluation too, of link, templates, parameters_file and output, and a name beside it was expected."
            )


def _text(path: Path) -> str:
    try:
        with path.open(encoding="utf-8", newline="") as file:
            return file.read()
    except OSError as error:
        raise InputError(unreadable(path, error, "a template")) from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: a template in UTF-8 was expected.") from None
