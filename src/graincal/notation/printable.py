"""Text from outside made fit to be shown: it moves no cursor, turns no line around, hides nothing and ends."""

from __future__ import annotations

import json
import re
import unicodedata
from typing import Any

MOST = 1_000
"""Characters of a text, where nothing else is said."""

_BREAKS = re.compile("\r\n|[\n\r\v\f\x1c-\x1e\x85\u2028\u2029]")
_UNUSUAL = re.compile("[^\n -~]")
# Letters and marks that show nothing at all; what else shows nothing has a category of its own.
_BLANK = frozenset("\u034f\u115f\u1160\u17b4\u17b5\u180b\u180c\u180d\u180f\u2800\u3164\uffa0") | frozenset(map(chr, range(0xE0000, 0xE1000)))
_HIDDEN = ("Cc", "Cf", "Cs", "Co", "Cn")


def printable(text: object, most: int | None = MOST, *, lines: bool = False) -> str:
    r"""The text with a visible escape, such as `\x1b`, in the place of each character that is not shown: controls, lone surrogates, marks of direction, other invisible ones.

    A line break becomes a space, or with `lines` a plain one. What is longer than `most` characters (None for no limit) is cut, with "…" at its end. What is no text is shown as Python writes it.
    """
    text = as_text(text)
    if most is not None and len(text) > most:
        text = f"{text[: max(0, most - 1)]}…"
    if not (text.isascii() and text.isprintable()):
        text = _UNUSUAL.sub(lambda found: _shown(found[0]), _BREAKS.sub("\n" if lines else " ", text))
    return text if most is None or len(text) <= most else f"{text[: max(0, most - 1)]}…"


def is_printable(text: str, most: int = MOST) -> bool:
    """Whether a name can be shown as it is, and shows something."""
    return bool(text.strip()) and printable(text, most) == text


def printable_json(value: Any, **options: Any) -> str:
    """A value as JSON, in which characters that are not shown are escapes, which mean the same."""
    document = json.dumps(value, ensure_ascii=False, **options)
    return _UNUSUAL.sub(lambda found: found[0] if _is_shown(found[0]) else json.dumps(found[0])[1:-1], document)


def as_text(value: object) -> str:
    """The value's own text: never an object of a class of somebody's, which may do anything."""
    if isinstance(value, str):
        return str.__str__(value)
    try:
        return str.__str__(str(value))
    # Whatever somebody's own class does here.
    except Exception:
        return f"an object of the class {type(value).__name__}"


def _shown(char: str) -> str:
    if _is_shown(char):
        return char
    number = ord(char)
    return f"\\x{number:02x}" if number < 0x100 else f"\\u{number:04x}" if number < 0x10000 else f"\\U{number:08x}"


def _is_shown(char: str) -> bool:
    return unicodedata.category(char) not in _HIDDEN and char not in _BLANK and char not in "\u2028\u2029"
