"""The table [experiment.model] of a program, kind = "command"."""

from __future__ import annotations

from pathlib import Path, PurePosixPath
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, ValidationInfo, field_validator

from graincal.campaign.file.model_section import ModelSection
from graincal.campaign.file.names import FileName
from graincal.campaign.file.output import OutputSection, inside
from graincal.campaign.file.section import mistake, show
from graincal.campaign.file.values import Count, Positive, Texts
from graincal.models import CommandModel
from graincal.models.command.folders import Folders
from graincal.models.command.work import Limits
from graincal.models.python import LONGEST_TIMEOUT

ExitCode = Annotated[int, Field(ge=0, le=255)]

_CODES = ("success_exit_codes", "retry_exit_codes", "infeasible_exit_codes")


class CommandSection(ModelSection):
    MOST: ClassVar[dict[str, float]] = {
        "time_limit": LONGEST_TIMEOUT,
        "command": 10_000,
        "memory": 1e15,
        "cores": 10_000,
        "max_at_once": 10_000,
        "link": 10_000,
        "derived": 1_000,
        "templates": 1_000,
        "environment": 1_000,
    }

    kind: Literal["command"] = Field(description='"command"')
    command: list[str] = Field(min_length=1, description='a list of a program and its arguments, such as ["python3", "simulate.py", "--E", "{{ E }}"]')
    output: OutputSection = Field(description='a table such as { file = "curve.csv", columns = { axial_strain = "eps_a [%]", stress_ratio = "ratio" } }')
    derived: Texts = Field({}, description='a table of names and expressions of parameters, such as { E = "10**log_E" }')
    link: list[FileName] = Field([], description='a list of files and folders that the folder of an evaluation sees, such as ["simulate.py"]')
    templates: dict[str, FileName] = Field(
        {}, description='a table of files to be written and the templates for them, such as { "case.in" = "case.in.template" }'
    )
    delimiters: list[str] = Field(["{{", "}}"], min_length=2, max_length=2, description='what stands around a name in templates, such as ["<<", ">>"]')
    environment: Texts = Field({}, description='a table of names and texts, such as { OMP_NUM_THREADS = "1" }')
    parameters_file: FileName | None = Field(None, description='the name of a file for all parameters, such as "parameters.json"')
    time_limit: Positive = Field(Limits.time_limit, description="a number of seconds above 0")
    memory: Positive | None = Field(None, description="a number of bytes above 0, such as 4e9")
    cores: Count = Field(1, description="a whole number above 0")
    max_at_once: Count | None = Field(None, description="a whole number above 0")
    success_exit_codes: list[ExitCode] = Field(list(Limits.success_exit_codes), min_length=1, description="a list of exit codes from 0 to 255, such as [0]")
    retry_exit_codes: list[ExitCode] = Field([], description="a list of exit codes from 0 to 255, such as [75]")
    infeasible_exit_codes: list[ExitCode] = Field([], description="a list of exit codes from 0 to 255, such as [3]")
    keep: Literal["failed", "all", "none"] = Field(Folders.keep, description='"failed", "all" or "none"')
    scratch: FileName | None = Field(None, min_length=1, description='a folder of the machine that evaluations run on, such as "$TMPDIR"')

    @field_validator("command", "environment")
    @classmethod
    def _can_be_given(cls, given: list[str] | dict[str, str]) -> list[str] | dict[str, str]:
        texts = [*given.keys(), *given.values()] if isinstance(given, dict) else given
        if any("\0" in text for text in texts) or (isinstance(given, dict) and any("=" in name or not name for name in given)):
            raise mistake(f" has {show(next(text for text in texts if chr(0) in text or '=' in text or not text))}, which no program can be given")
        if isinstance(given, list) and not given[0].strip():
            raise mistake(" begins with an empty name, and that of a program was expected")
        return given

    @field_validator("templates")
    @classmethod
    def _targets_inside(cls, templates: dict[str, str]) -> dict[str, str]:
        for target in templates:
            inside(target)
        return templates

    @field_validator("parameters_file")
    @classmethod
    def _file_inside(cls, name: str | None) -> str | None:
        return None if name is None else inside(name)

    @field_validator("link")
    @classmethod
    def _have_names(cls, names: list[str]) -> list[str]:
        for name in names:
            if PurePosixPath(name).name in ("", ".."):
                raise mistake(f" has {show(name)}, and the name of a file or folder was expected")
        return names

    @field_validator("delimiters")
    @classmethod
    def _can_be_told_apart(cls, delimiters: list[str]) -> list[str]:
        begin, end = delimiters
        if len(begin) < 2 or len(end) < 2 or begin == end or any(each.isspace() or each.isalnum() for each in begin + end):
            raise mistake(f' is {show(delimiters)}, and two that differ, of two signs or more each, were expected, such as ["<<", ">>"]')
        return delimiters

    @field_validator(*_CODES[1:])
    @classmethod
    def _mean_one_thing(cls, codes: list[int], info: ValidationInfo) -> list[int]:
        assert info.field_name is not None, "it is asked of a field"
        for key in _CODES[: _CODES.index(info.field_name)]:
            if twice := sorted(set(codes) & set(info.data.get(key, ()))):
                raise mistake(f" has {twice[0]}, which {key} has too, and each exit code was expected to mean one thing")
        return codes

    def build(self, folder: Path, control: str) -> CommandModel:
        return CommandModel(tuple(self.command), self.output.build(), link=tuple(self.link), **self.options(folder, control))

    def options(self, folder: Path, control: str) -> dict[str, Any]:
        """What any program is told, beside its command, its output and its links."""
        return {
            "control": control,
            "derived": self.derived,
            "templates": self.templates,
            "delimiters": tuple(self.delimiters),
            "environment": self.environment,
            "parameters_file": self.parameters_file,
            "limits": Limits(self.time_limit, self.memory, tuple(self.success_exit_codes), tuple(self.retry_exit_codes), tuple(self.infeasible_exit_codes)),
            "cores": self.cores,
            "max_at_once": self.max_at_once,
            "folders": Folders(keep=self.keep, scratch=self.scratch),
            "folder": folder.resolve(),
        }
