"""What stands above the rows of numbers: the names of the columns, on one line or two, names of groups of columns, and units."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

from graincal.errors import InputError
from graincal.laboratory.numbers import reads_as_number
from graincal.laboratory.rows import SNIFFED_LINES, SPACE, Grid, Row, comment_text, shape, split, words
from graincal.laboratory.units import find_unit, split_header
from graincal.laboratory.vocabulary import guess

LINES_ABOVE = 200
"""So many lines above the numbers are looked at."""
LONGEST_UNIT = 8
"""Letters of a unit that is not known: longer words above the numbers are remarks."""


@dataclass(frozen=True)
class Heading:
    """Names, units and groups of the columns (each empty, or one text a column), the line of the names (0 without), and the lines that are no remarks.

    `first` is the line of the first row of numbers; `misfit` says, as the end of a sentence, why there are no names.
    """

    first: int
    names: tuple[str, ...] = ()
    line: int = 0
    units: tuple[str, ...] = ()
    groups: tuple[str, ...] = ()
    used: frozenset[int] = frozenset()
    misfit: str = ""


@dataclass(frozen=True)
class _Line:
    """A line above the numbers: its cells between the file's delimiter, and its text (empty for a row of a sheet)."""

    number: int
    cells: tuple[str, ...]
    text: str = ""
    comment: bool = False


@dataclass(frozen=True)
class _Names:
    """A line taken for names of the columns. `native` where they stand between the file's delimiter."""

    at: int
    line: _Line
    names: tuple[str, ...]
    native: bool
    score: tuple[int, bool, bool, int] = field(default=(0, False, False, 0))


def find_heading(grid: Grid) -> Heading:
    """Find the names of the columns. Raises InputError for a line of units that cannot be told apart."""
    numeric = [row for row in grid.rows[:SNIFFED_LINES] if row.holds_numbers]
    width, widest = shape(numeric)
    first = next((row for row in numeric if 2 * len(row.filled) > width), numeric[0])
    heading = _heading(grid, first.line, width, widest)
    if known(heading.names) == 0 and (later := _after_other_numbers(grid, numeric, first.line)):
        below = _heading(grid, later, width, widest)
        heading = below if known(below.names) else heading
    return heading


def known(names: Sequence[str]) -> int:
    """How many names are those of quantities."""
    return sum(1 for name in names if name and guess(name)[0] is not None)


def _after_other_numbers(grid: Grid, numeric: list[Row], first: int) -> int | None:
    """The first row of numbers below a line of names that itself stands below a few rows of numbers: those are remarks."""
    above = 0
    for before, row in zip(grid.rows, grid.rows[1:11], strict=False):
        above += before.holds_numbers
        if before.line >= first and not before.holds_numbers and row.holds_numbers and _are_names(before.cells):
            return row.line if 2 * above < len(numeric) else None
    return None


def _heading(grid: Grid, first: int, width: int, widest: int) -> Heading:
    above = _lines_above(grid, first)
    found = _names(above, grid.delimiter, width, widest)
    if found is None:
        # Fewer names than numbers between commas are mostly decimal commas: the names are kept, and the rows refused.
        names = next((line.cells for line in reversed(above) if grid.delimiter == "," and not line.comment and _are_names(line.cells)), ())
        line = next((line.number for line in reversed(above) if line.cells == names), 0) if names else 0
        return Heading(first, names, line, used=frozenset([line] if line else []), misfit=_misfit(above, first, width))
    found, joined = _joined(above, found, grid.delimiter, width, widest)
    used = {found.line.number, *joined}
    groups, line = _groups(above, found, min([found.at, *(at for at, line in enumerate(above) if line.number in used)]))
    units, units_line = _units(above, found, used, grid, width, widest)
    used |= {number for number in (line, units_line) if number}
    return Heading(first, found.names, found.line.number, units, groups, frozenset(used))


def _lines_above(grid: Grid, first: int) -> list[_Line]:
    rows = [_Line(row.line, row.cells, grid.lines[row.line - 1] if grid.lines else "") for row in grid.rows if row.line < first][-LINES_ABOVE:]
    for row in [row for row in grid.comments if row.line < first][-LINES_ABOVE:]:
        marked = row.cells[0]
        text = comment_text(marked) or ""
        cells = next(split([text], grid.delimiter, grid.path), Row(row.line, ())).cells
        rows.append(_Line(row.line, cells, text, comment=True))
        if marked[1:2] == grid.delimiter:
            # The mark itself may be a name: "#,strain,stress".
            rows.append(_Line(row.line, next(split([marked], grid.delimiter, grid.path)).cells, marked, comment=True))
    return sorted(rows, key=lambda line: line.number)


