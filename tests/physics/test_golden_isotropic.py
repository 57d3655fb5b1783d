"""Step by step against YADE with time stepper and servo: 200 and, where the published data are there, 2,000 particles compressed to 0.5 MPa, for 800 steps from a time step of 1e-8 s.

Positions agree to 1e-7 of the largest up to step 400 and to 1e-4 at step 800. Velocities and spins do not stay that close to anything: in the overshoot of
pressure contacts open and close, and two runs of this same engine, one started from positions moved by a rounding unit, have velocities 1e-3 of the
largest apart at step 400 and some 3e-2 at step 800. YADE is one more such run, moved by a rounding in every step. So beyond 1e-7 a quantity may be as far
from YADE's as 5 times the largest separation of six such runs from the unmoved one. Were all seven separations of a number drawn alike, normal about zero,
one would exceed 5 times the largest of six in fewer than one case in ten thousand. Up to step 100 the runs are together, and 1e-7 holds for all.

The engine moves as YADE does (`as_yade`, native/cpu/yade_comparison.hpp, see test_golden_steps.py) and takes YADE's 1.41044 where its time stepper means the
root of two.
"""

import numpy as np
import pytest

from graincal import _native

STEPS = (1, 2, 3, 5, 10, 20, 50, 100, 200, 400, 600, 800)
LAW = (10**8.72, 0.227, np.tan(np.radians(28.099)), 0.079, 0.569)
TOGETHER = 1e-7
LATER = 1e-4
LEAST_APART = {200: 1e-5, 2000: 1e-3}
"""Particles -> what the velocities of twins are apart at the least after 800 steps, as a share of the largest."""
QUANTITIES = ("position", "velocity", "angular_velocity", "time_step", "cell", "velocity_gradient", "stress", "contacts", "unbalanced_force", "time")


def simulation_of(positions, radii, edges, law, precision):
    simulation = _native.Simulation(positions, radii, edges, _native.LinearLaw(*law), 2650e3, precision=precision)
    simulation.as_yade = True
    simulation.set_time_stepper(1.41044, 1)
    simulation.set_goals([_native.AxisGoal(True, 0.5e6, 1.0)] * 3)
    return simulation


def state_of(simulation):
    dt, gradient = simulation.time_step, simulation.velocity_gradient
    before = np.linalg.solve(np.eye(3) + dt * gradient, (simulation.positions - dt * simulation.velocities).T).T
    return {
        "position": simulation.positions,
        # YADE's velocities carry L x with x before the move.
        "velocity": simulation.velocities + before @ gradient.T,
        "angular_velocity": simulation.spins,
        "time_step": dt,
        # YADE's cell of a step is that of its force pass.
        "cell": np.diag(np.linalg.solve(np.eye(3) + dt * gradient, simulation.edges)),
        "velocity_gradient": np.diag(gradient),
        "stress": -simulation.stress_diagonal[0],
        "contacts": float(len(simulation.contacts()["first"])),
        "unbalanced_force": simulation.unbalanced_force,
        "time": simulation.time,
    }


def followed(packing, law=LAW, precision="float64"):
    """step -> state of a run from the packing."""
    simulation = simulation_of(*packing, law, precision)
    states = {}
    for step in STEPS:
        simulation.run(step - simulation.steps, 0.2)
        states[step] = state_of(simulation)
    return states


@pytest.fixture(scope="module")
def yade(isotropic_steps):
    return states_of(isotropic_steps.record)


def states_of(record):
    """step -> state in YADE's run."""
    states = {}
    for step in STEPS:
        meta = record[f"meta_{step}"]
        numbers = {"time_step": meta[0], "cell": meta[1:4], "velocity_gradient": meta[4:7], "stress": meta[7:10]}
        numbers |= {"contacts": meta[10], "unbalanced_force": meta[11], "time": meta[12]}
        states[step] = {"position": record[f"x_{step}"], "velocity": record[f"v_{step}"], "angular_velocity": record[f"w_{step}"]} | numbers
    return states


@pytest.fixture(scope="module")
def packing(isotropic_steps):
    return isotropic_steps.packing


@pytest.fixture(scope="module")
def run(packing):
    return followed(packing)


@pytest.fixture(scope="module")
def moved_runs(packing):
    """Six runs from positions of which two thirds are moved by one rounding unit."""
    positions, radii, edges = packing
    generator = np.random.default_rng(0)
    return [followed((positions * (1 + np.finfo(float).eps * generator.integers(-1, 2, positions.shape)), radii, edges)) for _ in range(6)]


def separation(one, other, step, quantity):
    return np.abs(np.asarray(one[step][quantity]) - other[step][quantity]).max()


@pytest.mark.parametrize("quantity", QUANTITIES)
@pytest.mark.parametrize("step", STEPS)
def test_the_run_is_as_close_to_yades_as_to_its_own_twins(run, moved_runs, yade, step, quantity):
    # Nothing has moved before the first force pass: the first spins are roundings of the size that the second step's have.
    judge = 2 if step == 1 and quantity == "angular_velocity" else step
    allowed = TOGETHER * np.abs(yade[judge][quantity]).max()
    if step > 100:
        allowed = max(allowed, 5 * max(separation(run, twin, step, quantity) for twin in moved_runs))
    assert separation(run, yade, step, quantity) <= allowed


@pytest.mark.parametrize("step", STEPS)
def test_positions_stay_together(run, yade, step):
    allowed = TOGETHER if step <= 400 else LATER
    assert separation(run, yade, step, "position") <= allowed * np.abs(yade[step]["position"]).max()


def test_the_twins_tell_something(run, moved_runs, yade, packing):
    # The argument above: together up to step 100, and apart enough at the end that no tolerance of 1e-7 could be asked for. Where fewer grains overshoot, fewer contacts open and close.
    apart = LEAST_APART[len(packing[1])]
    for twin in moved_runs:
        largest = np.abs(yade[100]["velocity"]).max()
        assert separation(run, twin, 100, "velocity") <= 1e-8 * largest
        assert apart < separation(run, twin, 800, "velocity") / np.abs(yade[800]["velocity"]).max() < 0.2
