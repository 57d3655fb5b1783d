"""The text of a file, whatever it is encoded in: UTF-8 and UTF-16 by their bytes, the older encodings by which of them makes known words of the header."""

from __future__ import annotations

import codecs
import re
from collections.abc import Callable
from dataclasses import dataclass

from charset_normalizer import from_bytes

from graincal.errors import InputError
from graincal.laboratory.decisions import Decision, Question

ENCODINGS = (
    "cp1252", "cp1251", "gb18030", "cp1250", "cp1254", "shift_jis", "euc_kr", "big5", "koi8_r", "iso8859_7", "cp1253", "cp866", "iso8859_2", "mac_roman", "cp850",
    "euc_jp",
)  # fmt: skip
"""Tried for a file that is not UTF-8, in this order among those under which as many names of columns are known. In all of them digits and marks are ASCII."""
SNIFFED_BYTES = 65536
_MARKS = (codecs.BOM_UTF8, codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
_CONTROL_CHARACTERS = re.compile("[\x00-\x08\x0e-\x1f\x7f-\x84\x86-\x9f]")


@dataclass(frozen=True)
class Text:
    """A file's text and its encoding, with what proves it or what is asked because nothing does."""

    text: str
    encoding: str
    byte_order_mark: bool
    decided: tuple[Decision, ...] = ()
    questions: tuple[Question, ...] = ()


def decode(raw: bytes, path: str, encoding: str | None, known: Callable[[str], int]) -> Text:
    """The text of a file's bytes. `encoding` is what is said of it; `known` counts the names of columns in a text that are known.

    Raises InputError for an encoding that does not exist or that the file is not in, and for a file that is no text.
    """
    marked = raw.startswith(_MARKS)
    if encoding is not None:
        return Text(_decode_as(raw, path, encoding), encoding, marked)
    # Some loggers reserve the end of a file.
    raw = raw if b"\x00" not in raw or raw.startswith(_MARKS[1:]) else _without_padding(raw)
    certain = "utf-16" if raw.startswith(_MARKS[1:]) else _utf16_without_mark(raw) or "utf-8-sig"
    if (text := _try(raw, certain)) is not None:
        unmarked = certain.startswith("utf-16-")
        decided = (Decision("encoding", certain, "every other byte of it is zero"),) if unmarked else ()
        return Text(text, certain.removesuffix("-sig"), marked, decided)
    texts = {each: text for each in ENCODINGS if (text := _try(raw, each)) is not None} if not marked and b"\x00" not in raw else {}
    if not texts:
        raise InputError(f"{path}: this is not a text file, and delimited text such as CSV was expected.")
    counts = {each: known(text) for each, text in texts.items()}
    best = max(counts, key=lambda each: counts[each])
    if counts[best]:
        names = f"{counts[best]} names of columns are known words in it" if counts[best] > 1 else "a name of a column is a known word in it"
        return Text(texts[best], best, False, (Decision("encoding", best, f"the file is not UTF-8 and {names}"),))
    return _asked(raw, texts)


def _try(raw: bytes, encoding: str) -> str | None:
    try:
        text = raw.decode(encoding)
    except UnicodeDecodeError:
        return None
    return None if _CONTROL_CHARACTERS.search(text) else text


def _decode_as(raw: bytes, path: str, encoding: str) -> str:
    try:
        text = raw.decode(encoding)
    except LookupError:
        raise InputError(f"{path}: there is no encoding '{encoding}', and one such as utf-8, cp1252 or gb18030 was expected.") from None
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise InputError(
            f"{path}: line {line} is not in the encoding '{encoding}' (byte {raw[error.start]:#04x}), and another encoding was expected."
        ) from None
    if "\x00" in text:
        raise InputError(f"{path}: this is not text in the encoding '{encoding}', and delimited text such as CSV was expected.")
    return text.removeprefix("\ufeff")


def _without_padding(raw: bytes) -> bytes:
    stripped = raw.rstrip(b"\x00")
    return raw if b"\x00" in stripped else stripped


def _utf16_without_mark(raw: bytes) -> str | None:
    """UTF-16 of mostly ASCII: every other byte is zero."""
    head = raw[:SNIFFED_BYTES]
    pairs = len(head) // 2
    if pairs < 4:
        return None
    zeros = (head[0::2].count(0) / pairs, head[1::2].count(0) / pairs)
    return "utf-16-le" if zeros[1] > 0.5 > 10 * zeros[0] else "utf-16-be" if zeros[0] > 0.5 > 10 * zeros[1] else None


def _asked(raw: bytes, texts: dict[str, str]) -> Text:
    """The likeliest encoding by the letters, to show the names in; which it is, is asked."""
    head = raw[:SNIFFED_BYTES]
    lines = head[: head.rfind(b"\n") + 1] if len(raw) > SNIFFED_BYTES else head
    # Numbers say nothing of the letters.
    lines = b"\n".join(line for line in lines.splitlines() if max(line, default=0) > 127)
    found = from_bytes(lines, cp_isolation=list(texts)).best()
    likely = found.encoding if found is not None and found.encoding in texts else next(iter(texts))
    sentence = f"The file is not UTF-8, and no name of a column is known in any other encoding: {likely} is shown, and numbers are the same in all."
    return Text(texts[likely], likely, False, (), (Question("encoding", sentence, tuple(texts), likely, "--encoding"),))
