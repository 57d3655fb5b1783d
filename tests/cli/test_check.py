"""graincal check for people and programs: open questions, exit codes, and what calibrate does with problems."""

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from campaign.hyperbola import write_calibration

from graincal.campaign.asked.doubt import CODES, LEVELS, Doubt
from graincal.campaign.file import laboratory_evidence
from graincal.campaign.file.config import read_calibration
from graincal.campaign.file.examination import examine
from graincal.data import InputError
from graincal.laboratory.decisions import Decision

from .tested import CONSTANT_MEAN, DRAINED, EXTENSION, UNDRAINED, write

ASKED = (
    ('"lab.csv", strain = "logarithmic"', '"lab.csv", strain = "?", units = { axial_strain = "?" }'),
    ("reference   =", "# How were strains computed?\nreference   ="),
)
BEHIND = (('strain = "logarithmic" }', 'strain = "?" }   # "engineering" or "logarithmic", see "#3"'),)
NO_PRESSURE = (("confining_pressure = 200e3", 'confining_pressure = "?"'),)


def test_questions_are_said_with_their_place_and_comment(call, tmp_path):
    file = write(tmp_path, DRAINED, {}, ASKED)
    checked = call("check", file)
    line = file.read_text().splitlines().index(next(each for each in file.read_text().splitlines() if each.startswith("reference"))) + 1
    said = f'experiment "drained": reference.strain is an open question (line {line}): How were strains computed? Write the answer'
    assert (
        checked.code == 2
        and f"Questions:\n  {said}" in checked.out
        and 'experiment "drained", triaxial (open: reference.strain, reference.units.axial_strain)' in checked.out
    )
    assert "11 rows, axial_strain 0 to 0.1" in checked.out and "Expect" not in checked.out
    for called in (call("calibrate", file, "-o", tmp_path / "campaign", "--accept"), call("explore", file, "-o", tmp_path / "library")):
        assert called.code == 1 and called.err.startswith(f"{file}: {said}") and called.err.count("is an open question") == 2
    with pytest.raises(InputError, match="is an open question"):
        read_calibration(file)


def test_a_question_goes_with_what_is_proposed_and_without_it(tmp_path):
    file, asked = write(tmp_path, DRAINED, {}, BEHIND), []

    def proposed(entry, key):
        asked.append((entry["name"], key))
        return "engineering"

    found = examine(file, proposed=proposed)
    assert asked == [("drained", ("reference", "strain"))] and found.questions[0].proposed == "engineering" and not found.is_clear
    assert found.questions[0].comment == '"engineering" or "logarithmic", see "#3"' and found.questions[0].answers == ("engineering", "logarithmic")
    assert found.experiments[0].reference.control[-1] > 0.105 and found.experiments[0].questions == ("reference.strain",)
    # Without a proposal the key is left out.
    assert examine(file).experiments[0].reference.control[-1] == pytest.approx(0.1)
    file = write(tmp_path, DRAINED, {}, NO_PRESSURE)
    assert examine(file).as_json()["experiments"][0]["confining_pressure"] is None and [each.key for each in examine(file).questions] == [
        "model.confining_pressure"
    ]
    assert examine(file, proposed=lambda entry, key: 200e3).as_json()["experiments"][0]["confining_pressure"] == 200e3


@pytest.mark.parametrize(
    ("written", "key"),
    [
        ("\"lab.csv\", strain = '?'", "reference.strain"),
        ('"lab.csv", strain = "logarithmic", columns = { axial_strain = "?" }', "reference.columns.axial_strain"),
    ],
)
def test_questions_are_found_wherever_they_stand(tmp_path, written, key):
    file = write(
        tmp_path,
        DRAINED,
        {},
        (('"lab.csv", strain = "logarithmic"', written), ("workers = 1", 'workers = "?"   # is "?" a number'), ("range = [10, 50]", 'range = ["?", 50]')),
    )
    found = examine(file).questions
    assert {(each.experiment, each.key) for each in found} == {("drained", key), (None, "run.workers"), (None, "parameters.phi.range 1")}
    lines = file.read_text().splitlines()
    assert all("?" in lines[each.line - 1] for each in found) and found[-1].comment == 'is "?" a number'


def test_programs_read_one_document(call, tmp_path):
    good = call("check", write(tmp_path, DRAINED), "--json")
    found = json.loads(good.out)
    assert good.code == 0 and good.err == "" and found["problems"] == found["questions"] == [] and found["limits"]["first_round"] > 0
    (experiment,) = found["experiments"]
    assert (
        experiment["name"],
        experiment["kind"],
        experiment["confining_pressure"],
        experiment["states"],
        experiment["kept_states"],
        experiment["control"],
    ) == ("drained", "triaxial", 200e3, 11, 11, "axial_strain")
    assert experiment["observables"]["stress_ratio"]["first"] == 1.0 and set(experiment["observables"]) == {"stress_ratio", "volumetric_strain", "void_ratio"}
    asked = call("check", write(tmp_path, DRAINED, {}, BEHIND), "--json")
    assert asked.code == 2
    (question,) = json.loads(asked.out)["questions"]
    assert (
        question["experiment"] == "drained"
        and question["key"] == "reference.strain"
        and question["answers"] == ["engineering", "logarithmic"]
        and question["proposed"] == "logarithmic"
    )
    wrong = call("check", write(tmp_path, DRAINED, {"stress_ratio": lambda r: r - 1}), "--json")
    assert wrong.code == 2 and {each["code"] for each in json.loads(wrong.out)["problems"]} == {"stress-ratio-low"}
    missing = call("check", tmp_path / "nowhere.toml", "--json")
    assert missing.code == 1 and json.loads(missing.out)["error"] + "\n" == missing.err


