"""The neighbour lists change nothing: the engine finds the contacts, and keeps the histories, that a search over all pairs does."""

from dataclasses import astuple

import numpy as np
import pytest

from graincal import _native

from .all_pairs import AllPairs, Parameters, nearest_branches
from .spheres import IMMOVABLE, ROUNDING, STILL, jittered_lattice, law, rounding, steps

# The lists' gaps as shares of the mean radius: the geometry below is chosen by them, and the near list is held to its promise.
OUTER_GAP, NEAR_GAP = 0.60, 0.02

SHEAR = np.array([[-0.4, 0.9, 0.2], [0.0, 0.5, -0.7], [0.3, 0.0, -0.3]])
PARAMETERS = Parameters(modulus=1e7, stiffness_ratio=0.3, friction=0.4, rolling_stiffness=0.2, rolling_strength=0.3)
NAMES = ("force", "normal", "shear", "bending", "twisting", "overlap")


def pairs_closer_than(gap, positions, radii, edges):
    """All pairs (i < j) whose surfaces are closer than gap, as a set: the N^2 answer."""
    first, second = np.triu_indices(len(radii), 1)
    distance = np.linalg.norm(nearest_branches(positions, edges, first, second), axis=1)
    close = distance < radii[first] + radii[second] + gap
    return set(zip(first[close].tolist(), second[close].tolist()))


def as_set(first, second):
    found = set(zip(first.tolist(), second.tolist()))
    assert len(found) == len(first), "a pair has two slots"
    return found


def cloud(count, radii, width, seed):
    return np.random.default_rng(seed).uniform(0, 1, (count, 3)) * width, radii, np.diag(np.broadcast_to(width, 3).astype(float))


def geometric(low, high, count, seed):
    return np.exp(np.random.default_rng(seed).uniform(np.log(low), np.log(high), count))


def walks():
    """name -> positions, radii, edges: loose and dense, one and many meshes of the grid across, narrow and broad gradings."""
    equal = np.ones(120)
    reach = 2.0 + OUTER_GAP
    broad = geometric(0.3, 2.0, 150, seed=5)
    broad_reach = 2 * broad.max() + OUTER_GAP * broad.mean()
    yield "many meshes", cloud(120, equal, 12.0, seed=1)
    yield "two meshes across", cloud(30, equal[:30], 2.25 * reach, seed=2)
    yield "about three meshes across", cloud(60, equal[:60], np.array([2.3, 2.8, 3.3]) * reach, seed=3)
    yield "slender cell", cloud(100, equal[:100], np.array([2.25, 2.25, 9.0]) * reach, seed=4)
    yield "broad grading", cloud(150, broad, 2.3 * broad_reach, seed=5)


WALKS = dict(walks())


@pytest.mark.parametrize("gradient", [STILL, SHEAR], ids=["resting", "deforming"])
@pytest.mark.parametrize("tilt", [0.0, 0.35], ids=["brick", "sheared"])
@pytest.mark.parametrize("name", WALKS)
def test_a_random_walk_finds_the_contacts_of_all_pairs_at_every_step(name, tilt, gradient, precision):
    positions, radii, edges = WALKS[name]
    # A sheared cell is narrower than its edges are long: twice the reach must still fit between its faces.
    edges = edges @ np.array([[1, tilt, 0], [0, 1, -tilt], [0, 0, 1]]) * (1 + tilt if tilt else 1)
    positions = positions @ np.linalg.inv(WALKS[name][2]).T @ edges.T
    simulation = _native.Simulation(np.ascontiguousarray(positions), radii, np.ascontiguousarray(edges), law(), IMMOVABLE, precision=precision)
    generator = np.random.default_rng(7)
    count = 250
    time_step = 0.1 / count
    rebuilds = (0, 0)
    for step in range(count):
        if step % 25 == 0:
            directions = generator.normal(size=positions.shape)
            directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        # From creeping, when lists last, to leaps of several near gaps in a single step.
        simulation.set_velocities(radii.min() * 10 ** generator.uniform(-4, -1) / time_step * directions)
        where, cell = simulation.positions, simulation.edges
        steps(simulation, 1, time_step, gradient)
        contacts = simulation.contacts()
        assert as_set(contacts["first"], contacts["second"]) == pairs_closer_than(0.0, where, radii, cell), step
        outer, near, *_ = simulation.rebuilds
        if near > rebuilds[1]:
            # Just rebuilt: the near pairs are those closer than the near gap.
            pairs = simulation.near_pairs
            assert as_set(pairs[:, 0], pairs[:, 1]) == pairs_closer_than(NEAR_GAP * radii.mean(), where, radii, cell), step
        rebuilds = (outer, near)
    # Both lists were rebuilt many times, and many times not.
    assert rebuilds[0] >= 4 and 3 * rebuilds[0] <= rebuilds[1] <= 0.8 * count


