"""The rows of a file of text, whatever it is delimited by: cells with the line each row stands on, and nothing understood yet."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

from graincal.errors import InputError
from graincal.laboratory.numbers import is_number, reads_as_number, shown, without_spaces
from graincal.laboratory.units import find_unit

SPACE = " "
SNIFFED_LINES = 2000
"""So many lines are enough to tell the delimiter and the decimal mark."""
DELIMITERS = ("\t", ";", ",", SPACE)
# A spreadsheet's error values begin like a comment.
_HASH = re.compile(r"#(?!N/A|DIV/0!|VALUE!|REF!|NUM!|NAME\?|NULL!)")
# Words, or what stands in quotation marks. A name keeps its unit, `q [kPa]`.
_WORDS = re.compile(r'"[^"]*"|(?:\S|\s+(?=[\[(]))+')


@dataclass(frozen=True, slots=True)
class Row:
    """One row: the line of the file it stands on, counted from 1, and its cells."""

    line: int
    cells: tuple[str, ...]

    def cell(self, index: int) -> str:
        return self.cells[index] if index < len(self.cells) else ""

    @property
    def filled(self) -> list[str]:
        return [cell for cell in self.cells if cell]

    @property
    def holds_numbers(self) -> bool:
        """Two numbers at least, and more numbers than words: lines above a header ("Pressure; 500; kPa") hold fewer."""
        filled = self.filled
        numbers = sum(map(reads_as_number, filled))
        return numbers >= 2 and 2 * numbers > len(filled)


@dataclass(frozen=True)
class Grid:
    """A file or a sheet in rows: those that are not blank, the comments (their text in one cell, with its mark), and for text the lines themselves."""

    path: str
    delimiter: str
    rows: list[Row]
    comments: list[Row] = field(default_factory=list)
    lines: Sequence[str] = ()


def comment_text(line: str) -> str | None:
    """What stands behind the mark of a comment line, `#`, `%`, `//`, `!` or `;`; None for any other line."""
    line = line.strip()
    if line[:1] not in ("#", "%", "/", "!", ";"):
        return None
    if line[0] == "#":
        return line.lstrip("#") if _HASH.match(line) else None
    if line[0] == "/":
        return line.lstrip("/") if line.startswith("//") else None
    if line[0] == "!":
        return line.lstrip("!")
    tokens = [token for token in re.split(r"[\s,;]+", line) if token]
    if line[0] == "%":
        # A line of units may begin with one: "% % kPa".
        units = sum(find_unit(token.strip("[]()")) is not None for token in tokens)
        return None if 2 * units >= len(tokens) else line.lstrip("%")
    # A row between semicolons may begin with an empty cell: ";5", ";%;kPa".
    text = line.lstrip("; ")
    return text if text and ";" not in text and len(tokens) > 1 else None


def delimited(path: str, text: str) -> Grid:
    """Text taken apart. Raises InputError for text without rows of numbers, and for one without anything."""
    # The typographic minus is a minus, in cells and in names.
    lines = re.split(r"\r\n|\r|\n", text.replace("\u2212", "-"))
    comments = [Row(number, (line.strip(),)) for number, line in enumerate(lines, 1) if comment_text(line) is not None]
    content = list(lines)
    for row in comments:
        content[row.line - 1] = ""
    if not any(line.strip() for line in content):
        raise InputError(f"{path}: the file is empty, and a header line with rows of numbers below it was expected.")
    delimiter = _delimiter(content, path)
    return Grid(path, delimiter, _without_doubled_tabs(list(split(content, delimiter, path)), delimiter), comments, lines)


def _delimiter(lines: list[str], path: str) -> str:
    """The delimiter under which most rows hold numbers and most of their cells are numbers."""
    filled_lines = [line for line in lines if line.strip()]
    best = (0, 0.0), ""
    for delimiter in DELIMITERS:
        numeric = [row for row in split(filled_lines[:SNIFFED_LINES], delimiter, path) if row.holds_numbers]
        filled = [cell for row in numeric for cell in row.filled]
        score = (len(numeric), sum(map(reads_as_number, filled)) / max(len(filled), 1))
        if score > best[0]:
            best = score, delimiter
    if best[1]:
        return best[1]
    if len(filled_lines) == 1:
        raise InputError(f"{path}: there is only a header, '{shown(filled_lines[0].strip())}', and rows of numbers were expected below it.")
    raise InputError(f"{path}: no line holds two numbers, and rows of numbers between commas, semicolons, tabs or spaces were expected.")


def split(lines: Sequence[str], delimiter: str, path: str) -> Iterator[Row]:
    """The rows that are not blank. Cells lose outer white space, and numbers that between their thousands, where it delimits nothing."""
    for number, record in _space_records(lines) if delimiter == SPACE else _csv_records(lines, delimiter, path):
        cells = tuple([cell.strip() for cell in record])
        if any(cells):
            if delimiter != SPACE and any(" " in cell or "\u00a0" in cell or "\u202f" in cell for cell in cells):
                cells = tuple(without_spaces(cell) if delimiter != "," or "," in cell or " " not in cell else cell for cell in cells)
            yield Row(number, cells)


def _csv_records(lines: Sequence[str], delimiter: str, path: str) -> Iterator[tuple[int, list[str]]]:
    reader = csv.reader([line + "\n" for line in lines], delimiter=delimiter, skipinitialspace=delimiter != "\t")
    number = 1
    try:
        for record in reader:
            yield number, record
            number = reader.line_num + 1
    except csv.Error as error:
        raise InputError(f"{path}: line {number} cannot be taken apart ({error}), and closed quotation marks were expected.") from None


def _space_records(lines: Sequence[str]) -> Iterator[tuple[int, list[str]]]:
    for number, line in enumerate(lines, 1):
        if line.strip():
            yield number, words(line)


def words(line: str) -> list[str]:
    """What stands between white space; a name keeps its unit in brackets."""
    if '"' not in line and "[" not in line and "(" not in line:
        return line.split()
    return [word.strip().strip('"') for word in _WORDS.findall(line.strip())]


def _without_doubled_tabs(rows: list[Row], delimiter: str) -> list[Row]:
    """Rows whose columns are set out by one tab or more: as many numbers in each, and not as many cells."""
    numeric = [row for row in rows[:SNIFFED_LINES] if row.holds_numbers]
    if delimiter != "\t" or len({len(row.filled) for row in numeric}) > 1 or len({len("\t".join(row.cells).rstrip("\t").split("\t")) for row in numeric}) == 1:
        return rows
    return [Row(row.line, tuple(row.filled)) for row in rows]


def without_gaps(grid: Grid) -> Grid | None:
    """The rows of a file between tabs without empty cells, where that leaves as many in each row of numbers; None where it does not."""
    numeric = [row for row in grid.rows[:SNIFFED_LINES] if row.holds_numbers]
    if grid.delimiter != "\t" or len({len(row.filled) for row in numeric}) > 1:
        return None
    return replace(grid, rows=[Row(row.line, tuple(row.filled)) for row in grid.rows])


def shape(rows: Sequence[Row]) -> tuple[int, int]:
    """How many columns most of the rows of numbers have, empty ones at their ends aside, and how many the widest has."""
    widths = Counter[int]()
    widest = 0
    for row in rows:
        width = next((at for at in range(len(row.cells), 0, -1) if row.cells[at - 1]), 0)
        widths[width] += 1
        widest = max(widest, len(row.cells))
    return max(widths, key=lambda width: (widths[width], width)), widest


def refuse_broken_rows(rows: Sequence[Row], header: Sequence[str], path: str) -> None:
    """Refuse more numbers than names, and an open quotation mark, which would swallow the rows below it."""
    for row in rows:
        if any("\n" in cell for cell in row.cells):
            raise InputError(f"{path}: line {row.line} opens a quotation mark, and its end was expected on the same line.")
        if len(row.cells) > len(header) and row.holds_numbers and any(map(is_number, row.cells[len(header) :])):
            raise InputError(
                f"{path}: line {row.line} has {len(row.cells)} cells where the header has {len(header)} names,"
                " and one number for each name was expected (decimal commas need another delimiter than the comma)."
            )


def without_cells(row: Row, header: Sequence[str], path: str) -> Row:
    """A row of numbers between white space that is too short: which of its cells it lacks cannot be told, so it lacks all. Refuse one with words."""
    if word := next((cell for cell in row.cells if not reads_as_number(cell)), None):
        raise InputError(
            f"{path}: line {row.line} says '{shown(word)}', and a number for each of the {len(header)} columns was expected (a line of fewer numbers is a gap)."
        )
    return Row(row.line, ())
