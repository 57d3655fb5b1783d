"""An unknown file understood, and the calibration proposed from it: read back, it gives the reference, told nothing but the strain measure."""

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from invented_test import (
    AXIAL_STRAIN,
    CANONICAL,
    CONFINING_PRESSURE,
    DEVIATOR_STRESS,
    SHAPES,
    STRAINS,
    STRESS_RATIO,
    Shape,
    assert_is_the_invented_test,
    percent,
    rows,
    text,
    with_loop,
    written,
)

from graincal.campaign.file.propose import propose
from graincal.data import InputError, ParameterSpace, Reference
from graincal.laboratory import Known, NotUnderstood, describe, understand
from graincal.laboratory.vocabulary import guess


def read_back(proposal: str, folder: Path) -> Reference:
    """Read the reference as a calibration would: options from its table, the confining pressure from the model's."""
    experiment = tomllib.loads(proposal)["experiment"][0]
    table: dict[str, Any] = dict(experiment["reference"])
    return Reference.read(
        folder / table.pop("file"),
        experiment["control"],
        tuple(experiment["observables"]),
        confining_pressure=experiment["model"]["confining_pressure"],
        **table,
    )


# One shape mixes the two measures of strain; that is for the user to find out, and no single word says it.
PROPOSED = [shape for shape in SHAPES if isinstance(shape.options.get("strain", ""), str)]


@pytest.mark.parametrize("shape", PROPOSED, ids=lambda shape: shape.name)
def test_a_proposal_read_back_gives_the_reference(shape: Shape, tmp_path: Path) -> None:
    # Where every column is negative, compression and extension look alike.
    everywhere = shape.options.get("compression") == "negative" and "deviator_stress" in shape.text
    said = dict.fromkeys(("axial_strain", "deviator_stress"), "negative") if everywhere else {}
    known = Known(strain=shape.options.get("strain", "logarithmic"), confining_pressure=CONFINING_PRESSURE, compression=said)
    found = understand(written(shape, tmp_path), known)
    assert not found.questions
    assert_is_the_invented_test(read_back(propose(found), tmp_path), shape.lost)


def proposal_of(
    content: str, written_in: Path, name: str = "lab.csv", folder: Path | None = None, packing: str | None = None, **known: Any
) -> tuple[dict[str, Any], str, str]:
    path = written_in / name
    path.write_text(content, encoding="utf-8")
    found = understand(path, Known(**known))
    proposal = propose(found, folder=folder, packing=packing)
    return tomllib.loads(proposal), proposal, "\n".join(describe(found))


def test_a_proposal_is_a_complete_calibration(tmp_path: Path) -> None:
    calibration, proposal, _ = proposal_of(text("# cell pressure 0.2 MPa, void ratio 0.71", CANONICAL, *percent()), tmp_path)
    assert set(calibration) == {"parameters", "experiment", "filter", "stop", "run"}
    space = ParameterSpace({name: parameter["range"] for name, parameter in calibration["parameters"].items()})
    assert space.names == ParameterSpace.paper().names
    assert (space.low == ParameterSpace.paper().low).all() and (space.high == ParameterSpace.paper().high).all()
    assert calibration["experiment"][0]["model"] == {
        "kind": "triaxial", "particles": 1000, "void_ratio": 0.71, "grading": "toyoura", "seed": 1, "confining_pressure": 2e5,
    }  # fmt: skip
    assert calibration["experiment"][0]["reference"]["strain"] == "?"
    assert "engineering or logarithmic cannot be seen from the numbers" in proposal.split("[experiment.reference]")[1]


def test_a_proposal_offers_to_end_before_a_shear_band(tmp_path: Path) -> None:
    proposal = propose(understand(written(SHAPES[0], tmp_path), Known(strain="logarithmic")))
    assert "until" not in tomllib.loads(proposal)["experiment"][0]["reference"]
    assert tomllib.loads(proposal.replace("# until", "until"))["experiment"][0]["reference"]["until"] == 0.1


def test_what_the_user_knows_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "tests").mkdir()
    calibration, proposal, _ = proposal_of(
        text(CANONICAL, *percent()),
        tmp_path,
        'tests/a "good" test.csv',
        strain="logarithmic",
        confining_pressure=3e5,
        void_ratio=0.7,
        folder=tmp_path / "calibrations",
    )
    experiment = calibration["experiment"][0]
    assert experiment["name"] == 'a "good" test'
    # A path that was given from the root stays so; others are relative to where the calibration file will stand.
    assert experiment["reference"]["file"] == f'{tmp_path}/tests/a "good" test.csv'
    monkeypatch.chdir(tmp_path)
    relative = propose(understand('tests/a "good" test.csv'), packing="tests/packing.csv", folder="calibrations")
    assert (
        'file        = "../tests/a \\"good\\" test.csv"' in relative and tomllib.loads(relative)["experiment"][0]["model"]["packing"] == "../tests/packing.csv"
    )
    assert experiment["reference"]["strain"] == "logarithmic"
    assert experiment["model"]["confining_pressure"] == 3e5
    assert '"?"' not in proposal.split("[[experiment]]")[1]


