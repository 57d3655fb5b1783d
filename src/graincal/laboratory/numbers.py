"""Numbers as laboratory files print them."""

from __future__ import annotations

import math
import re

LARGEST_NUMBER = 1e100
"""No measurement is larger, and none overflows when made SI."""
_NUMBER = re.compile(r"[+-]?(?:\d+(?P<mark>[.,])?\d*|(?P<leading>[.,])\d+)(?:[eE][+-]?\d+)?")
_NOT_A_NUMBER = re.compile(r"[+-]?(?:nan|inf|infinity)", re.IGNORECASE)
_DIGITS_AND_MARKS = re.compile(r"[+-]?\d[\d.,' \u00a0\u202f]*(?:[eE][+-]?\d+)?")


def is_number(cell: str) -> bool:
    """Whether a cell reads as a number under one decimal mark or the other."""
    return bool(_NUMBER.fullmatch(cell) or _NOT_A_NUMBER.fullmatch(cell))


def decimal_mark(cell: str) -> str | None:
    """The decimal mark that a number's cell shows, `.` or `,`, if it shows one."""
    found = _NUMBER.fullmatch(cell)
    return (found["mark"] or found["leading"]) if found else None


def read_number(cell: str, decimal: str) -> float:
    """The number in a cell; NaN for a gap, that is an empty cell.

    Raises ValueError, saying what was found, for anything else: words, the text nan or inf, a thousands separator, the other decimal mark. Dropping
    its row like a gap would thin the reference where nobody looks.
    """
    if not cell:
        return math.nan
    if _NOT_A_NUMBER.fullmatch(cell):
        raise ValueError(f"says '{cell}', and a reference takes finite numbers (an empty cell is a gap)")
    if _NUMBER.fullmatch(cell) and decimal_mark(cell) in (None, decimal):
        value = float(cell.replace(",", "."))
        if abs(value) > LARGEST_NUMBER:
            raise ValueError(f"says '{cell}', which is too large to be a measurement")
        return value
    if _DIGITS_AND_MARKS.fullmatch(cell):
        raise ValueError(f"says '{cell}', and numbers here have the decimal mark '{decimal}' and no thousands separator")
    raise ValueError(f"says '{cell}', and a number was expected (an empty cell is a gap)")
