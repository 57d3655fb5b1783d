"""What makes a run shorter, each by its law: the bound on the time step that looks at both grains of a contact, masses that do not go with the volume, and
ramps of the strain rate. With the options at their defaults nothing changes, which the other tests of the engine see."""

import numpy as np
import pytest

from graincal import _native, demo
from graincal.dem.batch import run_batch
from graincal.dem.stress_path import drained_triaxial

from .spheres import law, masses, normal_stiffness, ring, two_spheres

SAFETY = 0.84
CONTACT = _native.Economy(shared_bound=True)
# A force pass or two, a sum and a root: roundings.
EXACT = 1e-13


def first_time_step(simulation, damping=0.0):
    simulation.run(1, damping)
    return simulation.time_step


# The time step's bound


def test_the_bound_of_two_spheres_alone_is_exact_along_their_normal():
    # Without shear the only motion is w^2 = kn (1/m1 + 1/m2), which a leapfrog follows up to w dt = 2.
    radii = (1.0, 0.6)
    simulation = two_spheres(radii, density=2.0, stiffness_ratio=0.0, rolling_stiffness=0.0, economy=CONTACT)
    frequency = np.sqrt(normal_stiffness(radii) * (1 / masses(1.0, 2.0) + 1 / masses(0.6, 2.0)))
    assert first_time_step(simulation) == pytest.approx(SAFETY * 2 / frequency, rel=EXACT)


@pytest.mark.parametrize("ratio", [0.2, 0.3, 0.4, 0.5, 0.7, 1.0])
@pytest.mark.parametrize("radii", [(1.0, 1.0), (1.0, 0.6), (1.0, 0.1)], ids=str)
def test_the_step_of_two_spheres_that_slip_and_turn_is_stable(radii, ratio):
    # Slip by ks alone moves and turns both: w^2 = ks sum (1/m + r^2/I) = 7/2 ks (1/m1 + 1/m2), above the frequency of either alone.
    simulation = two_spheres(radii, density=2.0, stiffness_ratio=ratio, rolling_stiffness=0.0, economy=CONTACT)
    mobility = 1 / masses(radii[0], 2.0) + 1 / masses(radii[1], 2.0)
    stiffness = normal_stiffness(radii) * max(1.0, 3.5 * ratio)
    assert first_time_step(simulation) < 2 / np.sqrt(stiffness * mobility)


def test_the_bound_of_a_ring_is_below_its_limit_by_the_root_of_three_quarters():
    # The fastest motion of three equal masses on a ring has w^2 = 3 kn / m; its bound is 4 kn / m, each contact's of the two stiffnesses about both ends.
    simulation = ring(stiffness_ratio=0.0, rolling_stiffness=0.0, density=2.0, economy=CONTACT)
    limit = 2 / np.sqrt(3 * normal_stiffness((1.0, 1.0)) / masses(1.0, 2.0))
    assert first_time_step(simulation) == pytest.approx(SAFETY * np.sqrt(3 / 4) * limit, rel=EXACT)


def test_damping_that_strengthens_forces_makes_the_step_shorter():
    # Braking forces are 1 + zeta times what they are: stiffness is, as the step sees it.
    undamped, damped = (first_time_step(ring(density=2.0, economy=CONTACT), damping) for damping in (0.0, 0.9))
    assert damped == pytest.approx(undamped / np.sqrt(1.9), rel=EXACT)


def largest_stable_step(simulation, contact_law):
    """2 / w of the fastest motion of a packing held by the springs of its contacts, by power iteration; nothing slides."""
    contacts, radii = simulation.contacts(), simulation.radii
    first, second, normal = (contacts[name] for name in ("first", "second", "normal"))
    modulus, ratio, beta = contact_law
    product = radii[first] * radii[second]
    kn = 2 * modulus * product / (radii[first] + radii[second])
    ks, km = ratio * kn, beta * product * ratio * kn
    mass = masses(radii, 2.65e6)
    roots = np.sqrt(mass)[:, None], np.sqrt(0.4 * mass * radii**2)[:, None]

    def at_particles(index, terms):
        return np.stack([np.bincount(index, terms[:, k], len(radii)) for k in range(3)], axis=1)

    x = np.random.default_rng(1).normal(size=(len(radii), 6))
    for _ in range(300):
        velocity, spin = x[:, :3] / roots[0], x[:, 3:] / roots[1]
        arm1, arm2 = radii[first][:, None], radii[second][:, None]
        slip = velocity[second] - velocity[first] - np.cross(arm2 * spin[second] + arm1 * spin[first], normal)
        along = np.sum(slip * normal, axis=1, keepdims=True) * normal
        force = -(kn[:, None] * along + ks[:, None] * (slip - along))
        moment = -km[:, None] * (spin[second] - spin[first])
        lever = np.cross(normal, force)
        forces = at_particles(second, force) - at_particles(first, force)
        torques = at_particles(second, moment - arm2 * lever) - at_particles(first, arm1 * lever + moment)
        pushed = -np.concatenate([forces / roots[0], torques / roots[1]], axis=1)
        squared_frequency = np.linalg.norm(pushed) / np.linalg.norm(x)
        x = pushed / np.linalg.norm(pushed)
    return 2 / np.sqrt(squared_frequency)