def _are_names(cells: Sequence[str]) -> bool:
    """Two words at least, and no number; dashes drawn below names are no words."""
    filled = [cell for cell in cells if cell]
    return len(filled) >= 2 and not any(map(reads_as_number, filled)) and 2 * sum(any(map(str.isalpha, cell)) for cell in filled) >= len(filled)


def _are_units(cells: Sequence[str]) -> bool:
    """Known units for the most part, and no quantity among the others; or all in brackets."""
    filled = [cell for cell in cells if cell]
    units = sum(find_unit(cell.strip("[]()")) is not None for cell in filled)
    if not units and len(filled) < 2:
        return False
    if any(find_unit(unit or "?") is not None and find_unit(name) is None for name, unit in map(split_header, filled)):
        return False  # names that go on, with their units behind them
    bracketed = all(cell[0] in "[(" and cell[-1] in ")]" for cell in filled)
    return bracketed or (2 * units >= len(filled) and not any(find_unit(cell.strip("[]()")) is None and known([cell]) for cell in filled))


def _ways(line: _Line, delimiter: str, width: int, widest: int) -> Iterator[tuple[tuple[str, ...], bool]]:
    """The ways to take a line apart into as many cells as there are columns, the likeliest first, and whether it is by the file's delimiter."""
    filled = tuple(cell for cell in line.cells if cell)
    if delimiter != SPACE and len(line.cells) >= width and not (len(line.cells) > widest and len(filled) == width):
        yield _trimmed(line.cells, width), True
    elif delimiter == SPACE and len(line.cells) == width:
        yield line.cells, True
    if len(filled) == width and filled != line.cells:
        yield filled, delimiter != SPACE
    text = line.text.strip()
    # Words of a comment are names only where words are what the file is made of, or where they are known.
    apart = (
        words(text) if not line.comment or delimiter == SPACE or known(words(text)) else (),
        re.split(r"\t+|\s{2,}(?![\[(])", text),
        re.split(r"\t+", text),
        re.split(r"\s*[;,]\s*", text),
        re.split(r"(?<!/)\s+(?![\[(/])", text),
    )
    for way, parts in enumerate(apart if text else ()):
        cells = tuple(cell.strip().strip('"') for cell in parts)
        # A remark may have as many words as there are columns.
        if len(cells) == width and cells != line.cells and (way in (1, 2) or delimiter == SPACE or known(cells)):
            yield cells, False


def _trimmed(cells: tuple[str, ...], width: int) -> tuple[str, ...]:
    while len(cells) > width and not cells[-1]:
        cells = cells[:-1]
    return cells