def test_what_laboratory_files_say_is_put_beside(tmp_path):
    def evidence(entry, folder):
        assert entry.name == "drained" and (folder / entry.reference.file).exists()
        return [Decision("reference.strain", "logarithmic", "it goes beyond 1")], [Doubt("unsheared", "so.")], [Doubt("reading", "thus.")]

    found = examine(write(tmp_path, DRAINED), evidence=evidence)
    assert found.as_json()["decided"] == [
        {"experiment": "drained", "what": "reference.strain", "value": "logarithmic", "because": "it goes beyond 1", "by": "proof"}
    ]
    assert [str(each) for each in found.problems] == ['Experiment "drained": so.'] and Doubt("reading", "thus.", "drained") in found.notes


def test_a_void_ratio_out_of_reach_is_a_problem_with_the_range(call, tmp_path, monkeypatch):
    monkeypatch.setenv("GRAINCAL_CACHE", str(tmp_path / "cache"))
    file = write(tmp_path, DRAINED, {}, (('packing = "PACKING"', "particles = 180, void_ratio = 1.05"), (", void_ratio = {}", "")))
    checked = call("check", file)
    assert (
        checked.code == 2
        and "1.05 is out of reach for grading toyoura, which packs to between" in checked.out
        and "graincal init --relative-density" in checked.out
    )
    refused = call("calibrate", file, "-o", tmp_path / "campaign", "--accept")
    assert refused.code == 1 and "correct the file:" in refused.err and "--accept" not in refused.err


def test_codes_have_one_level_and_the_documents_list_them():
    assert len(LEVELS) == sum(map(len, CODES.values()))
    text = (Path(__file__).parents[2] / "docs" / "calibration-file.md").read_text()
    assert set(re.findall(r"^\| (problem|note) \| `([\w-]+)` \|", text, re.M)) == {(level, code) for code, level in LEVELS.items()}


@pytest.mark.parametrize(("by", "code"), [("proof", "contradicts-file"), ("words", "contradicts-words"), ("person", None)])
def test_only_a_proof_against_the_calibration_file_is_a_problem(tmp_path, monkeypatch, by, code):
    file = write(tmp_path, DRAINED)
    understand = laboratory_evidence.understand
    decided = (Decision("confining_pressure", "100000", "a line above the table says so", by), Decision("kind", "triaxial", "the file says so in words", by))
    monkeypatch.setattr(laboratory_evidence, "understand", lambda *said: replace(understand(*said), decided=decided))
    found = examine(file)
    assert {each.code for each in (*found.problems, *found.notes)} - {"reading"} == ({code} if code else set())
    assert found.is_clear == (code != "contradicts-file") and [each.by for each in found.decided] == ([by] * 2 if code else [])


KIND = (None,)
GRAINS = (('packing = "PACKING"', 'particles = 1000, void_ratio = "?"'),)


@pytest.mark.parametrize(
    "replacements", [GRAINS, NO_PRESSURE, (*GRAINS, *NO_PRESSURE), (('"PACKING"', '"?"'),), (('"PACKING"', '["PACKING", "?"]'),), KIND, (*KIND, *NO_PRESSURE)]
)
@pytest.mark.parametrize("case", [DRAINED, UNDRAINED, EXTENSION, CONSTANT_MEAN], ids=["drained", "undrained", "extension", "constant mean"])
def test_a_reference_is_examined_while_its_model_is_open(tmp_path, case, replacements):
    replacements = [each or (re.search(r'kind = "[\w-]+"', case[1])[0], 'kind = "?"') for each in replacements]
    found = examine(write(tmp_path, case, {}, replacements), proposed=lambda entry, key: None)
    assert len(found.experiments) == 1 and found.problems == () and found.experiments[0].questions == tuple(question.key for question in found.questions)
    wrong = examine(write(tmp_path, case, {next(iter(case[0])): lambda strain: strain / 100}, replacements), proposed=lambda entry, key: None)
    assert "strain-too-small" in {each.code for each in wrong.problems}


def test_a_stress_ratio_is_not_made_with_a_pressure_that_is_open(tmp_path):
    replacements = ((", strain =", ', columns = { deviator_stress = "deviatoric_stress [Pa]" }, strain ='), *NO_PRESSURE)
    found = examine(write(tmp_path, DRAINED, {}, replacements), proposed=lambda entry, key: None)
    assert found.experiments == () and "a confining_pressure in Pa was expected" in found.notes[0].sentence and found.notes[0].code == "unread-so-far"


def test_what_else_is_wrong_is_said_beside_questions(tmp_path):
    found = examine(write(tmp_path, DRAINED, {}, (*NO_PRESSURE, ("workers = 1", "wokers = 1"))))
    assert len(found.questions) == 1 and any("wokers is not a key" in each.sentence for each in found.notes)


def test_a_function_is_run_once_where_that_is_asked_for(call, tmp_path):
    file = write_calibration(tmp_path)
    assert "The first sample in" not in call("check", file).out
    ran = call("check", file, "--run", "--plot", tmp_path / "first.png")
    assert ran.code == 0 and 'The first sample in "drained"' in ran.out and "and the run of the first sample drawn to" in ran.out
    (tmp_path / "soil.py").write_text("def respond(theta):\n    raise ArithmeticError('no equilibrium')\n")
    failed = call("check", file, "--run")
    assert failed.code != 0 and "no equilibrium" in failed.out
