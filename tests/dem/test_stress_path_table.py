"""Stress paths as tables: what a table says is what is run, and a mistake in one is a sentence with file, line and column."""

from pathlib import Path

import numpy as np
import pytest

from graincal import InputError, StressPathTable, TableTest, TriaxialTest

THETA = [8.5, 0.2, 30.0, 0.1, 0.5]

DRAINED = """# isotropic consolidation, then axial strain at constant lateral stress
stress_x,stress_y,stress_z,strain_z,record,strain_origin

1e5,1e5,1e5,,no,yes
1e5,1e5,,0,,
1e5,1e5,,0.0005,yes,
# where the triaxial test rests on its way
1e5,1e5,,0.001,,no
1e5,1e5,,0.002,,no
"""


def read(folder, text):
    path = folder / "path.csv"
    path.write_text(text)
    return StressPathTable.read(path)


def test_a_table_with_the_stages_of_the_triaxial_test_is_the_triaxial_test(packing, tmp_path):
    table = TableTest(packing, table=read(tmp_path, DRAINED))
    assert table.table.recorded == (2, 3, 4, 5)
    (ours,) = table.simulate([THETA], at=[2, 3, 4, 5], threads=1)
    (expected,) = TriaxialTest(packing, 1e5).simulate([THETA], at=[0.0, 0.0005, 0.001, 0.002], threads=1)
    np.testing.assert_array_equal(ours.control, [2, 3, 4, 5])
    for name, values in expected.values.items():
        assert np.array_equal(ours.values[name], values), name
    # Consolidation may be left to the confining pressure.
    rest = DRAINED.replace("1e5,1e5,1e5,,no,yes\n", "")
    (consolidated,) = TableTest(packing, 1e5, table=read(tmp_path, rest)).simulate([THETA], at=[1, 2, 3, 4], threads=1)
    np.testing.assert_array_equal(consolidated.control, [1, 2, 3, 4])
    assert all(np.array_equal(consolidated.values[name], values) for name, values in expected.values.items())


def test_axes_are_driven_apart_and_no_faster_than_they_may(packing, tmp_path):
    header = "strain_x,stress_x,stress_y,strain_z,rate_x,rate_z\n"
    table = TableTest(packing, 1e5, table=read(tmp_path, header + "0.001,,1.2e5,-0.002,,\n,1.1e5,1.2e5,-0.002,0.5,\n"))
    (curve,) = table.simulate([THETA], at=[1, 2], threads=1)
    # Stresses to a thousandth and strains to 1e-6, as the servo's tolerances are.
    assert curve.values["strain_x"][0] == pytest.approx(0.001, abs=1e-6) and curve.values["stress_xx"][1] == pytest.approx(1.1e5, rel=1e-3)
    assert np.allclose(curve.values["stress_yy"], 1.2e5, rtol=1e-3, atol=0) and np.allclose(curve.values["strain_z"], -0.002, rtol=0, atol=1e-6)
    # At a tenth of the rate the strain takes ten times the steps.
    fast, slow = (read(tmp_path, f"strain_x,strain_y,strain_z,rate_z\n0,0,0,\n0,0,0.01,{rate}\n") for rate in (0.1, 0.01))
    (fast,), (slow,) = (TableTest(packing, 1e5, table=table).simulate([THETA], at=[1, 2], threads=1) for table in (fast, slow))
    loading = [np.diff(curve.values["steps"])[0] for curve in (fast, slow)]
    assert loading[1] > 5 * loading[0]  # and not quite ten, for the time step and the steps to rest


def test_the_table_of_the_documentation_is_what_it_says(packing, tmp_path):
    page = (Path(__file__).parents[2] / "docs" / "stress-paths.md").read_text()
    begin = page.index("# anisotropic consolidation, then undrained compression")
    table = read(tmp_path, page[begin : page.index("```", begin)])
    (curve,) = TableTest(packing, table=table).simulate([THETA], at=table.recorded, threads=1)
    assert curve.values["stress_ratio"][0] == pytest.approx(1.8, rel=2e-3)
    # The servo meets each of three strains to 1e-6.
    assert np.allclose(curve.values["axial_strain"], [0, 0.01, 0.02], rtol=0, atol=1e-6)
    assert np.allclose(curve.values["volumetric_strain"], 0, rtol=0, atol=3e-6)


def test_a_stage_that_is_not_recorded_cannot_be_asked_for(packing, tmp_path):
    table = TableTest(packing, table=read(tmp_path, DRAINED))
    for at in ([1, 2], [2.5], [], ["a"]):
        with pytest.raises(InputError, match="stages must be one row of the numbers of recorded ones, 2, 3, 4."):
            table.simulate([THETA], at=at)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("strain_z,record", "strain_z,recorded", 'column recorded is not known (did you mean "record"?), and each of stress_x, '),
        ("strain_z,record", "stress_z,record", "column stress_z stands twice, and each of stress_x, "),
        (",,0.0005,yes,", ",,0.0005,yes", "line 6 (stage 3) has 5 cells, and one for each of the 6 columns was expected."),
        (",,0.0005,yes,", ",,0.2%,yes,", 'line 6 (stage 3), column strain_z: a number was expected, not "0.2%".'),
        (",,0.0005,yes,", ",,nan,yes,", 'line 6 (stage 3), column strain_z: a number was expected, not "nan".'),
        (",,0.0005,yes,", ",,2,yes,", "line 6 (stage 3), column strain_z: a strain between -1 and 1, a fraction and not percent, was expected, not 2."),
        (",,0.0005,yes,", ",1e5,0.0005,yes,", "line 6 (stage 3), columns stress_z and strain_z: both are given, and one of them was expected."),
        (",,0.0005,yes,", ",,,yes,", "line 6 (stage 3), columns stress_z and strain_z: neither is given, and one of them was expected."),
        (",,0.0005,yes,", ",,0.0005,true,", 'line 6 (stage 3), column record: yes or no was expected, not "true".'),
        (",,0.002,,no", ",,0.002,,never", 'line 9 (stage 5), column strain_origin: yes or no was expected, not "never".'),
        ("1e5,1e5,1e5", "-1e5,1e5,1e5", "line 4 (stage 1), column stress_x: a stress above 0 in Pa was expected, not -100000."),
        (
            "1e5,1e5,,0,,\n1e5,1e5,,0.0005,yes,\n# where the triaxial test rests on its way\n1e5,1e5,,0.001,,no\n1e5,1e5,,0.002,,no\n",
            "",
            "no stage is recorded, and at least one row with record = yes was expected.",
        ),
        (DRAINED, "# nothing\n", "a header with some of the columns stress_x, "),
        (DRAINED, "stress_x,stress_y,stress_z,rate_y\n1,1,1,0\n", "line 2 (stage 1), column rate_y: a rate above 0 in 1/s was expected, not 0."),
        (DRAINED, "stress_x,stress_y\n1,1\n", "line 2 (stage 1), columns stress_z and strain_z: neither is given, and one of them was expected."),
    ],
)
def test_a_mistake_is_one_sentence_with_file_line_and_column(tmp_path, old, new, said):
    assert old in DRAINED
    with pytest.raises(InputError) as error:
        read(tmp_path, DRAINED.replace(old, new))
    sentence = str(error.value)
    assert sentence.startswith(f"{tmp_path / 'path.csv'}: {said}") and sentence.endswith(".") and "\n" not in sentence


def test_a_table_that_is_not_there_is_a_sentence_too(tmp_path):
    with pytest.raises(InputError, match="nowhere.csv: there is no such file, and the table of a stress path was expected here"):
        StressPathTable.read(tmp_path / "nowhere.csv")
