"""Numbers in the cells of a table made plain: without what parts thousands, and without the unit that a whole column has behind its numbers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from graincal.errors import InputError
from graincal.laboratory.numbers import decimal_mark, is_plain, part_thousands, proven_mark, reads_as_number, shown, split_unit
from graincal.laboratory.rows import SNIFFED_LINES, Row
from graincal.laboratory.units import Unit, find_unit, split_header
from graincal.laboratory.vocabulary import guess

PLAIN_THOUSANDS = 100.0
"""A column whose other numbers come so far goes on to 1,012; one that stays below does not."""


def find_decimal(rows: Sequence[Row], path: str) -> str:
    """The decimal mark that the numbers prove.

    Raises InputError where nothing proves it and there are numbers such as `1,012`, which may be either.
    """
    for chosen in (rows[:SNIFFED_LINES], rows):
        numbers = [split_unit(cell)[0] for row in chosen for cell in row.cells if not cell.isdecimal()]
        proofs = Counter(map(proven_mark, numbers))
        if proofs["."] and proofs[","]:
            # One of the two is a slip, which is refused where it is read: the mark of most numbers is taken.
            proofs = Counter(map(decimal_mark, numbers))
        if proofs["."] or proofs[","]:
            return "," if proofs[","] > proofs["."] else "."
    for row in rows:
        for cell in row.cells:
            if decimal_mark(split_unit(cell)[0]) == ",":
                whole = split_unit(cell)[0].replace(",", "")
                raise InputError(
                    f"{path}: line {row.line} says '{shown(cell)}', and nothing in the file tells whether that is {shown(split_unit(cell)[0].replace(',', '.'))} or {shown(whole)}:"
                    " numbers with a decimal point, or without anything between thousands, were expected."
                )
    return "."


def plain_numbers(rows: Sequence[Row], header: Sequence[str], units: Sequence[str], decimal: str) -> tuple[list[Row], tuple[str, ...]]:
    """The rows with plain numbers, and the units of the columns with those that stood behind the numbers of a whole column.

    Cells that cannot be told for certain stay as they are printed: `read_number` refuses them, should the column be read.
    """
    odd: set[int] = set()
    for row in rows:
        for index, cell in enumerate(row.cells):
            # Digits alone are plain, and much faster to see.
            if cell and not cell.isdecimal() and index not in odd and not is_plain(cell, decimal):
                odd.add(index)
    changes: dict[int, list[str]] = {}
    found = [*units, *[""] * (len(header) - len(units))] if odd else list(units)
    for index in odd:
        if index < len(header):
            cells, unit = _without_units([row.cell(index) for row in rows], header[index], found[index])
            changes[index] = _without_thousands(cells, decimal)
            found[index] = unit
    if not any(found):
        found = []
    if not changes:
        return list(rows), tuple(found)
    changed = [Row(row.line, tuple(changes[index][at] if index in changes else cell for index, cell in enumerate(row.cells))) for at, row in enumerate(rows)]
    return changed, tuple(found)


def _without_units(cells: list[str], header: str, printed: str) -> tuple[list[str], str]:
    """The cells of a column without the unit that stands behind all its numbers (a bare zero aside), and the column's unit, `printed` before.

    Nothing is changed where the numbers have several units or where header or `printed` say another.
    """
    parted = [split_unit(cell) for cell in cells]
    there = {unit for _, unit in parted if unit is not None}
    if len(there) != 1:
        return cells, printed
    (unit,) = there
    bare = [number for number, own in parted if own is None and reads_as_number(number) and number.strip("+-0.,")]
    stated = _stated(header, printed)
    if bare or (stated is not None and (stated.dimension, stated.factor) != (unit.dimension, unit.factor)):
        return cells, printed
    return [number for number, _ in parted], printed or unit.symbol


def _stated(header: str, printed: str) -> Unit | None:
    text = split_header(header)[1]
    return (find_unit(text) if text else None) or guess(header)[1] or (find_unit(printed) if printed else None)


def _without_thousands(cells: list[str], decimal: str) -> list[str]:
    """The cells of a column without what parts thousands, where all that are large have it, and where `1,012` can be nothing else."""
    parted = [part_thousands(cell, decimal) for cell in cells]
    marks = {found[1] for found in parted if found}
    if len(marks) != 1:
        return cells
    largest = max((abs(float(cell.replace(",", "."))) for cell in cells if is_plain(cell, decimal)), default=0.0)
    proven = any(found[2] for found in parted if found) or PLAIN_THOUSANDS <= largest
    if not proven or largest >= 1000:
        return cells
    return [found[0] if found else cell for cell, found in zip(cells, parted, strict=True)]
