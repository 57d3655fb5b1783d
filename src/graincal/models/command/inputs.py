"""What a program is given for a sample: its arguments, its environment, and the files in its folder."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal

import numpy as np
from jinja2 import StrictUndefined, Template, TemplateError, TemplateRuntimeError, TemplateSyntaxError
from jinja2.meta import find_undeclared_variables
from jinja2.runtime import Context
from jinja2.sandbox import ImmutableSandboxedEnvironment

from graincal.data import Failure, InputError
from graincal.models.derived import check_derived
from graincal.notation.expression import Expression
from graincal.suggestion import did_you_mean

BRACES = ("{{", "}}")
"""What stands around a name in arguments, in the environment, and in templates where nothing else is said."""


@dataclass(frozen=True)
class Given:
    """The inputs of one evaluation: command, what is added to the environment, texts of files by their names in the folder, and what their links lead to."""

    command: tuple[str, ...]
    environment: Mapping[str, str]
    files: Mapping[str, str]
    links: Mapping[str, Path]

    def put(self, folder: Path) -> None:
        """Write the files and make the links in a folder. Raises OSError."""
        for name, source in self.links.items():
            (folder / name).symlink_to(source)
        for name, text in self.files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            # As it stands: no line's end is changed.
            path.write_text(text, encoding="utf-8", newline="")


@dataclass(frozen=True)
class Inputs:
    """How inputs are made of parameters.

    command, environment: texts with `{{ name }}` in them. derived: name -> expression of parameters and of names before it. templates: name in the folder -> text. delimiters: what stands around a name in templates.
    links: name in the folder -> file or folder. parameters_file: its name in the folder, for all parameters and derived values: JSON, CSV (.csv), or else a table of one row between spaces.
    """

    command: tuple[str, ...]
    environment: Mapping[str, str] = field(default_factory=dict)
    derived: Mapping[str, str] = field(default_factory=dict)
    templates: Mapping[str, str] = field(default_factory=dict)
    delimiters: tuple[str, str] = BRACES
    links: Mapping[str, Path] = field(default_factory=dict)
    parameters_file: str | None = None

    def check(self, parameters: Sequence[str]) -> None:
        """Raise InputError for what no sample can mend: names that are not known, expressions and templates that cannot be read, files that are not there."""
        check_derived(self.derived, parameters)
        known = [*parameters, *self.derived]
        for place, text, delimiters in self._texts():
            try:
                _refuse_unknown(place, sorted(find_undeclared_variables(_environment(delimiters, _line_end(text)).parse(text))), known)
            except TemplateSyntaxError as error:
                raise InputError(
                    f"{place}: line {error.lineno} cannot be read as a template ({error.message}), and names between {' and '.join(delimiters)} were expected."
                ) from None
        if self.parameters_file and not self.parameters_file.endswith((".json", ".csv")) and (spaced := [name for name in known if len(name.split()) != 1]):
            raise InputError(
                f"parameters_file is {self.parameters_file}, a table between spaces, and '{spaced[0]}' has a space in its name: a file .json or .csv was expected."
            )
        for name, source in self.links.items():
            if not source.exists():
                raise InputError(f"link names {name}, and there is no {source}.")

    def unread(self, parameters: Sequence[str]) -> list[str]:
        """The parameters that nothing is filled in with."""
        if self.parameters_file:
            return []
        named = {name for _, text, delimiters in self._texts() for name in find_undeclared_variables(_environment(delimiters, _line_end(text)).parse(text))}
        for name, text in reversed(list(self.derived.items())):
            named |= set(Expression(text).names) if name in named else set()
        return [name for name in parameters if name not in named]

    def values(self, parameters: Mapping[str, float]) -> dict[str, float] | Failure:
        """The parameters and what is derived of them."""
        values = {name: float(value) for name, value in parameters.items()}
        for name, text in self.derived.items():
            value = np.float64(Expression(text)(values))
            if not np.isfinite(value):
                at = ", ".join(f"{each} = {values[each]!r}" for each in Expression(text).names)
                return Failure("not_finite", f"{name} = {text} is {value} at {at or 'any sample'}.")
            values[name] = float(value)
        return values

    def given(self, values: Mapping[str, float]) -> Given | Failure:
        """The inputs of a sample; a Failure where a template cannot be filled in."""
        place = ""
        try:
            filled = {}
            for place, text, delimiters in self._texts():
                filled[place] = _template(text, delimiters).render(values)
        # Whatever an expression in a template comes to.
        except (TemplateError, ArithmeticError, ValueError, TypeError, LookupError, AttributeError, RecursionError, MemoryError) as error:
            return Failure("not_started", f"{place} could not be filled in ({type(error).__name__}: {error}).")
        command = tuple(filled[f"command, argument {number}"] for number in range(len(self.command)))
        environment = {name: filled[f"environment.{name}"] for name in self.environment}
        if any("\0" in text for text in (*command, *environment.values())):
            return Failure("not_started", "an argument has the character \\x00 in it, which no program can be given.")
        files = {name: filled[f"template {name}"] for name in self.templates}
        if self.parameters_file:
            files[self.parameters_file] = _table(self.parameters_file, values)
        return Given(command, environment, files, self.links)

    def _texts(self) -> Iterator[tuple[str, str, tuple[str, str]]]:
        """Everything that names are filled into, with its place and delimiters."""
        for number, text in enumerate(self.command):
            yield f"command, argument {number}", text, BRACES
        for name, text in self.environment.items():
            yield f"environment.{name}", text, BRACES
        for name, text in self.templates.items():
            yield f"template {name}", text, self.delimiters


def _refuse_unknown(place: str, names: Sequence[str], known: Sequence[str]) -> None:
    if unknown := [name for name in names if name not in known]:
        raise InputError(
            f"{place} names {unknown[0]}{did_you_mean(unknown[0], known)}, which is no parameter and not derived, and some of {', '.join(known)} were expected."
        )


class _Environment(ImmutableSandboxedEnvironment):
    """The sandbox, in which no number and no text grows without end."""

    intercepted_binops = frozenset(["**", "*"])

    def call_binop(self, context: Context, operator: str, left: Any, right: Any) -> Any:
        if not isinstance(left, (int, float)) or not isinstance(right, (int, float)):
            raise TemplateRuntimeError(f"only numbers can stand beside {operator}")
        if operator == "*":
            return left * right
        power = float(left) ** float(right)
        return int(power) if isinstance(left, int) and isinstance(right, int) and abs(power) < 2**53 and power.is_integer() else power


@lru_cache(maxsize=100)
def _environment(delimiters: tuple[str, str], line_end: Literal["\n", "\r\n"]) -> ImmutableSandboxedEnvironment:
    """How templates are filled in: they see values alone, and load nothing."""
    begin, end = delimiters
    others = (
        {}
        if delimiters == BRACES
        else {"block_start_string": f"{begin}%", "block_end_string": f"%{end}", "comment_start_string": f"{begin}#", "comment_end_string": f"#{end}"}
    )
    return _Environment(
        variable_start_string=begin,
        variable_end_string=end,
        undefined=StrictUndefined,
        keep_trailing_newline=True,
        newline_sequence=line_end,
        loader=None,
        **others,
    )


def _line_end(text: str) -> Literal["\n", "\r\n"]:
    """That of a file, which what is made of it has too."""
    return "\r\n" if "\r\n" in text else "\n"


@lru_cache(maxsize=1_000)
def _template(text: str, delimiters: tuple[str, str]) -> Template:
    return _environment(delimiters, _line_end(text)).from_string(text)


def _table(name: str, values: Mapping[str, float]) -> str:
    """All values by their names, with every digit."""
    if name.endswith(".json"):
        return json.dumps(values, indent=2) + "\n"
    if not name.endswith(".csv"):
        return f"{' '.join(values)}\n{' '.join(map(repr, values.values()))}\n"
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([values, map(repr, values.values())])
    return text.getvalue()
