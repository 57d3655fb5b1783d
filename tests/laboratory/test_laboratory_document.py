"""docs/laboratory-data.md shows what `graincal init` prints. `python tests/laboratory/test_laboratory_document.py` writes it anew."""

import re
import shlex
import shutil
import tempfile
from contextlib import chdir
from pathlib import Path

from typer.testing import CliRunner

from graincal.cli import app

ROOT = Path(__file__).parents[2]
DOCUMENT = ROOT / "docs" / "laboratory-data.md"
EXAMPLES = [
    ("A header set out by spaces over rows by tabs, p and q, a void ratio under %", "drained_spaced_header.dat --strain engineering"),
    ("Total and effective lateral stress", "back_pressure.txt --strain engineering"),
    ("Undrained", "undrained.txt --strain engineering"),
    ("US units", "tsf.csv --confining-pressure 100e3"),
    ("Stresses without a unit", "bare_stresses.csv"),
    ("Stages of a machine", "stages.csv --strain engineering --stress-unit kPa"),
    ("A logger's rows", "dense.csv --confining-pressure 100e3 --kind triaxial --strain engineering"),
    ("An oedometer with a cycle", "oedometer.dat"),
    ("Two curves of a plot digitiser", "digitised.csv"),
    ("One of them", "digitised.csv --column axial_strain=3:% --column deviator_stress=4:kPa --confining-pressure 400e3 --kind triaxial --strain engineering"),
    (
        "No header",
        "headerless.txt --column deviator_stress=1:kPa --column axial_strain=2:- --column mean_stress=3:kPa --column volumetric_strain=4:- --column void_ratio=5",
    ),
    ("Portuguese", "portuguese.csv --strain engineering"),
    ("Russian, in Windows-1251", "russian_cp1251.csv --strain engineering --confining-pressure 100e3"),
    ("Chinese, in GBK", "chinese_gbk.csv --strain engineering --confining-pressure 100e3"),
    ("A simulation's recorder", "recorder.txt"),
    ("AGS4", "consolidation.ags"),
    ("Percent cells and thousands", "percent_cells.csv --strain engineering --confining-pressure 400e3"),
]


def shown() -> str:
    """The examples, as the document has them."""
    blocks = []
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        for file in (ROOT / "tests" / "data" / "field").iterdir():
            shutil.copy(file, folder)
        shutil.copy(ROOT / "src" / "graincal" / "demo" / "packing_500.csv", "packing.csv")
        for title, options in EXAMPLES:
            command = f"graincal init {options} --packing packing.csv"
            Path("calibration.toml").unlink(missing_ok=True)
            result = CliRunner().invoke(app, shlex.split(command)[1:])
            output = result.output if result.exit_code == 0 else str(result.exception)
            blocks.append(f"### {title}\n\n```console\n$ {command}\n{output.strip()}\n```\n")
    return "\n".join(blocks)


def test_the_document_shows_what_is_printed() -> None:
    examples = DOCUMENT.read_text(encoding="utf-8").partition("### ")
    assert examples[1] + examples[2] == shown()


def test_the_document_names_files_that_are_there() -> None:
    for link in re.findall(r"\]\((?!http)([^)#]+)", DOCUMENT.read_text(encoding="utf-8")):
        assert (DOCUMENT.parent / link).exists(), link


if __name__ == "__main__":
    text = DOCUMENT.read_text(encoding="utf-8").partition("### ")[0]
    DOCUMENT.write_text(text + shown(), encoding="utf-8")
