"""What cannot be read is refused in one sentence that names the file, the place and what was expected."""

import re
from pathlib import Path

import pytest
from invented_test import CANONICAL, DEVIATOR_STRESS, STRAINS, STRESS_RATIO, percent, rows, text, with_loop

from graincal.data import InputError, Reference
from graincal.laboratory import understand

LINES = percent()
GOOD = text(CANONICAL, *LINES)
Q = "axial_strain [%],volumetric_strain [%],deviator_stress [kPa]"
WITH_Q = text(Q, *rows(*STRAINS, DEVIATOR_STRESS / 1e3))
NEGATIVE_Q = text(Q, *rows(*STRAINS, -DEVIATOR_STRESS / 1e3))
NEGATIVE_STRAIN = text(CANONICAL, *rows(-STRAINS[0], STRAINS[1], STRESS_RATIO))


def changed(line: int, column: int, cell: str) -> str:
    """The good file with another cell; lines count from 1, the header being line 1."""
    lines = GOOD.splitlines()
    cells = lines[line - 1].split(",")
    cells[column] = cell
    lines[line - 1] = ",".join(cells)
    return text(*lines)


def with_header(header: str) -> str:
    return text(header, *LINES)


# name: (file's text, options, what the sentence must name)
REFUSALS = {
    "empty": ("", {}, ["empty", "header"]),
    "blank and comments": ("\n# nothing\n\n", {}, ["empty"]),
    "only a header": (text(CANONICAL), {}, ["only a header", CANONICAL, "rows of numbers"]),
    "prose": ("A test was made.\nIt went well.\n", {}, ["two numbers", "rows of numbers"]),
    "no header": (text(*LINES), {}, ["no column axial_strain"]),
    "binary": ("\x00\x01\x02", {}, ["not a text file"]),
    "spreadsheet": ("PK\x03\x04 sheet", {}, ["spreadsheet", "CSV"]),
    "decimal commas between commas": (
        text(CANONICAL, *(line.replace(".", ",") for line in LINES)),
        {},
        ["line 2", "6 cells", "3 names", "decimal commas"],
    ),
    "missing column": (
        with_header("axial_strain [%],eps_v,stress_ratio"),
        {},
        ["no column volumetric_strain", "'axial_strain [%]', 'eps_v', 'stress_ratio'"],
    ),
    "missing stress": (
        with_header("axial_strain [%],volumetric_strain [%],R"),
        {},
        ["no column stress_ratio", "deviator_stress", "axial_stress", "'R'"],
    ),
    "missing named column": (GOOD, {"columns": {"axial_strain": "Ea(%)"}}, ["'Ea(%)' for axial_strain", "'axial_strain [%]'"]),
    "two columns of a name": (
        with_header("axial_strain [%],volumetric_strain [%],volumetric_strain [-],stress_ratio"),
        {},
        ["2 columns", "volumetric_strain [-]"],
    ),
    "two stresses": (
        text("axial_strain [%],deviator_stress [kPa],axial_stress [kPa]", *LINES),
        {"observables": ["stress_ratio"]},
        ["'deviator_stress [kPa]', 'axial_stress [kPa]'", "columns"],
    ),
    "nan": (changed(7, 1, "NaN"), {}, ["'volumetric_strain [%]'", "line 7", "'NaN'", "finite"]),
    "infinite": (changed(8, 2, "-inf"), {}, ["'stress_ratio [-]'", "line 8", "'-inf'"]),
    "too large a number": (changed(8, 2, "1e999"), {}, ["'stress_ratio [-]'", "line 8", "'1e999'"]),
    "thousands separator": (changed(8, 2, '"12,34.5"'), {}, ["'stress_ratio [-]'", "line 8", "'12,34.5'", "thousands separator"]),
    "a thousands separator that may be a decimal mark": (changed(8, 2, '"1,234"'), {}, ["'stress_ratio [-]'", "line 8", "'1,234'", "thousands separator"]),
    "a percent sign in a cell": (changed(8, 2, "2.5%"), {}, ["'stress_ratio [-]'", "line 8", "'2.5%'", "behind all numbers of the column or none"]),
    "hardly a number": (changed(8, 2, "1e300"), {}, ["'stress_ratio [-]'", "line 8", "'1e300'"]),
    "open quotation mark": (changed(8, 2, '"2.5'), {}, ["line 8", "quotation mark"]),
    "two decimal marks": (changed(8, 2, '"2,5"'), {}, ["'stress_ratio [-]'", "line 8", "'2,5'", "decimal mark '.'"]),
    "words in a cell": (changed(7, 1, "n/a"), {}, ["'volumetric_strain [%]'", "line 7", "'n/a'", "a number was expected", "an empty cell is a gap"]),
    "a dash in a cell": (changed(7, 2, "-"), {}, ["'stress_ratio [-]'", "line 7", "'-'"]),
    "words between white space": (
        text(
            "axial_strain[%] volumetric_strain[%] stress_ratio",
            *(line.replace(",", " ") for line in LINES[:9]),
            "8 failed",
            *(line.replace(",", " ") for line in LINES[9:]),
        ),
        {},
        ["line 11", "'failed'", "each of the 3 columns"],
    ),
    "no numbers in a column": (
        text(CANONICAL, *(line.rsplit(",", 1)[0] + "," for line in LINES)),
        {},
        ["'stress_ratio [-]'", "no numbers"],
    ),
    "no complete row": (
        text("axial_strain [%],volumetric_strain [%],stress_ratio", *("1,2," for _ in LINES), "1,,2"),
        {},
        ["no row", "'stress_ratio'"],
    ),
    "percent without a unit": (
        with_header("axial_strain,volumetric_strain [%],stress_ratio"),
        {},
        ["'axial_strain'", "'axial_strain [%]'"],
    ),
    "both strains in percent without a unit": (
        with_header("axial_strain,volumetric_strain,stress_ratio"),
        {},
        ["reaches 20 on line 27", "'axial_strain [%]'", 'units = { axial_strain = "%" }'],
    ),
    "one strain without a unit": (
        with_header("axial_strain [%],volumetric_strain,stress_ratio"),
        {},
        ["'volumetric_strain'", "no unit", "'volumetric_strain [%]'"],
    ),
    "unknown unit": (
        with_header("axial_strain [furlong],volumetric_strain [%],stress_ratio"),
        {},
        ["axial_strain", "'furlong'", "-, %, permille"],
    ),
    "unknown unit said": (GOOD, {"units": {"axial_strain": "parts"}}, ["axial_strain", "'parts'", "-, %, permille"]),
    "unit of a free quantity": (
        with_header("depth [furlong],volumetric_strain [%],stress_ratio"),
        {"control": "depth"},
        ["depth", "'furlong'", "kPa", "mm"],
    ),
    "pressure for a strain": (with_header("axial_strain [kPa],volumetric_strain [%],stress_ratio"), {}, ["axial_strain", "'kPa'", "-, %"]),
    "pressure for a ratio": (
        with_header("axial_strain [%],volumetric_strain [%],stress_ratio [kPa]"),
        {},
        ["stress_ratio", "'kPa'", "deviator_stress or axial_stress"],
    ),
    "stress without a unit": (WITH_Q.replace(" [kPa]", ""), {"confining_pressure": 2e5}, ["'deviator_stress'", "no unit", "kPa, MPa"]),
    "no confining pressure": (WITH_Q, {}, ["'deviator_stress [kPa]'", "confining_pressure in Pa"]),
    "negative confining pressure": (WITH_Q, {"confining_pressure": -2e5}, ["confining_pressure", "positive", "-200000.0"]),
    "confining pressure in kPa": (
        WITH_Q,
        {"confining_pressure": 200},
        ["'deviator_stress [kPa]'", "confining_pressure = 200 Pa", "another unit"],
    ),
    "negative deviator stress": (
        NEGATIVE_Q,
        {"confining_pressure": 2e5},
        ["'deviator_stress [kPa]'", "mostly negative", "compression"],
    ),
    "q/p beyond its limit": (
        text("axial_strain [%],volumetric_strain [%],deviator_to_mean_stress", *LINES),
        {},
        ["'deviator_to_mean_stress'", "4.", "less than 3"],
    ),
    "tension positive, not said": (NEGATIVE_STRAIN, {}, ["axial_strain goes down to -0.2", 'write compression = "negative"']),
    "tension positive, loops dropped": (
        NEGATIVE_STRAIN,
        {"unloading": "drop"},
        ["axial_strain goes down to -0.2", 'write compression = "negative"'],
    ),
    "tension positive, said although it is not": (
        GOOD,
        {"compression": "negative"},
        ["axial_strain goes down to -0.2", 'leave axial_strain out of compression = "negative"'],
    ),
    "rows in reverse": (text(CANONICAL, *reversed(LINES)), {}, ["axial_strain falls throughout, from 0.2 to 0", "reverse", "order of the test"]),
    "rows in reverse, loops dropped": (text(CANONICAL, *reversed(LINES)), {"unloading": "drop"}, ["axial_strain falls throughout", "reverse"]),
    "tension positive and rows in reverse": (
        text(CANONICAL, *reversed(NEGATIVE_STRAIN.splitlines()[1:])),
        {},
        ["comes back from -0.2 to", 'write compression = "negative" and reverse the rows'],
    ),
    "a free control in reverse": (
        text("depth [m],stress_ratio", "3,1", "2,2", "1,3"),
        {"control": "depth", "observables": ["stress_ratio"]},
        ["depth falls throughout, from 3 to 1"],
    ),
    "engineering strain beyond one": (
        changed(27, 0, "120"),
        {"strain": "engineering"},
        ["'axial_strain [%]'", "line 27", "1.2", "less than 1"],
    ),
    "loop": (text(CANONICAL, *with_loop(LINES)), {}, ["axial_strain turns back at lines 13-15", 'unloading = "drop"']),
    "until zero": (GOOD, {"until": 0}, ["until", "positive", "0"]),
    "until negative": (GOOD, {"until": -0.1}, ["until", "positive", "-0.1"]),
    "until nowhere": (GOOD, {"until": float("nan")}, ["until", "positive", "nan"]),
    "until infinite": (GOOD, {"until": float("inf")}, ["until", "positive", "inf"]),
    "until in words": (GOOD, {"until": "10 %"}, ["until", "positive", "'10 %'"]),
    "until true": (GOOD, {"until": True}, ["until", "positive", "True"]),
    "until of no row": (text(CANONICAL, *LINES[1:]), {"until": 0.001}, ["until = 0.001 leaves no row", "from 0.008 to 0.2", "at least two"]),
    "until of a single row": (GOOD, {"until": 0.007}, ["until = 0.007 leaves a single row", "axial_strain goes from 0 to 0.2", "at least two"]),
    "until of a single row that is repeated": (text(CANONICAL, LINES[0], *LINES), {"until": 0.007}, ["until = 0.007 leaves a single row"]),
    "until in percent": (GOOD, {"until": 12}, ["until = 12 leaves nothing out", "axial_strain goes to 0.2", "a fraction was expected", "write 0.12"]),
    "tension positive, not said, until": (NEGATIVE_STRAIN, {"until": 0.1}, ["axial_strain goes down to -0.2"]),
    "unloading": (GOOD, {"unloading": "keep"}, ["unloading", '"drop"', "'keep'"]),
    "strain": (GOOD, {"strain": "true"}, ["strain", '"logarithmic" or "engineering"', "'true'"]),
    "strain of a stress": (
        GOOD,
        {"strain": {"stress_ratio": "engineering"}},
        ["strain", "'stress_ratio'", "axial_strain, volumetric_strain"],
    ),
    "compression": (GOOD, {"compression": {"axial_strain": "minus"}}, ["compression", '"positive" or "negative"', "'minus'"]),
    "columns of another quantity": (
        GOOD,
        {"columns": {"axial_stran": "x"}},
        ["columns", "'axial_stran'", "axial_strain, stress_ratio, volumetric_strain"],
    ),
    "units of another quantity": (GOOD, {"units": {"deviator_stress": "kPa"}}, ["units", "'deviator_stress'", "stress_ratio"]),
    "columns not a table": (GOOD, {"columns": "x"}, ["columns", "'x'"]),
    "column not text": (GOOD, {"columns": {"axial_strain": 1.5}}, ["columns of axial_strain", "text or a number above 0", "1.5"]),
    "no observables": (GOOD, {"observables": []}, ["observables", "at least one"]),
    "observables a word": (GOOD, {"observables": "stress_ratio"}, ["observables", "'stress_ratio'"]),
    "control among the observables": (GOOD, {"observables": ["axial_strain"]}, ["axial_strain is the control"]),
    "negative share": (GOOD, {"observables": {"stress_ratio": -1}}, ["variance shares", "stress_ratio", "positive", "-1"]),
    "share of words": (GOOD, {"observables": {"stress_ratio": "much"}}, ["variance shares", "stress_ratio", "'much'"]),
    "negative error": (GOOD, {"measurement_errors": {"stress_ratio": -0.1}}, ["measurement_errors", "stress_ratio", "positive"]),
    "error of another quantity": (GOOD, {"measurement_errors": {"void_ratio": 0.1}}, ["void_ratio", "stress_ratio"]),
}


