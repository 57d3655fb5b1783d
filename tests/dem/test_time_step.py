"""The critical time step of configurations worked out by hand: dt = 0.8 sqrt(2) min over particles of sqrt(min(m / K, I / R)), with per axis
K_a = sum (kn - ks) n_a^2 + ks and R_a = sum ks r^2 (1 - n_a^2) + km over the particle's contacts, the largest of the three axes."""

import numpy as np
import pytest

from graincal import _native

from .spheres import law, masses, normal_stiffness, ring, rounding, two_spheres

SAFETY = 0.8 * np.sqrt(2)


def near(precision):
    """A force pass, a sum and a root: roundings, 1e-13 in float64."""
    return 450 * rounding(precision)


def first_time_step(simulation):
    simulation.run(1, 0.0)
    return simulation.time_step


def test_without_contacts_it_is_half_the_time_of_a_stiff_wave_across_the_smallest_grain(precision):
    simulation = two_spheres(overlap=-0.1, radii=(1.0, 0.5), density=2.0, modulus=1e7, precision=precision)
    expected = 0.5 * 0.5 * np.sqrt(2.0 / 1e7)
    assert simulation.time_step == pytest.approx(expected, rel=near(precision))
    assert first_time_step(simulation) == pytest.approx(expected, rel=near(precision))


def test_translation_limits_a_ring_of_hard_springs(precision):
    # Each sphere has two contacts along x: K = 2 kn along it, and rotation is soft.
    simulation = ring(stiffness_ratio=0.1, rolling_stiffness=0.0, density=2.0, precision=precision)
    mass, kn = masses(1.0, 2.0), normal_stiffness((1.0, 1.0))
    assert first_time_step(simulation) == pytest.approx(SAFETY * np.sqrt(mass / (2 * kn)), rel=near(precision))


def test_rotation_limits_where_shear_and_rolling_are_stiff(precision):
    # Across x each contact gives ks r^2 + km, along it km alone: R = 2 (ks + km) against I = 2/5 m.
    simulation = ring(stiffness_ratio=0.8, rolling_stiffness=0.5, density=2.0, precision=precision)
    mass, ks = masses(1.0, 2.0), 0.8 * normal_stiffness((1.0, 1.0))
    assert first_time_step(simulation) == pytest.approx(SAFETY * np.sqrt(0.4 * mass / (2 * (ks + 0.5 * ks))), rel=near(precision))


def test_the_smaller_of_two_unequal_spheres_limits_an_oblique_contact(precision):
    # n = (2, 6, 3) / 7: the largest of K_a is along y, the largest of R_a along x.
    radii, stiffness_ratio, beta, density = (1.0, 0.6), 0.3, 0.2, 2.0
    squared = np.array([4, 36, 9]) / 49
    kn = normal_stiffness(radii)
    ks = stiffness_ratio * kn
    km = beta * radii[0] * radii[1] * ks
    mass = masses(0.6, density)
    translation = mass / ((kn - ks) * squared[1] + ks)
    rotation = 0.4 * mass * 0.36 / (ks * 0.36 * (1 - squared[0]) + km)
    assert rotation < translation
    simulation = two_spheres(radii, 0.01, (2, -6, 3), density=density, stiffness_ratio=stiffness_ratio, rolling_stiffness=beta, precision=precision)
    assert first_time_step(simulation) == pytest.approx(SAFETY * np.sqrt(rotation), rel=near(precision))


def test_particles_without_contact_do_not_limit(precision):
    # A speck would need a far smaller step, if anything touched it.
    edges = np.diag([8.0] * 3)
    positions = np.array([[3.0, 4, 4], [4.999, 4, 4], [4.0, 4, 7]])
    with_speck = _native.Simulation(positions, np.array([1.0, 1.0, 0.1]), edges, law(), 1.0, precision=precision)
    without = _native.Simulation(positions[:2].copy(), np.ones(2), edges, law(), 1.0, precision=precision)
    assert first_time_step(with_speck) == first_time_step(without)


def test_it_grows_by_a_twentieth_a_step_at_most_and_falls_at_once(precision):
    simulation = ring(density=1e30, precision=precision)  # nothing moves: the contacts stay what they are
    simulation.set_time_stepper(np.sqrt(2), 1)  # an estimate every step
    hard = first_time_step(simulation)
    simulation.set_law(law(modulus=1e6))
    for growth in (1.05, 1.05**2, 1.05**3):
        assert first_time_step(simulation) == pytest.approx(growth * hard, rel=near(precision))
    simulation.run(50, 0.0)  # 1.05^24 > sqrt(10)
    assert simulation.time_step == pytest.approx(np.sqrt(10) * hard, rel=near(precision))
    simulation.set_law(law())
    assert first_time_step(simulation) == pytest.approx(hard, rel=near(precision))


def test_a_contact_that_comes_while_the_step_is_steady_shortens_it_at_once():
    # A ring holds itself; a small sphere falls on it from the side, and touches it at step 40 or so, between two estimates.
    period = 3 * 1.99
    positions = np.array([[1.0, 4, 4], [2.99, 4, 4], [4.98, 4, 4], [2.99, 5.51, 4]])
    taken = []
    for longest_wait in (1, 16):
        simulation = _native.Simulation(positions, np.array([1.0, 1, 1, 0.5]), np.diag([period, 8.0, 8.0]), law(), 1.0)
        simulation.set_time_stepper(np.sqrt(2), longest_wait)
        first_time_step(simulation)
        velocities = np.zeros((4, 3))
        velocities[3, 1] = -0.01 / (40 * simulation.time_step)
        simulation.set_velocities(velocities)
        taken.append([first_time_step(simulation) for _ in range(60)])
    assert taken[0][30] == pytest.approx(taken[0][0], rel=1e-3)
    assert min(taken[0]) < 0.7 * taken[0][0]
    # Not one step is taken longer than if each had been estimated.
    assert taken[1][: np.argmin(taken[0]) + 1] == pytest.approx(taken[0][: np.argmin(taken[0]) + 1], rel=1e-3)
