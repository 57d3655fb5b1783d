"""The servo: each axis is driven to a stress or to a strain, by the formulas of YADE's PeriTriaxController with a dynamic cell."""

import numpy as np
import pytest

from graincal import _native

from .spheres import IMMOVABLE, ROUNDING, law, two_spheres

PRESSURE = 1e5  # what the packing was made at


def stress_goal(target=PRESSURE, largest_rate=1.0):
    return _native.AxisGoal(True, target, largest_rate)


def strain_goal(target, largest_rate=1.0):
    return _native.AxisGoal(False, target, largest_rate)


def simulation_of(packing, precision="float64", density=2.65e6, scale=1.0):
    grains = law(modulus=1e9, friction=0.4)
    return _native.Simulation(scale * packing.positions, scale * packing.radii, scale * packing.edges, grains, density, precision=precision)


def test_a_stress_is_sought_with_the_damped_acceleration_and_the_rate_is_clipped(packing, precision):
    # rate += (1 - 0.25 sign(rate * excess)) dt excess / M: a cell of inertia M pushed by the excess of stress, more slowly the way it already goes.
    # M = c rho V^(2/3), with c such that M is the particles' mass in kg on the 2000-particle packing of Hartmann, Cheng, Thornton (2022).
    density, limit = 2.65e6, 0.3
    simulation = simulation_of(packing, precision, density)
    inertia = 0.0374963 * density * packing.volume ** (2 / 3)
    targets = np.array([3.0, 0.7, 1.05]) * PRESSURE
    simulation.set_goals([stress_goal(target, limit) for target in targets])
    rate, clipped, free = np.zeros(3), 0, 0
    for _ in range(300):
        simulation.run(1, 0.2)
        excess = simulation.stress_diagonal[0] - targets
        wanted = rate + (1 - 0.25 * np.sign(rate * excess)) * simulation.time_step * excess / inertia
        rate = np.diag(simulation.velocity_gradient)
        # The factor above has six digits; a step's change of rate is less than twice the limit here.
        assert np.allclose(rate, np.clip(wanted, -limit, limit), rtol=0, atol=4e-6 * limit)
        clipped += np.count_nonzero(np.abs(rate) == limit)
        free += np.count_nonzero(np.abs(rate) < limit)
    assert clipped > 50 and free > 50
    assert np.array_equal(simulation.velocity_gradient, np.diag(rate))


def test_the_inertia_scales_with_the_sample(packing):
    # The same sample with all lengths doubled: stresses are the same, times and the inverses of rates double, strains are the same step by step. YADE's
    # mass of all particles in kg would not do as inertia: it grows with the cube of the lengths where the square is meant.
    small, large = simulation_of(packing), simulation_of(packing, scale=2.0)
    small.set_goals([stress_goal(2 * PRESSURE, 1.0)] * 3)
    large.set_goals([stress_goal(2 * PRESSURE, 0.5)] * 3)
    for simulation in (small, large):
        simulation.run(200, 0.2)
    # Factors of two are exact; what is left is the volume's power 2/3, rounded, and carried through 200 steps.
    assert np.allclose(large.edges, 2 * small.edges, rtol=1e-9, atol=0)
    assert np.allclose(large.stress_diagonal, small.stress_diagonal, rtol=1e-6, atol=0)
    assert np.allclose(large.velocity_gradient, 0.5 * small.velocity_gradient, rtol=0, atol=1e-6)


def test_stresses_reach_their_targets(packing, precision):
    simulation = simulation_of(packing, precision)
    targets = np.array([1.0, 1.3, 1.6]) * PRESSURE
    simulation.set_goals([stress_goal(target) for target in targets])
    for _ in range(2000):
        simulation.run(10, 0.2)
        if np.allclose(simulation.stress_diagonal[0], targets, rtol=1e-3, atol=0) and simulation.unbalanced_force < 1e-3:
            return
    pytest.fail(f"after {simulation.steps} steps the stresses are {simulation.stress_diagonal[0]} and not {targets}")


@pytest.mark.parametrize("target", [0.0203, -0.0203])
def test_a_strain_is_reached_at_the_constant_largest_rate_and_held(target, precision):
    # The largest rate, one step for what is left, then zero. The step is taken with 1 - strain where the logarithm says exp(-strain): half the square of the
    # last step is corrected in the step after.
    simulation = two_spheres(density=IMMOVABLE, precision=precision)
    simulation.run(1, 0.2)  # finds its time step
    time_step, edges = simulation.time_step, simulation.edges
    rate = 1e-3 / time_step
    simulation.restart_strain()
    simulation.set_goals([strain_goal(0.0), strain_goal(0.0), strain_goal(target, rate)])

    def strain():
        return np.log(edges[2, 2] / simulation.edges[2, 2])

    full_steps = int(abs(target) / -np.log1p(-np.sign(target) * 1e-3) * np.sign(target))
    for k in range(1, full_steps + 1):
        simulation.run(1, 0.2)
        assert simulation.velocity_gradient[2, 2] == -np.sign(target) * rate
        assert strain() == pytest.approx(-k * np.log1p(-np.sign(target) * 1e-3), rel=1e3 * ROUNDING)
    simulation.run(1, 0.2)
    assert 0 < abs(simulation.velocity_gradient[2, 2]) < rate
    assert strain() == pytest.approx(target, abs=0.5 * 1e-3**2)
    simulation.run(2, 0.2)
    assert strain() == pytest.approx(target, abs=10 * ROUNDING)
    simulation.run(1, 0.2)
    assert abs(simulation.velocity_gradient[2, 2]) * time_step < 10 * ROUNDING
    # The other axes had nowhere to go.
    assert simulation.edges[0, 0] == edges[0, 0] and simulation.edges[1, 1] == edges[1, 1]


def test_strains_count_from_where_they_were_restarted(precision):
    simulation = two_spheres(density=IMMOVABLE, precision=precision)
    simulation.run(1, 0.2)
    simulation.set_goals([strain_goal(0.01, 1e-3 / simulation.time_step)] * 3)
    simulation.run(20, 0.2)
    first = simulation.edges
    simulation.restart_strain()
    simulation.run(20, 0.2)
    assert np.allclose(np.diag(simulation.edges), np.diag(first) * np.exp(-0.01), rtol=100 * ROUNDING, atol=0)
