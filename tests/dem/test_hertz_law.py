"""Hertz-Mindlin: what an elastic contact does that linear springs do not. What the laws share is in test_pair_forces.py."""

import json
from pathlib import Path

import numpy as np
import pytest

from graincal import Response, TriaxialTest, _native, demo

from .spheres import ROUNDING, closed_form, exact, law, masses, only_contact, steps, two_spheres, unit

RADII = (1.0, 0.7)
KIND = "hertz-mindlin"
TIME_STEP = 1e-3


def hertz(overlap, radii=RADII, **options):
    return two_spheres(radii, overlap, kind=KIND, **options)


def hertz_form(overlap, radii=RADII, **options):
    return closed_form(KIND, radii, overlap, **options)


def load(simulation):
    """A shear force and both moments, all sticking."""
    simulation.set_spins(np.array([[-0.3, 0.2, 0.1], [0.3, -0.2, 0.3]]))
    steps(simulation, 20, TIME_STEP)
    simulation.set_spins(np.zeros((2, 3)))
    return only_contact(simulation)


def part(simulation, distance, count):
    """Move the spheres apart along x by `distance` (m) in `count` steps, and find the forces there."""
    simulation.set_velocities(np.array([[0.0, 0, 0], [distance / (count * TIME_STEP), 0, 0]]))
    steps(simulation, count, TIME_STEP)
    simulation.set_velocities(np.zeros((2, 3)))
    steps(simulation, 1, TIME_STEP)
    return only_contact(simulation)


STORED = ("shear", "bending", "twisting")

YADE = Path(__file__).parents[1] / "data" / "yade_hertz_pair.csv"


# Stiffness


@pytest.mark.parametrize("poisson_ratio", [0.0, 0.2, 0.49])
@pytest.mark.parametrize("radii", [(1.0, 1.0), (0.3, 1.2)])
@pytest.mark.parametrize("overlap", [1e-5, 1e-3, 0.1])
def test_tangential_stiffness_is_mindlins_at_each_overlap(poisson_ratio, radii, overlap, precision):
    simulation = hertz(overlap, radii, stiffness_ratio=poisson_ratio, precision=precision)
    simulation.set_spins(np.array([[0.0, 0, 1], [0, 0, 1]]))
    steps(simulation, 1, TIME_STEP)
    expected = hertz_form(overlap, radii, ratio=poisson_ratio)
    # The overlap is a difference of lengths of the cell's size.
    assert only_contact(simulation)["shear"][1] == pytest.approx(expected.shear * sum(radii) * TIME_STEP, rel=exact(precision, overlap))
    # Mindlin's ratio of the tangents depends on Poisson's ratio alone.
    assert expected.shear / expected.normal == pytest.approx(2 * (1 - poisson_ratio) / (2 - poisson_ratio), rel=10 * ROUNDING)


def test_the_normal_stiffness_is_the_tangent_of_the_normal_force():
    # The time step shows the stiffness; the forces at two overlaps their secant, which leaves the tangent by (h / un)^2 / 24 at most.
    radii, overlap, h = (1.0, 1.0), 0.01, 1e-5
    forces = [hertz_force(radii, overlap + sign * h / 2) for sign in (-1, 1)]
    simulation = hertz(overlap, radii, density=1.0, stiffness_ratio=0.49, rolling_stiffness=0.0)
    simulation.run(1, 0.0)
    # Along x kn holds a mass, and its rotation is held by ks r^2: with Poisson's ratio of 0.49 ks / kn is 0.675, above the 2/5 of the inertia.
    ratio = 2 * (1 - 0.49) / (2 - 0.49)
    stiffness = 2 * 0.64 * masses(1.0, 1.0) / simulation.time_step**2 * 0.4 / ratio
    assert stiffness == pytest.approx((forces[1] - forces[0]) / h, rel=1e-6)


def hertz_force(radii, overlap):
    simulation = hertz(overlap, radii, stiffness_ratio=0.49)
    steps(simulation, 1)
    return only_contact(simulation)["force"][0]


