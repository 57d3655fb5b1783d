"""Files in the shapes of the field: what is read from each, what is asked, and what is refused.

Strains below are logarithmic, compression and contraction positive, as fractions; stresses are effective, in Pa, unless they are said in kPa. Each figure is compared to half of its last
digit, and a bit. Every file but `recorder.txt` prints engineering strains, and only `drained_spaced_header.dat` and `headerless.txt` prove it, by their void ratio.
"""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass
from pathlib import Path

import pytest
from generated.expectation import Expectation, Figures
from generated.outcome import Outcome, differences, read, text_of
from generated.packing import packing
from typer.testing import CliRunner

from graincal.cli import app

FIELD = Path(__file__).parents[1] / "data" / "field"
SHOWN_DIGITS = 1e-6
E, T, U = "--strain engineering", "--kind triaxial", "--kind undrained"
AT_100, AT_400 = "--confining-pressure 100e3", "--confining-pressure 400e3"
NINE = "first=1.238 last=4.087"
PUBLIC = "--column axial_strain=1:% --column deviator_stress=2:kPa --column volumetric_strain=3:%"
BARE = "--column axial_strain=1:- --column axial_stress=2:kPa --column confining_pressure=C:kPa"
MACHINE = "--column axial_strain=7:% --column axial_stress=9:kPa --column lateral_stress=10:kPa --column volume_change=13:mm3"
HEADERLESS = "--column deviator_stress=1:kPa --column axial_strain=2:- --column mean_stress=3:kPa --column volumetric_strain=D:- --column void_ratio=5"
RECORDER = f"{T} --strain logarithmic --column axial_strain=e22:- --column radial_strain=e11:- --column axial_stress=s22:Pa --column lateral_stress=s11:Pa"
TEST_1 = f"{E} {T} {AT_100} --column axial_strain=1:% --column deviator_stress=2:kPa"
TEST_2 = f"{E} {T} {AT_400} --column axial_strain=C:% --column deviator_stress=D:kPa"


def figures(said: str, within: float | None = None) -> Figures:
    """Such as "first=1 last=3.674 max=3.792"; figures count to their last digit."""
    texts = dict(word.split("=") for word in said.split())
    digits = max((len(text.partition(".")[2]) for text in texts.values()), default=0)
    values = {name: float(text) for name, text in texts.items()}
    return Figures(*(values.get(name) for name in ("first", "last", "min", "max")), within or 0.6 * 10.0**-digits)


@dataclass(frozen=True)
class Reading:
    """A file, options of init, and what is read by them."""

    file: str
    options: str
    kind: str
    states: int
    pressure: float | None
    control: str
    observables: dict[str, Figures]
    void_ratio: float = 0.68
    known: tuple[tuple[str, Figures], ...] = ()

    def outcome(self, folder: Path) -> Outcome:
        return outcome(self.file, self.options, self.void_ratio, folder, self.expectation)

    @property
    def expectation(self) -> Expectation:
        name, last = (self.control.split(" to ") + [""])[:2]
        shown = figures(f"last={last}", 0.6 * 10.0 ** -len(last.partition(".")[2]) + SHOWN_DIGITS) if last else None
        return Expectation(self.kind, self.states, self.pressure, (name,), self.observables, dict(self.known), shown)


def outcome(file: str, options: str, void_ratio: float, folder: Path, expected: Expectation | None) -> Outcome:
    return read(FIELD / file, shlex.split(options), packing(void_ratio, folder), folder / "calibration.toml", expected)


def ratio_and_volume(ratio: str, volume: str, within: float | None = None) -> dict[str, Figures]:
    return {"stress_ratio": figures(ratio, within), "volumetric_strain": figures(volume)}


