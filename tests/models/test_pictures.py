"""The pictures of a test for ParaView: read back, they are the states of the run."""

import base64
import struct
from xml.etree import ElementTree

import numpy as np
import pytest

import graincal as gc
from graincal.data import Samples
from graincal.demo import packing

THETA = {"log_E": 8.72, "nu": 0.227, "phi": 28.1, "beta_m": 0.079, "eta_m": 0.569}
OPTIONS = [word for name, value in THETA.items() for word in ("-p", f"{name}={value}")]
PRESSURE = 5e5


def read_polydata(path):
    """{name: array} of a .vtp file, and the numbers of its points and cells."""
    root = ElementTree.parse(path).getroot()
    assert (root.attrib["type"], root.attrib["byte_order"], root.attrib["header_type"]) == ("PolyData", "LittleEndian", "UInt64")
    (piece,) = root.iter("Piece")
    found = {}
    for array in piece.iter("DataArray"):
        data = base64.b64decode(array.text)
        assert struct.unpack("<Q", data[:8]) == (len(data) - 8,)
        values = np.frombuffer(data[8:], dtype={"Float64": "<f8", "Int64": "<i8"}[array.attrib["type"]])
        found[array.attrib["Name"]] = values.reshape(-1, 3) if array.attrib["NumberOfComponents"] == "3" else values
    return found, {name: int(number) for name, number in piece.attrib.items()}


def series(path):
    return [(float(each.attrib["timestep"]), each.attrib["file"]) for each in ElementTree.parse(path).getroot().iter("DataSet")]


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    """A folder with the pictures of a short test, and its response at its own states at rest."""
    from graincal.models.pictures import write_pictures

    test = gc.TriaxialTest(packing(), PRESSURE, accuracy="reference")
    folder = tmp_path_factory.mktemp("pictures") / "vtk"
    at = np.array([0, 0.004, 0.008])
    write_pictures(test, np.array(list(THETA.values())), at, folder)
    samples = Samples(np.zeros(1, dtype=np.int64), np.array([list(THETA.values())]), tuple(THETA))
    ((_, curve),) = test.evaluate(samples, at=at, workers=1)
    return folder, curve


def test_there_is_a_picture_of_the_start_and_of_each_state_at_rest(pictures):
    folder, curve = pictures
    for kind in ("particles", "contacts"):
        found = series(folder / f"{kind}.pvd")
        assert [time for time, _ in found] == [*range(len(curve.control) + 1)]
        assert all((folder / name).is_file() for _, name in found)
    assert (folder / "states.csv").read_text().split() == [
        "picture,axial_strain",
        "0,",
        *(f"{k},{strain}" for k, strain in enumerate(curve.control.tolist(), start=1)),
    ]


def test_the_first_picture_is_the_packing(pictures):
    grains = packing()
    found, numbers = read_polydata(pictures[0] / "particles-0000.vtp")
    np.testing.assert_array_equal(found["radius"], grains.radii)
    assert numbers == {"NumberOfPoints": grains.count, "NumberOfVerts": grains.count}
    apart = np.linalg.solve(grains.edges, (found["points"] - grains.positions).T)
    np.testing.assert_allclose(apart, np.round(apart), atol=1e-9)


def test_contacts_join_the_centres_of_grains_that_overlap(pictures):
    grains, _ = read_polydata(pictures[0] / f"particles-{len(pictures[1].control):04}.vtp")
    found, numbers = read_polydata(pictures[0] / f"contacts-{len(pictures[1].control):04}.vtp")
    begins, ends = found["points"][::2], found["points"][1::2]
    assert numbers == {"NumberOfPoints": 2 * len(begins), "NumberOfLines": len(begins)}
    assert len(begins) > len(grains["radius"]) and (found["overlap"] > 0).all() and (found["force"] > 0).all()
    np.testing.assert_array_equal(found["offsets"], 2 * np.arange(1, len(begins) + 1))
    first = np.argmin(np.linalg.norm(begins[:, None] - grains["points"], axis=2), axis=1)
    np.testing.assert_allclose(begins, grains["points"][first], atol=0)
    # Most of the others lie within the cell too; the rest are images beyond it.
    apart = np.linalg.norm(ends[:, None] - grains["points"], axis=2)
    within = apart.min(axis=1) < 1e-9
    assert within.mean() > 0.5
    lengths = grains["radius"][first] + grains["radius"][apart.argmin(axis=1)] - found["overlap"]
    np.testing.assert_allclose(np.linalg.norm(ends - begins, axis=1)[within], lengths[within], rtol=1e-9)


def test_the_forces_carry_the_stress_of_the_curve(pictures):
    """The trace of the stress is the sum of normal force times branch over the volume; the norm of the force is above its normal part by the shear."""
    folder, curve = pictures
    found, _ = read_polydata(folder / f"contacts-{len(curve.control):04}.vtp")
    branch = np.linalg.norm(found["points"][1::2] - found["points"][::2], axis=1)
    grains, _ = read_polydata(folder / f"particles-{len(curve.control):04}.vtp")
    volume = (1 + curve.values["void_ratio"][-1]) * np.sum(4 / 3 * np.pi * grains["radius"] ** 3)
    trace = np.sum(found["force"] * branch) / volume
    expected = PRESSURE * (2 + curve.values["stress_ratio"][-1])
    assert expected < trace < 1.15 * expected


def test_the_run_of_the_pictures_is_that_of_the_curve(pictures):
    """To the last contact at the last state."""
    folder, curve = pictures
    _, numbers = read_polydata(folder / f"contacts-{len(curve.control):04}.vtp")
    assert numbers["NumberOfLines"] == curve.values["contacts"][-1]


def test_the_command_writes_them_beside_the_curve_and_overwrites_nothing(call, tmp_path):
    packing().write(tmp_path / "packing.csv")
    command = [
        "simulate",
        "triaxial",
        "--packing",
        tmp_path / "packing.csv",
        "--confining-pressure",
        PRESSURE,
        *OPTIONS,
        "--axial-strain",
        0.004,
        "--increment",
        0.004,
    ]
    told = call(*command, "--vtk", tmp_path / "vtk", "-o", tmp_path / "curve.csv")
    assert told.code == 0 and "particles.pvd" in told.err
    assert len(series(tmp_path / "vtk" / "particles.pvd")) == len(list((tmp_path / "vtk").glob("contacts-*.vtp"))) > 2
    told = call(*command, "--vtk", tmp_path / "vtk")
    assert told.code == 1 and "one that is empty or not there" in told.err
