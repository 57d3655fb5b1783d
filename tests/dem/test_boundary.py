"""The periodic boundary is nowhere: a pair across it is the same as one inside, in any cell, however that deforms."""

from itertools import product

import numpy as np
import pytest

from graincal import _native

from .spheres import CELL, ROUNDING, STILL, law, rounding, steps, unit

RADII = np.array([1.0, 0.7])
BRICK = np.diag([CELL, 0.9 * CELL, 1.1 * CELL])
SHEARED = BRICK @ np.array([[1.0, 0.4, -0.3], [0.1, 1.0, 0.2], [0.0, -0.3, 1.0]])
GRADIENT = np.array([[-0.5, 0.8, 0.3], [0.2, 0.4, -0.9], [-0.4, 0.6, 0.1]])

# Where the pair's centre lies, in lengths of the edges: zero puts it onto a face; all places but the cell's centre.
PLACES = [place for place in product((0.5, 0.0), repeat=3) if place != (0.5, 0.5, 0.5)]


def history_of_a_pair(precision, place, edges, gradient, images=((0, 0, 0), (0, 0, 0))):
    """A loaded pair centred at `place` for 200 steps; what it shows at the end. `images` moves each sphere by whole cells after wrapping."""
    branch = (RADII.sum() - 0.01) * unit((1, 2, -2))
    positions = edges @ np.array(place) + np.array([[-0.5], [0.5]]) * branch
    fractional = np.linalg.solve(edges, positions.T).T % 1.0 + np.array(images)
    density = 1.0
    simulation = _native.Simulation(fractional @ edges.T, RADII, edges, law(friction=0.4, rolling_strength=0.1), density, precision=precision)
    simulation.set_velocities(np.array([[1.0, 2.0, -0.5], [-1.0, 0.3, 0.8]]))
    simulation.set_spins(np.array([[3.0, 1.0, 2.0], [-1.0, 2.0, -3.0]]))
    simulation.set_velocity_gradient(gradient)
    steps(simulation, 200, 2e-6, gradient, damping=0.2)
    contacts = simulation.contacts()
    assert len(contacts["first"]) == 1
    return contacts | {
        "forces": simulation.forces,
        "torques": simulation.torques,
        "velocities": simulation.velocities,
        "spins": simulation.spins,
        "stress": simulation.stress,
    }


@pytest.mark.parametrize("gradient", [STILL, GRADIENT], ids=["resting", "deforming"])
@pytest.mark.parametrize("edges", [BRICK, SHEARED], ids=["brick", "sheared"])
@pytest.mark.parametrize("place", PLACES, ids=lambda place: "".join("xyz"[k] for k in range(3) if place[k] == 0))
def test_a_contact_across_the_boundary_is_the_same_as_one_inside(place, edges, gradient, precision):
    inside = history_of_a_pair(precision, (0.5, 0.5, 0.5), edges, gradient)
    across = history_of_a_pair(precision, place, edges, gradient)
    # Coordinates round at the cell's size, so an overlap of 0.01 m is known to this share, and with it all that follows but for the precision's
    # own roundings; 200 steps add up.
    tolerance = 200 * (ROUNDING * CELL / 0.01 + rounding(precision))
    for name, expected in inside.items():
        assert np.allclose(across[name], expected, rtol=0, atol=tolerance * np.abs(expected).max()), name


@pytest.mark.parametrize("images", [((0, 0, 0), (3, -2, 1)), ((-1, 5, 0), (0, 0, 2))])
def test_whole_cells_between_two_spheres_are_no_distance(images, precision):
    near = history_of_a_pair(precision, (0.5, 0.5, 0.5), SHEARED, GRADIENT)
    far = history_of_a_pair(precision, (0.5, 0.5, 0.5), SHEARED, GRADIENT, images)
    tolerance = 200 * (ROUNDING * 10 * CELL / 0.01 + rounding(precision))  # coordinates of up to ten cells
    for name, expected in near.items():
        assert np.allclose(far[name], expected, rtol=0, atol=tolerance * np.abs(expected).max()), name


def test_the_cells_motion_moves_a_contact_across_the_boundary_like_any_other(precision):
    # v2 - v1 + L (translation) against L branch: in a cell that deforms uniformly, spheres at rest against it slip by L n (r1 + r2) alone.
    sheared = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    for place in ((0.5, 0.5, 0.5), (0.0, 0.5, 0.5)):
        edges = np.diag([CELL] * 3)
        positions = (edges @ np.array(place) + np.array([[-0.5], [0.5]]) * np.array([1.69, 0, 0])) % CELL
        simulation = _native.Simulation(positions, RADII, edges, law(), 1e30, precision=precision)
        simulation.set_velocity_gradient(sheared)
        steps(simulation, 1, 1e-6, sheared)
        ks = 0.3 * 2 * 1e7 * 0.7 / 1.7
        # To first order in the angle of one step, 2e-6.
        assert simulation.contacts()["shear"][0] == pytest.approx([0, -ks * 2.0 * 1e-6 * 1.7, 0], rel=1e-5, abs=1e-5 * ks * 2e-6)
