"""Open questions of a calibration file: values "?", which stand where nothing but the person who knows the test can say the answer."""

from __future__ import annotations

import copy
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from graincal.campaign.file.section import place
from graincal.laboratory.decisions import UNANSWERED
from graincal.laboratory.quantities import DIMENSIONS
from graincal.laboratory.units import UNITS
from graincal.notation.toml import NotTOML, read_toml

Proposed = Callable[[dict[str, Any], tuple[str | int, ...]], Any]
"""What a laboratory file says to a question: of the entry of its experiment, as TOML has it, and the keys on the way from there; None for nothing."""

_WRITTEN = re.compile(r"\"\?\"|'\?'")
_TEXT = re.compile(r"\"(?:\\.|[^\"\\])*\"|'[^']*'")
_WORDS = {"strain": ("engineering", "logarithmic"), "compression": ("positive", "negative")}
_MOST_WORDS = 6
_KEY = re.compile(r"([\w-]+)\s*=")
_ONE_OF, _LIKELY = re.compile(r'One of: ((?:"[^"]*"(?:, )?)+)\.?'), re.compile(r'Likely: "([^"]*)"\.?')
"""What `graincal init` writes behind a question: the answers that are possible, and the likely one."""


@dataclass(frozen=True)
class OpenQuestion:
    """A key whose value is "?". path: the keys from the root; place: the same in words. line: where it stands, from 1; None where that is not known. comment: what the file says of it."""

    path: tuple[str | int, ...]
    place: str
    experiment: str | None
    line: int | None
    comment: str
    proposed: str = ""

    @property
    def key(self) -> str:
        """The key in its experiment, or else in the file."""
        return place(self.path[2:] if self.experiment is not None else self.path, None)

    @property
    def answers(self) -> tuple[str, ...]:
        """The answers that are possible; () for any."""
        words = [part for part in self.path if isinstance(part, str)]
        for key, answers in _WORDS.items():
            if key in words:
                return answers
        if "units" in words:
            return tuple(symbol for symbol, unit in UNITS.items() if DIMENSIONS.get(words[-1]) in (None, unit.dimension))
        listed = _ONE_OF.search(self.comment)
        return tuple(dict.fromkeys(re.findall(r'"([^"?]+)"', listed[1] if listed else _LIKELY.sub("", self.comment))))[:_MOST_WORDS]

    @property
    def asked(self) -> str:
        """What is asked, as the file says it, and what is likely."""
        said = " ".join(_LIKELY.sub("", _ONE_OF.sub("", self.comment)).split()) or f"What is {self.key}?"
        likely = self.proposed or ((found := _LIKELY.search(self.comment)) and found[1])
        return f"{said}{'' if said[-1] in '.?!' else '.'}" + (f" Likely: {likely}." if likely else "")

    @property
    def sentence(self) -> str:
        """What is asked, with the place of the key and what the file says of it."""
        at = f" (line {self.line})" if self.line else ""
        # What is likely by the laboratory file is said by whoever knows it.
        comment = _LIKELY.sub("", self.comment).strip() if self.proposed else self.comment
        said = f": {comment.rstrip('.:')}" if comment else f"; one of {', '.join(self.answers)} is possible" if self.answers else ""
        end = "" if said.endswith("?") else "."
        return f'{self.place} is an open question{at}{said}{end} Write the answer in the place of "?".'


def open_questions(source: str, content: Mapping[str, Any]) -> tuple[OpenQuestion, ...]:
    """The questions of a calibration file by its text and its content, in the order of the content."""
    lines = source.splitlines()
    where = _lines(source)
    found = []
    for path in _paths(content):
        line = where.get(path)
        experiments = content["experiment"] if path[0] == "experiment" else None
        entry = experiments[path[1]] if isinstance(experiments, list) and len(path) > 2 and isinstance(path[1], int) else None
        name = entry.get("name") if isinstance(entry, dict) else None
        experiment = None if entry is None else name if isinstance(name, str) else str(int(path[1]) + 1)
        found.append(OpenQuestion(path, place(path, content), experiment, line, _comment(lines, line, path) if line else ""))
    return tuple(found)


def without_questions(content: Mapping[str, Any], questions: Sequence[OpenQuestion], proposed: Proposed) -> tuple[dict[str, Any], tuple[OpenQuestion, ...]]:
    """A copy of the content with what is proposed in the place of questions, and without the other keys that are questions; and the questions, with what was proposed to each."""
    answered, known = copy.deepcopy(dict(content)), []
    # A list loses its whole key with one of its elements, and a key may hold several questions.
    for question in questions:
        entry = content["experiment"][question.path[1]] if question.experiment is not None else None
        value = None if entry is None else proposed(entry, question.path[2:])
        known.append(question if value is None else replace(question, proposed=str(value)))
        _put(answered, question.path, value)
    return answered, tuple(known)


