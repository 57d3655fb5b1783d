"""Packings as users bring them: what is read is what was written, centres are wrapped, and what cannot be a packing is refused in one sentence."""

import re

import numpy as np
import pytest

from graincal import InputError, Packing

from .spheres import ROUNDING, jittered_lattice

CUBE = np.diag([8.0] * 3)
APART = np.array([[1.0, 1, 1], [1, 1, 5]])

FILE = """# two spheres, metres; cell lengths: 8.0 8.0 9.0
x,y,z,radius
1.0,1.0,1.0,1.0
1.0,1.0,4.0,0.5
"""


def refusal(action):
    """The one sentence with which the input is refused."""
    with pytest.raises(InputError) as refused:
        action()
    message = str(refused.value)
    assert "\n" not in message and message.endswith(".")
    assert not re.search(r"[.!?] [A-Z]", message), "more than one sentence"
    return message


def refusal_of(tmp_path, content):
    path = tmp_path / "sample.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    message = refusal(lambda: Packing.read(path))
    assert message.startswith(f"{path}: ")
    return message.removeprefix(f"{path}: ")


# Files


def test_what_is_written_is_read_with_every_digit(tmp_path):
    positions, radii, edges = jittered_lattice(side=4, spacing=2.5, jitter=0.02)
    packing = Packing(positions / 3, radii / 3, edges / 3)
    packing.write(tmp_path / "packing.csv", comment="a lattice, metres")
    again = Packing.read(tmp_path / "packing.csv")
    for name in ("positions", "radii", "edges"):
        assert np.array_equal(getattr(again, name), getattr(packing, name)), name
    assert again.name == str(tmp_path / "packing.csv")
    assert (tmp_path / "packing.csv").read_text().startswith("# a lattice, metres; cell lengths: ")


@pytest.mark.parametrize(
    "content",
    [
        FILE,
        FILE.replace("\n", "\r\n"),
        "\ufeff" + FILE,
        "# made by hand\n" + FILE,
        FILE + "\n\n",
        FILE.replace("x,y,z,radius", " x, y, z, radius"),
        FILE.replace("1.0,1.0,4.0,0.5", " 1.0, 1.0, 4.0, 5e-1"),
        FILE.replace("8.0 8.0 9.0", "8 8 9; seed 3\n# 500 grains\n"),
        FILE.replace("two spheres", "two spheres, in a cell: a brick; pressure and cell"),
        FILE + "# 1.0,1.0,5.0,0.5\n",
    ],
    ids=[
        "plain", "Windows line ends", "byte order mark", "two comments", "blank lines", "spaced header", "spaced numbers", "more said", "cells in other words",
        "particle in a comment",
    ],
)  # fmt: skip
def test_a_file_is_read_as_it_comes(tmp_path, content):
    (tmp_path / "packing.csv").write_text(content, newline="", encoding="utf-8")
    packing = Packing.read(tmp_path / "packing.csv")
    assert np.array_equal(packing.positions, [[1, 1, 1], [1, 1, 4]])
    assert np.array_equal(packing.radii, [1.0, 0.5])
    assert np.array_equal(packing.edges, np.diag([8.0, 8.0, 9.0]))


def test_a_file_that_is_not_there_or_not_text_is_refused(tmp_path):
    path = tmp_path / "nowhere.csv"
    assert refusal(lambda: Packing.read(path)) == f"{path}: there is no such file, and a packing file was expected here."
    assert "text file with the columns x,y,z,radius" in refusal_of(tmp_path, b"\xff\xfe\x00\x80")


