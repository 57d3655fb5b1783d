"""One test file per shape, all giving the same reference."""

from pathlib import Path

import numpy as np
import pytest
from invented_test import (
    AXIAL_STRAIN,
    CANONICAL,
    DEVIATOR_STRESS,
    RATIO_TOLERANCE,
    SHAPES,
    STRESS_RATIO,
    Shape,
    assert_is_the_invented_test,
    percent,
    rows,
    text,
    with_loop,
    written,
)

from graincal.data import MeasurementError, Reference


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.name)
def test_every_shape_gives_the_same_reference(shape: Shape, tmp_path: Path) -> None:
    assert_is_the_invented_test(Reference.read(written(shape, tmp_path), **shape.options), shape.lost)


def notes_of(name: str, folder: Path) -> str:
    shape = next(shape for shape in SHAPES if shape.name == name)
    return " ".join(Reference.read(written(shape, folder), **{"strain": "logarithmic", **shape.options}).notes)


def test_notes_count_and_name_what_was_dropped(tmp_path: Path) -> None:
    assert notes_of("canonical", tmp_path) == ""
    # The header is line 1, so the state i stands on line i + 2.
    where = "in axial_strain, stress_ratio, volumetric_strain"
    assert notes_of("gaps", tmp_path) == f"3 rows dropped for an empty cell, {where}: lines 5-6, 22."
    assert notes_of("a footer", tmp_path) == ""
    assert notes_of("an unload-reload loop", tmp_path) == "3 rows dropped where axial_strain turned back: lines 13-15."
    assert notes_of("a pause", tmp_path) == "2 rows dropped where axial_strain stood still: lines 11-12."


def test_notes_name_conversions(tmp_path: Path) -> None:
    said = notes_of("engineering, tension positive, q", tmp_path)
    assert "axial_strain is given as engineering strain and was converted to logarithmic strain." in said
    assert "deviator_stress is given with compression negative, and its sign was changed." in said
    assert "stress_ratio was computed from deviator_stress, column 'deviator_stress [kPa]' at a confining pressure of 200000 Pa." in said


def test_a_note_says_what_is_taken_as_logarithmic_and_what_engineering_would_change(tmp_path: Path) -> None:
    path = written(SHAPES[0], tmp_path)
    # The largest strains of the invented test; -ln(1 - 0.2) = 0.2231 and ln(1.05627) = 0.05474.
    assert Reference.read(path).notes == (
        "axial_strain and volumetric_strain are taken as logarithmic, since the key strain does not say. "
        'With strain = "engineering", axial_strain 0.2 would be 0.2231 and volumetric_strain -0.05627 would be -0.05474.',
    )
    (note,) = Reference.read(path, strain={"volumetric_strain": "logarithmic"}).notes
    assert note.startswith("axial_strain is taken as logarithmic, since the key strain does not say.")
    assert Reference.read(path, strain="logarithmic").notes == ()


def test_rows_are_kept_until_a_control(tmp_path: Path) -> None:
    path = written(SHAPES[0], tmp_path)
    # The states are 0.008 apart: 0.08 is the 11th, on line 12.
    for until in (0.08, 0.0879):
        reference = Reference.read(path, strain="logarithmic", until=until)
        assert_is_the_invented_test(reference, tuple(range(11, 26)))
        assert reference.notes == (f"15 rows left out beyond until = {until:g}, where axial_strain goes on to 0.2: lines 13-27.",)
    assert len(Reference.read(path, until=0.008).control) == 2
    # Of what is left alone it is said what another measure of strain would change: -ln(1 - 0.08) = 0.08338.
    assert "axial_strain 0.08 would be 0.08338" in Reference.read(path, until=0.08).notes[1]


def test_until_is_a_value_as_the_reference_has_it(tmp_path: Path) -> None:
    # The 12th state, of a logarithmic strain of 0.088, is printed as an engineering one of 1 - exp(-0.088) = 0.0842.
    engineering = next(shape for shape in SHAPES if shape.name == "engineering, tension positive, q")
    reference = Reference.read(written(engineering, tmp_path), until=0.085, **engineering.options)
    assert_is_the_invented_test(reference, tuple(range(11, 26)))
    path = tmp_path / "stress.csv"
    path.write_text(text("mean_stress [kPa],void_ratio", "10,0.8", "200,0.79", "400,0.78", "800,0.77"))
    np.testing.assert_allclose(Reference.read(path, "mean_stress", ["void_ratio"], until=4e5).control, [1e4, 2e5, 4e5])
    # 35 * 0.01 is not 0.35 but the number above it.
    path.write_text(text("axial_strain [%],stress_ratio", "0,1", "20,2", "35,2", "40,2"))
    assert len(Reference.read(path, observables=["stress_ratio"], until=0.35).control) == 3


