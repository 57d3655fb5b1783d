"""Numbers as laboratory files print them: with either decimal mark, with thousands parted, with a unit behind them."""

from __future__ import annotations

import math
import re

from graincal.laboratory.units import Unit, find_unit
from graincal.notation.printable import printable

LARGEST_NUMBER = 1e100
"""No measurement is larger, and none overflows when made SI."""
_NUMBER = re.compile(r"[+-]?(?:\d+(?P<mark>[.,])?\d*|(?P<leading>[.,])\d+)(?:[eE][+-]?\d+)?")
_NOT_A_NUMBER = re.compile(r"[+-]?(?:nan|inf|infinity)", re.IGNORECASE)
_DIGITS_AND_MARKS = re.compile(r"[+-]?\d[\d.,' \u00a0\u202f]*(?:[eE][+-]?\d+)?")
# A zero before the first mark parts no thousands: 0,123 is a decimal number.
_GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}(?P<first>[.,'\u2019])\d{3}(?P<more>(?:(?P=first)\d{3})*)(?:(?!(?P=first))(?P<mark>[.,])\d*)?")
_GROUPED_BY_SPACES = re.compile(r"[+-]?[1-9]\d{0,2}(?:[ \u00a0\u2009\u202f]\d{3})+(?:[.,]\d*)?")
_WITH_UNIT = re.compile(r"(?P<number>[+-]?[\d.,][\d.,'\u2019]*(?:[eE][+-]?\d+)?)[ \u00a0\u202f]?(?P<unit>[^\d\s.,'].{0,11})")


LONGEST_SHOWN = 100
"""Characters of a cell or a name in a message."""


def shown(cell: str) -> str:
    """A cell or a name of a column as it stands in a message: printable, and its beginning where it is long."""
    return printable(cell, LONGEST_SHOWN)


def is_number(cell: str) -> bool:
    """Whether a cell reads as a number under one decimal mark or the other."""
    return bool(_NUMBER.fullmatch(cell) or _NOT_A_NUMBER.fullmatch(cell))


def reads_as_number(cell: str) -> bool:
    """Whether a cell is a number, perhaps with thousands parted or with a known unit behind it."""
    return is_number(cell) or (cell[:1] in "+-.,0123456789" and bool(_GROUPED.fullmatch(cell) or split_unit(cell)[1]))


def split_unit(cell: str) -> tuple[str, Unit | None]:
    """A number and the known unit behind it, `12.3 kPa` or `0.40%`; the cell as it is and None where there is no such unit."""
    found = _WITH_UNIT.fullmatch(cell)
    if found is None:
        return cell, None
    unit = find_unit(found["unit"]) if (_NUMBER.fullmatch(found["number"]) or _GROUPED.fullmatch(found["number"])) else None
    # A dash or a digit behind a number is no unit, though either may stand for "none" in a header.
    return (found["number"], unit) if unit is not None and found["unit"].strip(" \u00a0").strip("-\u2013\u2014") else (cell, None)


def decimal_mark(cell: str) -> str | None:
    """The decimal mark that a number's cell shows, `.` or `,`, if it shows one."""
    found = _NUMBER.fullmatch(cell)
    return (found["mark"] or found["leading"]) if found else None


def is_plain(cell: str, decimal: str) -> bool:
    """Whether a cell is a number with that decimal mark or none, and nothing that parts thousands."""
    found = _NUMBER.fullmatch(cell)
    return found is not None and (found["mark"] or found["leading"]) in (None, decimal)


def proven_mark(cell: str) -> str | None:
    """The decimal mark that a cell proves: none for `1,012`, which may be either; the point for `1,012.7` and for `1,012,345`."""
    grouped = _GROUPED.fullmatch(cell)
    if grouped is None:
        return decimal_mark(cell)
    return grouped["mark"] or ({".": ",", ",": "."}.get(grouped["first"]) if grouped["more"] else None)


def part_thousands(cell: str, decimal: str) -> tuple[str, str, bool] | None:
    """A number without what parts its thousands, the mark that did, and whether the cell alone proves it; None for a cell in which none are parted."""
    found = _GROUPED.fullmatch(cell)
    if found is None or found["first"] == decimal or found["mark"] not in (None, decimal):
        return None
    return cell.replace(found["first"], ""), found["first"], bool(found["mark"] or found["more"] or found["first"] not in ".,")


def without_spaces(cell: str) -> str:
    """A number whose thousands are parted by spaces, without them; any other cell as it is."""
    return re.sub(r"\s", "", cell) if _GROUPED_BY_SPACES.fullmatch(cell) else cell


def read_number(cell: str, decimal: str) -> float:
    """The number in a cell; NaN for a gap, that is an empty cell.

    Raises ValueError, saying what was found, for anything else: words, the text nan or inf, a thousands separator, the other decimal mark, a unit that not
    all numbers of the column have. Dropping its row like a gap would thin the reference where nobody looks.
    """
    if not cell:
        return math.nan
    if _NOT_A_NUMBER.fullmatch(cell):
        raise ValueError(f"says '{shown(cell)}', and a reference takes finite numbers (an empty cell is a gap)")
    if _NUMBER.fullmatch(cell) and decimal_mark(cell) in (None, decimal):
        value = float(cell.replace(",", "."))
        if abs(value) > LARGEST_NUMBER:
            raise ValueError(f"says '{shown(cell)}', which is too large to be a measurement")
        return value
    if _DIGITS_AND_MARKS.fullmatch(cell):
        raise ValueError(f"says '{shown(cell)}', and numbers here have the decimal mark '{decimal}' and no thousands separator")
    if split_unit(cell)[1]:
        raise ValueError(f"says '{shown(cell)}', and a unit was expected behind all numbers of the column or none, and none other than its header's")
    raise ValueError(f"says '{shown(cell)}', and a number was expected (an empty cell is a gap)")