def _put(content: dict[str, Any], path: tuple[str | int, ...], value: Any) -> None:
    """Put a value in its place, or for None remove the key, where it was not removed before."""
    holders: list[Any] = [content]
    for part in path[:-1]:
        try:
            holders.append(holders[-1][part])
        except (KeyError, IndexError):
            return
    if value is not None:
        holders[-1][path[-1]] = value
        return
    for holder, part in zip(reversed(holders), reversed(path)):
        if isinstance(holder, dict):
            holder.pop(part, None)
            return


def _paths(content: Any, path: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    """The keys on the way to each "?"."""
    if content == UNANSWERED:
        yield path
    elif isinstance(content, dict):
        for key, value in content.items():
            yield from _paths(value, (*path, key))
    elif isinstance(content, list):
        for index, value in enumerate(content):
            yield from _paths(value, (*path, index))


def _lines(source: str) -> dict[tuple[str | int, ...], int]:
    """The line of each "?", from 1, by the keys on the way to it. TOML's reader does not say where a value stands, so each is given a number of its own and is read again."""
    lines: list[int] = []

    def numbered(found: re.Match) -> str:
        lines.append(source.count("\n", 0, found.start()) + 1)
        mark = found[0][0]
        return f"{mark}?{len(lines) - 1}{mark}"

    try:
        content = read_toml(_WRITTEN.sub(numbered, source))
    except NotTOML:  # a key that is "?" twice, or the like: the questions are known without their lines
        return {}
    return {path: lines[number] for path, number in _numbers(content) if number < len(lines)}


def _numbers(content: Any, path: tuple[str | int, ...] = ()) -> Iterator[tuple[tuple[str | int, ...], int]]:
    if isinstance(content, str) and re.fullmatch(r"\?\d+", content):
        yield path, int(content[1:])
    elif isinstance(content, dict):
        for key, value in content.items():
            yield from _numbers(value, (*path, key))
    elif isinstance(content, list):
        for index, value in enumerate(content):
            yield from _numbers(value, (*path, index))


def comment_behind(line: str) -> str:
    """The comment behind what a line holds, without its sign; "" for none."""
    # A comment may hold quotes itself: it begins at the first sign that no text holds.
    at = 0
    while at < len(line):
        if line[at] == "#":
            return line[at + 1 :].strip()
        found = _TEXT.match(line, at)
        at = found.end() if found else at + 1
    return ""


def comments_above(lines: Sequence[str], number: int) -> list[tuple[int, str]]:
    """The comments directly above a line (its number from 1), each with its own number, without their sign."""
    found: list[tuple[int, str]] = []
    above = number - 1
    while above >= 1 and lines[above - 1].lstrip().startswith("#"):
        found.insert(0, (above, lines[above - 1].lstrip().lstrip("#").strip()))
        above -= 1
    return found


def _comment(lines: Sequence[str], number: int, path: tuple[str | int, ...]) -> str:
    """What the file says of a key on a line, by the keys on the way to it, as one text.

    Where a line holds several keys: what names this one; else what names a table on the line that it is in, and no other key; else what names no key of the line.
    """
    line = lines[number - 1]
    said = [text for text in (*(above for _, above in comments_above(lines, number)), comment_behind(line)) if text]
    on_line = _KEY.findall(_TEXT.sub('""', line).partition("#")[0])
    own = [key for key in path if isinstance(key, str) and key in on_line]
    if len(on_line) < 2 or not own:
        return " ".join(said)
    others = [key for key in on_line if key not in own]
    plain = [text for text in said if not any(_names(text, key) for key in others)]
    choices = ([text for text in said if _names(text, own[-1])], [text for text in plain if any(_names(text, key) for key in own)], plain)
    return " ".join(next(filter(None, choices), ()))


def _names(text: str, key: str) -> bool:
    """Whether a comment speaks of a key, by its name or in words; names of columns are none."""
    text = re.sub(r"'[^']*'", "", text)
    return re.search(rf"\b(?:{re.escape(key.removesuffix('s'))}|{re.escape(key.removesuffix('s').replace('_', ' '))})s?\b", text, re.IGNORECASE) is not None