def test_forces_on_a_path_are_yades():
    # Two spheres that close in on each other, stick, slide, turn back and slide (tests/data/SOURCES.md). Both take the same sums in other orders, over positions
    # that each of 160 steps rounds at the cell's size.
    about = json.loads(YADE.read_text().splitlines()[0].removeprefix("#"))
    rows = iter(np.loadtxt(YADE, delimiter=",", skiprows=2))
    simulation = two_spheres(
        about["radii"], about["overlap"], about["normal"], modulus=about["young"], stiffness_ratio=about["poisson"], friction=about["friction"],
        rolling_stiffness=0.0, rolling_strength=0.0, edges=np.diag([about["cell"]] * 3), kind=KIND,
    )  # fmt: skip
    slides = []
    for count, velocity, *spins in about["legs"]:
        simulation.set_velocities(np.array([[0.0, 0, 0], velocity]))
        simulation.set_spins(np.array(spins))
        for _ in range(count // 4):
            steps(simulation, 4, about["time_step"])
            yade, contact = next(rows), only_contact(simulation)
            near = 160 * ROUNDING * about["cell"] / about["overlap"]
            assert contact["overlap"] == pytest.approx(yade[0], rel=near)
            force = np.linalg.norm(yade[1:4])
            assert np.allclose(contact["force"] - contact["shear"], yade[1:4], rtol=0, atol=near * force)
            assert np.allclose(contact["shear"], yade[4:], rtol=0, atol=near * force)
            slides.append(np.linalg.norm(yade[4:]) > 0.3999 * force)
    assert 5 < sum(slides) < len(slides) - 5 and next(rows, None) is None


# Time step


@pytest.mark.parametrize("beta", [0.0, 0.5])
def test_the_critical_step_of_two_touching_grains(beta, precision):
    radii, overlap, density = (1.0, 0.6), 0.01, 2.0
    k = hertz_form(overlap, radii, rolling_stiffness=beta)
    mass = masses(0.6, density)
    rotation = 0.4 * mass * 0.36 / (k.shear * 0.36 + k.rolling)
    simulation = hertz(overlap, radii, density=density, rolling_stiffness=beta, precision=precision)
    simulation.run(1, 0.0)
    # Poisson's ratio is 0.3: ks / kn = 0.82, so it is the smaller sphere's rotation that limits.
    assert rotation < mass / k.normal
    assert simulation.time_step == pytest.approx(0.8 * np.sqrt(2 * rotation), rel=exact(precision, overlap))


def test_a_first_touch_asks_for_no_longer_step_than_the_bound(precision):
    # At an overlap of 1e-12 the critical step is a hundred times that of a working contact; nothing says that the next overlap is as small.
    simulation = hertz(1e-12, (1.0, 1.0), density=2.0, precision=precision)
    wave_time = simulation.time_step
    simulation.run(1, 0.0)
    assert simulation.time_step == pytest.approx(20 * wave_time, rel=10 * ROUNDING)


# Energy


def test_a_collision_is_the_one_of_hertz(precision):
    # Largest overlap (15 m v^2 / (16 E* sqrt(r*)))^(2/5) and duration 2.9433 of it over v (Johnson 1985, section 11.4); what comes out is what went in.
    density, speed, normal = 1.0, 1.0, (1, 2, 2)
    mass = masses(np.array(RADII), density)
    reduced_mass, reduced_radius = mass[0] * mass[1] / mass.sum(), RADII[0] * RADII[1] / sum(RADII)
    contact_modulus = 1e7 / (2 * (1 - 0.3**2))
    deepest = (15 * reduced_mass * speed**2 / (16 * contact_modulus * np.sqrt(reduced_radius))) ** 0.4
    duration, count = 2.9432750 * deepest / speed, 1000
    time_step = duration / count
    simulation = two_spheres(RADII, 0.0, normal, density=density, friction=0.0, kind=KIND, precision=precision)
    simulation.set_velocities(np.ascontiguousarray(np.outer([reduced_mass / mass[0], -reduced_mass / mass[1]], speed * unit(normal))))
    energy = simulation.kinetic_energy
    overlaps = []
    for _ in range(count + 5):
        steps(simulation, 1, time_step)
        contact = only_contact(simulation)
        overlaps.append(contact["overlap"] if contact else 0.0)
    # The leapfrog is wrong by shares of (omega dt)^2, omega of about pi / duration: 1e-5.
    assert max(overlaps) == pytest.approx(deepest, rel=1e-4)
    assert simulation.kinetic_energy == pytest.approx(energy, rel=1e-4)
    assert np.count_nonzero(overlaps) == pytest.approx(count, abs=2)


def test_unloading_scales_what_is_stored_down_with_the_stiffness_and_loading_keeps_it(precision):
    overlap = 0.01
    simulation = hertz(overlap, precision=precision)
    loaded = load(simulation)
    near = 1e-9 + exact(precision, 0.25 * overlap, count=80)
    opened = part(simulation, 0.75 * overlap, 30)
    for name in STORED:  # the stiffness goes with the root of the overlap
        assert np.allclose(opened[name], 0.5 * loaded[name], rtol=0, atol=near * np.linalg.norm(loaded[name])), name
    closed = part(simulation, -0.75 * overlap, 30)
    for name in STORED:
        assert np.allclose(closed[name], opened[name], rtol=0, atol=near * np.linalg.norm(loaded[name])), name


def test_a_slip_out_deep_and_back_shallow_loses_energy(precision):
    # Slip s at the overlap u1, unload to u2, slip back, load again. The spring keeps its stretch, so the way back unloads it exactly, and what unloading took
    # is lost: k1 s^2 / 2 (1 - sqrt(u2 / u1)). With the force kept instead, sliding back against k2 < k1 would give back k1 s^2 / 2 (2 - sqrt(u2 / u1)).
    deep, shallow, count = 0.01, 0.0025, 40
    simulation = hertz(deep, precision=precision)
    near = 1e-9 + exact(precision, shallow, count=2 * count + 60)
    rate = 0.1
    spent = 0.0

    def slip(sign):
        nonlocal spent
        simulation.set_spins(np.full((2, 3), [0, 0, sign * rate]))
        before = only_contact(simulation)["shear"] if simulation.steps else np.zeros(3)
        for _ in range(count):
            steps(simulation, 1, TIME_STEP)
            after = only_contact(simulation)["shear"]
            spent += 0.5 * (before + after)[1] * sign * rate * sum(RADII) * TIME_STEP
            before = after
        simulation.set_spins(np.zeros((2, 3)))

    slip(1)
    stretch = rate * sum(RADII) * count * TIME_STEP
    stored = hertz_form(deep).shear * stretch**2 / 2
    assert spent == pytest.approx(stored, rel=near)
    assert simulation.elastic_energy == pytest.approx(hertz_form(deep).energy + stored, rel=near)
    part(simulation, deep - shallow, 30)
    assert simulation.elastic_energy == pytest.approx(hertz_form(shallow).energy + 0.5 * stored, rel=near)
    slip(-1)
    back = part(simulation, shallow - deep, 30)
    assert np.linalg.norm(back["shear"]) < near * hertz_form(deep).shear * stretch
    assert spent == pytest.approx(0.5 * stored, rel=near)


@pytest.mark.parametrize("strength", [1e9, 0.3], ids=["sticking", "sliding"])
def test_no_path_gains_energy(strength, precision):
    # Random slips, rolls, twists, openings and closings along a fixed normal. Whatever was spent on the contact is stored or lost: the energy never exceeds it.
    # Work is summed by the mean of the forces at both ends of a step. A stiffness that changes by a share d in a step is wrong there by a share d of the work of
    # the slip: d is at most half a percent (2e-5 m of an overlap of 2e-3 m or more), mostly a tenth of that, and of either sign: a fifth of a percent in all.
    generator = np.random.default_rng(5)
    simulation = hertz(0.01, friction=strength, rolling_strength=strength, precision=precision)
    steps(simulation, 1, TIME_STEP)
    overlap, before = 0.01, only_contact(simulation)
    start = energy = peak = simulation.elastic_energy
    spent, lost, most = 0.0, 0.0, -np.inf
    for _ in range(60):
        target = generator.uniform(0.002, 0.02)
        count = int(np.ceil(abs(target - overlap) / 2e-5))
        spins = generator.normal(0, 0.02, (2, 3))
        spins[1, 0] = -spins[0, 0]  # together about the normal, spheres would turn the memory
        simulation.set_spins(spins)
        simulation.set_velocities(np.array([[0.0, 0, 0], [(overlap - target) / (count * TIME_STEP), 0, 0]]))
        slip = -TIME_STEP * np.cross(RADII[0] * spins[0] + RADII[1] * spins[1], [1, 0, 0])
        turn = TIME_STEP * (spins[1] - spins[0])
        for _ in range(count):
            steps(simulation, 1, TIME_STEP)
            after = only_contact(simulation)
            mean = {name: 0.5 * (before[name] + after[name]) for name in STORED}
            spent -= mean["shear"] @ slip + (mean["bending"] + mean["twisting"]) @ turn
            normal = 0.5 * ((before["force"] - before["shear"])[0] + (after["force"] - after["shear"])[0])
            spent += normal * (after["overlap"] - before["overlap"])
            before, energy = after, simulation.elastic_energy
            peak = max(peak, energy)
            most = max(most, energy - start - spent)
        overlap = target
        lost = start + spent - energy
    assert most < 2e-3 * peak
    assert lost > 0.1 * peak


# A packing


def strain_under(kind, pressure):
    """Volumetric strain of the embedded packing at rest under an isotropic pressure."""
    grains = demo.packing()
    grains_law = law(10**10.5, 0.2, np.tan(np.radians(30)), 0.1, 0.5, kind=kind)
    simulation = _native.Simulation(grains.positions, grains.radii, grains.edges, grains_law, 2.65e6)
    simulation.set_goals([_native.AxisGoal(True, pressure, 1.0)] * 3)
    simulation.run(100, 0.2)
    while not (np.allclose(simulation.stress_diagonal, pressure, rtol=1e-3) and simulation.unbalanced_force < 1e-3):
        simulation.run(10, 0.2)
        assert simulation.steps < 20_000
    return np.log(grains.volume / np.linalg.det(simulation.edges))


def test_the_strain_of_a_packing_goes_with_the_pressure_to_the_power_of_two_thirds():
    # As overlaps do, as long as the same contacts carry; the ones that close on the way take something off. Linear springs have a power of one.
    power = np.log(strain_under(KIND, 8e5) / strain_under(KIND, 1e5)) / np.log(8)
    assert 0.6 < power <= 2 / 3
    assert np.log(strain_under("linear", 8e5) / strain_under("linear", 1e5)) / np.log(8) > 0.8


def test_a_triaxial_test_is_at_rest_at_each_state():
    strains = [0.0, 0.004, 0.008, 0.02]
    test = TriaxialTest(demo.packing(), 1e5, law=KIND, step_limit=300_000)
    (outcome,) = test.simulate([[10.8, 0.2, 30.0, 0.1, 0.5]], at=strains, threads=1)
    assert isinstance(outcome, Response) and outcome.details["flagged"] == 0
    curve = outcome.values
    assert np.all(curve["unbalanced_force"] < 1e-3) and np.allclose(curve["axial_strain"], strains, rtol=0, atol=1e-6)
    assert curve["stress_ratio"][0] == pytest.approx(1, abs=2e-3)
    # Dense, and of stiff grains: it carries more than their friction alone, (1 + sin phi) / (1 - sin phi) = 3, and dilates; it was isostatic at the least.
    assert np.all(curve["stress_ratio"][1:] > 3) and curve["void_ratio"][-1] > curve["void_ratio"][0]
    assert 4 < curve["coordination_number"][0] < 6
    assert np.all(curve["a_c"][1:] > 0) and np.all(curve["a_n"][1:] > 0)
