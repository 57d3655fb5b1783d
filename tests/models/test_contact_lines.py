"""Lines of a contact law for other DEM programs: two spheres have the forces and torques there that they have in graincal's engine."""

import numpy as np
import pytest

from graincal import _native
from graincal.models.contact_laws import LAWS
from graincal.models.contact_lines.contact import Contact
from graincal.models.contact_lines.lammps import MOST_CLASSES, lammps_lines, radius_classes
from graincal.models.contact_lines.pfc import pfc_lines
from graincal.models.contact_lines.yade import yade_lines

from .pairs_elsewhere import Leg, in_lammps, in_yade, needs_lammps, needs_yade

RADII, OVERLAP, TIME_STEP = (1.0, 0.7), 0.01, 1e-3
NORMAL = np.array([1, 2, 2]) / 3
POSITIONS = 4 + (sum(RADII) - OVERLAP) * NORMAL * np.array([[-0.5], [0.5]])
VALUES = {"log_E": 7.0, "nu": 0.3, "phi": 20.0, "beta_m": 0.2, "eta_m": 0.1}
ACROSS = np.array([2, -1, 0]) / np.sqrt(5)

# A slip that sticks, and one that goes on until it slides; a bending, then one to the cap, with a twisting beside; back again.
LEGS = [
    Leg(3, [(0.3 * ACROSS).tolist()] * 2),
    Leg(20, [(0.5 * ACROSS).tolist()] * 2),
    Leg(4, [(-0.2 * ACROSS).tolist(), (0.3 * ACROSS).tolist()]),
    Leg(30, [(0.1 * ACROSS - 0.4 * NORMAL).tolist(), (0.4 * np.cross(NORMAL, ACROSS) + 0.4 * NORMAL).tolist()]),
    Leg(5, [(-0.1 * ACROSS + 0.2 * NORMAL).tolist(), (-0.3 * ACROSS - 0.2 * NORMAL).tolist()]),
]
# The second sphere approaches, passes, and turns back while it still approaches.
PASSING = [
    Leg(40, [[0.02, -0.01, 0.03], [0.01, 0.02, -0.05]], [[0.0] * 3, [-0.05, 0.05, -0.12]]),
    Leg(60, [[-0.08, 0.03, 0.0], [0.0, 0.05, 0.1]], [[0.0] * 3, [-0.2, 0.15, -0.11]]),
]


def contact(law, **values):
    return Contact(law, VALUES | values, np.array(RADII), "a test.")


def in_graincal(asked, legs):
    """(legs, 2, 3): forces and torques."""
    values = asked.values
    law = LAWS[asked.law].engine(asked.modulus, values["nu"], asked.friction, values["beta_m"], values["eta_m"])
    simulation = _native.Simulation(POSITIONS, np.array(RADII), np.diag([8.0] * 3), law, 1e30, precision="float64", economy=_native.Economy())
    forces, torques = [], []
    for leg in legs:
        simulation.set_velocities(np.array(leg.velocities, dtype=float))
        simulation.set_spins(np.array(leg.spins, dtype=float))
        simulation.run_prescribed(leg.steps, np.zeros((3, 3)), TIME_STEP, 0.0)
        forces.append(simulation.forces)
        torques.append(simulation.torques)
    return np.array(forces), np.array(torques)


def agree(found, expected):
    for there, here in zip(found, expected):
        # Both add up some hundred steps; an overlap of 0.01 has 14 digits in a cell of 8.
        assert np.allclose(there, here, rtol=0, atol=1e-10 * np.abs(here).max()), np.abs(there - here).max() / np.abs(here).max()


def test_the_path_sticks_slides_rolls_and_is_capped():
    """The path shows what it is for: by one law each of these makes a difference."""
    forces, torques = in_graincal(contact("linear"), LEGS)
    friction = contact("linear").friction
    shear = forces[:, 1] - (forces[:, 1] @ NORMAL)[:, None] * NORMAL
    ratio = np.linalg.norm(shear, axis=1) / (forces[:, 1] @ NORMAL)
    assert 0.1 * friction < ratio[0] < 0.99 * friction and ratio[1] == pytest.approx(friction, rel=1e-6)
    largest = VALUES["eta_m"] * min(RADII) * (forces[3, 1] @ NORMAL)
    assert abs(torques[3, 1] @ NORMAL) == pytest.approx(largest, rel=1e-6)


