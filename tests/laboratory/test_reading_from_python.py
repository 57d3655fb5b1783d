"""Files of the field, read from Python by the same words as from a calibration file."""

from pathlib import Path

import pytest

import graincal as gc

FIELD = Path(__file__).parents[1] / "data" / "field"
MACHINE = {"axial_strain": 7, "axial_stress": "I", "lateral_stress": 10, "volume_change": "Volume Change"}
UNITS = {"axial_strain": "%", "axial_stress": "kPa", "lateral_stress": "kPa", "volume_change": "mm3"}


@pytest.mark.parametrize("part", [{"stage": 3}, {"stage": "3"}, {"rows": (38, 53)}])
def test_a_stage_of_a_machines_file_is_read_by_numbers_letters_and_names(part):
    zero = ["axial_strain", "volume_change"]
    reference = gc.Reference.read(FIELD / "stages.csv", columns=MACHINE, units=UNITS, strain="engineering", zero=zero, sample_volume=1.9635e-4, **part)
    assert len(reference.control) == 16 and reference.control[0] == 0 and reference.observables["volumetric_strain"][0] == 0
    assert reference.control[-1] == pytest.approx(0.134675, abs=1e-6)
    assert reference.observables["stress_ratio"].max() == pytest.approx(4.018, abs=1e-4)
    assert reference.read_as == ("axial_strain", "axial_stress", "lateral_stress", "volume_change")


def test_a_file_without_names_is_read_by_numbers():
    columns = {"axial_strain": 2, "deviator_stress": "A", "volumetric_strain": 4, "void_ratio": "5"}
    options = {"columns": columns, "units": {"deviator_stress": "kPa"}, "strain": "engineering", "confining_pressure": 120e3}
    signs = {"axial_strain": "negative", "volumetric_strain": "negative"}
    reference = gc.Reference.read(FIELD / "headerless.txt", observables=("stress_ratio", "volumetric_strain", "void_ratio"), compression=signs, **options)
    assert len(reference.control) == 15 and reference.control[-1] == pytest.approx(0.109815, abs=1e-6)
    assert reference.observables["stress_ratio"][-1] == pytest.approx(3.0269, abs=1e-4)


def test_what_is_recorded_is_read_as_an_observable_is():
    options = {"columns": MACHINE, "units": UNITS, "strain": "engineering", "zero": ["axial_strain", "volume_change"], "sample_volume": 1.9635e-4, "stage": 3}
    fitted = gc.Reference.read(FIELD / "stages.csv", **options)
    beside = gc.Reference.read(FIELD / "stages.csv", observables=["stress_ratio"], recorded=["volumetric_strain"], **options)
    assert beside.names == ("stress_ratio",) and beside.notes == fitted.notes and beside.read_as == fitted.read_as
    for name, values in fitted.observables.items():
        assert list(beside.measured[name]) == list(values)
    for observables, recorded, said in (
        (["stress_ratio"], ["stress_ratio"], "stress_ratio is an observable, which is fitted, and cannot be recorded"),
        (["stress_ratio"], ["axial_strain"], "axial_strain is the control"),
        (["stress_ratio"], "volumetric_strain", "recorded must list names"),
        (["stress_ratio"], ["volumetric_stain"], "'volumetric_stain' is not an observable"),
    ):
        with pytest.raises(gc.InputError, match=said):
            gc.Reference.read(FIELD / "stages.csv", observables=observables, recorded=recorded, **options)


def test_an_encoding_is_taken_from_python_too():
    columns = {"axial_strain": 1, "deviator_stress": 2, "volumetric_strain": 3}
    reference = gc.Reference.read(
        FIELD / "russian_cp1251.csv",
        columns=columns,
        units={"axial_strain": "%", "deviator_stress": "kPa", "volumetric_strain": "%"},
        strain="engineering",
        confining_pressure=100e3,
        encoding="cp1251",
    )
    assert reference.observables["stress_ratio"][-1] == pytest.approx(4.087, abs=1e-3)
    with pytest.raises(gc.InputError, match="there is no column 9, and a number from 1 to 3 was expected"):
        gc.Reference.read(FIELD / "russian_cp1251.csv", columns=columns | {"axial_strain": 9}, encoding="cp1251")
