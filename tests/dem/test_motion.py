"""Motion: what the leapfrog conserves, what damping takes away, how the cell carries particles."""

import numpy as np
import pytest

from graincal import _native

from .spheres import CELL, ROUNDING, STILL, jittered_lattice, law, masses, normal_stiffness, only_contact, ring, rounding, steps, two_spheres, unit

SHEARED = np.array([[-0.2, 0.3, 0.0], [0.1, 0.1, -0.4], [0.0, 0.2, 0.05]])


# Conservation


@pytest.mark.parametrize("kind", ["linear", "hertz-mindlin"])
@pytest.mark.parametrize("gradient", [STILL, SHEARED], ids=["resting cell", "deforming cell"])
def test_momentum_of_a_periodic_packing_is_conserved_to_rounding(gradient, kind, precision):
    positions, radii, edges = jittered_lattice(side=6)
    density, count, time_step = 1.0, 300, 2e-5
    simulation = _native.Simulation(positions, radii, edges, law(friction=0.5, rolling_strength=0.3, kind=kind), density, precision=precision)
    start = np.random.default_rng(1).normal(0, 10, positions.shape)
    simulation.set_velocities(start)
    mass = masses(radii, density)
    before = mass @ simulation.velocities
    largest = 0.0
    for _ in range(count):
        steps(simulation, 1, time_step, gradient)
        largest = max(largest, np.sum(mass * np.linalg.norm(simulation.velocities, axis=1)))
    assert len(simulation.contacts()["first"]) > 2 * len(radii)
    # Every step rounds every particle's momentum once, and each of its pair forces, which act on both alike, less.
    assert np.allclose(mass @ simulation.velocities, before, rtol=0, atol=2 * count * rounding(precision) * largest)
    # Collisions have passed momentum around: the velocities are nothing like those of the start.
    assert np.linalg.norm(simulation.velocities - start) > 0.5 * np.linalg.norm(start)


@pytest.mark.parametrize("kind", ["linear", "hertz-mindlin"])
def test_angular_momentum_of_an_isolated_pair_is_conserved_to_rounding(kind, precision):
    # Contact torques have the arms to the middle of the overlap, together the distance of the centres, so the law conserves x cross m u + I w; the
    # leapfrog does too, step by step, for forces along the branch and torques in this balance.
    density, count = 1.0, 2000
    simulation = two_spheres((1.0, 0.7), 0.01, (1, 2, 2), density=density, friction=0.4, rolling_strength=0.3, kind=kind, precision=precision)
    simulation.set_velocities(np.array([[1.0, 2.0, -0.5], [-1.0, 0.3, 0.8]]))
    simulation.set_spins(np.array([[3.0, 1.0, 2.0], [-1.0, 2.0, -3.0]]))
    mass = masses(simulation.radii, density)
    inertia = 0.4 * mass * simulation.radii**2

    def angular_momentum():
        return np.sum(np.cross(simulation.positions, mass[:, None] * simulation.velocities) + inertia[:, None] * simulation.spins, axis=0)

    before, spins = angular_momentum(), simulation.spins
    steps(simulation, count, 1e-5)
    assert np.linalg.norm(simulation.spins - spins) > 0.1 * np.linalg.norm(spins)
    # Each step rounds positions of the cell's size beside momenta, and spins.
    scale = np.sum(CELL * mass * np.linalg.norm(simulation.velocities, axis=1) + inertia * np.linalg.norm(spins, axis=1))
    assert np.allclose(angular_momentum(), before, rtol=0, atol=2 * count * rounding(precision) * scale)


