"""Text from outside: nothing of it reaches a terminal but what is shown, and names that can be shown stay as they are."""

import json
import sys
import unicodedata

import pytest

from graincal.notation.printable import is_printable, printable, printable_json

HOSTILE = "x\x1b[2J\x1b[31mRED\x07\x9b1m\u202e\u200b\u2066\ud83e.\udce9\ufeff"


@pytest.mark.parametrize("name", ["σ1'/σ3'", "Axial strain [%]", "内摩擦角 φ", "деформация", "e\u0301", "قوة", "☀\ufe0f", "a\u00a0b", "1 µε × 10⁻⁶ − 2"])
def test_what_is_shown_stays_as_it_is(name):
    assert printable(name) == name and is_printable(name)


def test_what_is_not_shown_becomes_an_escape():
    shown = printable(HOSTILE)
    assert shown == r"x\x1b[2J\x1b[31mRED\x07\x9b1m\u202e\u200b\u2066\ud83e.\udce9\ufeff"
    assert printable(shown) == shown and not is_printable(HOSTILE)
    assert printable("\U000e0041") == r"\U000e0041" and printable("a\u3164") == r"a\u3164"


def test_no_character_moves_a_cursor_turns_a_line_or_hides():
    for number in range(sys.maxunicode + 1):
        left = printable(chr(number), None)
        assert all(unicodedata.category(each) not in ("Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp") for each in left)


@pytest.mark.parametrize("parted", ["a\nb", "a\r\nb", "a\rb", "a\u2028b", "a\x85b", "a\x0bb"])
def test_a_line_break_is_a_space_or_stays_one(parted):
    assert printable(parted) == "a b" and printable(parted, lines=True) == "a\nb"


def test_long_text_is_cut():
    assert printable("a" * 5_000_000, 10) == "a" * 9 + "…" and printable("a" * 10, 10) == "a" * 10
    assert len(printable("\x1b" * 20, 20)) == 20 and printable("\x1b" * 5, 20) == r"\x1b" * 5
    assert len(printable("\r\n" * 20, 20)) <= 20


def test_what_is_no_text_is_shown_all_the_same():
    class Hostile:
        def __str__(self):
            raise SystemError("no")

    class Name(str):
        def __str__(self):
            return "\x1b"

    assert printable(None) == "None" and printable(Hostile()) == "an object of the class Hostile"
    assert type(printable(Name("a"))) is str and printable(Name("a")) == "a"


def test_json_means_the_same():
    document = {HOSTILE: [HOSTILE, "σ", 1.5, None]}
    written = printable_json(document, indent=1)
    assert json.loads(written) == document and "σ" in written
    assert all(unicodedata.category(each) not in ("Cc", "Cf", "Cs") for each in written.replace("\n", ""))
