"""The questions of a calibration file: each with what the file says of it, and of nothing else."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from graincal.campaign.file.examination import examine
from graincal.campaign.file.questions import OpenQuestion

from .tested import DRAINED, write

FIELD = Path(__file__).parents[1] / "data" / "field"


def questions(call, tmp_path: Path, name: str, *options: str) -> dict[str, OpenQuestion]:
    """Those of the file that init writes of a laboratory file."""
    file = tmp_path / "calibration.toml"
    assert call("init", FIELD / name, *options, "-o", file).code == 0
    found, lines = examine(file).questions, file.read_text(encoding="utf-8").splitlines()
    for question in found:
        assert lines[question.line - 1].split("=")[0].strip() in question.path and '"?"' in lines[question.line - 1]
    return {question.key: question for question in found}


def test_each_question_of_init_stands_above_its_own_key(call, tmp_path):
    found = questions(call, tmp_path, "bare_stresses.csv")
    said = {key: (question.asked, question.answers) for key, question in found.items()}
    unit = "'axial_stress', 'confining_pressure' have no unit, and no stress of the file has one: in which unit are they?"
    assert said == {
        "model.kind": (
            "The file has neither a change of volume nor a pore pressure that tells a drained from an undrained test: which is it? Likely: triaxial.", ("triaxial", "undrained", "constant-mean-stress"),
        ),
        "model.void_ratio": ("The file does not say the void ratio before shearing: what is it?", ()),
        "model.confining_pressure": ("It follows from the columns once the unit of their stresses is known: what is it in Pa? Likely: 7000.0.", ()),
        "reference.strain": (
            "Whether axial strain is engineering or logarithmic cannot be seen from the numbers. Laboratories mostly print engineering strain, simulations logarithmic. Likely: engineering.",
            ("engineering", "logarithmic"),
        ),
        **{f"reference.units.{key}": (f"{unit} Likely: kPa.", found[f"reference.units.{key}"].answers) for key in ("axial_stress", "lateral_stress")},
    }  # fmt: skip
    assert all(
        "kPa" in found[f"reference.units.{key}"].answers and "%" not in found[f"reference.units.{key}"].answers for key in ("axial_stress", "lateral_stress")
    )
    for question in found.values():
        assert "CHECK" not in question.sentence and question.sentence.count("Likely") <= 1


def test_programs_read_the_plain_question_and_people_its_place(call, tmp_path):
    file = tmp_path / "calibration.toml"
    call("init", FIELD / "bare_stresses.csv", "-o", file)
    asked = json.loads(call("check", file, "--json").out)["questions"]
    (question,) = [each for each in asked if each["key"] == "model.void_ratio"]
    assert question == {
        "experiment": "bare_stresses",
        "key": "model.void_ratio",
        "line": question["line"],
        "question": "The file does not say the void ratio before shearing: what is it?",
        "answers": [],
        "proposed": None,
    }
    assert (
        f'experiment "bare_stresses": model.void_ratio is an open question (line {question["line"]}): The file does not say the void ratio'
        in call("check", file).out
    )


@pytest.mark.parametrize(("name", "options"), [("digitised.csv", ()), ("headerless.txt", ()), ("undrained.txt", ()), ("portuguese.csv", ())])
def test_questions_of_other_files_say_something_of_their_own(call, tmp_path, name, options):
    found = questions(call, tmp_path, name, *options)
    assert found and all(question.comment and "CHECK" not in question.comment for question in found.values())


def test_comments_of_a_line_with_several_keys_go_to_the_key_that_they_name(tmp_path):
    inline = (
        ('packing = "PACKING", confining_pressure = 200e3', 'particles = 1000, void_ratio = "?", grading = "toyoura", confining_pressure = "?"'),
        ("model       =", "# The void ratio: loose or dense?\n# The confining pressure in Pa?\n# The grading: CHECK, that of Toyoura sand.\nmodel       ="),
        ('strain = "logarithmic" }', 'strain = { axial_strain = "?", volumetric_strain = "?" } }   # see the standard'),
        ("reference   =", "# axial_strain: by the length of before, or of then?\nreference   ="),
    )
    found = {question.key: question.comment for question in examine(write(tmp_path, DRAINED, {}, inline)).questions}
    assert found == {
        "model.void_ratio": "The void ratio: loose or dense?", "model.confining_pressure": "The confining pressure in Pa?",
        "reference.strain.axial_strain": "axial_strain: by the length of before, or of then?", "reference.strain.volumetric_strain": "see the standard",
    }  # fmt: skip


def test_a_question_without_a_comment_is_asked_by_its_key(tmp_path):
    (question,) = examine(
        write(tmp_path, DRAINED, {}, (("confining_pressure = 200e3", 'confining_pressure = "?"'),)), proposed=lambda entry, key: 2e5
    ).questions
    assert question.asked == "What is model.confining_pressure? Likely: 200000.0."