CORNERS = [(1e9, 0.2, 0.0), (1e9, 0.5, 1.0), (1e11, 0.2, 0.1), (1e11, 0.5, 1.0), (1e7, 0.2, 0.1), (1e7, 0.5, 1.0)]


@pytest.mark.parametrize("corner", CORNERS)
@pytest.mark.parametrize("friction", [0.0, np.tan(np.radians(60))])
def test_packings_move_without_gain_of_energy_at_a_step_below_their_limit(packing, corner, friction):
    modulus, ratio, beta = corner
    simulation = _native.Simulation(packing.positions, packing.radii, packing.edges, law(modulus, ratio, friction, beta, 1.0), 2.65e6, economy=CONTACT)
    still = [_native.AxisGoal(False, 0.0, 1.0)] * 3
    simulation.set_goals(still)
    simulation.run(1, 0.0)
    speed = 1e-3 * np.sqrt(2 * simulation.elastic_energy / masses(packing.radii, 2.65e6).sum())
    simulation.set_velocities(speed * np.random.default_rng(2).normal(size=packing.positions.shape))
    energies = []
    for _ in range(20):
        simulation.run(100, 0.0)
        energies.append(simulation.kinetic_energy + simulation.elastic_energy)
    # Whoever slides does not hold: springs that all hold are stiffer than any state of the packing.
    assert simulation.time_step < largest_stable_step(simulation, corner)
    # A leapfrog's energy swings with the velocities' half step, the more the nearer the limit; a motion beyond the limit would grow by orders of magnitude.
    assert np.mean(energies[10:]) < 1.02 * np.mean(energies[:10])


# Masses


@pytest.mark.parametrize("exponent", [0.0, 1.0, 2.0])
def test_masses_go_with_a_power_of_the_radius_and_the_whole_weighs_the_same(packing, exponent):
    simulation = _native.Simulation(packing.positions, packing.radii, packing.edges, law(1e9), 2.65e6, economy=_native.Economy(mass_exponent=exponent))
    expected = packing.radii**exponent * (masses(packing.radii, 2.65e6).sum() / np.sum(packing.radii**exponent))
    simulation.run(1, 0.0)
    pushes = np.linalg.norm(simulation.forces, axis=1) * simulation.time_step
    speeds = np.linalg.norm(simulation.velocities, axis=1)
    # From rest, u = f dt / m; grains without contact are not moved.
    pushed = pushes > 0
    assert np.count_nonzero(pushed) > 50
    assert np.allclose(pushes[pushed], expected[pushed] * speeds[pushed], rtol=1e-12, atol=0)


def test_small_grains_do_not_limit_the_step_where_masses_go_with_the_radius():
    # Stiffness goes with about the radius: of a chain of a large and a small grain, the small one's frequency is then that of the large one.
    steps = {}
    for exponent in (3.0, 1.0):
        economy = _native.Economy(mass_exponent=exponent)
        for small in (0.5, 0.1):
            simulation = two_spheres((1.0, small), 0.001, density=2.0, stiffness_ratio=0.0, rolling_stiffness=0.0, economy=economy)
            steps[exponent, small] = first_time_step(simulation)
    # kn of the pair falls as s / (1 + s), the small grain's mass as s^3, or as (1 + s^3) s / (1 + s).
    assert steps[3.0, 0.1] / steps[3.0, 0.5] == pytest.approx(np.sqrt((0.1**3 / (0.1 / 1.1)) / (0.5**3 / (0.5 / 1.5))), rel=1e-12)
    assert steps[1.0, 0.1] / steps[1.0, 0.5] == pytest.approx(np.sqrt((1 + 0.1**3) / (1 + 0.5**3)), rel=1e-12)


