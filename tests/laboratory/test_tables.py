"""A layout a line: what a file's columns are called, in which units, and its first and last row, whatever it is set out by."""

import time
from pathlib import Path

import pytest

from graincal.data import InputError
from graincal.laboratory.numbers import read_number
from graincal.laboratory.table import Table, read_table

FIELD = Path(__file__).parent.parent / "data" / "field"


def table_of(content: str | bytes, folder: Path, name: str = "lab.txt", **how) -> Table:
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_table(path, **how)


def numbers(table: Table) -> list[list[float]]:
    return [[read_number(row.cell(index), table.decimal) for index in range(len(table.header))] for row in table.rows]


TABS, SPACES, COMMAS = "0\t1.5\t2\n1\t2.5\t3\n", "0 1.5 2\n1 2.5 3\n", "0,1.5,2\n1,2.5,3\n"
# name: (text, names, units, line of the names, line of the first row); the rows are 0, 1.5, 2 and 1, 2.5, 3.
LAYOUTS = {
    "tabs": ("eps\tq\te\n" + TABS, "eps|q|e", "", 1, 2),
    "names by spaces over tabs": ("eps   q   e\n" + TABS, "eps|q|e", "", 1, 2),
    "names by single spaces over tabs": ("eps q e\n" + TABS, "eps|q|e", "", 1, 2),
    "names of two words by spaces over tabs": ("Axial strain   q / p   Void ratio  \n" + TABS, "Axial strain|q / p|Void ratio", "", 1, 2),
    "names of two words by spaces over spaces": ("Axial strain   q / p   Void ratio\n" + SPACES, "Axial strain|q / p|Void ratio", "", 1, 2),
    "names of two words by spaces over commas": ("Axial strain   q / p   Void ratio\n" + COMMAS, "Axial strain|q / p|Void ratio", "", 1, 2),
    "a ratio with spaces among single spaces": ("eps q / p e\n" + SPACES, "eps|q / p|e", "", 1, 2),
    "names by commas over tabs": ("Axial strain, q, e\n" + TABS, "Axial strain|q|e", "", 1, 2),
    "names by commas over spaces": ("Axial strain, q, e\n" + SPACES, "Axial strain|q|e", "", 1, 2),
    "names by semicolons over spaces": ("Axial strain;q;e\n" + SPACES, "Axial strain|q|e", "", 1, 2),
    "names in quotation marks": ('"Axial strain" "q" "Void ratio"\n' + SPACES, "Axial strain|q|Void ratio", "", 1, 2),
    "doubled tabs between names": ("eps\t\tq\t\te\n" + TABS, "eps|q|e", "", 1, 2),
    "doubled tabs between numbers": ("eps\tq\te\n0\t\t1.5\t2\n1\t2.5\t\t3\n", "eps|q|e", "", 1, 2),
    "units in brackets in single spaces": ("eps [%] q [kPa] e [-]\n" + SPACES, "eps [%]|q [kPa]|e [-]", "", 1, 2),
    "a row of units": ("eps,q,e\n%,kPa,-\n" + COMMAS, "eps|q|e", "%|kPa|-", 1, 3),
    "a row of units in brackets": ("eps,q,e\n[%],(kPa),[-]\n" + COMMAS, "eps|q|e", "%|kPa|-", 1, 3),
    "a row of units with one that is not known": ("eps,q,e\n%,stone,-\n" + COMMAS, "eps|q|e", "%|stone|-", 1, 3),
    "a row of units in brackets none of which is known": ("eps,q,e\n[pct.],[stone],[one]\n" + COMMAS, "eps|q|e", "pct.|stone|one", 1, 3),
    "a row of units none of which is known": (
        "Axial strain,Deviator stress,e\npulg,stone,one\n" + COMMAS,
        "Axial strain|Deviator stress|e",
        "pulg|stone|one",
        1,
        3,
    ),
    "units by spaces below names by spaces over tabs": ("eps    q      Void ratio\n[%]    [kPa]  [-]\n\n" + TABS, "eps|q|Void ratio", "%|kPa|-", 1, 4),
    "units by single spaces below names by spaces": ("eps    q      Void ratio\n% kPa -\n" + SPACES, "eps|q|Void ratio", "%|kPa|-", 1, 3),
    "units for some of the names, by where they stand": ("eps    q      Void ratio\n%      kPa\n" + SPACES, "eps|q|Void ratio", "%|kPa|", 1, 3),
    "a row of units that begins with percent": ("eps q e\n% kPa -\n" + SPACES, "eps|q|e", "%|kPa|-", 1, 3),
    "blank lines": ("\n\neps,q,e\n\n%,kPa,-\n\n\n0,1.5,2\n\n1,2.5,3\n\n", "eps|q|e", "%|kPa|-", 3, 8),
    "hash": ("# eps q e\n" + SPACES, "eps|q|e", "", 1, 2),
    "hash without a space over tabs": ("#eps\tq\te\n" + TABS, "eps|q|e", "", 1, 2),
    "percent": ("% eps q e\n" + SPACES, "eps|q|e", "", 1, 2),
    "slashes": ("// eps,q,e\n" + COMMAS, "eps|q|e", "", 1, 2),
    "semicolon": ("; eps q e\n" + SPACES, "eps|q|e", "", 1, 2),
    "exclamation mark": ("! eps q e\n" + SPACES, "eps|q|e", "", 1, 2),
    "hash that is a name": ("#,strain,stress\n" + COMMAS, "#|strain|stress", "", 1, 2),
    "names and units in comments": ("# eps q e\n# [%] [kPa] [-]\n" + SPACES, "eps|q|e", "%|kPa|-", 1, 3),
    "a comment below the names": ("eps,q,e\n# dense sand here\n" + COMMAS, "eps|q|e", "", 1, 3),
    "a comment of words above names in a comment": ("# made by hand\n# eps q e\n" + SPACES, "eps|q|e", "", 2, 3),
    "a drawn line below the names": ("eps  q  e\n---  ---  ---\n" + SPACES, "eps|q|e", "", 1, 3),
    "LAMMPS averages": ("# Time-averaged data for fix 3\n# TimeStep v_strain c_press[3]\n" + SPACES, "TimeStep|v_strain|c_press[3]", "", 2, 3),
    "YADE": ("# e11\te22\ts22\n" + TABS, "e11|e22|s22", "", 1, 2),
    "GrainLearning": ("# e_a e_v s33_over_s11\n" + SPACES, "e_a|e_v|s33_over_s11", "", 1, 2),
    "no names": (COMMAS, "||", "", 0, 1),
    "no names under a title": ("Dense Toyoura sand, drained\n" + TABS, "||", "", 0, 2),
    "too few names": ("eps   q\n" + TABS, "||", "", 0, 2),
    "too many names between spaces": ("axial strain q e\n" + SPACES, "||", "", 0, 2),
    "trailing delimiters": ("eps,q,e,\n0,1.5,2,\n1,2.5,3,\n", "eps|q|e", "", 1, 2),
    "trailing delimiters of the rows alone": ("eps;q;e\n0;1.5;2;\n1;2.5;3;\n", "eps|q|e", "", 1, 2),
    "a column without a name": ("eps;;e\n0;1.5;2\n1;2.5;3\n", "eps||e", "", 1, 2),
    "a last column without a name": ("eps;q;\n0;1.5;2\n1;2.5;3\n", "eps|q|", "", 1, 2),
    "names on two lines": ("Axial,Deviator,Void\nstrain,stress,ratio\n" + COMMAS, "Axial strain|Deviator stress|Void ratio", "", 2, 3),
    "names on two lines by spaces": (
        "Axial   Deviator   Void\nstrain  stress     ratio\n%       kPa        -\n" + TABS,
        "Axial strain|Deviator stress|Void ratio",
        "%|kPa|-",
        2,
        4,
    ),
    "names on two lines that tell columns apart": ("aba,abo,abu\nx,x,y\n" + COMMAS, "aba x|abo x|abu y", "", 2, 3),
    "a repeated header": ("eps,q,e\n%,kPa,-\n0,1.5,2\neps,q,e\n%,kPa,-\n1,2.5,3\n", "eps|q|e", "%|kPa|-", 1, 3),
    "a repeated header by spaces": ("eps  q  e\n0 1.5 2\n\neps  q  e\n1 2.5 3\n", "eps|q|e", "", 1, 2),
    "job data above": ("Height,100,mm\nDate,12.03.2020,\nTest,CD 12,\neps,q,e\n" + COMMAS, "eps|q|e", "", 4, 5),
    "job data that is mostly numbers": ("Date 12 03 2020\neps q e\n" + SPACES, "eps|q|e", "", 2, 3),
    "what a spreadsheet writes first": ("sep=;\neps;q;e\n" + COMMAS.replace(",", ";"), "eps|q|e", "", 2, 3),
    "percent cells": ("eps,q,e\n0%,1.5,2\n1%,2.5,3\n", "eps|q|e", "%||", 1, 2),
    "percent cells below a unit": ("eps [%],q,e\n0.0%,1.5,2\n1 %,2.5,3\n", "eps [%]|q|e", "%||", 1, 2),
    "units in cells": ("eps;q;e\n0;1.5 kPa;2\n1;2.5 kPa;3\n", "eps|q|e", "|kPa|", 1, 2),
    "carriage returns": ("eps,q,e\r\n" + COMMAS.replace("\n", "\r\n"), "eps|q|e", "", 1, 2),
    "zeros at the end of the file": ("eps,q,e\n" + COMMAS + "\x00\x00\x00", "eps|q|e", "", 1, 2),
}