def test_an_elastic_collision_conserves_energy_to_the_order_of_the_scheme(precision):
    # The leapfrog conserves m u^2 / 2 + k x x' / 2 exactly, x and x' the overlaps at both ends of the step. A collision that starts and ends between two
    # steps misses k x x' / 2 with |x x'| <= (v dt / 2)^2 at each end: a share (omega dt)^2 / 4 of the energy, omega = sqrt(k / m) of the pair. At a force
    # pass, with the mean of m u^2 / 2 before and after it, the sum exceeds the conserved one by k x^2 / 2 (omega dt)^2 / 2.
    density, speed, radii, normal = 1.0, 1.0, (1.0, 0.7), (1, 2, 2)
    mass = masses(np.array(radii), density)
    reduced = mass[0] * mass[1] / mass.sum()
    omega = np.sqrt(normal_stiffness(radii) / reduced)
    time_step = 0.05 / omega
    simulation = two_spheres(radii, -0.3 * speed * time_step, normal, density=density, friction=0.0, precision=precision)
    approach = np.outer([reduced / mass[0], -reduced / mass[1]], speed * unit(normal))
    simulation.set_velocities(np.ascontiguousarray(approach))
    energy = simulation.kinetic_energy
    assert energy == pytest.approx(0.5 * reduced * speed**2, rel=10 * rounding(precision))

    totals, overlaps, kinetic = [], [], energy
    for _ in range(int(np.pi / 0.05) + 10):
        steps(simulation, 1, time_step)
        totals.append(0.5 * (kinetic + simulation.kinetic_energy) + simulation.elastic_energy)
        kinetic = simulation.kinetic_energy
        contact = only_contact(simulation)
        overlaps.append(contact["overlap"] if contact else 0.0)
    assert overlaps[0] == overlaps[-1] == 0
    share = (omega * time_step) ** 2
    assert np.allclose(totals, energy, rtol=0.75 * share, atol=0)
    assert kinetic == pytest.approx(energy, rel=share / 2)
    # Coefficient of restitution one, along the normal and nowhere else; roundings of the overlap turn into velocity at omega, and those of velocities add up.
    noise = omega * 100 * ROUNDING * CELL + 100 * rounding(precision) * speed
    assert np.allclose(simulation.velocities, -approach, rtol=0, atol=speed * share / 4 + noise)
    assert np.array_equal(simulation.spins, np.zeros((2, 3)))
    # The largest overlap is v / omega and the collision lasts pi / omega, both seen through steps.
    assert max(overlaps) == pytest.approx(speed / omega, rel=share)
    assert np.count_nonzero(overlaps) * time_step == pytest.approx(np.pi / omega, abs=time_step)


# The cell


def test_particles_without_contacts_are_carried_by_the_cell(precision):
    # x = H H0^-1 x0 where nothing acts and the fluctuation is zero; the cell itself grows by (1 + dt L) each step.
    positions, radii, edges = jittered_lattice(side=3, spacing=3.0, spread=0.1, jitter=0.05)
    simulation = _native.Simulation(positions, radii, edges, law(), 1.0, precision=precision)
    steps(simulation, 200, 1e-3, SHEARED)
    expected = np.linalg.matrix_power(np.eye(3) + 1e-3 * SHEARED, 200) @ edges
    assert np.allclose(simulation.edges, expected, rtol=0, atol=200 * ROUNDING * edges.max())
    carried = positions @ (expected @ np.linalg.inv(edges)).T
    assert np.allclose(simulation.positions, carried, rtol=0, atol=200 * ROUNDING * edges.max())
    assert np.array_equal(simulation.velocities, np.zeros_like(positions))


def test_a_free_particle_keeps_its_fluctuation_and_crosses_the_boundary(precision):
    positions, radii, edges = jittered_lattice(side=3, spacing=3.0, spread=0.0, jitter=0.0)
    simulation = _native.Simulation(positions, radii, edges, law(), 1.0, precision=precision)
    velocity = np.tile([1.0, -2.0, 0.5], (len(radii), 1))  # all alike: they never meet
    simulation.set_velocities(velocity)
    steps(simulation, 5000, 1e-2)
    assert np.array_equal(simulation.velocities, velocity)
    # 50 s at 2 m/s are eleven cells of 9 m; each step rounds a path of that length.
    assert np.allclose(simulation.positions, positions + 50 * velocity, rtol=0, atol=5000 * ROUNDING * 100)


# Damping


def oscillation(precision, damping, time_step, count, radius=1.0, overlap=0.01, amplitude=1e-4):
    """Three spheres in a ring, the first two swinging against each other while the third rests: the first one's displacement, velocity
    and spin along x after each step.

    Along x each of the two feels 3 kn (two contacts, one of them closing twice as fast), about x 3 km.
    """
    simulation = ring(radius, overlap, rolling_stiffness=0.2, precision=precision)
    kick = np.zeros((3, 3))
    kick[0, 0], kick[1, 0] = amplitude, -amplitude
    simulation.set_velocities(kick)
    simulation.set_spins(kick)
    displacements, velocities, spins = [], [], []
    origin = simulation.positions
    for _ in range(count):
        steps(simulation, 1, time_step, damping=damping)
        displacements.append((simulation.positions - origin)[0, 0])
        velocities.append(simulation.velocities[0, 0])
        spins.append(simulation.spins[0, 0])
    return np.array(displacements), np.array(velocities), np.array(spins)