# The mass, the size and the specific gravity that `stages.csv` states make a void ratio of 0.365, and of 0.359 where shearing begins.
# fmt: off
READINGS = [
    Reading("drained_spaced_header.dat", E, "triaxial", 20, 150e3, "axial_strain to 0.248461", ratio_and_volume("first=1 last=3.16979 max=3.74511", "last=-0.0297332 max=0.0010553"), 0.742),
    # The lateral stress is from 99.7 to 100.3 kPa: these are ratios at 100 kPa, and row by row they are 3.789 and 3.682.
    Reading("back_pressure.txt", E, "triaxial", 16, 100e3, "axial_strain to 0.134675", ratio_and_volume("first=1 last=3.674 max=3.792", "first=0 last=-0.0179598", within=0.009)),
    Reading("undrained.txt", E, "undrained", 17, 200e3, "axial_strain to 0.162519", {"deviatoric_stress": figures("first=0 last=433330 min=0 max=433330", 6), "excess_pore_pressure": figures("first=0 last=-124200 min=-124200 max=55330", 6)}, known=(("stress_ratio", figures("first=1 last=2.33661")),)),
    Reading("tsf.csv", f"{E} {T} {AT_100}", "triaxial", 15, 100e3, "axial_strain to 0.109815", {"stress_ratio": figures("first=1 max=3.90729", 2e-5), "volumetric_strain": figures("first=0 last=-0.0192044")}),
    Reading("bare_stresses.csv", f"{E} {T} {BARE}", "triaxial", 15, 7e3, "axial_strain to 0.109815", {"stress_ratio": figures("first=1 last=4.347 max=4.411")}),
    Reading("stages.csv", f"{E} {T} --stage 3 {MACHINE}", "triaxial", 16, 190e3, "axial_strain to 0.134675", ratio_and_volume("first=1.0105 last=3.9493 max=4.0180", "first=0 last=-0.021514")),
    Reading("stages.csv", f"{E} {T} {MACHINE}", "triaxial", 16, 190e3, "axial_strain to 0.134675", ratio_and_volume("first=1.0105 last=3.9493 max=4.0180", "first=0 last=-0.021514")),
    Reading("stages.csv", f"{E} {T} --rows 38-53 {MACHINE}", "triaxial", 16, 190e3, "axial_strain to 0.134675", ratio_and_volume("first=1.0105 last=3.9493 max=4.0180", "first=0 last=-0.021514")),
    Reading("dense.csv", f"{E} {T} {AT_100}", "triaxial", 900, 100e3, "axial_strain", {"stress_ratio": figures("max=3.949", 0.003)}),
    Reading("oedometer.dat", "", "oedometric", 24, None, "position", {"void_ratio": figures("first=0.72106 last=0.68721 min=0.68721 max=0.72106")}, 0.724),
    Reading("oedometer.dat", "--kind oedometric", "oedometric", 24, None, "position", {"void_ratio": figures("first=0.72106 last=0.68721 min=0.68721 max=0.72106")}, 0.724),
    Reading("digitised.csv", TEST_1, "triaxial", 7, 100e3, "axial_strain to 0.166055", {"stress_ratio": figures("first=1.272 last=3.629 max=3.877")}, 0.71),
    Reading("digitised.csv", TEST_2, "triaxial", 8, 400e3, "axial_strain to 0.220647", {"stress_ratio": figures("first=1.147 last=3.371 max=3.379")}, 0.79),
    # -ln(1 - 0.03978), of the last volumetric strain as it is printed.
    Reading("headerless.txt", f"{E} {T} {HEADERLESS}", "triaxial", 15, 120e3, "axial_strain to 0.109815", ratio_and_volume("first=1 last=3.0269 max=3.0269", "first=0 last=0.0405929"), 0.72),
    Reading("portuguese.csv", E, "triaxial", 9, 100e3, "axial_strain to 0.0263440", ratio_and_volume(NINE, "last=-0.0044999")),
    Reading("portuguese.csv", f"{E} {T} {PUBLIC} --column lateral_stress=4:kPa", "triaxial", 9, 100e3, "axial_strain to 0.0263440", ratio_and_volume(NINE, "last=-0.0044999")),
    Reading("russian_cp1251.csv", f"{E} {T} {AT_100}", "triaxial", 9, 100e3, "axial_strain to 0.0263440", ratio_and_volume(NINE, "last=-0.0044999")),
    Reading("russian_cp1251.csv", f"{E} {T} {AT_100} {PUBLIC} --encoding cp1251", "triaxial", 9, 100e3, "axial_strain to 0.0263440", ratio_and_volume(NINE, "last=-0.0044999")),
    Reading("chinese_gbk.csv", f"{E} {T} {AT_100}", "triaxial", 9, 100e3, "axial_strain to 0.0263440", ratio_and_volume(NINE, "last=-0.0044999")),
    Reading("chinese_gbk.csv", f"{E} {T} {AT_100} {PUBLIC} --encoding gbk", "triaxial", 9, 100e3, "axial_strain to 0.0263440", ratio_and_volume(NINE, "last=-0.0044999")),
    Reading("recorder.txt", f"{RECORDER} --column porosity=porosity", "triaxial", 20, 200e3, "axial_strain to 0.22", ratio_and_volume("first=1 max=3.79178", "first=0 last=-0.02663"), 0.68067, known=(("void_ratio", figures("first=0.68067 last=0.72603")),)),
    Reading("recorder.txt", "", "triaxial", 20, 200e3, "axial_strain to 0.22", ratio_and_volume("first=1 max=3.79178", "first=0 last=-0.02663"), 0.68067),
    Reading("consolidation.ags", "--kind oedometric", "oedometric", 6, None, "position", {"void_ratio": figures("first=0.757 last=0.699 min=0.694 max=0.757")}, 0.764),
    Reading("percent_cells.csv", f"{E} {T} {AT_400}", "triaxial", 6, 400e3, "axial_strain to 0.107585", ratio_and_volume("first=1 last=3.81725 max=3.95075", "first=0 last=-0.0204887")),
]

