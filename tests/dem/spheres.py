"""Simulations that the tests of the engine start from: two spheres in hand, rings, lattices and clouds of spheres, a packing at rest."""

from dataclasses import dataclass

import numpy as np

from graincal import _native
from graincal.dem.packing import Packing
from graincal.models.contact_laws import LAWS

IMMOVABLE = 1e30
"""A density, kg/m^3, at which contact forces change no velocity: spheres then move exactly as they are told to."""

STILL = np.zeros((3, 3))
"""The velocity gradient of a cell that does not deform."""

ROUNDING = np.finfo(float).eps

CELL = 8.0
"""Width of the cell around two spheres, m."""


def rounding(precision):
    """The distance of neighbouring numbers about one: what is computed in a precision rounds by half of this share."""
    return float(np.finfo(precision).eps)


def exact(precision, overlap=0.01, count=0):
    """The share to which what follows from an overlap (m) in `count` steps is known.

    An overlap is a difference of lengths of the cell's size, which are float64 in any precision: a few roundings of the cell against the overlap are what is
    left of its digits. What is computed from it takes a few roundings of the precision, and what a contact stores three halves more each step: it is turned
    twice and added to.
    """
    return 10 * (ROUNDING * CELL / overlap + rounding(precision)) + 2 * count * rounding(precision)


def law(modulus=1e7, stiffness_ratio=0.3, friction=1e9, rolling_stiffness=0.2, rolling_strength=1e9, kind="linear"):
    """A contact law with round stiffnesses; without an argument nothing slides, rolls or twists off. "hertz-mindlin" takes the ratio for Poisson's."""
    return LAWS[kind].engine(modulus, stiffness_ratio, friction, rolling_stiffness, rolling_strength)


@dataclass(frozen=True)
class ClosedForm:
    """A contact by the text-books' formulas: tangent stiffnesses kn, ks (N/m), km (N m) and the normal force (N) with the energy it stored (J)."""

    normal: float
    shear: float
    rolling: float
    force: float
    energy: float


def closed_form(kind, radii, overlap, modulus=1e7, ratio=0.3, rolling_stiffness=0.2):
    """The contact of spheres with this overlap, m; with the defaults of `law`."""
    product, reduced = radii[0] * radii[1], radii[0] * radii[1] / (radii[0] + radii[1])
    if kind == "linear":
        normal = 2 * modulus * reduced
        shear, force, energy = ratio * normal, normal * overlap, normal * overlap**2 / 2
    else:
        contact_modulus = 1 / (2 * (1 - ratio**2) / modulus)
        shear_modulus = 1 / (2 * (2 - ratio) / (modulus / (2 * (1 + ratio))))
        normal, shear = 2 * contact_modulus * np.sqrt(reduced * overlap), 8 * shear_modulus * np.sqrt(reduced * overlap)
        force = 4 / 3 * contact_modulus * np.sqrt(reduced) * overlap**1.5
        energy = 8 / 15 * contact_modulus * np.sqrt(reduced) * overlap**2.5
    return ClosedForm(normal, shear, rolling_stiffness * product * shear, force, energy)


def normal_stiffness(radii, modulus=1e7):
    """kn = 2 E r*, with the law's defaults."""
    return 2 * modulus * radii[0] * radii[1] / (radii[0] + radii[1])


def unit(vector):
    return np.asarray(vector, dtype=float) / np.linalg.norm(vector)


PLAIN = _native.Economy()
"""No option for fewer steps."""


def two_spheres(
    radii=(1.0, 0.7), overlap=0.01, normal=(1, 0, 0), density=IMMOVABLE, edges=np.diag([CELL] * 3), precision="float64", economy=PLAIN, **parameters
):
    """Two spheres whose normal from the first to the second, and overlap (m), are given; far from the cell's faces."""
    centre = edges @ np.full(3, 0.5)
    branch = (sum(radii) - overlap) * unit(normal)
    positions = np.stack([centre - branch / 2, centre + branch / 2])
    edges = np.ascontiguousarray(edges, dtype=float)
    return _native.Simulation(positions, np.array(radii, dtype=float), edges, law(**parameters), density, precision=precision, economy=economy)


def steps(simulation, count, time_step=1e-3, gradient=STILL, damping=0.0):
    """Step with a velocity gradient and a time step that are given."""
    simulation.run_prescribed(count, np.ascontiguousarray(gradient, dtype=float), time_step, damping)


def only_contact(simulation):
    """The one contact of two spheres, as name -> value; None where they do not touch. The normal points from the first sphere to the second."""
    contacts = simulation.contacts()
    assert len(contacts["first"]) <= 1
    return {name: column[0] for name, column in contacts.items()} if len(contacts["first"]) else None


def ring(radius=1.0, overlap=0.01, density=1.0, precision="float64", economy=PLAIN, **parameters):
    """Three equal spheres in a row along x, the last touching the first through the boundary."""
    period = 3 * (2 * radius - overlap)
    positions = np.array([[(k + 0.5) * period / 3, CELL * radius / 2, CELL * radius / 2] for k in range(3)])
    edges = np.diag([period, CELL * radius, CELL * radius])
    return _native.Simulation(positions, np.full(3, radius), edges, law(**parameters), density, precision=precision, economy=economy)


def jittered_lattice(side=5, spacing=1.9, spread=0.2, jitter=0.1, seed=1):
    """Positions, radii and edges of side^3 spheres of radius 1 +- spread about a cubic lattice, m. Many touch, some do not."""
    generator = np.random.default_rng(seed)
    sites = np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) + 0.5
    positions = spacing * (sites + jitter * generator.uniform(-1, 1, sites.shape))
    return positions, generator.uniform(1 - spread, 1 + spread, len(sites)), np.diag([spacing * side] * 3)


def masses(radii, density):
    return density * 4 / 3 * np.pi * radii**3


def packing_at_rest(count=100, pressure=1e5, seed=3):
    """A packing of millimetre grains, compressed to `pressure` (Pa) from a loose lattice without friction. Overlaps are some 1e-4 of a radius."""
    side = round(count ** (1 / 3) + 0.5)
    positions, radii, edges = jittered_lattice(side, spacing=2.5, spread=0.2, jitter=0.02, seed=seed)
    chosen = np.sort(np.random.default_rng(seed).permutation(len(radii))[:count])
    positions, radii, edges = 1e-3 * positions[chosen], 1e-3 * radii[chosen], 1e-3 * edges
    modulus, density = 1e4 * pressure, 2.65e6
    frictionless = law(modulus=modulus, stiffness_ratio=0.2, friction=0.0, rolling_stiffness=0.0, rolling_strength=0.0)
    simulation = _native.Simulation(positions, radii, edges, frictionless, density)
    # Without contacts there is no critical time step to take: one well below that of two touching grains.
    time_step = 0.1 * radii.min() * np.sqrt(density / modulus)
    while np.min(simulation.stress_diagonal) < 0.1 * pressure:
        steps(simulation, 10, time_step, gradient=-1.0 * np.eye(3), damping=0.2)
    simulation.set_goals([_native.AxisGoal(True, pressure, 1.0)] * 3)
    while not (np.allclose(simulation.stress_diagonal, pressure, rtol=1e-3) and simulation.unbalanced_force < 1e-3):
        simulation.run(10, 0.2)
        assert simulation.steps < 100_000
    return Packing(simulation.positions, radii, simulation.edges)