@pytest.mark.parametrize(
    ("found", "put", "expected"),
    [
        ("; cell lengths: 8.0 8.0 9.0", "", "'cell lengths: Lx Ly Lz' in metres is needed"),
        ("8.0 8.0 9.0", "8.0 8.0", "'cell lengths: Lx Ly Lz' in metres is needed"),
        ("8.0 8.0 9.0", "8.0 wide 9.0", "'cell lengths: Lx Ly Lz' in metres is needed"),
        ("8.0 8.0 9.0", "8.0 0.0 9.0", "the cell lengths must be positive, not 8.0 0.0 9.0"),
        ("8.0 8.0 9.0", "8.0 inf 9.0", "must be finite numbers"),
        ("8.0 8.0 9.0", "8.0 4.9 9.0", "the cell is only 4.9 m wide, and must be at least 2.5 times the largest diameter of 2 m"),
        ("8.0 8.0 9.0", "1e103 1e103 1e103", "cell length 1 is 1e+103 m, and a length from 1e-9 to 1e9 m was expected"),
        ("8.0 8.0 9.0", "8.0 8.0 1e308", "cell length 3 is 1e+308 m, and a length from 1e-9 to 1e9 m was expected"),
        ("8.0 8.0 9.0", "8.0 1e-110 9.0", "cell length 2 is 1e-110 m, and a length from 1e-9 to 1e9 m was expected"),
        ("1.0,1.0,4.0,0.5", "1.0,1.0,4.0,1e200", "the radius of particle 2 is 1e+200 m, and a length from 1e-9 to 1e9 m was expected"),
        ("1.0,1.0,4.0,0.5", "1.0,1.0,4.0,1e-200", "the radius of particle 2 is 1e-200 m, and a length from 1e-9 to 1e9 m was expected"),
        ("x,y,z,radius\n", "", "the header must be 'x,y,z,radius'"),
        ("x,y,z,radius", "x,y,z,r", "the header must be 'x,y,z,radius'"),
        ("1.0,1.0,4.0,0.5", "1.0,1.0,4.0", "line 4 must hold four numbers x,y,z,radius"),
        ("1.0,1.0,4.0,0.5", "1.0,1.0,4.0,small", "line 4 must hold four numbers x,y,z,radius"),
        ("1.0,1.0,4.0,0.5", "1.0,1.0,4.0,nan", "must be finite numbers"),
        ("1.0,1.0,4.0,0.5", "1.0,1.0,4.0,-0.5", "the radius of particle 2 must be positive"),
        ("1.0,1.0,4.0,0.5\n", "", "at least two particles"),
        ("1.0,1.0,4.0,0.5", "1.0,1.0,2.4,0.5", "particles 1 and 2 overlap by 20.0% of the smaller radius, and at most 1% is allowed"),
    ],
)
def test_a_file_that_holds_no_packing_is_refused(tmp_path, found, put, expected):
    assert found in FILE
    assert expected in refusal_of(tmp_path, FILE.replace(found, put))


@pytest.mark.parametrize(
    ("cell", "name", "count"),
    [
        ("cell lengths: 8 0 0 0 8 0 0 0 9", "cell lengths", 9),
        ("cell lengths: 8 1 0\n# 0 8 0\n# 0 0 9", "cell lengths", 9),
        ("cell lengths: 8 8 9 0 0.1 0", "cell lengths", 6),
        ("cell lengths: 8 8 9; cell: [[8, 1, 0], [0, 8, 0], [0, 0, 9]]", "cell", 9),
        ("cell vectors (m): 8 1 0 0 8 0 0 0 9\n# cell lengths: 8 8 9", "cell vectors (m)", 9),
    ],
    ids=["matrix in a line", "matrix in three lines", "tilts", "lengths and a matrix", "vectors and lengths"],
)
def test_a_cell_that_is_more_than_three_lengths_is_refused(tmp_path, cell, name, count):
    # A cell that leans, read as one that does not, would be another packing.
    message = refusal_of(tmp_path, FILE.replace("cell lengths: 8.0 8.0 9.0", cell))
    assert message == f"the comment '{name}:' gives {count} numbers, and the three lengths Lx Ly Lz of a cell with edges along x, y and z were expected."


@pytest.mark.parametrize("far", [1e308, -1.7e308, 1e290, 1e10], ids=str)
def test_a_centre_too_far_away_to_be_wrapped_is_refused_by_its_number(tmp_path, far):
    # In a cell of centimetres 1e308 overflows as a share of the cell, 1e290 has no digits that say where in it.
    file = f"# cell lengths: 0.0369 0.0374 0.0723\nx,y,z,radius\n0.01,0.01,0.01,0.003\n0.01,{far},0.03,0.003\n0.02,0.02,0.05,0.003\n"
    expected = (
        f"the centre of particle 2 at 0.01, {far:.3g}, 0.03 m is more than a million cells away, and coordinates in metres in or near the cell were expected."
    )
    assert refusal_of(tmp_path, file) == expected


def test_an_empty_file_is_refused(tmp_path):
    assert "'cell lengths: Lx Ly Lz' in metres is needed" in refusal_of(tmp_path, "")


@pytest.mark.parametrize("header", ["axial_strain [%],volumetric_strain [%]", "Ea(%);q (kPa)", "# cell pressure\neps_v, %\ts1/s3"])
def test_a_laboratory_file_is_called_so(tmp_path, header):
    assert "this looks like a laboratory file (column '" in refusal_of(tmp_path, f"{header}\n0,1\n")


