"""What a program wrote, as the quantities that it is declared to be."""

import io

import numpy as np
import pytest

import graincal as gc
from graincal import Failure, InputError
from graincal.laboratory.units import find_unit
from graincal.models.output import Column, Output

AT = np.array([0.01, 0.05, 0.1])
STRAIN = np.linspace(0, 0.12, 13)
RATIO = 1 + 20 * STRAIN
CONTRACTION = STRAIN / 5
COLUMNS = {"axial_strain": Column("eps_a"), "stress_ratio": Column("ratio"), "volumetric_strain": Column("eps_v")}


def output(file="curve.csv", columns=COLUMNS, **options):
    return Output(columns, file, **options)


def table(header, *columns, delimiter=",", comment=""):
    rows = [delimiter.join(repr(float(value)) for value in row) for row in zip(*columns)]
    return "\n".join([*([comment] if comment else []), header, *rows, ""]).encode()


def read(content, declared=None, name="curve.csv", at=AT, folder=None):
    if folder is None:
        return (declared or output()).read(content, "axial_strain", at)
    (folder / name).write_bytes(content)
    return (declared or output(name)).read(folder / name, "axial_strain", at)


def is_read(response):
    assert not isinstance(response, Failure), response
    np.testing.assert_array_equal(response.control, AT)
    np.testing.assert_allclose(response.values["stress_ratio"], 1 + 20 * AT, rtol=1e-12)
    np.testing.assert_allclose(response.values["volumetric_strain"], AT / 5, rtol=1e-12)


@pytest.mark.parametrize(
    ("header", "delimiter", "comment"),
    [
        ("eps_a,ratio,eps_v", ",", ""),
        ("eps_a ratio eps_v", " ", "# made by a program, version 1"),
        ("# eps_a\tratio\teps_v", "\t", ""),
        ("eps_a; ratio; eps_v", ";", "# one\n# two"),
    ],
)
def test_text_is_taken_as_laboratory_files_are(header, delimiter, comment, tmp_path):
    is_read(read(table(header, STRAIN, RATIO, CONTRACTION, delimiter=delimiter, comment=comment), folder=tmp_path))
    is_read(read(table(header, STRAIN, RATIO, CONTRACTION, delimiter=delimiter, comment=comment)))


def test_a_unit_stands_in_the_file_or_in_the_name_that_is_declared_or_beside_it():
    percent = {**COLUMNS, "axial_strain": Column("eps_a [%]")}
    is_read(read(table("eps_a [%],ratio,eps_v", 100 * STRAIN, RATIO, CONTRACTION), output(columns=percent)))
    is_read(read(table("eps_a [%],ratio,eps_v", 100 * STRAIN, RATIO, CONTRACTION)))
    is_read(read(table("eps_a,ratio,eps_v", 100 * STRAIN, RATIO, CONTRACTION), output(columns=percent)))
    is_read(read(table("eps_a,ratio,eps_v", 100 * STRAIN, RATIO, CONTRACTION), output(columns=COLUMNS | {"axial_strain": Column("eps_a", "%")})))
    other = read(table("eps_a [-],ratio,eps_v", STRAIN, RATIO, CONTRACTION), output(columns=percent))
    assert other.kind == "unreadable" and "'-' in the file and '%' in columns" in other.reason
    wrong = read(table("eps_a [kPa],ratio,eps_v", STRAIN, RATIO, CONTRACTION))
    assert wrong.kind == "unreadable" and "the unit of axial_strain is 'kPa'" in wrong.reason


def test_an_expression_of_columns_a_sign_and_the_number_of_a_column():
    columns = {"axial_strain": Column(1, sign=-1), "stress_ratio": Column("s33 / s11"), "volumetric_strain": Column("eps_v")}
    is_read(read(table("e33,s33 [kPa],s11 [MPa],eps_v [%]", -STRAIN, 100 * RATIO, 0.1 + 0 * STRAIN, 100 * CONTRACTION), output(columns=columns)))


def test_a_stress_without_a_unit_is_in_pascals():
    found = read(table("eps_a,q", STRAIN, 1e5 * RATIO), output(columns={"axial_strain": Column("eps_a"), "deviatoric_stress": Column("q")}))
    np.testing.assert_allclose(found.values["deviatoric_stress"], 1e5 * (1 + 20 * AT))