@needs_yade
@pytest.mark.parametrize("legs", [LEGS, PASSING], ids=["turning", "passing"])
def test_linear_lines_give_the_same_forces_in_yade(legs, tmp_path):
    asked = contact("linear")
    agree(in_yade(yade_lines(asked), POSITIONS, RADII, TIME_STEP, legs, tmp_path), in_graincal(asked, legs))


@needs_yade
@pytest.mark.parametrize("legs", [LEGS, PASSING], ids=["turning", "passing"])
def test_hertz_lines_give_the_same_forces_in_yade(legs, tmp_path):
    asked = contact("hertz-mindlin", beta_m=0.0, eta_m=0.0)
    agree(in_yade(yade_lines(asked), POSITIONS, RADII, TIME_STEP, legs, tmp_path), in_graincal(asked, legs))


@needs_lammps
@pytest.mark.parametrize("values", [{}, {"beta_m": 0.0}, {"nu": 0.0}, {"phi": 0.0}], ids=["all", "no rolling", "no shear", "no friction"])
def test_linear_lines_give_the_same_forces_in_lammps(values, tmp_path):
    asked = contact("linear", **values)
    agree(in_lammps(lammps_lines(asked), POSITIONS, RADII, TIME_STEP, LEGS, tmp_path), in_graincal(asked, LEGS))


@needs_lammps
def test_hertz_lines_give_the_same_forces_in_lammps(tmp_path):
    asked = contact("hertz-mindlin", beta_m=0.0, eta_m=0.0)
    agree(in_lammps(lammps_lines(asked), POSITIONS, RADII, TIME_STEP, LEGS, tmp_path), in_graincal(asked, LEGS))


def test_what_has_no_counterpart_is_said():
    linear, hertz = contact("linear"), contact("hertz-mindlin")
    for lines in (yade_lines(hertz), lammps_lines(hertz), pfc_lines(hertz), pfc_lines(linear)):
        assert "NO COUNTERPART: resistance to " in lines
    for lines in (yade_lines(linear), lammps_lines(linear), *(each(contact("hertz-mindlin", beta_m=0.0)) for each in (yade_lines, lammps_lines, pfc_lines))):
        assert "NO COUNTERPART" not in lines
    assert all("NOT RUN" in pfc_lines(each) for each in (linear, hertz))


def test_pfcs_springs_in_series_are_graincals():
    """By the manual's formula, with what the lines give each ball."""
    asked = contact("linear")
    first, second = (2.0 * asked.modulus * radius for radius in RADII)
    assert first * second / (first + second) == pytest.approx(asked.pair(*RADII).normal, rel=1e-15)
    assert f"2.0 * {asked.modulus!r} * ball.radius(b)" in pfc_lines(asked)


def test_many_radii_are_put_into_classes():
    radii = np.geomspace(1e-3, 3e-3, 500)
    means, limits = radius_classes(radii)
    assert len(means) == MOST_CLASSES and len(limits) == MOST_CLASSES - 1
    assert np.all(means[:-1] < limits) and np.all(limits < means[1:])
    assert "10 classes" in lammps_lines(Contact("linear", VALUES, radii, "a test."))
    few, between = radius_classes(np.array([2.0, 1.0, 2.0, 4.0]))
    assert few.tolist() == [1.0, 2.0, 4.0] and between.tolist() == [1.5, 3.0]


def test_a_campaigns_name_stays_within_its_comment():
    lines = yade_lines(Contact("linear", VALUES, np.array(RADII), "answer of a\nimport os # ü"))
    assert lines.splitlines()[0] == "# Contact parameters from graincal: answer of a import os # \\xfc"