def test_negative_cell_lengths_are_refused(tmp_path):
    assert "positive" in refusal_of(tmp_path, FILE.replace("8.0 8.0 9.0", "-8.0 -8.0 9.0"))


def test_a_particle_given_twice_is_refused(tmp_path):
    assert "particles 1 and 2 overlap" in refusal_of(tmp_path, FILE.replace("1.0,1.0,4.0,0.5", "1.0,1.0,1.0,1.0"))


# Positions


def test_centres_outside_the_cell_are_wrapped():
    edges = np.diag([8.0, 9.0, 10.0])
    inside = (edges @ np.array([[0.1, 0.2, 0.3], [0.6, 0.7, 0.8]]).T).T
    shifted = inside + np.array([[1, -2, 0], [0, 0, 3]]) @ edges.T
    packing = Packing(shifted, np.ones(2), edges)
    assert np.allclose(packing.positions, inside, rtol=0, atol=10 * ROUNDING * np.abs(shifted).max())
    # What was inside is kept to the digit.
    assert np.array_equal(Packing(inside, np.ones(2), edges).positions, inside)


def test_centres_on_a_face_stay_within_rounding_of_the_cell():
    packing = Packing(np.array([[8.0, -1e-17, 1], [1, 1, 5]]), np.ones(2), CUBE)
    assert np.all((packing.positions >= 0) & (packing.positions <= 8.0))
    assert packing.positions[0, 0] == 0


# Overlaps


@pytest.mark.parametrize("across", [False, True], ids=["inside", "across the boundary"])
def test_overlaps_above_a_hundredth_of_the_smaller_radius_are_refused(across):
    def pair(overlap):
        distance = 1.5 - overlap
        return lambda: Packing(np.array([[1.0, 1, 1], [1, 1, 9 - distance if across else 1 + distance]]), np.array([1.0, 0.5]), CUBE)

    pair(0.0099 * 0.5)()
    message = refusal(pair(0.0102 * 0.5))
    assert message == "packing: particles 1 and 2 overlap by 1.0% of the smaller radius, and at most 1% is allowed."
    assert "by 50.0% of" in refusal(pair(0.5 * 0.5))


def test_the_worst_of_many_overlaps_is_named():
    positions, radii, edges = jittered_lattice(side=4, spacing=2.5, spread=0.0, jitter=0.0)
    positions[21] = positions[20] + [0, 0, 1.8]
    positions[5] = positions[4] + [0, 0, 1.7]
    assert "particles 5 and 6 overlap by 30.0%" in refusal(lambda: Packing(positions, radii, edges))


# Arrays


@pytest.mark.parametrize(
    ("positions", "radii"),
    [(APART[:, :2], np.ones(2)), (APART, np.ones(3)), (APART[:1], np.ones(1)), (APART.ravel(), np.ones(2))],
)
def test_arrays_of_other_shapes_are_refused(positions, radii):
    assert "positions must be (N, 3) and radii (N,) for at least two particles" in refusal(lambda: Packing(positions, radii, CUBE))


@pytest.mark.parametrize(
    "edges",
    [
        CUBE + 0.1 * np.eye(3, k=1),
        CUBE[[1, 2, 0]],
        CUBE @ np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]]),
        np.diag([-8.0, -8.0, 8.0]),
        np.diag([8.0, 8.0]),
    ],
    ids=["sheared", "axes exchanged", "turned", "negative", "flat"],
)
def test_a_cell_whose_edges_are_not_along_the_axes_is_refused(edges):
    # Stress paths drive x, y and z.
    expected = "packing: the cell's edges must lie along x, y and z, and a diagonal matrix of three positive lengths was expected."
    assert refusal(lambda: Packing(APART, np.ones(2), edges)) == expected


def test_a_packing_does_not_change_with_the_arrays_it_was_made_from():
    positions, radii = APART.copy(), np.ones(2)
    packing = Packing(positions, radii, CUBE)
    positions[:] = 0
    assert np.array_equal(packing.positions, APART)
    with pytest.raises(ValueError):
        packing.positions[0, 0] = 0


def test_volumes_and_void_ratio():
    packing = Packing(APART, np.array([1.0, 0.5]), CUBE)
    assert packing.volume == pytest.approx(512, rel=10 * ROUNDING)
    assert packing.solid_volume == pytest.approx(4 / 3 * np.pi * 1.125, rel=10 * ROUNDING)
    assert packing.void_ratio == pytest.approx(512 / (1.5 * np.pi) - 1, rel=10 * ROUNDING)
    assert packing.count == 2
