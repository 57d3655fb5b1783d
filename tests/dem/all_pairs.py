"""The engine's mechanics once more, in NumPy over all N (N - 1) / 2 pairs: no neighbour list, no slots, nothing kept apart but what the law remembers.

Source: Hartmann, Cheng, Thornton (2022), Table 1 and Eq. 1, and the order of operations of YADE's Law2_ScGeom6D_CohFrictPhys_CohesionMoment.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Parameters:
    modulus: float
    stiffness_ratio: float
    friction: float
    rolling_stiffness: float
    rolling_strength: float


def capped(vectors, limits):
    lengths = np.linalg.norm(vectors, axis=1)
    return vectors * np.where(lengths > limits, limits / np.where(lengths > 0, lengths, 1), 1)[:, None]


def across(vectors, normals):
    return vectors - along(vectors, normals)


def along(vectors, normals):
    return np.sum(vectors * normals, axis=1, keepdims=True) * normals


def nearest_branches(positions, edges, first, second):
    """From the first to the nearest image of the second, (P, 3)."""
    fractional = np.linalg.solve(edges, (positions[second] - positions[first]).T).T
    return (fractional - np.rint(fractional)) @ edges.T


class AllPairs:
    """Spheres in a periodic cell under a prescribed velocity gradient; `step` is one step of `Simulation.run_prescribed`.

    positions (N, 3), velocities (N, 3) of the fluctuation u = v - L x, spins (N, 3), edges (3, 3); after a step: forces and torques (N, 3), and the
    force pass's contacts as (P, ...) arrays of which `touching` marks the real ones.
    """

    def __init__(self, positions, radii, edges, parameters, density):
        self.positions, self.radii, self.edges, self.parameters = positions.copy(), radii, edges.copy(), parameters
        self.mass = density * 4 / 3 * np.pi * radii**3
        self.inertia = 0.4 * self.mass * radii**2
        self.velocities, self.spins = np.zeros_like(positions), np.zeros_like(positions)
        self.gradient = np.zeros((3, 3))
        self.first, self.second = np.triu_indices(len(radii), 1)
        pairs = len(self.first)
        self.touching = np.zeros(pairs, dtype=bool)
        self.normal, self.shear, self.bending, self.twisting = (np.zeros((pairs, 3)) for _ in range(4))

    def step(self, time_step, gradient, damping=0.0):
        self.find_forces(time_step)
        self.gradient = gradient
        self.move(time_step, damping)

    def find_forces(self, dt):
        p, i, j = self.parameters, self.first, self.second
        r1, r2 = self.radii[i], self.radii[j]
        branch = nearest_branches(self.positions, self.edges, i, j)
        distance = np.linalg.norm(branch, axis=1)
        overlap = r1 + r2 - distance
        touching = overlap >= 0
        n = branch / distance[:, None]
        spin1, spin2 = self.spins[i], self.spins[j]

        # The branch grew from what it was before the latest motion: v2 - v1 + shift = u2 - u1 + L (branch as it was).
        fluctuation = self.velocities[j] - self.velocities[i]
        before = np.linalg.solve(np.eye(3) + dt * self.gradient, (branch - dt * fluctuation).T).T
        relative_velocity = fluctuation + before @ self.gradient.T
        stretch = ((r1 + r2) / distance)[:, None]
        slip = dt * across(stretch * relative_velocity - np.cross(r2[:, None] * spin2 + r1[:, None] * spin1, n), n)
        roll = dt * (spin2 - spin1)

        kn = 2 * p.modulus * r1 * r2 / (r1 + r2)
        ks = p.stiffness_ratio * kn
        km = p.rolling_stiffness * r1 * r2 * ks
        normal_force = kn * overlap
        old_normal = np.where(self.touching[:, None], self.normal, n)
        turn = np.cross(old_normal, n)
        spin_about_normal = along(0.5 * dt * (spin1 + spin2), old_normal)

        def carried(memory):
            memory = np.where(self.touching[:, None], memory, 0)
            memory = memory - np.cross(memory, turn)
            return memory - np.cross(memory, spin_about_normal)

        strength = p.rolling_strength * normal_force * np.minimum(r1, r2)
        only = touching[:, None]
        self.shear = np.where(only, capped(carried(self.shear) - ks[:, None] * slip, p.friction * normal_force), 0)
        self.bending = np.where(only, capped(carried(self.bending) - km[:, None] * across(roll, n), strength), 0)
        self.twisting = np.where(only, capped(carried(self.twisting) - km[:, None] * along(roll, n), strength), 0)
        self.touching, self.normal, self.overlap, self.branch = touching, n, overlap, branch

        force = np.where(only, normal_force[:, None] * n + self.shear, 0)
        moment = self.bending + self.twisting
        lever = np.cross(n, self.shear)
        self.pair_force = force
        self.forces, self.torques = np.zeros_like(self.positions), np.zeros_like(self.positions)
        np.add.at(self.forces, j, force)
        np.add.at(self.forces, i, -force)
        np.add.at(self.torques, j, moment - (r2 - 0.5 * overlap)[:, None] * lever)
        np.add.at(self.torques, i, -moment - (r1 - 0.5 * overlap)[:, None] * lever)

    def move(self, dt, damping):
        def damped(acceleration, velocity):
            return acceleration * (1 - damping * np.sign(acceleration * (velocity + 0.5 * dt * acceleration)))

        self.velocities = self.velocities + dt * damped(self.forces / self.mass[:, None], self.velocities)
        self.spins = self.spins + dt * damped(self.torques / self.inertia[:, None], self.spins)
        self.positions = self.positions + dt * (self.velocities + self.positions @ self.gradient.T)
        self.edges = self.edges + dt * self.gradient @ self.edges

    def contacts(self):
        """The real contacts as columns, rows sorted by pair."""
        rows = self.touching
        names = ("normal", "shear", "bending", "twisting", "overlap")
        return {"first": self.first[rows], "second": self.second[rows], "force": self.pair_force[rows]} | {name: getattr(self, name)[rows] for name in names}