def test_what_comes_after_until_is_no_loop_to_refuse(tmp_path: Path) -> None:
    path = tmp_path / "lab.csv"
    path.write_text(text(CANONICAL, *percent(), "10,-1.6,2.5", "5,-1.65,1.6"))
    reference = Reference.read(path, strain="logarithmic", until=0.15)
    assert_is_the_invented_test(reference, tuple(range(19, 26)))
    assert reference.notes == ("9 rows left out beyond until = 0.15, where axial_strain goes on to 0.2: lines 21-29.",)
    path.write_text(text(CANONICAL, *with_loop(percent())))
    whole = Reference.read(path, strain="logarithmic", until=0.15, unloading="drop")
    assert_is_the_invented_test(whole, tuple(range(19, 26)))
    assert [note.split(" where")[0] for note in whole.notes] == ["7 rows left out beyond until = 0.15,", "3 rows dropped"]


def test_a_note_says_that_until_leaves_nothing_out(tmp_path: Path) -> None:
    for until in (0.2, 0.25):
        reference = Reference.read(written(SHAPES[0], tmp_path), strain="logarithmic", until=until)
        assert_is_the_invented_test(reference)
        assert reference.notes == (f"nothing is left out by until = {until:g}, which no row lies beyond: axial_strain goes to 0.2.",)


def test_a_gap_in_a_column_that_is_not_read_costs_nothing(tmp_path: Path) -> None:
    path = tmp_path / "lab.csv"
    path.write_text(text(CANONICAL + ",q [kPa]", *(line + "," for line in percent())))
    assert_is_the_invented_test(Reference.read(path))


def test_reference_read_is_the_same_reader(tmp_path: Path) -> None:
    path = written(SHAPES[0], tmp_path)
    shares = {"volumetric_strain": 0.8, "stress_ratio": 0.2}
    reference = Reference.read(path, control="axial_strain", observables=shares, measurement_errors={"stress_ratio": 0.04})
    assert_is_the_invented_test(reference)
    assert reference.variance_shares == shares
    assert reference.measurement_errors == {"stress_ratio": MeasurementError(absolute=0.04)}


def test_quantities_of_any_name_are_read_in_si_units(tmp_path: Path) -> None:
    path = tmp_path / "lab.csv"
    path.write_text(text("settlement [mm],force [kN],wall", *rows(1e3 * AXIAL_STRAIN, DEVIATOR_STRESS / 1e3, STRESS_RATIO)))
    reference = Reference.read(path, control="settlement", observables=["force", "wall"])
    np.testing.assert_allclose(reference.control, AXIAL_STRAIN, rtol=0, atol=5.1e-9)
    np.testing.assert_allclose(reference.observables["force"], DEVIATOR_STRESS, rtol=0, atol=5.1e-3)
    np.testing.assert_allclose(reference.observables["wall"], STRESS_RATIO, rtol=0, atol=RATIO_TOLERANCE)


def test_the_deviator_stress_itself_may_be_the_observable(tmp_path: Path) -> None:
    path = tmp_path / "lab.csv"
    path.write_text(text("axial_strain [%],deviator_stress [kPa]", *rows(100 * AXIAL_STRAIN, DEVIATOR_STRESS / 1e3, decimals=(5, 2))))
    reference = Reference.read(path, observables=["deviator_stress"])
    np.testing.assert_allclose(reference.observables["deviator_stress"], DEVIATOR_STRESS, rtol=0, atol=5.1)


def test_what_is_said_of_a_unit_outranks_the_header(tmp_path: Path) -> None:
    path = tmp_path / "lab.csv"
    path.write_text(text("axial_strain [-],volumetric_strain [LVDT],stress_ratio", *percent()))
    assert_is_the_invented_test(Reference.read(path, units={"axial_strain": "%", "volumetric_strain": "%"}))


def test_a_ratio_column_is_preferred_to_the_stresses_beside_it(tmp_path: Path) -> None:
    path = tmp_path / "lab.csv"
    path.write_text(text(CANONICAL + ",deviator_stress [kPa]", *(line + ",7" for line in percent())))
    assert_is_the_invented_test(Reference.read(path))