def test_it_is_said_how_the_file_is_written(tmp_path: Path) -> None:
    path = tmp_path / "lab.csv"
    lines = rows(-STRAINS[0], -STRAINS[1], DEVIATOR_STRESS / 1e3, delimiter=";", decimal=",")
    path.write_bytes(text("Test;7", "compression is negative", "ea (%);ev (%);q (kPa)", *lines).encode("utf-8-sig"))
    found = understand(path)
    assert (found.table.delimiter, found.table.decimal, found.table.byte_order_mark, found.table.encoding) == (";", ",", True, "utf-8")
    assert (found.table.header_line, len(found.table.rows)) == (3, 26)
    assert found.columns == {"axial_strain": "ea (%)", "volumetric_strain": "ev (%)", "deviator_stress": "q (kPa)"}
    assert found.units == {"axial_strain": "%", "volumetric_strain": "%", "deviator_stress": "kPa"}
    assert found.compression == {"axial_strain": "negative", "volumetric_strain": "negative", "deviator_stress": "positive"}
    assert found.strain == {"axial_strain": "?", "volumetric_strain": "?"} and found.confining_pressure is None


def test_a_sign_against_that_of_the_stress_is_a_question(tmp_path: Path) -> None:
    lines = rows(-STRAINS[0], -STRAINS[1], DEVIATOR_STRESS / 1e3)
    calibration, _, said = proposal_of(text("ea (%),ev (%),q (kPa)", *lines), tmp_path, strain="logarithmic", confining_pressure=2e5)
    assert calibration["experiment"][0]["reference"]["compression"]["axial_strain"] == "?"
    assert "compression.axial_strain: 'ea (%)' falls while the axial stress is above the lateral one, against the sign of the stresses" in said


def test_loops_pauses_and_gaps_are_found(tmp_path: Path) -> None:
    path = tmp_path / "lab.csv"
    lines = with_loop(percent())
    path.write_text(text(CANONICAL, *lines[:5], lines[4], *lines[5:20], "13.4,,3", *lines[20:]))
    found = understand(path)
    assert found.loops == ((14, 16),)
    assert found.standstills == ((7, 7),)
    said = "\n".join(describe(found))
    for words in ("turns back at lines 14-16", "stands still at line 7", "no number on line 23"):
        assert words in said


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (text(CANONICAL, *percent()[:4], "2.5,nan,3.0", *percent()[4:]), "line 6 says 'nan'"),
        (text("axial_strain,stress_ratio", *rows(AXIAL_STRAIN, STRESS_RATIO)), "does not say the confining pressure"),
        (text("axial_strain,stress_ratio", *rows(AXIAL_STRAIN, STRESS_RATIO)), "engineering or logarithmic cannot be seen"),
        (text("axial_strain,stress_ratio", *rows(AXIAL_STRAIN, STRESS_RATIO)), "tells a drained from an undrained test"),
        (text("axial_strain,stress_ratio,time", *rows(AXIAL_STRAIN, STRESS_RATIO, STRESS_RATIO)), "Left out: 'time' (time)."),
        (text("axial_strain [%],volumetric_strain,stress_ratio", *rows(*STRAINS, STRESS_RATIO)), "'volumetric_strain' has no unit, and 'axial_strain [%]' is in %"),
        (text("axial_strain,q", *rows(AXIAL_STRAIN, DEVIATOR_STRESS / 1e3)), "'q' has no unit, and no stress of the file has one"),
        (text("eps_a [%],eps_v [%]", *rows(100 * AXIAL_STRAIN, STRAINS[1])), "No column of a stress is understood"),
        (text("# cell pressure 500 kPa, back pressure 300 kPa", "eps_a [%],q [kPa]", *rows(100 * AXIAL_STRAIN, DEVIATOR_STRESS / 1e3)), "speaks of a back pressure"),
    ],
)  # fmt: skip
def test_what_a_person_has_to_know_is_said(content: str, words: str, tmp_path: Path) -> None:
    assert words in proposal_of(content, tmp_path)[2]