def _names(above: list[_Line], delimiter: str, width: int, widest: int) -> _Names | None:
    """The line that names the columns: most known names count, then whether all columns have one, then the file's own delimiter, and the nearest."""
    found = []
    for at, line in enumerate(above):
        for cells, native in _ways(line, delimiter, width, widest):
            if _are_names(cells):
                cells = tuple(" ".join(cell.split()) for cell in cells)
                filled = sum(map(bool, cells))
                score = (known(cells) + (2 * min(filled, width)) // width, native, not line.comment, at)
                found.append(_Names(at, line, cells, native, score))
                break
    plain = [names for names in found if not (_are_units(names.names) and any(other.at < names.at for other in found))]
    return max(plain or found, key=lambda names: names.score, default=None)


def _joined(above: list[_Line], found: _Names, delimiter: str, width: int, widest: int) -> tuple[_Names, tuple[int, ...]]:
    """Names that go over two lines, joined, where more of them are known then, or where two that are the same become two; and the other line."""
    for step in (-1, 1):
        if not 0 <= (at := found.at + step) < len(above) or above[at].comment != found.line.comment:
            continue
        for cells, _ in _ways(above[at], delimiter, width, widest):
            if len(cells) != len(found.names) or any(map(reads_as_number, cells)) or _are_units(cells):
                continue
            pairs = zip(cells, found.names, strict=True) if step < 0 else zip(found.names, cells, strict=True)
            both = tuple(" ".join(f"{upper} {lower}".split()) for upper, lower in pairs)
            parted = all(cells) and len(set(both)) > len(set(found.names)) and not _repeats(cells)
            if known(both) > known(found.names) or (step < 0 and parted and known(both) == known(found.names)):
                return replace(found, names=both, line=above[max(at, found.at)], at=max(at, found.at)), (above[at].number, found.line.number)
    return found, ()


def _repeats(cells: Sequence[str]) -> bool:
    return any(cell == after for cell, after in zip(cells, cells[1:], strict=False))


def _groups(above: list[_Line], found: _Names, top: int) -> tuple[tuple[str, ...], int]:
    """The names of groups of columns on the line above the names, filled forward, and that line; nothing and 0 where there are none."""
    if not found.native or top == 0:
        return (), 0
    line, names = above[top - 1], found.names
    starts = [at for at, cell in enumerate(line.cells[: len(names)]) if cell]
    if len(starts) < 2 or any(line.cells[len(names) :]) or line.comment != found.line.comment:
        return (), 0
    groups: list[str] = []
    for at in range(len(names)):
        cell = line.cells[at] if at < len(line.cells) else ""
        groups.append(cell or (groups[-1] if groups else ""))
    named = [pair for pair in zip(groups, names, strict=True) if pair[1]]
    doubled = len({name for _, name in named}) < len(named) and len(set(named)) == len(named)
    span = len(names) // len(starts)
    even = span > 1 and starts == list(range(0, len(names), span)) and not any(map(reads_as_number, filter(None, line.cells)))
    return (tuple(groups), line.number) if even or (doubled and (len(starts) < len(names) or _repeats(groups))) else ((), 0)


def _units(above: list[_Line], found: _Names, used: set[int], grid: Grid, width: int, widest: int) -> tuple[tuple[str, ...], int]:
    """The units on a line between the names and the numbers, as they are printed but for brackets, and that line; nothing and 0 without."""
    for line in above[found.at + 1 :]:
        if line.number in used:
            continue
        ways = [*(cells for cells, _ in _ways(line, grid.delimiter, width, widest)), tuple(line.text.split())]
        for cells in ways:
            if len(cells) in (width, len(found.names)) and (_are_units(cells) or (line.comment == found.line.comment and _may_be_units(cells, found))):
                return tuple(_bare(cell) for cell in cells), line.number
        if line.cells and found.native and grid.delimiter != SPACE and len(line.cells) > 1 and _are_units(line.cells):
            return tuple(_bare(cell) for cell in line.cells), line.number
        if _are_units(line.text.split()):
            return _placed(line, found, grid), line.number
    return (), 0


def _bare(cell: str) -> str:
    """A unit without its brackets: one for no unit is none that is unknown."""
    return cell.strip().strip("[]()").strip()


def _may_be_units(cells: Sequence[str], found: _Names) -> bool:
    """A short word for each of the columns, below names that are known: units that are not."""
    if not all(cells) or known(found.names) == 0 or known(cells) or any(map(reads_as_number, cells)):
        return False
    return all(len(cell) <= LONGEST_UNIT and cell[-1].isalnum() and " " not in cell for cell in cells)


def _placed(line: _Line, found: _Names, grid: Grid) -> tuple[str, ...]:
    """Units for some of the columns: each belongs to the name that it stands below. Raises InputError for one that stands below none."""
    names, units = grid.lines[found.line.number - 1].expandtabs(), grid.lines[line.number - 1].expandtabs()
    spans, at = [], 0
    for name in found.names:
        at = names.find(name, at)
        spans.append((at, at + len(name)))
        at += len(name)
    placed = [""] * len(found.names)
    # Names one space apart say nothing of what stands below which.
    apart = bool(re.search(r"\s{2,}", names.strip()))
    for token in re.finditer(r"\S+", units):
        over = [index for index, (start, end) in enumerate(spans) if start >= 0 and start < token.end() and token.start() < end]
        if len(over) != 1 or placed[over[0]] or not apart:
            given = len(units.split())
            raise InputError(
                f"{grid.path}: line {line.number} gives {given} unit{'s' if given > 1 else ''} where line {found.line.number} has {len(found.names)} names,"
                " and a unit for each name was expected (- for none)."
            )
        placed[over[0]] = _bare(token[0])
    return tuple(placed)


def _misfit(above: list[_Line], first: int, width: int) -> str:
    """Why no line names the columns, as the end of a sentence."""
    for line in reversed(above):
        spaced = tuple(re.split(r"\t+|\s{2,}(?![\[(])", line.text.strip()))
        cells = next((cells for cells in (line.cells, spaced, tuple(words(line.text))) if _are_names(cells)), None)
        if cells is None or _are_units(cells) or (line.comment and not known(cells)):
            continue
        return f"line {line.number} has {len([cell for cell in cells if cell])} names above {width} columns of numbers"
    return f"line {first} is numbers already, and no line above it names the columns"
