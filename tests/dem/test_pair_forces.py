"""Two spheres that move as they are told: what the contact laws share, against closed forms."""

import numpy as np
import pytest

from .spheres import ROUNDING, closed_form, exact, law, only_contact, rounding, steps, two_spheres, unit

RADII = (1.0, 0.7)
OVERLAP = 0.01
LINEAR = closed_form("linear", RADII, OVERLAP)

DIRECTIONS = [(1, 0, 0), (0, -1, 0), (1, 2, 2), (-0.3, 0.5, -0.8)]


@pytest.fixture(params=["linear", "hertz-mindlin"])
def kind(request):
    """The contact law."""
    return request.param


@pytest.fixture
def expected(kind):
    """The contact of the two spheres that most tests take."""
    return closed_form(kind, RADII, OVERLAP)


def same_spin(simulation, spin):
    """Both spheres spin alike: their surfaces slip, and nothing rolls or twists."""
    simulation.set_spins(np.array([spin, spin], dtype=float))


def rolling_spin(simulation, relative_spin):
    """A relative spin that lets the surfaces roll (or twist) without slip: r1 omega1 = -r2 omega2."""
    share = np.array([-RADII[1], RADII[0]]) / sum(RADII)
    simulation.set_spins(share[:, None] * np.asarray(relative_spin, dtype=float))


# Normal force


@pytest.mark.parametrize("radii", [(1.0, 1.0), (1.0, 0.7), (0.3, 1.2)])
@pytest.mark.parametrize("overlap", [1e-5, 1e-2, 0.1])
@pytest.mark.parametrize("normal", DIRECTIONS)
def test_the_overlap_gives_the_normal_force_and_the_energy(kind, radii, overlap, normal, precision):
    simulation = two_spheres(radii, overlap, normal, kind=kind, precision=precision)
    steps(simulation, 1)
    expected = closed_form(kind, radii, overlap)
    force = expected.force * unit(normal)
    tolerance = exact(precision, overlap) * expected.force
    assert np.allclose(only_contact(simulation)["force"], force, rtol=0, atol=tolerance)
    assert np.allclose(simulation.forces, [-force, force], rtol=0, atol=tolerance)
    assert np.array_equal(simulation.torques, np.zeros((2, 3)))
    assert simulation.elastic_energy == pytest.approx(expected.energy, rel=exact(precision, overlap))


def test_spheres_apart_do_not_act_on_each_other(kind, precision):
    simulation = two_spheres(overlap=-1e-9, kind=kind, precision=precision)
    steps(simulation, 1)
    assert only_contact(simulation) is None
    assert np.array_equal(simulation.forces, np.zeros((2, 3)))
    assert simulation.elastic_energy == 0


def test_a_contact_ends_at_once_and_takes_its_history_along(kind, expected, precision):
    simulation = two_spheres(RADII, OVERLAP, kind=kind, precision=precision)
    simulation.set_spins(np.array([[0.3, 0.2, 0.1], [0.5, -0.2, 0.3]]))
    steps(simulation, 5)
    loaded = only_contact(simulation)
    assert all(np.linalg.norm(loaded[name]) > 0 for name in ("shear", "bending", "twisting"))

    # 0.002 m a step: the overlap of 0.01 m is gone after six steps, and back after as many the other way.
    simulation.set_spins(np.zeros((2, 3)))
    simulation.set_velocities(np.array([[0.0, 0, 0], [2.0, 0, 0]]))
    steps(simulation, 7)
    assert only_contact(simulation) is None
    assert np.array_equal(simulation.torques, np.zeros((2, 3)))
    simulation.set_velocities(np.array([[0.0, 0, 0], [-2.0, 0, 0]]))
    steps(simulation, 7)
    back = only_contact(simulation)
    assert back["overlap"] == pytest.approx(OVERLAP - 0.002, rel=exact(precision))
    # The spheres moved along x alone: only roundings of the normal are across it.
    for name in ("shear", "bending", "twisting"):
        assert np.linalg.norm(back[name]) < exact(precision) * expected.force, name


# Sliding


@pytest.mark.parametrize("normal", DIRECTIONS)
def test_stick_stores_stiffness_times_slip(kind, expected, normal, precision):
    simulation = two_spheres(RADII, OVERLAP, normal, kind=kind, precision=precision)
    spin, time_step, count = np.array([0.2, -0.1, 0.4]), 1e-3, 50
    n = unit(normal)
    spin -= spin @ n * n  # about the normal the memory would turn
    same_spin(simulation, spin)
    steps(simulation, count, time_step)
    slip = -count * time_step * sum(RADII) * np.cross(spin, n)
    assert np.allclose(
        only_contact(simulation)["shear"], -expected.shear * slip, rtol=0, atol=exact(precision, count=count) * expected.shear * np.linalg.norm(slip)
    )


