"""The sheets of a spreadsheet, of Excel or of OpenDocument, as rows of text."""

from __future__ import annotations

import io
import re
from datetime import date, time, timedelta

from python_calamine import CalamineError, CalamineWorkbook, SheetTypeEnum, SheetVisibleEnum

from graincal.errors import InputError
from graincal.laboratory.numbers import reads_as_number, shown
from graincal.laboratory.percent_formats import percent_cells
from graincal.laboratory.rows import Grid, Row
from graincal.suggestion import did_you_mean

SIGNATURES = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")
"""What the files of spreadsheets begin with."""
LARGEST_SHEET = 50_000_000
"""Cells of a sheet, empty ones between others too."""
LARGEST_WHOLE = 1e15
"""Whole numbers up to here are printed without a decimal point."""


def read_sheet(raw: bytes, path: str, wanted: str | int | None) -> tuple[str, Grid]:
    """The name of a sheet and its rows: the one that is wanted, by its name or its number from 1, or the only one that holds rows of numbers.

    Raises InputError for what is no spreadsheet, for a sheet that is missing or holds no numbers, and where several sheets hold numbers and none is wanted.
    """
    hidden, grids = _sheets(raw, path)
    names = list(grids)
    if wanted is not None:
        name = _named(names, wanted, path)
        if not _holds_numbers(grids[name]):
            raise InputError(f"{path}: sheet '{shown(name)}' has no two rows of numbers, and a header with rows of numbers below it was expected.")
        return name, grids[name]
    full = [name for name in names if _holds_numbers(grids[name])]
    # What a person does not see is taken only when it is asked for, or where there is nothing else.
    full = [name for name in full if name not in hidden] or full
    if not full:
        raise InputError(f"{path}: no sheet has two rows of numbers, and a header with rows of numbers below it was expected.")
    if len(full) > 1:
        listed = ", ".join(f"'{shown(name)}'" for name in full)
        raise InputError(
            f'{path}: {len(full)} sheets hold rows of numbers, {listed}: say which with --sheet, or sheet = "{shown(full[0])}" in a calibration file.'
        )
    return full[0], grids[full[0]]


def _sheets(raw: bytes, path: str) -> tuple[set[str], dict[str, Grid]]:
    """The names of hidden sheets, and all sheets by name."""
    try:
        book = CalamineWorkbook.from_filelike(io.BytesIO(raw))
        hidden = {sheet.name for sheet in book.sheets_metadata if sheet.visible != SheetVisibleEnum.Visible}
        percent = percent_cells(raw)
        names = [sheet.name for sheet in book.sheets_metadata if sheet.typ == SheetTypeEnum.WorkSheet]
        return hidden, {name: _grid(book, name, path, percent.get(name, set())) for name in names}
    except BaseException as error:
        # On some damaged files the library fails with what is no Exception.
        if not isinstance(error, (CalamineError, OSError, ValueError)) and type(error).__name__ != "PanicException":
            raise
        why = "it is damaged" if not isinstance(error, Exception) or not str(error) else str(error).splitlines()[0].rstrip(".")
        raise InputError(f"{path}: this spreadsheet cannot be read ({why}), save its sheet as CSV first.") from None


def _named(names: list[str], wanted: str | int, path: str) -> str:
    if wanted in names:
        return str(wanted)
    if re.fullmatch("[0-9]{1,9}", str(wanted)) and 1 <= int(wanted) <= len(names):
        return names[int(wanted) - 1]
    listed = ", ".join(f"'{shown(name)}'" for name in names)
    raise InputError(f"{path}: there is no sheet '{shown(str(wanted))}'{did_you_mean(str(wanted), names)}, and one of {listed} was expected.")


def _grid(book: CalamineWorkbook, name: str, path: str, percent: set[tuple[int, int]]) -> Grid:
    """A sheet's rows that are not blank; their lines are the sheet's own. Cells in `percent` (line, column) become what they show, 0.4%. Raises ValueError for a sheet that is far too large."""
    sheet = book.get_sheet_by_name(name)
    if sheet.start is None:
        return Grid(path, "", [])
    if sheet.height * sheet.width > LARGEST_SHEET:
        raise ValueError(f"sheet '{shown(name)}' goes on to row {sheet.total_height} and column {sheet.total_width}")
    left = sheet.start[1]
    rows = []
    # The rows come from the sheet's first, the cells from the first column that holds any.
    for line, record in enumerate(sheet.iter_rows(), 1):
        cells = ("",) * left + tuple([_percent(value) if (line, left + at) in percent else _text(value) for at, value in enumerate(record)])
        if any(cells):
            rows.append(Row(line, cells))
    width = max((len(row.cells) for row in rows), default=0)
    while width and not any(row.cell(width - 1) for row in rows):
        width -= 1
    return Grid(path, "", [Row(row.line, row.cells[:width]) for row in rows])


def _holds_numbers(grid: Grid) -> bool:
    return sum(row.holds_numbers for row in grid.rows[:1000]) >= 2


def _percent(value: object) -> str:
    return f"{100 * value:.15g}%" if isinstance(value, float) else _text(value)


def _text(value: object) -> str:
    """A cell's value with all its digits; what is no number is text."""
    if isinstance(value, bool):
        return str(value).upper()
    if isinstance(value, float):
        return str(int(value)) if value.is_integer() and abs(value) < LARGEST_WHOLE else repr(value)
    if isinstance(value, (date, time)):
        return value.isoformat()
    if value is None or isinstance(value, timedelta):
        return "" if value is None else str(value)
    text = " ".join(str(value).replace("\u2212", "-").split())
    # A number that a sheet keeps as text is one all the same.
    return text.lstrip("'") if reads_as_number(text.lstrip("'")) else text