@pytest.mark.parametrize(
    ("headers", "lacking"),
    [
        ("depth,R", "an axial strain, a stress or a volumetric strain"),
        ("depth,q", "an axial strain"),
        ("eps_a,R", "a stress or a volumetric strain"),
    ],
)
def test_a_file_that_is_not_understood_is_said_with_its_columns(headers: str, lacking: str, tmp_path: Path) -> None:
    with pytest.raises(NotUnderstood) as error:
        proposal_of(text(headers, *rows(AXIAL_STRAIN, STRESS_RATIO)), tmp_path)
    first, second = headers.split(",")
    assert str(error.value) == (
        f"{tmp_path / 'lab.csv'}: none of the columns 1 '{first}', 2 '{second}' is known as {lacking}: --column axial_strain=COLUMN:UNIT and so on say which is which, by numbers or names."
    )


def test_a_column_that_cannot_be_read_is_left_out_with_the_reason(tmp_path: Path) -> None:
    # Two columns with decimal points and one with commas.
    lines = [f"{100 * strain:.3f};{100 * volume:.3f};{str(round(q, 1)).replace('.', ',')}" for strain, volume, q in zip(*STRAINS, DEVIATOR_STRESS / 1e3)]
    _, _, said = proposal_of(text("eps_a [%];eps_v [%];q [kPa]", *lines), tmp_path)
    assert "Left out: 'q [kPa]' (deviator_stress, but its numbers cannot be read: line 2 says '0,0', and numbers here have the decimal mark '.'" in said
    assert "No column of a stress is understood" in said
    _, _, said = proposal_of(text("eps_a [%],eps_v [mm],q [kPa]", *rows(*STRAINS, DEVIATOR_STRESS / 1e3)), tmp_path)
    assert "Left out: 'eps_v [mm]' (volumetric_strain, but 'mm' is a unit of length, and one of -, %, permille, microstrain was expected)." in said
    with pytest.raises(InputError, match=r"'eps_a \[mm\]' would be axial_displacement, but no line above the table is known as the sample's height"):
        proposal_of(text("eps_a [mm],q [kPa]", *rows(AXIAL_STRAIN, DEVIATOR_STRESS / 1e3)), tmp_path)


@pytest.mark.parametrize("unit", ["kip", "foo", "kg", "lb/in"])
def test_a_unit_that_is_stated_and_not_known_is_refused_by_name(unit: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=f"is in '{unit}', which is not a unit that is known|'{unit}' is a unit of"):
        proposal_of(text(f"eps_a [%],q [{unit}]", *rows(100 * AXIAL_STRAIN, DEVIATOR_STRESS / 1e3)), tmp_path)


def test_what_the_user_says_against_the_file_is_said(tmp_path: Path) -> None:
    content = text("# confining pressure 0.5e6 Pa, true strain", CANONICAL, *percent())
    said = proposal_of(content, tmp_path, strain="engineering", confining_pressure=500)[2]
    assert "The file says a confining pressure of 500000 Pa, and you 500 Pa: yours is taken." in said
    assert "The file speaks of logarithmic strain, and you of engineering strain: yours is taken." in said
    assert "yours" not in proposal_of(content, tmp_path, strain="logarithmic", confining_pressure=5e5)[2]


def test_a_german_file_is_understood(tmp_path: Path) -> None:
    lines = rows(*STRAINS, DEVIATOR_STRESS / 1e3, delimiter=";", decimal=",")
    content = text("Zelldruck: 200 kPa;;", "Axialdehnung in %;Volumendehnung [%];Deviatorspannung (kN/m²)", *lines)
    calibration, proposal, _ = proposal_of(content, tmp_path, strain="logarithmic")
    assert calibration["experiment"][0]["model"]["confining_pressure"] == CONFINING_PRESSURE
    assert_is_the_invented_test(read_back(proposal, tmp_path))


def test_a_stress_alone_is_proposed_alone(tmp_path: Path) -> None:
    content = text("strain_axial,q", *rows(100 * AXIAL_STRAIN, DEVIATOR_STRESS / 1e3))
    calibration, _, _ = proposal_of(content, tmp_path, confining_pressure=CONFINING_PRESSURE)
    assert calibration["experiment"][0]["observables"] == {"stress_ratio": {"relative_error": 0.01}}
    assert calibration["experiment"][0]["reference"]["units"] == {"axial_strain": "%", "deviator_stress": "?"}


@pytest.mark.parametrize(
    ("remark", "pressure"),
    [
        ("# confining pressure 0.5e6 Pa", 5e5),
        ("# Cell pressure: 200 kPa, sand", 2e5),
        ("# confining stress (kPa) = 150", 1.5e5),
        ("# sigma3 = 1 bar", 1e5),
        ("# σ3' = 49 kN/m2", 4.9e4),
        ("# confining pressure 1,000 kPa", None),
        ("# cell pressure constant, height 100 mm", None),
        ("# sand", None),
    ],
)
def test_a_confining_pressure_is_found_in_remarks(remark: str, pressure: float | None, tmp_path: Path) -> None:
    path = tmp_path / "lab.csv"
    path.write_text(text(remark, CANONICAL, *percent()), encoding="utf-8")
    assert understand(path).confining_pressure == (None if pressure is None else pytest.approx(pressure))