# What is asked where the deciding option is not given.
# file, options, words of a question of `check`
QUESTIONS = [
    # The void ratio proves the measure of the volumetric strain alone.
    ("drained_spaced_header.dat", "", "axial strain is engineering or logarithmic"),
    ("headerless.txt", f"{T} {HEADERLESS}", "axial strain is engineering or logarithmic"),
    ("back_pressure.txt", "", "engineering or logarithmic"),
    ("undrained.txt", "", "engineering or logarithmic"),
    ("tsf.csv", f"{T} {AT_100}", "engineering or logarithmic"),
    ("bare_stresses.csv", f"{E} {T}", "in which unit"),
    ("dense.csv", f"{T} {AT_100}", "engineering or logarithmic"),
    ("dense.csv", f"{E} {AT_100}", "a drained from an undrained test"),
    ("portuguese.csv", f"{T} {PUBLIC} --column lateral_stress=4:kPa", "engineering or logarithmic"),
    ("russian_cp1251.csv", f"{T} {AT_100} {PUBLIC} --encoding cp1251", "engineering or logarithmic"),
    ("chinese_gbk.csv", f"{T} {AT_100} {PUBLIC} --encoding gbk", "engineering or logarithmic"),
    ("digitised.csv", TEST_1.removeprefix(E), "engineering or logarithmic"),
]

# file, options, void ratio of the packing, words of the refusal, the question or the problem: either is allowed
ASKED = [
    ("tsf.csv", f"{E} {T}", 0.68, "does not say the confining pressure"),
    ("dense.csv", f"{E} {T}", 0.68, "does not say the confining pressure"),
    ("stages.csv", f"{E} {T}", 0.68, "in which unit"),
    ("stages.csv", f"{E} {T} --stage 4 {MACHINE}", 0.68, r"stage is '4'"),
    ("digitised.csv", E, 0.71, "Which columns"),
    ("headerless.txt", E, 0.72, "Which columns are these"),
    ("recorder.txt", f"{RECORDER} --column void_ratio=porosity", 0.68067, "as a porosity does"),
    ("russian_cp1251.csv", E, 0.68, "does not say the confining pressure"),
    ("chinese_gbk.csv", E, 0.68, "does not say the confining pressure"),
]
# fmt: on