def test_a_new_contact_takes_its_first_slip(kind, expected, precision):
    simulation = two_spheres(RADII, OVERLAP, kind=kind, precision=precision)
    same_spin(simulation, [0, 0, 1])
    steps(simulation, 1, 1e-3)
    assert np.allclose(only_contact(simulation)["shear"], [0, expected.shear * sum(RADII) * 1e-3, 0], rtol=exact(precision), atol=exact(precision))


def test_slip_caps_at_friction_and_reversal_unloads_with_the_stiffness(kind, expected, precision):
    friction = 0.5
    simulation = two_spheres(RADII, OVERLAP, friction=friction, kind=kind, precision=precision)
    limit = friction * expected.force
    step_force = expected.shear * sum(RADII) * 1e-3  # at spin 1 /s and 1 ms
    to_limit = int(np.ceil(limit / step_force))
    near = exact(precision) * limit * 10 * to_limit  # one rounding of the cap a step

    def shear_after(count, spin):
        same_spin(simulation, [0, 0, spin])
        steps(simulation, count, 1e-3)
        shear = only_contact(simulation)["shear"]
        assert shear[0] == pytest.approx(0, abs=near) and shear[2] == pytest.approx(0, abs=near)
        return shear[1]

    assert shear_after(to_limit - 1, 1.0) == pytest.approx((to_limit - 1) * step_force, abs=near)
    assert shear_after(20, 1.0) == pytest.approx(limit, abs=near)
    assert shear_after(3, -1.0) == pytest.approx(limit - 3 * step_force, abs=near)
    assert shear_after(2 * to_limit + 20, -1.0) == pytest.approx(-limit, abs=near)
    assert shear_after(3, 1.0) == pytest.approx(-limit + 3 * step_force, abs=near)


def test_the_cap_follows_the_normal_force(kind, precision):
    simulation = two_spheres(RADII, OVERLAP, friction=0.5, kind=kind, precision=precision)
    same_spin(simulation, [0, 0, 1])
    steps(simulation, 100)
    same_spin(simulation, [0, 0, 0])
    simulation.set_velocities(np.array([[0.0, 0, 0], [1.0, 0, 0]]))  # the overlap shrinks by 0.001 m a step
    for k in range(1, 9):
        steps(simulation, 1)
        normal_force = closed_form(kind, RADII, OVERLAP - 1e-3 * (k - 1)).force
        assert np.linalg.norm(only_contact(simulation)["shear"]) == pytest.approx(0.5 * normal_force, rel=100 * exact(precision))


def test_without_friction_nothing_is_stored(kind, precision):
    simulation = two_spheres(RADII, OVERLAP, friction=0.0, kind=kind, precision=precision)
    same_spin(simulation, [0, 0, 1])
    steps(simulation, 5)
    assert np.array_equal(only_contact(simulation)["shear"], np.zeros(3))


def moved_past(count, path, precision):
    """The contact after the second sphere has followed `path` (legs in m) in `count` steps a leg, without spin; springs alike at any overlap."""
    simulation = two_spheres(RADII, overlap=0.05, precision=precision)
    for leg in np.asarray(path, dtype=float):
        simulation.set_velocities(np.stack([np.zeros(3), leg / (count * 1e-3)]))
        steps(simulation, count)
    simulation.set_velocities(np.zeros((2, 3)))
    steps(simulation, 1)
    return only_contact(simulation)


def test_the_slip_of_a_passing_sphere_is_its_angle_times_both_radii(precision):
    # A straight pass from the angle zero to theta: with full radii as arms and the stretched translation the slip is (r1 + r2) theta, whatever the
    # overlap on the way. The scheme sums it as N rectangles under a rate that falls by a share of theta^2: at most theta^2 / N of the whole is missed or
    # added. Memory turned by first-order rotations of delta grows by delta^2 / 2 a step: half as much again.
    distance, side, count = sum(RADII) - 0.05, 0.3, 400
    theta = np.arctan(side / distance)
    contact = moved_past(count, [[0, side, 0]], precision)
    slip = sum(RADII) * theta
    assert contact["shear"] @ [-np.sin(theta), np.cos(theta), 0] == pytest.approx(
        -LINEAR.shear * slip, rel=1.5 * theta**2 / count + exact(precision, 0.05, count)
    )
    # It lies across the present normal: each rotation leaves at most delta^3 / 2 of it along, and its roundings.
    assert abs(contact["shear"] @ contact["normal"]) <= LINEAR.shear * slip * (theta**3 / count**2 + exact(precision, 0.05, count))