RING_MASS = masses(np.array([1.0]), 1.0)[0]
RING_INERTIA = 0.4 * RING_MASS
RING_KN = normal_stiffness((1.0, 1.0))
RING_KM = 0.2 * 0.3 * RING_KN


@pytest.mark.parametrize("damping", [0.0, 0.2, 0.9])
def test_cundall_damping_of_an_oscillating_contact_is_its_recurrence(damping, precision):
    # a (1 - zeta sign(a (u + a dt / 2))), for translation and for spin alike. The memory of twisting takes its increment from the spin that led to a force
    # pass, the first one included; the spheres' centres do not move before it.
    time_step, count, overlap = 1e-4, 2000, 0.01
    kick = {"float64": 1e-4, "float32": 4.0}[precision]  # such that the forces it makes stand out from the roundings of those at rest, below
    _, velocities, spins = oscillation(precision, damping, time_step, count, amplitude=kick)

    def recurrence(squared_frequency, start):
        x, u, path = start, kick, []
        for _ in range(count):
            a = -squared_frequency * x
            u += time_step * a * (1 - damping * np.sign(a * (u + 0.5 * time_step * a)))
            x += time_step * u
            path.append(u)
        return np.array(path)

    expected = recurrence(3 * RING_KN / RING_MASS, 0.0)
    # Overlaps are rounded at the cell's size, and forces in the precision; the force that makes is felt for the whole time.
    noise = 3 * RING_KN / RING_MASS * (10 * ROUNDING * CELL + rounding(precision) * overlap) * time_step * count
    assert np.ptp(expected[: count // 4]) > 1e3 * noise
    assert np.allclose(velocities, expected, rtol=0, atol=noise)
    expected = recurrence(3 * RING_KM / RING_INERTIA, kick * time_step)
    # Where a swing turns, and where it has died away, roundings choose the sign: what that moves is small against the first swing. Each step rounds it, too.
    assert np.allclose(spins, expected, rtol=0, atol=(1e-7 + 2 * count * rounding(precision)) * kick)


def test_cundall_damping_leaves_a_share_of_the_amplitude_each_half_period(precision):
    # Speeding up with 1 - zeta and slowing down with 1 + zeta: a swing from A ends at A sqrt((1 - zeta) / (1 + zeta)), after
    # pi / (2 omega) (1 / sqrt(1 - zeta) + 1 / sqrt(1 + zeta)).
    damping = 0.2
    omega = np.sqrt(3 * RING_KN / RING_MASS)
    time_step = 1e-3 / omega
    displacements, _, _ = oscillation(precision, damping, time_step, 20_000, amplitude=1e-4 * omega)
    turns = 1 + np.flatnonzero(np.diff(np.sign(np.diff(displacements))))
    swings = np.abs(displacements[turns])
    assert len(swings) >= 6
    # The switch from one to the other is found only at a step: omega dt of a swing's time, and less of its energy.
    assert np.allclose(swings[1:] / swings[:-1], np.sqrt((1 - damping) / (1 + damping)), rtol=1e-3, atol=0)
    half_period = np.pi / (2 * omega) * (1 / np.sqrt(1 - damping) + 1 / np.sqrt(1 + damping))
    assert np.allclose(np.diff(turns) * time_step, half_period, rtol=0, atol=2 * time_step)


def test_damping_opposes_the_fluctuation_and_not_the_cell(precision):
    # Two spheres carried apart by the cell at rest against it: what acts on them first is the same whatever the cell does.
    kicks = []
    for gradient in (STILL, SHEARED):
        simulation = two_spheres(density=1.0, precision=precision)
        steps(simulation, 1, 1e-5, gradient, damping=0.9)
        kicks.append(simulation.velocities)
    assert np.array_equal(*kicks)