@pytest.mark.parametrize("reading", READINGS, ids=lambda reading: reading.file)
def test_a_file_of_the_field_is_read_as_it_is(reading: Reading, tmp_path: Path) -> None:
    found = reading.outcome(tmp_path)
    assert found.verdict == "RIGHT", f"{found.verdict}: {found.why}"


@pytest.mark.parametrize(("file", "options", "words"), QUESTIONS, ids=[question[0] for question in QUESTIONS])
def test_what_a_file_does_not_say_is_a_question(file: str, options: str, words: str, tmp_path: Path) -> None:
    found = outcome(file, options, 0.68, tmp_path, None)
    assert found.verdict == "ASKED", found.why
    assert any(re.search(words, text_of(question)) for question in found.said.get("questions", [])), found.why


@pytest.mark.parametrize(("file", "options", "void_ratio", "words"), ASKED, ids=[asked[0] for asked in ASKED])
def test_what_is_not_enough_is_refused_or_asked(file: str, options: str, void_ratio: float, words: str, tmp_path: Path) -> None:
    found = outcome(file, options, void_ratio, tmp_path, None)
    assert found.verdict == "ASKED", found.why
    assert re.search(words, found.why), found.why


def test_all_files_of_the_field_are_read() -> None:
    assert {reading.file for reading in READINGS} == {path.name for path in FIELD.iterdir()}


def test_stresses_of_a_file_share_the_unit_that_is_proposed(tmp_path: Path) -> None:
    """7 is not taken for kPa in one column and for MPa in another: what is shown beside the question is at 7 kPa."""
    found = outcome("bare_stresses.csv", f"{E} {T}", 0.68, tmp_path, None)
    assert found.verdict == "ASKED" and found.said, found.why
    for experiment in found.said["experiments"]:
        reading = next(reading for reading in READINGS if reading.file == "bare_stresses.csv")
        assert differences(experiment, reading.expectation, None) == []


def test_the_stages_of_a_machine_are_named_where_none_is_chosen(tmp_path: Path) -> None:
    calibration = tmp_path / "calibration.toml"
    result = CliRunner().invoke(app, ["init", str(FIELD / "stages.csv"), "--strain", "engineering", "-o", str(calibration)])
    assert result.exit_code == 0
    for text in (result.output, calibration.read_text()):
        assert "1 (lines 12-23), 2 (lines 24-37), 3 (lines 38-53)" in text
    assert 'stage       = "3"' in calibration.read_text()


def test_a_dense_file_is_thinned_and_that_is_said(tmp_path: Path) -> None:
    found = outcome("dense.csv", f"{E} {T} {AT_100}", 0.68, tmp_path, None)
    (experiment,) = found.said["experiments"]
    assert experiment["states"] == 900
    assert 40 <= experiment["kept_states"] <= 120


def test_rows_without_a_stress_are_left_out_and_named(tmp_path: Path) -> None:
    found = outcome("oedometer.dat", "--kind oedometric", 0.724, tmp_path, None)
    notes = " ".join(map(text_of, found.said["notes"]))
    for line in (4, 20):
        assert re.search(rf"\b{line}\b", notes), notes


def test_what_is_stated_in_percent_and_is_a_fraction_is_not_divided(tmp_path: Path) -> None:
    """The void ratio of 0.742 stands under [%]: by the packing, and by the strains beside it, it is no 0.00742."""
    found = outcome("drained_spaced_header.dat", E, 0.742, tmp_path, None)
    assert found.said, found.why
    said = " ".join(map(text_of, [*found.said["notes"], *found.said["decided"], *found.said["problems"], *found.said["questions"]]))
    assert not re.search(r"0\.0074\d*", said), said
