"""All generated cases, each of them from its own seed."""

from __future__ import annotations

import random
from collections import Counter
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from .choice import Choice, balanced
from .deprived import ASKED, OPEN, TAKEN
from .draft import Draft, drafted, printed
from .expectation import Expectation
from .expected import expected
from .outcome import Outcome, read
from .packing import packing

SEED = 20240607
DECIDABLE, DEPRIVED, OPEN_TO_BOTH = "decidable", "deprived", "open"
NUMBER_DECIDABLE = 200
NUMBER_OF_EACH_TAKEN = 9
NUMBER_OF_EACH_OPEN = 5


@dataclass(frozen=True)
class Case:
    """`truth` is what the maker of the file knows. Of a deprived file a reader cannot know it, and has to ask."""

    number: int
    group: str
    name: str
    seed: str
    file: str
    content: bytes
    encoding: str
    options: list[str]
    void_ratio: float
    truth: Expectation
    choice: Choice

    @property
    def title(self) -> str:
        return f"case {self.number} (seed {self.seed}), {self.group}, {self.name}"

    @property
    def wanted(self) -> Expectation | None:
        return None if self.group == DEPRIVED else self.truth

    def write(self, folder: Path) -> Path:
        path = folder / self.file
        path.write_bytes(self.content)
        return path

    def outcome(self, folder: Path) -> Outcome:
        return read(
            self.write(folder),
            self.options,
            packing(self.void_ratio, folder),
            folder / f"case_{self.number:03d}.toml",
            self.wanted,
            ASKED[self.name] if self.group == DEPRIVED else "",
        )


@cache
def cases() -> tuple[Case, ...]:
    """The decidable ones first, then the deprived ones, then those that may be either."""
    made: list[Case] = []
    seen: Counter[tuple[str, str]] = Counter()
    for _ in range(NUMBER_DECIDABLE):
        seed, rng = _seed(len(made))
        choice = balanced(rng, seen)
        made.append(_case(len(made), DECIDABLE, choice["family"], seed, drafted(choice, rng)))
    for group, functions, number in ((DEPRIVED, TAKEN, NUMBER_OF_EACH_TAKEN), (OPEN_TO_BOTH, OPEN, NUMBER_OF_EACH_OPEN)):
        for name, function in functions.items():
            for _ in range(number):
                seed, rng = _seed(len(made))
                made.append(_case(len(made), group, name, seed, function(rng)))
    return tuple(made)


def _seed(number: int) -> tuple[str, random.Random]:
    seed = f"{SEED}-{number}"
    return seed, random.Random(seed)


def _case(number: int, group: str, name: str, seed: str, draft: Draft) -> Case:
    content, options = printed(draft)
    ending = {"comma": "csv", "semicolon": "csv", "tab": "txt", "spaces": "dat"}[draft.choice["delimiter"]]
    file = f"case_{number:03d}.{ending}"
    return Case(number, group, name, seed, file, content, draft.choice["encoding"], options, draft.test.initial_void_ratio, expected(draft), draft.choice)
