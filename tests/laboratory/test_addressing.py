"""The column that is meant, however it is said."""

from pathlib import Path

import pytest

from graincal.data import InputError
from graincal.laboratory.addressing import column_index
from graincal.laboratory.table import Table, read_table


def table_of(text: str, folder: Path) -> Table:
    path = folder / "lab.csv"
    path.write_text(text)
    return read_table(path)


@pytest.mark.parametrize(
    ("said", "index"),
    [("q [kPa]", 1), ("q", 1), ("Void  ratio", 2), (3, 2), ("3", 2), ("A", 0), ("C", 2), ("E", 4), ("F", 3), ("7", 5), (7, 6)],
)
def test_a_column_is_named_by_its_header_its_number_or_its_letter(said: int | str, index: int, tmp_path: Path) -> None:
    # "F" and "7" are names here, before they are a letter and a number.
    table = table_of("eps [%],q [kPa],Void ratio,F [kN],u,7 [-],x\n1,2,3,4,5,6,7\n1,2,3,4,5,6,7\n", tmp_path)
    assert column_index(table, said) == index


@pytest.mark.parametrize(
    ("said", "second", "index"),
    [("loose: X", False, 0), ("dense Y", False, 3), ("loose", False, 0), ("loose", True, 1), ("dense", False, 2), ("dense", True, 3), (4, True, 3)],
)
def test_a_column_of_a_group_is_named_with_it(said: int | str, second: bool, index: int, tmp_path: Path) -> None:
    table = table_of("loose,,dense,\nX,Y [kPa],X,Y [kPa]\n1,2,3,4\n5,6,7,8\n", tmp_path)
    assert column_index(table, said, second=second) == index


@pytest.mark.parametrize(
    ("said", "expected"),
    [
        ("X", "2 columns answer to 'X' (1 'loose: X', 3 'dense: X'), and a single one was expected (a column may be named by its number)."),
        ("Z", "there is no column 'Z', and those present are 'X', 'Y', 'X', 'Y' (columns = { ... } in a calibration file says which is which)."),
        (9, "there is no column 9, and a number from 1 to 4 was expected (1 'loose: X', 2 'loose: Y', 3 'dense: X', 4 'dense: Y')."),
        ("0", "there is no column 0, and a number from 1 to 4 was expected"),
        (True, "a column is named by its header or its number, and not by True."),
        (1.0, "a column is named by its header or its number, and not by 1.0."),
    ],
)
def test_what_names_no_column_or_several_is_refused(said, expected: str, tmp_path: Path) -> None:
    table = table_of("loose,,dense,\nX,Y,X,Y\n1,2,3,4\n5,6,7,8\n", tmp_path)
    with pytest.raises(InputError) as refusal:
        column_index(table, said)
    assert str(refusal.value).startswith(f"{table.path}: {expected}")


def test_a_group_of_more_than_two_columns_is_no_pair(tmp_path: Path) -> None:
    table = table_of("loose,,,dense,,\nX,Y,Z,X,Y,Z\n1,2,3,4,5,6\n5,6,7,8,9,1\n", tmp_path)
    with pytest.raises(InputError, match=r"the group 'dense' has 3 columns \(4 'dense: X', 5 'dense: Y', 6 'dense: Z'\), and a pair was expected"):
        column_index(table, "dense")


def test_where_no_column_has_a_name_it_is_said_why(tmp_path: Path) -> None:
    table = table_of("1,2\n3,4\n", tmp_path)
    assert column_index(table, "B") == 1
    with pytest.raises(InputError) as refusal:
        column_index(table, "eps")
    assert str(refusal.value) == (
        f"{table.path}: there is no column 'eps', for line 1 is numbers already, and no line above it names the columns: columns may be named by number, "
        "as --column axial_strain=2:%."
    )