@pytest.mark.parametrize("name", LAYOUTS)
def test_every_layout_gives_the_same_rows(name: str, tmp_path: Path) -> None:
    text, names, units, line, first = LAYOUTS[name]
    table = table_of(text, tmp_path)
    assert "|".join(table.header) == names
    assert "|".join(table.units) == units
    assert (table.header_line, table.rows[0].line) == (line, first)
    assert numbers(table) == [[0, 1.5, 2], [1, 2.5, 3]]
    assert bool(table.questions) == (line == 0)


def test_what_names_no_columns_is_asked_for(tmp_path: Path) -> None:
    assert (
        table_of(TABS, tmp_path)
        .questions[0]
        .sentence.startswith("Line 1 is numbers already, and no line above it names the columns: columns may be named by number")
    )
    (question,) = table_of("\neps   q\n" + TABS, tmp_path).questions
    assert (question.key, question.option) == ("columns", "--column")
    assert question.sentence.startswith("Line 2 has 2 names above 3 columns of numbers: ")
    table = table_of(TABS, tmp_path)
    assert [table.label(index) for index in range(3)] == ["column 1", "column 2", "column 3"]


def test_names_of_groups_stand_above_those_of_columns(tmp_path: Path) -> None:
    for above, groups in (
        ("loose,,dense,", "loose|loose|dense|dense"),
        ("100,,400,", "100|100|400|400"),
        ("loose,loose,dense,dense", "loose|loose|dense|dense"),
    ):
        table = table_of(above + "\nX,Y,X,Y\n1,2,3,4\n5,6,,\n", tmp_path)
        assert ("|".join(table.groups), table.header, table.header_line, table.remarks) == (groups, ("X", "Y", "X", "Y"), 2, ())
        assert [row.cells for row in table.rows] == [("1", "2", "3", "4"), ("5", "6", "", "")]
    assert table.label(2) == "'dense: X'"
    assert table_of("Test,CD-12,,\nX,Y,V,W\n1,2,3,4\n", tmp_path).groups == ()
    assert table_of("loose,,,dense,,\neps,q,e,p,u,t\n%,kPa,-,kPa,kPa,s\n1,2,3,4,5,6\n7,8,9,1,2,3\n", tmp_path).groups == ("loose",) * 3 + ("dense",) * 3