def test_two_spheres_that_race_at_each_other_meet(precision):
    # The worst case for a list: the two fastest, head on, all others at rest; at any pace.
    positions, radii, edges = jittered_lattice(side=4, spacing=3.0, spread=0.0, jitter=0.0)
    for pace in (1e-4, 1e-3, 0.0149, 0.0151, 0.05, 0.099):
        simulation = _native.Simulation(positions, radii, edges, law(), IMMOVABLE, precision=precision)
        velocities = np.zeros_like(positions)
        first, second = 0, 16  # neighbours along x, their surfaces 1 m apart
        velocities[first, 0], velocities[second, 0] = pace / 1e-3, -pace / 1e-3
        simulation.set_velocities(velocities)
        met = int(np.ceil(0.5 / pace))
        steps(simulation, met, 1e-3)
        assert len(simulation.contacts()["first"]) == 0
        steps(simulation, 2, 1e-3)
        contacts = simulation.contacts()
        assert as_set(contacts["first"], contacts["second"]) == {(first, second)}


def compared(simulation, everything, tolerance):
    """Asserts that both show the same contacts, forces and motion, to a share of the largest of each."""
    mine, yours = simulation.contacts(), everything.contacts()
    order = np.lexsort((mine["second"], mine["first"]))
    assert np.array_equal(mine["first"][order], yours["first"]) and np.array_equal(mine["second"][order], yours["second"])
    for name in NAMES:
        assert np.allclose(mine[name][order], yours[name], rtol=0, atol=tolerance * np.abs(yours[name]).max()), name
    for name in ("forces", "torques", "velocities", "spins", "positions"):
        mine, yours = getattr(simulation, name), getattr(everything, name)
        assert np.allclose(mine, yours, rtol=0, atol=tolerance * np.abs(yours).max()), name


@pytest.mark.parametrize("damping", [0.0, 0.2])
@pytest.mark.parametrize("gradient", [STILL, SHEAR], ids=["resting", "deforming"])
def test_a_sheared_packing_moves_as_one_computed_over_all_pairs(gradient, damping, precision):
    positions, radii, edges = jittered_lattice(side=4, spacing=1.9)
    edges = np.ascontiguousarray(edges @ np.array([[1, 0.3, 0], [0, 1, -0.2], [0, 0, 1]]))
    positions = np.ascontiguousarray(positions @ (edges @ np.linalg.inv(np.diag(np.diag(edges)))).T)
    density, time_step, count = 1.0, 2e-5, 300
    simulation = _native.Simulation(positions, radii, edges, law(*astuple(PARAMETERS)), density, precision=precision)
    everything = AllPairs(positions, radii, edges, PARAMETERS, density)
    generator = np.random.default_rng(3)
    velocities, spins = generator.normal(0, 20, positions.shape), generator.normal(0, 20, positions.shape)
    simulation.set_velocities(velocities)
    simulation.set_spins(spins)
    everything.velocities, everything.spins = velocities, spins
    for _ in range(count):
        everything.step(time_step, gradient, damping)
    steps(simulation, count, time_step, gradient, damping)
    assert simulation.rebuilds[1] >= 10
    # The same sums in another order: roundings of the overlap (the cell against 1 % of a radius) and of the precision, grown by 300 steps of colliding spheres:
    # 1e-8 in float64.
    compared(simulation, everything, tolerance=6e4 * (ROUNDING * edges.max() / 0.01 + rounding(precision)))


def test_particles_that_wander_are_sorted_anew_and_keep_their_histories(precision):
    # Spheres pushed through each other, several radii far. The engine sorts them with every eighth outer list: order and sides of pairs change, memory must not.
    positions, radii, edges = jittered_lattice(side=4, spacing=1.9)
    parameters = Parameters(modulus=1e7, stiffness_ratio=0.3, friction=1e9, rolling_stiffness=0.2, rolling_strength=1e9)
    simulation = _native.Simulation(positions, radii, edges, law(*astuple(parameters)), IMMOVABLE, precision=precision)
    everything = AllPairs(positions, radii, edges, parameters, IMMOVABLE)
    generator = np.random.default_rng(8)
    for _ in range(30):
        velocities, spins = generator.normal(0, 20, positions.shape), generator.normal(0, 20, positions.shape)
        simulation.set_velocities(velocities)
        simulation.set_spins(spins)
        everything.velocities, everything.spins = velocities, spins
        for _ in range(10):
            everything.step(1e-3, STILL)
        steps(simulation, 10, 1e-3)
        # Roundings of the gap (of the cell's edge) and of the law, turned a few hundred times.
        compared(simulation, everything, tolerance=6e4 * (ROUNDING * edges.max() + rounding(precision)))
    assert simulation.rebuilds[0] >= 17