def test_numpy_and_hdf5(tmp_path):
    h5py = pytest.importorskip("h5py")
    rows = np.rec.fromarrays([STRAIN, RATIO, CONTRACTION], names="eps_a,ratio,eps_v")
    for array, columns in ((rows, COLUMNS), (np.stack([STRAIN, RATIO, CONTRACTION], axis=1), dict(zip(COLUMNS, map(Column, (1, 2, 3)))))):
        np.save(tmp_path / "curve.npy", array)
        is_read(output("curve.npy", columns).read(tmp_path / "curve.npy", "axial_strain", AT))
    np.savez_compressed(tmp_path / "curve.npz", eps_a=STRAIN, ratio=RATIO, eps_v=CONTRACTION, other=np.zeros((3, 3)))
    is_read(output("curve.npz").read(tmp_path / "curve.npz", "axial_strain", AT))
    with h5py.File(tmp_path / "curve.h5", "w") as file:
        file["run/eps_a"], file["run/ratio"], file["run/eps_v"], file["table"] = STRAIN, RATIO, CONTRACTION, rows
    for where in ("run", "/run", "table"):
        is_read(output("curve.h5", {name: Column(f"{where}/{each.column}") for name, each in COLUMNS.items()}).read(tmp_path / "curve.h5", "axial_strain", AT))
    missing = output("curve.h5").read(tmp_path / "curve.h5", "axial_strain", AT)
    assert missing.kind == "unreadable" and "has no 'eps_a'" in missing.reason and "run/eps_a" in missing.reason


def test_no_object_is_unpickled(tmp_path):
    np.save(tmp_path / "curve.npy", np.array([{"a": 1}], dtype=object), allow_pickle=True)
    assert output("curve.npy").read(tmp_path / "curve.npy", "axial_strain", AT).kind == "unreadable"


def test_consolidation_is_left_out_and_counting_begins_behind_it():
    stage = np.repeat([1.0, 2.0], [4, 13])
    strain, ratio, contraction = (np.concatenate([[3.0, 5.0, 2.0, 0.5], each + shift]) for each, shift in ((STRAIN, 0.02), (RATIO, 0), (CONTRACTION, 0.3)))
    content = table("stage,eps_a,ratio,eps_v", stage, strain, ratio, contraction)
    for chosen in ({"where": "stage == 2"}, {"first_row": 5}):
        is_read(read(content, output(zero=("axial_strain", "volumetric_strain"), **chosen)))
    none = read(content, output(where="stage == 7"))
    assert none.kind == "unreadable" and "none of its 17 rows is chosen by where = 'stage == 7'" in none.reason


def test_engineering_strains_become_logarithmic():
    is_read(read(table("eps_a,ratio,eps_v", -np.expm1(-STRAIN), RATIO, -np.expm1(-CONTRACTION)), output(strain="engineering")))
    is_read(read(table("eps_a,ratio,eps_v", -np.expm1(-STRAIN), RATIO, CONTRACTION), output(strain={"axial_strain": "engineering"})))


def test_rows_where_the_control_falls_back_are_left_out_and_counted():
    strain, ratio, contraction = (np.insert(each, 5, [each[3], each[4]]) for each in (STRAIN, RATIO, CONTRACTION))
    found = read(table("eps_a,ratio,eps_v", strain, ratio, contraction))
    is_read(found)
    assert found.details["rows_left_out"] == 2


@pytest.mark.parametrize(
    ("strain", "kind", "said"),
    [
        (
            100 * STRAIN,
            "unreadable",
            'axial_strain reaches 12, and the reference 0.1: the program\'s strain may be in percent, and is then named with its unit, such as "axial_strain [%]", in output.columns.',
        ),
        (100 * STRAIN + 0.02, "unreadable", "in percent"),
        (STRAIN / 100, "incomplete", "and the reference goes from 0.01 to 0.1: the program's strain may be a fraction, and is taken as percent."),
        (
            np.concatenate([[0.3], STRAIN[1:]]),
            "incomplete",
            ": 12 of its 13 rows are left out, where axial_strain does not exceed that of an earlier row; where or first_row chooses the rows that are read.",
        ),
        (STRAIN + 0.02, "incomplete", ": it begins too late, and the program should write its first state too, before anything is strained."),
        (STRAIN / 2, "incomplete", ": it ends too early."),
    ],
)
def test_why_it_does_not_cover_the_reference_is_said(strain, kind, said):
    found = read(table("eps_a,ratio,eps_v", strain, RATIO, CONTRACTION))
    assert found.kind == kind and said in found.reason


def test_what_does_not_reach_far_enough_is_incomplete():
    found = read(table("eps_a,ratio,eps_v", STRAIN[:8], RATIO[:8], CONTRACTION[:8]))
    assert found.kind == "incomplete" and "0 to 0.07" in found.reason and "0.01 to 0.1" in found.reason