def test_words_may_stand_in_a_column_of_their_own(tmp_path: Path) -> None:
    table = table_of("stage eps q\nconsolidation 0 1\nshear 1 2\n", tmp_path)
    assert [row.cells for row in table.rows] == [("consolidation", "0", "1"), ("shear", "1", "2")]


# name: (cells of a column beside which others are, decimal mark, its numbers)
CELLS = {
    "points": ("0.5 12.25 1012.7", ".", [0.5, 12.25, 1012.7]),
    "commas": ("0,5 12,25 1012,7", ",", [0.5, 12.25, 1012.7]),
    "thousands by commas": ("0.5 999 1,012.7 1,234,567", ".", [0.5, 999, 1012.7, 1234567]),
    "thousands by points": ("0,5 999 1.012,7 1.234.567", ",", [0.5, 999, 1012.7, 1234567]),
    "thousands by spaces": ("0,5 999 1_012,7 1_234_567", ",", [0.5, 999, 1012.7, 1234567]),
    "thousands by apostrophes": ("0.5 999 1'012.7 1'234'567", ".", [0.5, 999, 1012.7, 1234567]),
    "whole thousands that go on from hundreds": ("0.5 875 1,012 1,120", ".", [0.5, 875, 1012, 1120]),
    "three decimals": ("0,500 1,012 1,120", ",", [0.5, 1.012, 1.12]),
    "three decimals with a point": ("1.500 1.012 1.120", ".", [1.5, 1.012, 1.12]),
    "exponents": ("1e-3 2.5E+02 3.0e1", ".", [1e-3, 250, 30]),
    "a percent sign behind all": ("0.40% 1,012.5% 0", ".", [0.4, 1012.5, 0]),
    "a unit behind all": ("12.3_kPa 1,012.5_kPa", ".", [12.3, 1012.5]),
}


@pytest.mark.parametrize("name", CELLS)
def test_numbers_are_read_however_they_are_printed(name: str, tmp_path: Path) -> None:
    printed, decimal, expected = CELLS[name]
    cells = [cell.replace("_", " ") for cell in printed.split()]
    table = table_of("no;q\n" + "".join(f"{at};{cell}\n" for at, cell in enumerate(cells)), tmp_path)
    assert table.decimal == decimal
    assert [row[1] for row in numbers(table)] == expected


