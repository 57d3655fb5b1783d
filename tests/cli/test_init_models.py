"""What graincal init writes for a simulator of the user's own."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest

from graincal.campaign.file.own_simulator import OwnSimulator

LAB = "axial strain [%],q [kPa],volumetric strain [%]\n" + "".join(
    f"{100 * strain:.2f},{100 * 2.5 * strain / (0.005 + strain):.3f},{100 * (0.1 * strain * np.exp(-strain / 0.02) - 0.2 * strain**2):.4f}\n"
    for strain in np.linspace(0, 0.1, 11)
)
KNOWN = ("--strain", "logarithmic", "--compression", "volumetric_strain=positive", "--confining-pressure", "1e5")
PROGRAM = """
import sys
strength = float(sys.argv[1])
with open("curve.csv", "w") as curve:
    print("eps,ratio,ev", file=curve)
    for percent in range(11):
        print(percent, 1 + strength * percent / (0.5 + percent), 0.0003 * percent, sep=",", file=curve)
"""
ANSWERED = {
    'parameter_1 = { range = "?" }': "strength = { range = [1, 5] }",
    'function   = "?"': 'function   = "model:respond"',
    'command    = "?"': 'command    = ["python3", "simulate.py", "{{ strength }}"]',
    '# link       = ["simulate.py"]': 'link       = ["simulate.py"]',
    'script     = "?"': 'script     = "simulate.py"',
    'table      = "?"': 'table      = ["strength"]',
    'file       = "?"': 'file       = "curve.csv"',
    'strain     = "?"': 'strain     = "logarithmic"',
    '{ axial_strain = "?", stress_ratio = "?", volumetric_strain = "?" }': '{ axial_strain = "eps", stress_ratio = "ratio", volumetric_strain = "ev" }',
}


@pytest.fixture
def lab(tmp_path):
    (tmp_path / "lab.csv").write_text(LAB)
    (tmp_path / "simulate.py").write_text(PROGRAM)
    (tmp_path / "model.py").write_text(
        "import numpy as np\n"
        "E = np.linspace(0, 0.1, 11)\n"
        "def respond(theta):\n"
        "    return {'stress_ratio': 1 + theta[0] * E / (0.005 + E), 'volumetric_strain': 0 * E}\n"
    )
    return tmp_path / "lab.csv"


@pytest.mark.parametrize("model", [each.value for each in OwnSimulator])
def test_the_file_can_be_checked_as_soon_as_its_questions_are_answered(call, lab, model):
    file = lab.with_name("calibration.toml")
    called = call("init", lab, "--model", model, *KNOWN, "-o", file)
    assert called.code == 0 and "of your simulator too" in called.out, called.err
    text = file.read_text(encoding="utf-8")
    asked = call("check", file)
    assert asked.code == 2 and "parameters.parameter_1.range is an open question" in asked.out and "is missing" not in asked.out and "kind" not in asked.out
    for question, answer in ANSWERED.items():
        text = text.replace(question, answer)
    assert '= "?"' not in text
    file.write_text(text, encoding="utf-8")
    checked = call("check", file)
    assert checked.code == 0, checked.out + checked.err
    reference = tomllib.loads(text)["experiment"][0]["reference"]
    assert reference["confining_pressure"] == 1e5


def test_what_was_proposed_of_a_program_runs(call, lab):
    file = lab.with_name("calibration.toml")
    call("init", lab, "--model", "command", *KNOWN, "-o", file)
    text = file.read_text(encoding="utf-8")
    for question, answer in ANSWERED.items():
        text = text.replace(question, answer)
    file.write_text(text.replace('axial_strain = "eps"', "axial_strain = { column = 'eps', unit = '%' }"), encoding="utf-8")
    checked = call("check", file, "--run")
    assert checked.code == 0 and "error" in checked.out, checked.out + checked.err


def test_a_stress_ratio_of_the_file_needs_no_confining_pressure(call, lab):
    file = lab.with_name("calibration.toml")
    lab.write_text(LAB.replace("q [kPa]", "stress ratio"))
    called = call("init", lab, "--model", "python", "--strain", "logarithmic", "-o", file)
    assert called.code == 0 and "confining_pressure" not in file.read_text(encoding="utf-8"), called.out + called.err


def test_columns_that_are_not_known_are_asked_beside_the_simulator(call, lab):
    file = lab.with_name("calibration.toml")
    lab.write_text(LAB.replace("q [kPa]", "abc").replace("axial strain [%]", "def"))
    called = call("init", lab, "--model", "yade", "-o", file)
    asked = call("check", file)
    assert called.code == 0 and asked.code == 2
    for key in ("parameters.parameter_1.range", "model.script", "reference.columns.axial_strain", "reference.confining_pressure"):
        assert f"{key} is an open question" in asked.out


@pytest.mark.parametrize("option", ["--grading", "--particles", "--relative-density", "--packing"])
def test_grains_of_graincal_do_not_go_with_another_simulator(call, lab, option):
    file = lab.with_name("calibration.toml")
    value = {"--grading": "toyoura", "--packing": "packing.csv", "--particles": "500"}.get(option, "0.5")
    called = call("init", lab, "--model", "command", *KNOWN, option, value, "-o", file)
    assert called.code != 0 and f"--model command has grains of its own, so {option} cannot stand beside it." in called.err and not file.exists()


def checked_run(call, lab, *changes):
    """What check --run says of the proposed file of a program, with other answers."""
    file = lab.with_name("calibration.toml")
    file.unlink(missing_ok=True)
    call("init", lab, "--model", "command", *KNOWN, "-o", file)
    text = file.read_text(encoding="utf-8")
    for question, answer in (*changes, *ANSWERED.items()):
        text = text.replace(question, answer)
    file.write_text(text.replace('axial_strain = "eps"', "axial_strain = { column = 'eps', unit = '%' }"), encoding="utf-8")
    return call("check", file, "--run")


COLUMNS = '{ axial_strain = "?", stress_ratio = "?", volumetric_strain = "?" }'


def test_a_run_that_is_read_rightly_has_no_notes(call, lab):
    checked = checked_run(call, lab, (COLUMNS, '{ axial_strain = "eps", stress_ratio = "ratio", volumetric_strain = "ev" }'))
    assert checked.code == 0 and not any(said in checked.out for said in ("Of this run", "in this run", "the other way")), checked.out


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        ('stress_ratio = "ratio - 1", volumetric_strain = "0.01 * eps / 5"', "Of this run: the stress ratio is 0 at axial_strain 0"),
        ('stress_ratio = "1 + 1e-3 * (ratio - 1)", volumetric_strain = "0.01 * eps / 5"', "is its unit another, or its column?"),
        ('stress_ratio = "ratio", volumetric_strain = "eps / 5"', "Of this run: volumetric_strain reaches"),
        (
            'stress_ratio = "ratio", volumetric_strain = "3e-5 * eps**2 - 1e-4 * eps"',
            "volumetric_strain goes the other way than in the reference: is its sign another?",
        ),
    ],
)
def test_a_run_that_is_read_wrongly_is_noted(call, lab, columns, said):
    checked = checked_run(call, lab, (COLUMNS, f'{{ axial_strain = "eps", {columns} }}'))
    assert said in checked.out, checked.out + checked.err


def test_strains_of_another_sign_or_measure_are_named(call, lab):
    turned = checked_run(call, lab, (COLUMNS, '{ axial_strain = "-0.01 * eps", stress_ratio = "ratio", volumetric_strain = "ev" }'))
    assert turned.code == 2 and "sign = -1 of its column in output.columns turns it" in turned.out and "-0" not in turned.out.split("covers")[1].split("and")[0]
    short = checked_run(call, lab, (COLUMNS, '{ axial_strain = "0.0097 * eps", stress_ratio = "ratio", volumetric_strain = "ev" }'))
    assert 'unless its strain is engineering, which strain = "engineering" beside output.columns says' in short.out


def test_a_script_beside_the_file_that_is_not_linked_is_noted(call, lab):
    file = lab.with_name("calibration.toml")
    call("init", lab, "--model", "command", *KNOWN, "-o", file)
    text = file.read_text(encoding="utf-8")
    for question, answer in ANSWERED.items():
        text = text.replace(question, answer) if "link" not in question else text
    file.write_text(text, encoding="utf-8")
    assert 'sees it where link = ["simulate.py"] says so' in call("check", file).out


def with_control(call, lab, control):
    file = lab.with_name("calibration.toml")
    call("init", lab, "--model", "python", *KNOWN, "-o", file)
    text = file.read_text(encoding="utf-8")
    for question, answer in ANSWERED.items():
        text = text.replace(question, answer)
    file.write_text(text.replace("# control    = [0, 0.001, 0.002]", f"control = {list(control)}"), encoding="utf-8")
    (lab.parent / "model.py").write_text(
        f"import numpy as np\nE = np.array({list(control)})\n"
        "def respond(theta):\n    return {'stress_ratio': 1 + theta[0] * E / (0.005 + E), 'volumetric_strain': 0.1 * E * (E < 0.05)}\n"
    )
    return file


def test_a_function_of_its_own_strains_is_drawn_at_those_of_the_reference(call, lab):
    # As many values as the reference has rows, and to 20 %, where the reference ends at 10 %.
    file = with_control(call, lab, [round(0.02 * k, 4) for k in range(11)])
    model = lab.parent / "model.py"
    model.write_text(model.read_text().replace("0.1 * E * (E < 0.05)", "0.1 * E"))
    checked = call("check", file, "--run", "--plot", lab.parent / "run.png")
    assert checked.code == 0 and "0 to 0.01\n" in checked.out and "0.02" not in checked.out.split("The first sample")[1].split("Notes")[0], (
        checked.out + checked.err
    )


def test_strains_of_a_function_in_percent_are_a_problem(call, lab):
    checked = call("check", with_control(call, lab, range(14)))
    assert checked.code == 2 and "model.control goes to 13, which no strain reaches: values are fractions, not percent." in checked.out


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ('[experiment.model]\nkind = "python"\nfunction = "model:respond"\n', "are control under [experiment.model]"),
        (
            '[experiment.model]\nkind = "command"\ncommand = ["a"]\noutput = { columns = { axial_strain = "e", stress_ratio = "r" }, units = { stress_ratio = "-" } }\n',
            "a unit stands with its column",
        ),
        ('[experiment.model]\nkind = "triaxial"\nparticles = 500\nrelative_density = 0.7\nconfining_pressure = 1e5\n', "--relative-density"),
    ],
)
def test_keys_that_people_look_for_elsewhere_are_named(call, lab, line, said):
    file = lab.with_name("calibration.toml")
    control = "[0, 0.1]" if "function" in line else '"axial_strain"'
    file.write_text(
        f'[parameters]\nlog_E = {{ range = [7, 9] }}\n[[experiment]]\nname = "a"\ncontrol = {control}\nobservables = {{ stress_ratio = {{}} }}\nreference = "lab.csv"\n{line}',
        encoding="utf-8",
    )
    assert said in call("check", file).err