def test_a_confining_pressure_is_found_in_a_column(tmp_path: Path) -> None:
    path = tmp_path / "lab.csv"
    constant = np.ones_like(AXIAL_STRAIN)
    path.write_text(text("ea,s1' [kPa],s3' [kPa],e", *rows(AXIAL_STRAIN, 200 * STRESS_RATIO, 200 * constant, 0.7 - 0.1 * AXIAL_STRAIN)))
    assert understand(path).confining_pressure == 2e5
    assert understand(path).void_ratio == 0.7


@pytest.mark.parametrize(
    ("header", "quantity", "unit"),
    [
        ("eps_a", "axial_strain", None),
        ("Ea(%)", "axial_strain", "%"),
        ("Axial strain", "axial_strain", None),
        ("axial strain, %", "axial_strain", "%"),
        ("Axial Strain / %", "axial_strain", "%"),
        ("ε_a [-]", "axial_strain", "-"),
        ("axial strain (LVDT)", "axial_strain", None),
        ("ev", "volumetric_strain", None),
        ("vol. strain %", "volumetric_strain", "%"),
        ("e_v", "volumetric_strain", None),
        ("q", "deviator_stress", None),
        ("q kPa", "deviator_stress", "kPa"),
        ("Deviator stress [kN/m²]", "deviator_stress", "kPa"),
        ("σ1-σ3 (kPa)", "deviator_stress", "kPa"),
        ("sigma1", "axial_stress", None),
        ("s1/s3", "stress_ratio", None),
        ("σ1'/σ3'", "stress_ratio", None),
        ("s1_over_s3", "stress_ratio", None),
        ("q/p'", "deviator_to_mean_stress", None),
        ("sigma'_3 [MPa]", "lateral_stress", "MPa"),
        ("Axialdehnung ε1 [%]", "axial_strain", "%"),
        ("Dehnung in %", "axial_strain", "%"),
        ("Axiale Stauchung [%]", "axial_strain", "%"),
        ("Volumendehnung / %", "volumetric_strain", "%"),
        ("Spannungsverhältnis", "stress_ratio", None),
        ("Spannungsverhaeltnis [-]", "stress_ratio", "-"),
        ("Deviatorspannung [kN/m²]", "deviator_stress", "kPa"),
        ("Größte Hauptspannung in kPa", "axial_stress", "kPa"),
        ("1. Hauptspannung (kPa)", "axial_stress", "kPa"),
        ("Zelldruck [kPa]", "lateral_stress", "kPa"),
        ("Hauptspannung σ1 [kPa]", "axial_stress", "kPa"),
        ("Hauptspannung σ3 [kPa]", "lateral_stress", "kPa"),
        ("Deviator stress q (kPa)", "deviator_stress", "kPa"),
        ("Axial strain time", None, None),
        ("Porenzahl", "void_ratio", None),
        ("Déformation axiale (%)", "axial_strain", "%"),
        ("Déformation volumique en %", "volumetric_strain", "%"),
        ("Déviateur q (kPa)", "deviator_stress", "kPa"),
        ("Déviateur des contraintes [kPa]", "deviator_stress", "kPa"),
        ("time (min)", "time", "min"),
        ("p", "mean_stress", None),
        ("Eff. axial stress (psi)", "axial_stress", "psi"),
        ("Осевая деформация, %", "axial_strain", "%"),
        ("偏应力(kPa)", "deviator_stress", "kPa"),
        ("軸ひずみ [%]", "axial_strain", "%"),
        ("축변형률 (%)", "axial_strain", "%"),
        ("Presión de poros (kPa)", "pore_pressure", "kPa"),
        ("Deformação volumétrica (%)", "volumetric_strain", "%"),
    ],
)
def test_names_that_laboratories_use_are_recognised(header: str, quantity: str | None, unit: str | None) -> None:
    found, found_unit = guess(header)
    assert (found, found_unit.symbol if found_unit else None) == (quantity, unit)


def test_a_contraction_far_smaller_than_the_dilation_decides_no_sign(tmp_path: Path) -> None:
    volumetric = (0.0, 0.0146, -0.0326, -0.1661, -0.6033, -1.1107, -1.9553)
    for sign, axial in ((1, 1), (-1, 1)):
        lines = [f"{0.6 * at * axial:.4f},{sign * value:.4f},{1 + 0.5 * at:.2f}" for at, value in enumerate(volumetric)]
        calibration, _, _ = proposal_of(text(CANONICAL, *lines), tmp_path, strain="logarithmic", confining_pressure=1e5)
        assert calibration["experiment"][0]["reference"]["compression"]["volumetric_strain"] == "?"
