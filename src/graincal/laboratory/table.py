"""The rows of a laboratory file, whatever it is delimited by: text cells with the line each stands on, and nothing understood yet."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from graincal.data import InputError
from graincal.files import unreadable
from graincal.laboratory.numbers import decimal_mark, is_number
from graincal.laboratory.units import find_unit

SPACE = " "
SNIFFED_LINES = 2000
"""So many lines are enough to tell the delimiter and the decimal mark."""
DELIMITERS = ("\t", ";", ",", SPACE)
_SPREADSHEETS = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")
_CONTROL_CHARACTERS = re.compile("[\x00-\x08\x0e-\x1f\x7f]")
# A spreadsheet's error values begin like a comment.
_COMMENT = re.compile(r"\s*#(?!N/A|DIV/0!|VALUE!|REF!|NUM!|NAME\?|NULL!)")


@dataclass(frozen=True)
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
        numbers = sum(map(is_number, self.filled))
        return numbers >= 2 and 2 * numbers > len(self.filled)

    @property
    def holds_names(self) -> bool:
        return len(self.filled) >= 2 and not any(map(is_number, self.filled))

    @property
    def holds_units(self) -> bool:
        return bool(self.filled) and all(find_unit(cell.strip("[]()")) for cell in self.filled)


@dataclass(frozen=True)
class Table:
    """A file taken apart: `header` names the columns, `units` holds the line of units below it, if there is one."""

    path: str
    encoding: str
    byte_order_mark: bool
    delimiter: str
    decimal: str
    header_line: int
    header: tuple[str, ...]
    units: tuple[str, ...]
    rows: tuple[Row, ...]
    remarks: tuple[str, ...]

    @property
    def lines(self) -> list[int]:
        return [row.line for row in self.rows]


def read_table(path: str | PathLike[str]) -> Table:
    """Read a file of delimited text: comma, semicolon, tab or white space; decimal point or comma; UTF-8, UTF-16 or Windows-1252.

    Lines that begin with # are comments; the names may stand in the last comment before the numbers. Lines above the header are remarks, and so are
    lines without a number below the last row of numbers.
    Raises InputError for a file that is missing, empty, not text, or without a header and rows of numbers.
    """
    name = str(path)
    text, encoding, marked = _decode(Path(path), name)
    lines = re.split(r"\r\n|\r|\n", text)
    comments = [Row(number, (line.strip(),)) for number, line in enumerate(lines, 1) if _COMMENT.match(line)]
    content = ["" if _COMMENT.match(line) else line for line in lines]
    if not any(line.strip() for line in content):
        raise InputError(f"{name}: the file is empty, and a header line with rows of numbers below it was expected.")

    delimiter, rows = _delimit(content, name)
    first = next(i for i, row in enumerate(rows) if row.holds_numbers)
    at = _header_index(rows, first)
    if at is not None:
        header, header_line = rows[at].cells, rows[at].line
    else:
        header, header_line = _header_in_comment(comments, lines, delimiter, rows[first], name)
    # As lines above the header, lines without any number below the last row of numbers are remarks.
    last = max(row.line for row in rows if any(map(is_number, row.cells)))
    body = [row for row in rows if header_line < row.line <= last]
    units: tuple[str, ...] = ()
    if body[0].holds_units and not body[0].holds_numbers:
        units, body = tuple(cell.strip("[]()") for cell in body[0].cells), body[1:]
    while header and not header[-1]:
        header = header[:-1]
    header = tuple(" ".join(cell.split()) for cell in header)
    _refuse_broken_rows(body, header, name)
    if delimiter == SPACE:
        body = [row if len(row.cells) == len(header) else _without_cells(row, header, name) for row in body]

    marks = Counter(decimal_mark(cell) for row in body[:SNIFFED_LINES] for cell in row.cells)
    remarks = [row for row in comments if row.line != header_line] + [row for row in rows if row.line < header_line or row.line > last]
    return Table(
        path=name,
        encoding=encoding,
        byte_order_mark=marked,
        delimiter=delimiter,
        decimal="," if marks[","] > marks["."] else ".",
        header_line=header_line,
        header=header,
        units=units,
        rows=tuple(body),
        remarks=tuple(" ".join(row.filled) for row in sorted(remarks, key=lambda row: row.line)),
    )


def _decode(path: Path, name: str) -> tuple[str, str, bool]:
    try:
        raw = path.read_bytes()
    except OSError as error:
        raise InputError(unreadable(name, error, "a laboratory file")) from None
    if raw.startswith(_SPREADSHEETS):
        raise InputError(f"{name}: this is a spreadsheet and not text, save its sheet as CSV first.")
    marked = raw.startswith((b"\xef\xbb\xbf", b"\xff\xfe", b"\xfe\xff"))
    encodings = ("utf-16",) if raw.startswith((b"\xff\xfe", b"\xfe\xff")) else ("utf-8-sig", "cp1252")
    for encoding in encodings:
        try:
            text = raw.decode(encoding)
        except UnicodeDecodeError:
            continue
        if not _CONTROL_CHARACTERS.search(text):
            return text, encoding.removesuffix("-sig"), marked
    raise InputError(f"{name}: this is not a text file, and delimited text such as CSV was expected.")


def _delimit(lines: list[str], name: str) -> tuple[str, list[Row]]:
    """The delimiter under which most rows hold numbers and most of their cells are numbers, and the rows it gives."""
    best = (0, 0.0), ""
    for delimiter in DELIMITERS:
        numeric = [row for row in _split(lines[:SNIFFED_LINES], delimiter, name) if row.holds_numbers]
        filled = [cell for row in numeric for cell in row.filled]
        score = (len(numeric), sum(map(is_number, filled)) / max(len(filled), 1))
        if score > best[0]:
            best = score, delimiter
    if not best[1]:
        filled_lines = [line.strip() for line in lines if line.strip()]
        if len(filled_lines) == 1:
            raise InputError(f"{name}: there is only a header, '{filled_lines[0][:80]}', and rows of numbers were expected below it.")
        raise InputError(f"{name}: no line holds two numbers, and rows of numbers between commas, semicolons, tabs or spaces were expected.")
    return best[1], list(_split(lines, best[1], name))


def _split(lines: list[str], delimiter: str, name: str) -> Iterator[Row]:
    """The rows that are not blank. Cells lose outer white space, and the typographic minus becomes a plain one."""
    for number, record in _space_records(lines) if delimiter == SPACE else _csv_records(lines, delimiter, name):
        cells = tuple(cell.strip().replace("\u2212", "-") for cell in record)
        if any(cells):
            yield Row(number, cells)


def _csv_records(lines: list[str], delimiter: str, name: str) -> Iterator[tuple[int, list[str]]]:
    reader = csv.reader([line + "\n" for line in lines], delimiter=delimiter, skipinitialspace=delimiter != "\t")
    number = 1
    try:
        for record in reader:
            yield number, record
            number = reader.line_num + 1
    except csv.Error as error:
        raise InputError(f"{name}: line {number} cannot be taken apart ({error}), and closed quotation marks were expected.") from None


def _space_records(lines: list[str]) -> Iterator[tuple[int, list[str]]]:
    """Words between white space. A name keeps its unit, `q [kPa]`; where that gives more names than columns, names stand two spaces apart."""
    records = [(number, re.split(r"\s+(?![\[(])", line.strip())) for number, line in enumerate(lines, 1) if line.strip()]
    width = Counter(len(cells) for _, cells in records if all(map(is_number, cells))).most_common(1)
    for number, cells in records:
        apart = re.split(r"\s{2,}(?![\[(])", lines[number - 1].strip())
        yield number, apart if width and len(cells) != width[0][0] == len(apart) else cells


def _header_index(rows: list[Row], first: int) -> int | None:
    """The last row of names above the first row of numbers; a row of units below the names is not it."""
    for index in range(first - 1, -1, -1):
        above = rows[index - 1] if index else None
        if rows[index].holds_names and not (rows[index].holds_units and above is not None and above.holds_names):
            return index
    return None


def _header_in_comment(comments: list[Row], lines: list[str], delimiter: str, first: Row, name: str) -> tuple[tuple[str, ...], int]:
    for comment in reversed([row for row in comments if row.line < first.line]):
        text = lines[comment.line - 1].lstrip().removeprefix("#")
        row = next(_split([text], delimiter, name), None)
        if row is not None and len(row.cells) == len(first.cells) and row.holds_names:
            return row.cells, comment.line
    raise InputError(f"{name}: line {first.line} is numbers already, and a header line that names the columns was expected above it.")


def _without_cells(row: Row, header: tuple[str, ...], name: str) -> Row:
    """A row of numbers between white space that is too short: which of its cells it lacks cannot be told, so it lacks all. Refuse one with words."""
    if word := next((cell for cell in row.cells if not is_number(cell)), None):
        raise InputError(f"{name}: line {row.line} says '{word}', and a number for each of the {len(header)} columns was expected (a line of fewer numbers is a gap).")
    return Row(row.line, ())


def _refuse_broken_rows(rows: list[Row], header: tuple[str, ...], name: str) -> None:
    """Refuse more numbers than names, and an open quotation mark, which would swallow the rows below it."""
    for row in rows:
        if any("\n" in cell for cell in row.cells):
            raise InputError(f"{name}: line {row.line} opens a quotation mark, and its end was expected on the same line.")
        if row.holds_numbers and any(map(is_number, row.cells[len(header) :])):
            raise InputError(
                f"{name}: line {row.line} has {len(row.cells)} cells where the header has {len(header)} names,"
                " and one number for each name was expected (decimal commas need another delimiter than the comma)."
            )
