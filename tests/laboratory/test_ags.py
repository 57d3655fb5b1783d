"""Files of the AGS format: a group is a table, of one specimen."""

from pathlib import Path

import pytest

from graincal.data import InputError
from graincal.laboratory.table import read_table

CONSOLIDATION = Path(__file__).parent.parent / "data" / "field" / "consolidation.ags"


def test_a_group_is_a_table() -> None:
    table = read_table(CONSOLIDATION)
    assert (table.sheet, table.header_line, table.lines, table.delimiter) == ("CONS", 8, [11, 12, 13, 14, 15, 16], ",")
    columns = {name: [float(row.cell(index)) for row in table.rows] for index, name in enumerate(table.header) if name.startswith("CONS_")}
    assert columns["CONS_INCF"] == [25, 50, 100, 200, 400, 100]
    assert columns["CONS_INCE"] == [0.757, 0.748, 0.735, 0.717, 0.694, 0.699]
    assert columns["CONS_IVR"][0] == 0.764
    assert dict(zip(table.header, table.units, strict=True))["CONS_INCF"] == "kPa"


def several(folder: Path) -> Path:
    path = folder / "lab.ags"
    text = CONSOLIDATION.read_text()
    path.write_text(text.rstrip("\n") + '\n"DATA","BH0","5.10","U3","1","0.800","25","0.790","0.20"\n')
    return path


def test_of_several_specimens_one_is_said(tmp_path: Path) -> None:
    path = several(tmp_path)
    with pytest.raises(InputError) as refusal:
        read_table(path)
    assert str(refusal.value) == (
        f"{path}: group CONS holds 2 specimens, 'BH0 3.20 U2', 'BH0 5.10 U3': say which with --sheet 'CONS/BH0 3.20 U2', or sheet = \"CONS/BH0 3.20 U2\" in a calibration file."
    )
    assert len(read_table(path, sheet="CONS/BH0 3.20 U2").rows) == 6
    for said in ("CONS/BH0 5.10 U3", "CONS/U3", "CONS/5.10"):
        table = read_table(path, sheet=said)
        assert (table.sheet, [row.cells[4:7] for row in table.rows]) == ("CONS/BH0 5.10 U3", [("0.800", "25", "0.790")])
    with pytest.raises(InputError, match="group CONS holds 2 specimens"):
        read_table(path, sheet="CONS/BH0")
    with pytest.raises(InputError, match="group CONS has no specimen 'BH1', and one of 'BH0 3.20 U2', 'BH0 5.10 U3' was expected"):
        read_table(path, sheet="CONS/BH1")


def test_a_group_that_is_missing_or_not_known_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no group 'TRET' with rows, and one of PROJ, CONS was expected"):
        read_table(CONSOLIDATION, sheet="TRET")
    path = tmp_path / "lab.ags"
    path.write_text(CONSOLIDATION.read_text().replace('"CONS"', '"TRET"'))
    with pytest.raises(InputError, match="none of the groups PROJ, TRET is known to hold the states of a test"):
        read_table(path)
    assert read_table(path, sheet="TRET").sheet == "TRET"
    path.write_text(CONSOLIDATION.read_text().rstrip("\n") + '\n"DATA","BH0","3.20","U2","7","1","2","3","4","5"\n')
    with pytest.raises(InputError, match="line 17 has 9 values where group CONS has 8 headings"):
        read_table(path)
