"""A laboratory file taken apart into columns of text: the names, units and rows of a text, a sheet or a group, and nothing understood yet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path

from graincal.errors import InputError
from graincal.files import check_name, unreadable
from graincal.laboratory.ags import is_ags, read_group
from graincal.laboratory.cells import find_decimal, plain_numbers
from graincal.laboratory.decisions import Decision, Question
from graincal.laboratory.heading import Heading, find_heading, known
from graincal.laboratory.numbers import is_number, reads_as_number, shown
from graincal.laboratory.rows import SPACE, Grid, Row, delimited, refuse_broken_rows, without_cells, without_gaps
from graincal.laboratory.spreadsheets import SIGNATURES, read_sheet
from graincal.laboratory.text import Text, decode

__all__ = ["Row", "Table", "read_table"]

NAMED_BY_NUMBER = "columns may be named by number, as --column axial_strain=2:%"
LINES_TO_KNOW = 400
"""So many lines show which encoding makes known words of a file's names."""


@dataclass(frozen=True)
class Table:
    """A file taken apart: `header` names the columns, `units` holds the line of units below it, if there is one, or what stands behind all numbers of a column.

    `header_line` is 0 where no line names the columns, and all names are empty then. `groups` are the names that stand above those of the columns, one each
    ("" without), or nothing; `sheet` is the sheet or the AGS group that was read, "" for other text. A spreadsheet has no encoding and no delimiter: both "".
    Numbers have the decimal mark `decimal` and nothing between thousands. `decided` and `questions` are what the file proves of its layout, and what not.
    """

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
    groups: tuple[str, ...] = ()
    sheet: str = ""
    decided: tuple[Decision, ...] = ()
    questions: tuple[Question, ...] = ()

    @property
    def lines(self) -> list[int]:
        return [row.line for row in self.rows]

    def label(self, index: int) -> str:
        """What a column is called in a message: its header in quotation marks, behind that of its group; "column 3" without."""
        group = self.groups[index] if index < len(self.groups) else ""
        header = self.header[index] if index < len(self.header) else ""
        return f"'{shown(group)}: {shown(header)}'" if group and header else f"'{shown(header)}'" if header else f"column {index + 1}"


def read_table(path: str | PathLike[str], *, encoding: str | None = None, sheet: str | int | None = None) -> Table:
    """Read delimited text (comma, semicolon, tab or white space; decimal point or comma), a sheet of a spreadsheet, or a group of an AGS file.

    `encoding` is the text's, found out if it is not said; `sheet` the name or number of a spreadsheet's sheet, or an AGS group, "CONS" or "CONS/BH0 3.20 U2".
    Lines that begin with #, %, //, ! or ; are comments; the names may stand in one of them. Lines above the header are remarks, and so are
    lines without a number below the last row of numbers.
    Raises InputError for a file that is missing, empty, not text, or without rows of numbers, and for what may be read in two ways.
    """
    check_name(path, "a laboratory file")
    name = str(path)
    try:
        raw = Path(path).read_bytes()
    except OSError as error:
        raise InputError(unreadable(name, error, "a laboratory file")) from None
    if raw.startswith(SIGNATURES):
        title, grid = read_sheet(raw, name, sheet)
        return replace(_table(grid, Text("", "", False)), sheet=title)
    text = decode(raw, name, encoding, lambda text: _known_names(text, name))
    if is_ags(text.text):
        return _ags_table(text, name, sheet)
    if sheet is not None:
        raise InputError(f"{name}: this is text, which has no sheet '{sheet}', and a spreadsheet or an AGS file was expected with one.")
    return _table(delimited(name, text.text), text)


def _known_names(text: str, path: str) -> int:
    try:
        return known(find_heading(delimited(path, "\n".join(text.splitlines()[:LINES_TO_KNOW]))).names)
    except InputError:
        return 0


def _ags_table(text: Text, path: str, sheet: str | int | None) -> Table:
    title, group = read_group(text.text, path, None if sheet is None else str(sheet))
    return Table(
        path=path,
        encoding=text.encoding,
        byte_order_mark=text.byte_order_mark,
        delimiter=",",
        decimal=".",
        header_line=group.line,
        header=group.headings,
        units=group.units,
        rows=tuple(group.rows),
        remarks=(),
        sheet=title,
        decided=text.decided,
        questions=text.questions,
    )


def _table(grid: Grid, text: Text) -> Table:
    heading = find_heading(grid)
    # Numbers set out by several tabs in each row: their names tell.
    if not heading.names and (closed := without_gaps(grid)) and (found := find_heading(closed)).names:
        grid, heading = closed, found
    header, body = _body(grid, heading)
    decimal = find_decimal(body, grid.path)
    body, units = plain_numbers(body, header, heading.units, decimal)
    questions = text.questions
    if not heading.names:
        sentence = f"{heading.misfit[:1].upper()}{heading.misfit[1:]}: {NAMED_BY_NUMBER}."
        questions = (*questions, Question("columns", sentence, option="--column"))
    return Table(
        path=grid.path,
        encoding=text.encoding,
        byte_order_mark=text.byte_order_mark,
        delimiter=grid.delimiter,
        decimal=decimal,
        header_line=heading.line,
        header=header,
        units=units,
        rows=tuple(body),
        remarks=_remarks(grid, heading, {row.line for row in body}),
        groups=heading.groups,
        decided=text.decided,
        questions=questions,
    )


def _body(grid: Grid, heading: Heading) -> tuple[tuple[str, ...], list[Row]]:
    """The names of all columns, empty ones too, and the rows below them.

    Lines without any number are remarks between the names and the first row of numbers, as below the last; so is a header that a logger repeats.
    """
    top = max(heading.line, *heading.used) if heading.used else heading.first - 1
    repeated = {row.cells for row in grid.rows if row.line in heading.used}
    numbered = [row.line for row in reversed(grid.rows) if any(map(reads_as_number, row.cells))][:1]
    body = [
        row
        for row in grid.rows
        if top < row.line <= numbered[0] and row.cells not in repeated and (row.line >= heading.first or any(map(reads_as_number, row.cells)))
    ]
    header = heading.names
    if not header or not grid.lines:
        # A sheet's cells stand below their names, whether all columns have one or not.
        widest = max((_width(row) for row in body), default=0)
        header = (*header, *[""] * (widest - len(header)))
    refuse_broken_rows(body, header, grid.path)
    if grid.delimiter == SPACE:
        body = [row if len(row.cells) == len(header) else without_cells(row, header, grid.path) for row in body]
    return header, body


def _width(row: Row) -> int:
    """How many columns a row has, but for words and empty cells at its end."""
    return next((at for at in range(len(row.cells), 0, -1) if is_number(row.cells[at - 1])), 0)


def _remarks(grid: Grid, heading: Heading, read: set[int]) -> tuple[str, ...]:
    rows: Sequence[Row] = [row for row in (*grid.rows, *grid.comments) if row.line not in read and row.line not in heading.used]
    return tuple(" ".join(row.filled) for row in sorted(rows, key=lambda row: row.line))