# name: (text, cell that is refused, what is said)
LEFT = {
    "a comma that may be either": ("no;eps;q\n1;0.5;2.1\n2;0.6;2,500\n", "2,500", "decimal mark"),
    "thousands parted in some": ("no;eps;q\n1;0.5;1012.5\n2;0.6;1,013.5\n", "1,013.5", "no thousands separator"),
    "percent sign in some": ("no;eps;q\n1;0.5%;2\n2;0.6;3\n", "0.5%", "behind all numbers of the column or none"),
    "percent sign against the header": ("no;eps [kPa];q\n1;0.5%;2\n2;0.6%;3\n", "0.5%", "none other than its header's"),
    "percent sign against the row of units": ("no;eps;q\n-;mm;kPa\n1;0.5%;2\n2;0.6%;3\n", "0.5%", "none other than its header's"),
    "two units": ("no;eps;q\n1;0;2 kPa\n2;1;3 MPa\n", "2 kPa", "behind all numbers of the column or none"),
}


@pytest.mark.parametrize("name", LEFT)
def test_cells_that_cannot_be_told_for_certain_are_refused_when_they_are_read(name: str, tmp_path: Path) -> None:
    text, cell, said = LEFT[name]
    table = table_of(text, tmp_path)
    assert any(cell in row.cells for row in table.rows)
    with pytest.raises(ValueError, match=f"says '{cell}', .*{said}"):
        read_number(cell, table.decimal)


REFUSED = {
    "a comma that nothing explains": ("eps;q\n1;1,012\n2;1,500\n", "line 2 says '1,012', and nothing in the file tells whether that is 1.012 or 1012"),
    "units below no name": ("eps q e u\n[%]  [kPa]  [-]\n1 2 3 4\n5 6 7 8\n", "line 2 gives 3 units where line 1 has 4 names"),
    "a single column": ("q\n1\n2\n3\n", "no line holds two numbers"),
    "zeros between": ("eps,q\n1,2\n\x00\x003,4\n", "not a text file"),
    "a ragged row": ("eps,q\n1,2\n3,4,5\n", "line 3 has 3 cells where the header has 2 names"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_may_be_read_in_two_ways_is_refused_by_its_line(name: str, tmp_path: Path) -> None:
    text, said = REFUSED[name]
    with pytest.raises(InputError) as refusal:
        table_of(text, tmp_path)
    assert said in str(refusal.value) and str(refusal.value).startswith(str(tmp_path / "lab.txt"))


def test_files_of_the_field_are_taken_apart() -> None:
    def seen(name: str) -> tuple[object, ...]:
        table = read_table(FIELD / name)
        return len(table.rows), table.header_line, table.rows[0].line, len(table.header), table.rows[-1].filled[-1]

    assert seen("drained_spaced_header.dat") == (20, 1, 4, 6, "1.259116")
    table = read_table(FIELD / "drained_spaced_header.dat")
    assert (table.header[4:], table.units) == (("Void ratio", "q / p"), ("%", "%", "kPa", "kPa", "%", "-"))
    assert seen("stages.csv")[:4] == (42, 11, 12, 14)
    assert read_table(FIELD / "stages.csv").header[8] == "Eff, Axial Stress"
    assert seen("oedometer.dat") == (26, 1, 4, 3, "0.68721")
    assert seen("digitised.csv") == (8, 2, 3, 4, "948.3")
    assert read_table(FIELD / "digitised.csv").groups == ("e0 0.71 100 kPa",) * 2 + ("e0 0.79 400 kPa",) * 2
    assert seen("headerless.txt")[:4] == (15, 0, 1, 5)
    assert seen("recorder.txt")[:4] == (20, 1, 2, 10)
    assert seen("dense.csv") == (900, 1, 2, 2, "274.6")
    percent = read_table(FIELD / "percent_cells.csv")
    assert (percent.units, numbers(percent)[-1]) == (("%", "", "%"), [10.2, 1126.9, -2.07])
    assert read_table(FIELD / "portuguese.csv").header == ("Deform_axial_(%)", "Sigma_d_(kPa)", "Deform_Vol_(%)", "Sigma_3_(kPa)")


def test_many_rows_are_read_in_seconds(tmp_path: Path) -> None:
    text = "eps [%];q [kPa];epsv [%];e\n" + "".join(f"{at * 1e-4:.4f};{at * 0.01:,.2f};{-at * 1e-5:.5f};0.{at:06d}\n" for at in range(100_000))
    began = time.perf_counter()
    table = table_of(text, tmp_path)
    assert time.perf_counter() - began < 30
    assert len(table.rows) == 100_000 and read_number(table.rows[-1].cell(1), table.decimal) == 999.99
