"""Sheets of spreadsheets are read as text is; which sheet is said where several hold numbers."""

from pathlib import Path

import pytest
from workbooks import write_ods, write_xlsx

from graincal.data import InputError
from graincal.laboratory.table import read_table

DATA = Path(__file__).parent.parent / "data"
NOTES = [["Toyoura sand"], ["prepared dry", 3]]
TEST = [["Test", "CD-12"], [], ["Axial strain", "q", "note"], ["%", "kPa"], [0, 0.1 + 0.2, "begins"], [0.004, 1012.7, None], [1, -3.5e-7, None]]
OTHER = [["loose", None, "dense", None], ["X", "Y", "X", "Y"], [1, 2, 3, 4], [5, 6, 7, 8]]


@pytest.mark.parametrize("write", [write_xlsx, write_ods])
def test_the_only_sheet_with_numbers_is_taken(write, tmp_path: Path) -> None:
    table = read_table(write(tmp_path / "lab.sheet", {"Notes": NOTES, "Shear": TEST}))
    assert (table.sheet, table.encoding, table.delimiter, table.decimal) == ("Shear", "", "", ".")
    assert (table.header, table.units, table.header_line, table.lines) == (("Axial strain", "q", "note"), ("%", "kPa", ""), 3, [5, 6, 7])
    # All digits of a number, whatever the sheet shows.
    assert [row.cells[:2] for row in table.rows] == [("0", "0.30000000000000004"), ("0.004", "1012.7"), ("1", "-3.5e-07")]
    assert table.remarks == ("Test CD-12",)


def test_an_old_workbook_is_read() -> None:
    table = read_table(DATA / "sheets" / "oedometer.xls")
    assert (table.sheet, table.header, table.units) == ("Oedometer", ("sigma1", "Void ratio"), ("kPa", "-"))
    assert [row.cells for row in table.rows] == [("2", "0.72106"), ("20", "0.71103"), ("320", "0.69218")]


def test_of_several_sheets_one_is_said(tmp_path: Path) -> None:
    path = write_xlsx(tmp_path / "lab.xlsx", {"Notes": NOTES, "Shear": TEST, "Curves": OTHER})
    with pytest.raises(InputError) as refusal:
        read_table(path)
    assert (
        str(refusal.value) == f"{path}: 2 sheets hold rows of numbers, 'Shear', 'Curves': say which with --sheet, or sheet = \"Shear\" in a calibration file."
    )
    for said in ("Curves", 3, "3"):
        table = read_table(path, sheet=said)
        assert (table.sheet, table.groups, table.header) == ("Curves", ("loose", "loose", "dense", "dense"), ("X", "Y", "X", "Y"))
    with pytest.raises(InputError, match=r"there is no sheet 'Curvs' \(did you mean \"Curves\"\?\), and one of 'Notes', 'Shear', 'Curves' was expected"):
        read_table(path, sheet="Curvs")
    with pytest.raises(InputError, match="sheet 'Notes' has no two rows of numbers"):
        read_table(path, sheet=1)


def test_a_hidden_sheet_is_taken_only_when_it_is_said(tmp_path: Path) -> None:
    path = write_xlsx(tmp_path / "lab.xlsx", {"Shear": TEST, "Curves": OTHER}, hidden=["Shear"])
    assert read_table(path).sheet == "Curves"
    assert read_table(path, sheet="Shear").sheet == "Shear"


def test_columns_without_a_name_keep_their_place(tmp_path: Path) -> None:
    table = read_table(write_xlsx(tmp_path / "lab.xlsx", {"A": [[None, "Axial strain", None, "q"], [1, 0.5, 7, 8, 9], [2, 0.6, 7, 8, 9]]}))
    assert table.header == ("", "Axial strain", "", "q", "")
    assert table.rows[0].cells == ("1", "0.5", "7", "8", "9")


@pytest.mark.parametrize("write", [write_xlsx, write_ods])
def test_rows_and_columns_are_counted_from_the_corner_of_the_sheet(write, tmp_path: Path) -> None:
    table = read_table(write(tmp_path / "lab.sheet", {"A": [[], [], [None, None, "e", "q"], [None, None, 1, 2], [], [None, None, 3, 4]]}))
    assert (table.header_line, table.lines, table.header) == (3, [4, 6], ("", "", "e", "q"))
    assert table.rows[1].cells == ("", "", "3", "4")


@pytest.mark.parametrize("header", ["Axial strain", "Axial strain (%)"])
def test_cells_shown_in_percent_are_percent(header: str, tmp_path: Path) -> None:
    table = read_table(write_xlsx(tmp_path / "lab.xlsx", {"A": [[header, "q"], [0, 1], [0.004, 2], [0.0713, 3]]}, percent="A"))
    assert table.units == ("%", "")
    assert [row.cells for row in table.rows] == [("0", "1"), ("0.4", "2"), ("7.13", "3")]


@pytest.mark.parametrize("content", [b"PK\x03\x04 sheet", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(600)])
def test_what_only_begins_like_a_spreadsheet_is_refused(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "lab.xlsx"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"this spreadsheet cannot be read \(.*\), save its sheet as CSV first\."):
        read_table(path)


def test_text_has_no_sheet(tmp_path: Path) -> None:
    path = tmp_path / "lab.csv"
    path.write_text("eps,q\n1,2\n3,4\n")
    with pytest.raises(InputError, match="this is text, which has no sheet 'Shear'"):
        read_table(path, sheet="Shear")