def assert_one_sentence(message: str, path: Path, expected: list[str]) -> None:
    assert message.startswith(f"{path}: ")
    sentence = message.removeprefix(f"{path}: ")
    assert "\n" not in sentence and sentence.endswith(".")
    assert not re.search(r"[.!?]['\")]*\s+[A-Z]", sentence), "more than one sentence"
    for words in expected:
        assert words in sentence, sentence


@pytest.mark.parametrize("name", REFUSALS)
def test_refused_in_one_sentence(name: str, tmp_path: Path) -> None:
    content, options, expected = REFUSALS[name]
    path = tmp_path / "lab.csv"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(InputError) as refusal:
        Reference.read(path, **options)
    assert_one_sentence(str(refusal.value), path, expected)


@pytest.mark.parametrize("read", [Reference.read, understand])
def test_what_is_no_file_is_refused(read, tmp_path: Path) -> None:
    with pytest.raises(InputError) as refusal:
        read(tmp_path / "nowhere.csv")
    assert_one_sentence(str(refusal.value), tmp_path / "nowhere.csv", ["no such file"])
    with pytest.raises(InputError) as refusal:
        read(tmp_path)
    assert_one_sentence(str(refusal.value), tmp_path, ["this is a folder", "a laboratory file was expected"])


@pytest.mark.parametrize("header", ["q [kPa]", "Deviator [kPa]"])
def test_another_name_of_an_observable_is_refused_and_not_the_column_that_is_right(header: str, tmp_path: Path) -> None:
    path = tmp_path / "lab.csv"
    path.write_text(f"axial_strain,{header}\n0,0\n0.1,100\n")
    with pytest.raises(InputError) as error:
        Reference.read(path, observables=["q"], columns={"deviator_stress": header}, confining_pressure=1e5)
    assert str(error.value).startswith(f"{path}: 'q' is not an observable (did you mean \"stress_ratio\"?), and stress_ratio, volumetric_strain, ")


def test_long_lists_of_lines_are_cut(tmp_path: Path) -> None:
    path = tmp_path / "lab.csv"
    path.write_text(text("axial_strain,stress_ratio", *(f"{0.001 * i},{i}\n{0.001 * i - 0.0005},0" for i in range(12))))
    with pytest.raises(InputError, match=r"lines 3, 5, 7, 9, 11, 13, 15, 17 and 4 more places"):
        Reference.read(path, observables=["stress_ratio"])
