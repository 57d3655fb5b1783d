"""What graincal init asks in a terminal, and that an answer is the same as its option."""

from pathlib import Path

import pytest

from graincal.cli.asking import _as_argument
from graincal.laboratory import Question

from .terminal import in_terminal

FIELD = Path(__file__).parents[1] / "data" / "field"
BARE = FIELD / "bare_stresses.csv"
WAITS = "(empty: it stays"
OPTIONS = ("--stress-unit", "kPa", "--kind", "triaxial", "--strain", "engineering", "--void-ratio", "0.68")


@pytest.fixture
def written(call, tmp_path):
    """The calibration file of options, written where nobody is asked."""

    def write(*arguments):
        assert call("init", *arguments, "-o", tmp_path / "by_options.toml").code == 0
        return (tmp_path / "by_options.toml").read_text(encoding="utf-8")

    return write


def asked(tmp_path, *arguments, answers=()):
    """What the terminal shows, and the calibration file."""
    file = tmp_path / "asked.toml"
    code, shown = in_terminal(["init", *arguments, "-o", file], answers)
    assert code == 0, shown
    return shown, file.read_text(encoding="utf-8")


def test_an_answer_is_the_same_as_its_option(tmp_path, written):
    shown, text = asked(tmp_path, BARE, answers=("kPa", "triaxial", "engineering", "0.68"))
    assert text == written(BARE, *OPTIONS) and '"?"' not in text.partition("[parameters]")[2]
    # The confining pressure follows from the unit, and is asked no more.
    assert [line.split(" (empty")[0] for line in shown.splitlines() if WAITS in line] == ["units.stresses", "kind", "strain", "void_ratio"]


def test_nothing_is_asked_where_options_give_all(tmp_path, written):
    shown, text = asked(tmp_path, BARE, *OPTIONS)
    assert WAITS not in shown and text == written(BARE, *OPTIONS)


def test_an_invalid_answer_is_asked_again_with_the_reason(tmp_path, written):
    shown, text = asked(tmp_path, BARE, *OPTIONS[2:], answers=("furlong", "m", "kPa"))
    assert shown.count(WAITS) == 3 and "Error: --stress-unit is 'furlong', and one of" in shown and text == written(BARE, *OPTIONS)


def test_an_empty_answer_leaves_the_question_in_the_file(tmp_path, written):
    _, text = asked(tmp_path, BARE, *OPTIONS[2:], answers=("", ""))
    assert text == written(BARE, *OPTIONS[2:]) and 'confining_pressure = "?"' in text


def test_a_pressure_that_cannot_be_is_asked_again(tmp_path, written):
    shown, text = asked(tmp_path, FIELD / "tsf.csv", "--strain", "engineering", "--void-ratio", "0.68", answers=("-1", "much", "100e3"))
    assert shown.count("Error: ") == 2 and text == written(
        FIELD / "tsf.csv", "--strain", "engineering", "--void-ratio", "0.68", "--confining-pressure", "100e3"
    )


def test_a_refusal_is_answered_by_the_options_that_it_names(tmp_path, written):
    columns = "--column axial_strain=3:% --column deviator_stress=4:kPa"
    others = ("--confining-pressure", "400e3", "--kind", "triaxial", "--strain", "engineering", "--void-ratio", "0.68")
    shown, text = asked(tmp_path, FIELD / "digitised.csv", *others, answers=("--column axial_strain=9", "--output x", "3", columns))
    assert text == written(FIELD / "digitised.csv", *others, *columns.split())
    assert shown.count("Error: ") == 3 and "3  'e0 0.79 400 kPa: X'" in shown


def test_a_refusal_that_nobody_answers_is_as_without_a_terminal(tmp_path, written):
    _, text = asked(tmp_path, FIELD / "digitised.csv", answers=("",))
    assert text == written(FIELD / "digitised.csv")


def test_what_no_option_answers_is_refused_at_once(tmp_path):
    code, shown = in_terminal(["init", tmp_path / "none.csv", "-o", tmp_path / "c.toml"])
    assert code == 1 and "none.csv" in shown and "(empty" not in shown


def test_nothing_is_written_where_the_person_ends_it(tmp_path):
    code, _ = in_terminal(["init", BARE, "-o", tmp_path / "c.toml"], ("kPa",))
    assert code == 1 and not (tmp_path / "c.toml").exists()


@pytest.mark.parametrize(
    ("key", "option", "answer", "argument"),
    [
        ("kind", "--kind", "triaxial", "--kind=triaxial"),
        ("confining_pressure", "--stress-unit, or --confining-pressure", "7e3", "--confining-pressure=7e3"),
        ("void_ratio", "--void-ratio, --relative-density, or --packing FILE", "0.7", "--void-ratio=0.7"),
        ("units.axial_strain", "--column axial_strain=2:UNIT", "%", "--column=axial_strain=2:%"),
        ("compression.volumetric_strain", "--compression volumetric_strain=positive", "negative", "--compression=volumetric_strain=negative"),
    ],
)
def test_an_answer_becomes_the_argument_of_its_option(key, option, answer, argument):
    assert _as_argument(Question(key, "Which?", option=option), answer) == argument