def test_no_force_is_gained_in_a_closed_loop(precision):
    # Forward at a small overlap, back at a large one. With the true distance as arm a loop would leave ks side depth / distance, and again each time.
    distance, side, depth, count = sum(RADII) - 0.05, 0.05, 0.04, 500
    contact = moved_past(count, [[0, side, 0], [-depth, 0, 0], [0, -side, 0], [depth, 0, 0]], precision)
    ratchet = LINEAR.shear * side * depth / distance
    # The rates along each leg change by shares of theta and depth / distance: that much of the slip, over N, is what rectangles leave.
    theta = side / distance
    left = LINEAR.shear * (side + depth) * theta * (theta + depth / distance) / count
    roundings = exact(precision, count=4 * count) * LINEAR.shear * (side + depth)
    assert left < 1e-3 * ratchet and roundings < 0.1 * ratchet
    assert np.linalg.norm(contact["shear"]) <= left + roundings


# Rolling and twisting


@pytest.mark.parametrize("normal", DIRECTIONS)
def test_bending_and_twisting_store_stiffness_times_rotation(kind, expected, normal, precision):
    n = unit(normal)
    relative_spin = np.array([0.3, 0.7, -0.2])
    simulation = two_spheres(RADII, OVERLAP, normal, kind=kind, precision=precision)
    # Spheres that twist against each other must not spin together about the normal, or the memory turns: opposite spins along it.
    along = relative_spin @ n * n
    across = relative_spin - along
    share = np.array([-RADII[1], RADII[0]]) / sum(RADII)
    simulation.set_spins(share[:, None] * across + np.array([[-0.5], [0.5]]) * along)
    steps(simulation, 20, 1e-3)
    contact = only_contact(simulation)
    scale = exact(precision, count=20) * expected.rolling * 0.02
    assert np.allclose(contact["bending"], -expected.rolling * 0.02 * across, rtol=0, atol=scale)
    assert np.allclose(contact["twisting"], -expected.rolling * 0.02 * along, rtol=0, atol=scale)
    # A rolling contact does not slip; the spins' roundings against the force that slip of their size would give.
    assert np.allclose(contact["shear"], 0, rtol=0, atol=exact(precision, count=20) * expected.shear * 0.02)


@pytest.mark.parametrize(("bends", "twists"), [(True, False), (False, True), (True, True)])
def test_each_moment_is_capped_by_itself(kind, expected, bends, twists, precision):
    strength = 0.4
    limit = strength * expected.force * min(RADII)
    simulation = two_spheres(RADII, OVERLAP, rolling_strength=strength, kind=kind, precision=precision)
    fast, slow = 10.0, 0.001
    simulation.set_spins(np.array([[-0.5, 0, 0], [0.5, 0, 0]]) * (fast if twists else slow))
    spins = simulation.spins
    spins[:, 2] = np.array([-RADII[1], RADII[0]]) / sum(RADII) * (fast if bends else slow)
    simulation.set_spins(spins)
    count = 500
    steps(simulation, count, 1e-3)
    contact = only_contact(simulation)
    near = 10 * count * exact(precision) * limit
    assert limit < expected.rolling * fast * count * 1e-3 and limit > 10 * expected.rolling * slow * count * 1e-3
    expected_bending = limit if bends else expected.rolling * slow * count * 1e-3
    expected_twisting = limit if twists else expected.rolling * slow * count * 1e-3
    assert np.allclose(contact["bending"], [0, 0, -expected_bending], rtol=0, atol=near)
    assert np.allclose(contact["twisting"], [-expected_twisting, 0, 0], rtol=0, atol=near)
    # And back: a reversal unloads from the cap with the stiffness.
    simulation.set_spins(-simulation.spins)
    steps(simulation, 1, 1e-3)
    assert only_contact(simulation)["bending"][2] == pytest.approx(-expected_bending + expected.rolling * (fast if bends else slow) * 1e-3, abs=near)
    assert only_contact(simulation)["twisting"][0] == pytest.approx(-expected_twisting + expected.rolling * (fast if twists else slow) * 1e-3, abs=near)


def test_without_strength_no_moment_is_stored(kind, precision):
    simulation = two_spheres(RADII, OVERLAP, rolling_strength=0.0, kind=kind, precision=precision)
    rolling_spin(simulation, [1.0, 1.0, 1.0])
    steps(simulation, 5)
    contact = only_contact(simulation)
    assert np.array_equal(contact["bending"], np.zeros(3)) and np.array_equal(contact["twisting"], np.zeros(3))


# Both spheres