def test_what_is_declared_is_finite_within_the_reference_s_range_and_may_be_anything_outside():
    ratio = RATIO.copy()
    ratio[-1] = np.nan
    is_read(read(table("eps_a,ratio,eps_v", STRAIN, ratio, CONTRACTION)))
    ratio[5] = np.inf
    found = read(table("eps_a,ratio,eps_v", STRAIN, ratio, CONTRACTION))
    assert found.kind == "not_finite" and "stress_ratio is inf at axial_strain 0.05" in found.reason
    strain = STRAIN.copy()
    strain[-1] = np.nan
    is_read(read(table("eps_a,ratio,eps_v", strain, RATIO, CONTRACTION)))
    strain[5] = np.nan
    assert read(table("eps_a,ratio,eps_v", strain, RATIO, CONTRACTION)).kind == "not_finite"


@pytest.mark.parametrize(
    ("content", "kind"),
    [(b"", "no_output"), (b" \n", "no_output"), (b"eps_a,ratio,eps_v\n", "unreadable"), (b"\x00\x01\x02\x03" * 50, "unreadable"), (b"words and more words\n" * 9, "unreadable"),
     (b"eps_a,ratio,eps_v\n0,1,0\n0.1,what,0\n", "unreadable"), (b"eps_a,other,eps_v\n0,1,0\n0.1,2,0\n", "unreadable"), (b"\x93NUMPY\x01\x00", "unreadable"), (b"PK\x03\x04junk", "unreadable"), (b"\x89HDF\r\n\x1a\njunk", "unreadable")],
)  # fmt: skip
def test_what_cannot_be_read_is_a_failure_with_a_reason(content, kind, tmp_path):
    found = read(content, folder=tmp_path) if content.strip() else read(content)
    assert found.kind == kind and len(found.reason) > 20


def _good_files(folder):
    np.save(folder / "a.npy", np.stack([STRAIN, RATIO, CONTRACTION], axis=1))
    np.savez(folder / "a.npz", eps_a=STRAIN, ratio=RATIO, eps_v=CONTRACTION)
    binary = [(folder / name).read_bytes() for name in ("a.npy", "a.npz")]
    return [
        table("eps_a [%],ratio,eps_v", STRAIN, RATIO, CONTRACTION),
        table("# eps_a ratio eps_v", STRAIN, RATIO, CONTRACTION, delimiter=" ", comment="# made"),
        *binary,
    ]


@pytest.mark.parametrize("seed", range(200))
def test_whatever_is_written_is_a_response_or_a_failure(seed, tmp_path):
    generator = np.random.default_rng(seed)
    content = bytearray(_good_files(tmp_path)[seed % 4])
    for _ in range(generator.integers(1, 6)):
        at = int(generator.integers(len(content)))
        match generator.integers(4):
            case 0:
                content[at] = int(generator.integers(256))
            case 1:
                del content[at : at + int(generator.integers(1, 40))]
            case 2:
                content[at:at] = [b"nan", b"\n", b",", b'"', b"#", b"1e999", b"\x00", b" ", b"word"][generator.integers(9)]
            case 3:
                content[at:at] = content[max(0, at - 30) : at]
    columns = COLUMNS | {"stress_ratio": Column("ratio + 0 * eps_v"), "void_ratio": Column(2)}
    found = output(columns=columns, where="eps_a >= 0").read(bytes(content), "axial_strain", AT)
    assert isinstance(found, (Failure, gc.Response)) and (
        isinstance(found, gc.Response) or found.kind in ("unreadable", "not_finite", "incomplete", "no_output")
    )


def test_a_file_that_is_not_there_or_empty_is_no_output(tmp_path):
    assert "wrote no file curve.csv" in output().read(tmp_path / "curve.csv", "axial_strain", AT).reason
    (tmp_path / "curve.csv").touch()
    assert output().read(tmp_path / "curve.csv", "axial_strain", AT).kind == "no_output"


def test_an_archive_that_unpacks_to_more_than_anybody_means_is_not_unpacked(tmp_path, monkeypatch):
    from graincal.models.output import tables

    monkeypatch.setattr(tables, "LARGEST_BINARY", 1000)
    buffer = io.BytesIO()
    np.savez_compressed(buffer, eps_a=np.zeros(10**5))
    assert (
        "unpacks to" in output("curve.npz").read(buffer.getvalue()[:], "axial_strain", AT).reason
        or "MiB" in output("curve.npz").read(buffer.getvalue(), "axial_strain", AT).reason
    )


def test_what_cannot_be_declared_is_refused():
    with pytest.raises(InputError, match="output.zero names 'axial_stran'"):
        output(zero=("axial_stran",))
    with pytest.raises(InputError, match="output.strain names 'stress_ratio'"):
        output(strain={"stress_ratio": "engineering"})
    with pytest.raises(InputError, match="output.columns has no axial_extension"):
        output().check("axial_extension")
    with pytest.raises(InputError, match="'furlong' is not known"):
        Column("x", "furlong")
    assert find_unit("kPa") and output().returned("axial_strain") == ("stress_ratio", "volumetric_strain")
