"""What graincal init asks in a terminal: what no option gives, and what would otherwise stay a "?" in the calibration file or be refused.

An answer is taken as the option that gives it: read by the command's own options, and then by what is found in the file with it.
"""

from __future__ import annotations

import re
import shlex
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import typer

from graincal.cli.saying import say
from graincal.data import InputError
from graincal.notation.printable import printable

if TYPE_CHECKING:
    from graincal.laboratory import Question, Understanding

REPEATED = {"column", "compression"}
"""Options that are given once for each quantity: one of them says nothing of the other quantities."""


def in_a_terminal() -> bool:
    """Whether a person can be asked: what is typed and what is printed are both of a terminal."""
    return sys.stdin.isatty() and sys.stdout.isatty()


@dataclass
class Asking:
    """Asks until nothing is open but what the person leaves open.

    look: what is understood of the file by values of options, of which `given` are those of the command line. check: refuses a value that its option would refuse.
    """

    context: typer.Context
    look: Callable[[dict[str, Any]], Understanding]
    check: Callable[[dict[str, Any]], None]
    given: dict[str, Any]
    left: set[str] = field(default_factory=set)

    def understood(self) -> Understanding:
        """What is understood with all answers. Raises InputError where a refusal stays: no option answers it, or the person gives none."""
        from graincal.laboratory.describe import describe_question

        found = self._past_refusal()
        while question := next((each for each in found.questions if each.key not in self.left and self._can_give(_option(each))), None):
            say(describe_question(question))
            answered = self._ask(f'{question.key} (empty: it stays "?")', partial(_as_arguments, question))
            if answered is None:
                self.left.add(question.key)
            found = answered or found
        return found

    def _past_refusal(self) -> Understanding:
        try:
            return self.look(self.given)
        except InputError as refusal:
            if not any(self._can_give(option) for option in _options(str(refusal))):
                raise
            say("\n".join([str(refusal), *self._columns()]))
            if (found := self._ask("The options that answer this, in one line (empty: none)", shlex.split)) is None:
                raise
            return found

    def _columns(self) -> list[str]:
        """The columns of the file, in lines; none where it is not known what its table is."""
        from graincal.laboratory.describe import list_columns
        from graincal.laboratory.table import read_table

        try:
            table = read_table(self.context.params["file"], encoding=self.given["encoding"], sheet=self.given["sheet"])
        except InputError:
            return []
        return ["Its columns, by number and name, with their first values:", *(f"  {line}" for line in list_columns(table))]

    def _can_give(self, option: str) -> bool:
        return option in self.given and (option in REPEATED or self.given[option] is None)

    def _ask(self, prompt: str, as_arguments: Callable[[str], list[str]]) -> Understanding | None:
        """What is understood with the answer that is typed, which is asked again while it is refused; None for an empty one."""

        def take(text: str) -> tuple[dict[str, Any], Understanding] | None:
            if not text.strip():
                return None
            try:
                given = self._with(as_arguments(text.strip()))
                return given, self.look(given)
            except (InputError, ValueError) as refusal:
                raise typer.BadParameter(printable(str(refusal), None, lines=True)) from None
            except typer.Exit:
                raise typer.BadParameter("--help answers nothing; the options are above.") from None

        taken = typer.prompt(printable(prompt), default="", show_default=False, value_proc=take)
        if taken is None:
            return None
        self.given, found = taken
        return found

    def _with(self, options: list[str]) -> dict[str, Any]:
        """The values of options with those that are typed. Raises typer.BadParameter and InputError for what the command refuses."""
        parsed = self.context.command.make_context(self.context.info_name, [str(self.context.params["file"]), *options], parent=self.context.parent)
        typed = {
            name: value
            for name, value in parsed.params.items()
            if (source := parsed.get_parameter_source(name)) and source.name == "COMMANDLINE" and name != "file"
        }
        if not typed or (others := typed.keys() - self.given.keys()):
            known = ", ".join(f"--{name.replace('_', '-')}" for name in self.given)
            raise InputError(
                f"{', '.join(f'--{name}' for name in sorted(others)).replace('_', '-') if typed else ' '.join(options)} answers nothing of the file, and one of {known} was expected."
            )
        self.check(typed)
        return self.given | {name: _each_once(self.given[name], value) if name in REPEATED else value for name, value in typed.items()}


def _each_once(before: list[str] | None, typed: list[str]) -> list[str]:
    """What is said of quantities, with what is typed of them in place of what was said before."""
    of = {each.partition("=")[0].strip() for each in typed}
    return [*(each for each in before or () if each.partition("=")[0].strip() not in of), *typed]


def _options(text: str) -> list[str]:
    """The options that a text names, as parameters of the command."""
    return [name.replace("-", "_") for name in re.findall(r"--([a-z]+(?:-[a-z]+)*)", text)]


def _option(question: Question) -> str:
    """The option that answers a question: the one that is called as its key, where there is one."""
    options = _options(question.option)
    return question.key if question.key in options else next(iter(options), "")


def _as_arguments(question: Question, text: str) -> list[str]:
    return [_as_argument(question, text)]


def _as_argument(question: Question, text: str) -> str:
    """The option that answers a question, with the answer: --kind=triaxial, --column=axial_strain=2:%, --compression=volumetric_strain=negative."""
    option = _option(question)
    if option not in REPEATED:
        return f"--{option.replace('_', '-')}={text}"
    example = question.option.partition(" ")[2]
    return f"--{option}={example.removesuffix('UNIT') if option == 'column' else example.partition('=')[0] + '='}{text}"