def test_forces_are_opposite_and_torques_have_the_arms_to_the_middle_of_the_overlap(kind, precision):
    simulation = two_spheres(RADII, OVERLAP, (1, 2, 2), kind=kind, precision=precision)
    simulation.set_spins(np.array([[0.3, 0.2, 0.1], [0.5, -0.2, 0.3]]))
    simulation.set_velocities(np.array([[0.1, 0.2, 0.0], [0.0, 0.2, 0.1]]))
    steps(simulation, 10)
    contact = only_contact(simulation)
    n, shear, moment = contact["normal"], contact["shear"], contact["bending"] + contact["twisting"]
    force = closed_form(kind, RADII, contact["overlap"]).force * n + shear
    arms = np.array(RADII) - contact["overlap"] / 2
    # The same sums in another order: roundings of each term.
    assert np.allclose(simulation.forces, [-force, force], rtol=0, atol=10 * rounding(precision) * np.linalg.norm(force))
    torques = [-arms[0] * np.cross(n, shear) - moment, -arms[1] * np.cross(n, shear) + moment]
    assert np.allclose(simulation.torques, torques, rtol=0, atol=10 * rounding(precision) * np.linalg.norm(force))


def rotation(vector):
    """The rotation by |vector| radians about it (Rodrigues)."""
    angle = np.linalg.norm(vector)
    x, y, z = np.asarray(vector) / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def errors_after_rigid_rotation(kind, turn, count, precision):
    """Loads a pair, turns it as a rigid body in `count` steps; the errors of shear, bending and twisting against the turned ones, relative to each."""
    simulation = two_spheres(RADII, OVERLAP, (1, 2, 2), kind=kind, precision=precision)
    simulation.set_spins(np.array([[0.3, 0.2, 0.1], [0.5, -0.2, 0.3]]))
    steps(simulation, 20)
    time_step = 1e-3
    step = rotation(turn / count)
    centre = simulation.positions.mean(axis=0)
    simulation.set_spins(np.stack([turn / (count * time_step)] * 2))
    start = None
    for _ in range(count + 1):
        x = simulation.positions - centre
        simulation.set_velocities(np.ascontiguousarray((x @ step.T - x) / time_step))
        steps(simulation, 1, time_step)
        start = only_contact(simulation) if start is None else start  # its force pass comes before the first turn
    end, whole = only_contact(simulation), rotation(turn)
    assert np.allclose(end["normal"], whole @ start["normal"], rtol=0, atol=count * 10 * ROUNDING + exact(precision))
    assert end["overlap"] == pytest.approx(OVERLAP, rel=count * exact(precision))
    errors = {name: np.linalg.norm(end[name] - whole @ start[name]) / np.linalg.norm(start[name]) for name in ("shear", "bending", "twisting")}
    return errors, np.linalg.norm(start["shear"])


@pytest.mark.parametrize("turn", [(0.0, 0.0, 1.0), (0.6, -0.5, 0.4)])
def test_the_forces_of_a_loaded_pair_turn_with_it(kind, expected, turn, precision):
    # Each step turns the memory by two first-order rotations of at most delta = theta / N. Either is wrong by at most delta^2 / 2 of the vector, and their
    # product by no more than delta^2 / 2 again: 1.5 theta^2 / N over the whole. The shear also takes the slip that the chord of a step leaves at its end,
    # a half of (1 - cos delta) of both radii at most.
    turn = np.array(turn)
    # In float32 fewer steps are taken, so that the scheme's error stands out from roundings.
    theta, count = np.linalg.norm(turn), {"float64": 4000, "float32": 200}[precision]
    coarse, shear = errors_after_rigid_rotation(kind, turn, count, precision)
    fine, _ = errors_after_rigid_rotation(kind, turn, 2 * count, precision)
    rotations, chords = 1.5 * theta**2 / count, expected.shear * sum(RADII) * theta**2 / (4 * count) / shear
    assert coarse["bending"] <= rotations and coarse["twisting"] <= rotations
    assert coarse["shear"] <= rotations + chords < 60 / count
    # Of first order, and nothing else but roundings: every step turns by the same angle, and so they may add up.
    roundings = 2 * 2 * count * rounding(precision)
    for name in coarse:
        assert coarse[name] / fine[name] == pytest.approx(2, rel=0.02 + roundings / fine[name]), name


def test_a_changed_law_acts_on_the_contact_as_it_stands(kind, expected, precision):
    simulation = two_spheres(RADII, OVERLAP, kind=kind, precision=precision)
    same_spin(simulation, [0, 0, 1])
    steps(simulation, 10)
    same_spin(simulation, [0, 0, 0])
    simulation.set_law(law(friction=0.01, kind=kind))
    steps(simulation, 1)
    assert np.linalg.norm(only_contact(simulation)["shear"]) == pytest.approx(0.01 * expected.force, rel=exact(precision))