@pytest.mark.parametrize("exponent", [3.0, 1.0])
def test_contacts_that_have_only_begun_take_steps_by_the_densities_that_grains_have(exponent):
    # Twenty times half the time of a wave through a grain, r sqrt(rho / E): a Hertz contact without overlap has no stiffness to go by.
    radii = np.array([1.0, 0.1])
    simulation = two_spheres(radii, 1e-12, density=2.0, kind="hertz-mindlin", modulus=1e7, economy=_native.Economy(mass_exponent=exponent))
    own = radii**exponent * (masses(radii, 2.0).sum() / np.sum(radii**exponent))
    densities = 2.0 * own / masses(radii, 2.0)
    assert first_time_step(simulation) == pytest.approx(10 * np.min(radii * np.sqrt(densities / 1e7)), rel=EXACT)


def test_the_moment_of_inertia_is_scaled():
    # A packing whose rotation limits the step: R / I, and the step with the root of the factor.
    plain, heavy = (
        first_time_step(ring(stiffness_ratio=0.8, rolling_stiffness=0.5, density=2.0, economy=_native.Economy(inertia_factor=factor))) for factor in (1.0, 1.2)
    )
    assert heavy == pytest.approx(np.sqrt(1.2) * plain, rel=EXACT)


# Ramps


def ramped_goal(simulation, target, rate, ramp):
    acceleration = rate**2 / (2 * ramp * abs(target))
    simulation.set_goals([_native.AxisGoal(False, 0.0, rate)] * 2 + [_native.AxisGoal(False, target, rate, acceleration)])
    return acceleration


@pytest.mark.parametrize("target", [0.01, -0.01])
@pytest.mark.parametrize("ramp", [0.1, 0.5])
def test_a_ramped_strain_is_reached_exactly_and_never_faster_than_its_largest_rate(target, ramp):
    simulation = two_spheres()
    simulation.run(1, 0.2)
    time_step = simulation.time_step
    rate = 1e-2 * abs(target) / time_step  # a hundred steps at full rate
    simulation.restart_strain()
    edge = simulation.edges[2, 2]
    acceleration = ramped_goal(simulation, target, rate, ramp)
    rates, strains = [0.0], []
    for _ in range(260):
        simulation.run(1, 0.2)
        rates.append(-np.sign(target) * simulation.velocity_gradient[2, 2])
        strains.append(np.log(edge / simulation.edges[2, 2]))
    rates = np.array(rates)
    assert strains[-1] == pytest.approx(target, abs=1e-12)
    # Steps add strain where the logarithm is meant: half a step's square is corrected by the next.
    assert np.all(np.abs(strains) <= abs(target) * (1 + 1e-4))
    assert rates.max() <= rate
    assert np.abs(np.diff(rates)).max() <= acceleration * time_step * (1 + 1e-6)
    # Both ramps cover their share of the strain at half the rate: the way takes 1 + 2 s times as long as at full rate, to a few steps at its end.
    taken = np.argmax(np.abs(np.array(strains) - target) < 1e-6) + 1
    assert taken == pytest.approx(100 * (1 + 2 * ramp), abs=8)
    if ramp == 0.1:
        assert np.count_nonzero(rates == rate) > 50


# Whole paths


def test_each_option_comes_to_the_same_strains_at_rest():
    packing = demo.packing()
    strains = [0.0, 0.004, 0.008]
    options = [{}, {"shared_bound": True}, {"mass_exponent": 1.0}, {"settling_damping": 0.4}, {"strain_ramp": 0.2}, {"inertia_factor": 2.0}]
    steps = []
    for option in options:
        (run,) = run_batch(
            packing, [law(5e8, 0.2, 0.5, 0.1, 0.3)], drained_triaxial(1e5, strains), density=2.65e6, expected_steps=[1], threads=1, step_limit=100_000,
            economy=_native.Economy(**option),
        )  # fmt: skip
        assert run.status == "finished" and not run.columns["flagged"].any()
        assert np.allclose(run.columns["strain_z"], strains, rtol=0, atol=1e-6)
        assert np.all(run.columns["unbalanced_force"] < 1e-3)
        steps.append(run.steps)
    plain, contact, mass, settling = steps[:4]
    assert contact < plain and mass < plain and settling < plain