def test_lists_that_overflow_leave_histories_intact(precision):
    # A cubic lattice compressed until its second and third neighbours come near too: 13 near pairs a particle where the list begins with room for 6,
    # and more than 20 in the outer list, which begins with room for 16. Whichever pair it belongs to, the law's memory must come through as lists grow.
    positions, radii, edges = jittered_lattice(side=5, spacing=2.05, spread=0.02, jitter=0.005)
    parameters = Parameters(modulus=1e7, stiffness_ratio=0.3, friction=1e9, rolling_stiffness=0.2, rolling_strength=1e9)
    simulation = _native.Simulation(positions, radii, edges, law(*astuple(parameters)), IMMOVABLE, precision=precision)
    everything = AllPairs(positions, radii, edges, parameters, IMMOVABLE)
    spins = np.random.default_rng(4).normal(0, 1, positions.shape)
    simulation.set_spins(spins)
    everything.spins = spins
    near_room, outer_room = 6 * len(radii) + 64, 16 * len(radii) + 64
    squeeze = -1.0 * np.eye(3)
    listed = []
    for _ in range(33):
        for _ in range(10):
            everything.step(2e-3, squeeze)
        steps(simulation, 10, 2e-3, squeeze)
        # Nothing but roundings of the normals, turned a few hundred times: 1e-11 in float64.
        compared(simulation, everything, tolerance=4.5e4 * rounding(precision))
        listed.append(simulation.rebuilds[2:])
    assert listed[0][0] < near_room < 0.6 * listed[-1][0]
    assert listed[0][1] < outer_room < 0.8 * listed[-1][1]


def test_a_copy_goes_on_as_its_original(precision):
    positions, radii, edges = jittered_lattice(side=5, spacing=1.9)
    simulation = _native.Simulation(positions, radii, edges, law(friction=0.4), 1.0, precision=precision)
    simulation.set_velocities(np.random.default_rng(3).normal(0, 20, positions.shape))
    steps(simulation, 100, 2e-5, SHEAR)
    copy = simulation.copy()
    for each in (simulation, copy):
        steps(each, 100, 2e-5, SHEAR)
    # Lists made at another time hold other pairs at a distance, which add nothing, in the same order: bit for bit the same.
    assert np.array_equal(simulation.positions, copy.positions)
    assert np.array_equal(simulation.torques, copy.torques)


def test_a_cell_too_small_for_two_images_apart_is_refused(precision):
    # Below two reaches a sphere could touch another and its image at once; the outer list makes do with the room there is, down to two near gaps.
    narrowest = 2 * (2 + 2 * NEAR_GAP)
    for width, enough in ((0.999 * narrowest, False), (1.001 * narrowest, True)):
        simulation = _native.Simulation(*cloud(3, np.ones(3), width, seed=1), law(), IMMOVABLE, precision=precision)
        if enough:
            steps(simulation, 1)
        else:
            with pytest.raises(RuntimeError, match="cell has become too small"):
                steps(simulation, 1)


@pytest.mark.parametrize("where", [np.nan, np.inf, -np.inf, 1e308, -1e308], ids=str)
def test_a_particle_that_is_nowhere_ends_a_simulation(where, precision):
    # 1e308 m is no finite share of a cell of centimetres. Without neighbours, such a particle has no force that would give it away.
    positions, edges = np.array([[1.0, 1, 1], [1, 1, 5], [1, 5, 1]]) / 300, np.eye(3) * 8 / 300
    positions[1, 1] = where
    radii, grains = np.full(3, 1 / 300), law()
    simulation = _native.Simulation(positions, radii, edges, grains, 1.0, precision=precision)
    for advance in (lambda: simulation.run(1, 0.2), lambda: steps(simulation, 1)):
        with pytest.raises(RuntimeError, match="the simulation diverged"):
            advance()
    never = [_native.Stage([_native.AxisGoal(stress=False, target=0.1, largest_rate=0.0)] * 3)]
    held = _native.Packing(positions, radii, edges)
    for name in _native.instruction_sets:
        assert _native.Batch([held], [grains], 1.0, never, [0], 1, 1000, name, precision).next(60.0)["status"] == "diverged"


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e110], ids=str)
@pytest.mark.parametrize("wrong", ["edges", "radii"])
def test_a_cell_or_a_radius_that_is_no_length_ends_a_simulation(wrong, value, precision):
    # The volume of a cell of 1e110 m is infinite, and its faces are then an infinity apart.
    given = {"positions": np.array([[1.0, 1, 1], [1, 1, 5]]), "radii": np.ones(2), "edges": np.eye(3) * 8}
    given[wrong] = np.where(given[wrong] > 0, value, 0.0)
    simulation = _native.Simulation(*given.values(), law(), 1.0, precision=precision)
    with pytest.raises(RuntimeError, match="the simulation diverged|too small for its largest particles"):
        simulation.run(1, 0.2)
