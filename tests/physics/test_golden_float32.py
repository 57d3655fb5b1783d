"""Step by step against YADE in float32, in the two runs of test_golden_steps.py and test_golden_isotropic.py.

Forces, velocities and the contacts' memory round by 6e-8 in float32, so agreement to 1e-7 holds for a few steps at most. For twenty steps a quantity
may be 16 units of the largest from YADE's, the roundings of some ten operations and of ten steps. Later it may be as far from it as one unit grows
to: 5 times the largest separation of six float64 runs, each from positions of which every coordinate is moved by one float32 unit of a mean radius,
from the unmoved one (5: see test_golden_isotropic.py). So the yardstick owes nothing to float32's own arithmetic.
"""

from types import SimpleNamespace

import numpy as np
import pytest

from . import test_golden_isotropic as isotropic
from . import test_golden_steps as prescribed

UNIT = np.finfo(np.float32).eps
UNITS, SEPARATIONS = 16, 5
LAST_OF_ROUNDINGS = 20

IN_CONTACTS = ("normal_force", "normal", "shear", "bending", "twisting")
EARLY = ("shear", "bending", "twisting", "torque", "angular_velocity")
"""Roundings of the first steps, judged by the size that they have at step 10."""


def with_twins(followed, packing):
    """The run in float32 and in float64, and six float64 twins of moved positions: step -> state each."""
    positions, radii, edges = packing
    generator = np.random.default_rng(0)
    moves = [UNIT * radii.mean() * generator.choice([-1, 1], positions.shape) for _ in range(6)]
    twins = [followed((positions + move, radii, edges)) for move in moves]
    return SimpleNamespace(run=followed(packing, precision="float32"), unmoved=followed(packing), twins=twins)


@pytest.fixture(scope="module")
def sheared(prescribed_steps):
    states = with_twins(prescribed.followed, prescribed_steps.packing)
    states.yade = {step: prescribed.golden(prescribed_steps.record, step) for step in prescribed.STEPS}
    return states


@pytest.fixture(scope="module")
def compressed(isotropic_steps):
    states = with_twins(isotropic.followed, isotropic_steps.packing)
    states.yade = isotropic.states_of(isotropic_steps.record)
    return states


def pairs_apart(one, other):
    """How many pairs touch in one state and not in the other."""
    return len({*map(tuple, one["pairs"].tolist())} ^ {*map(tuple, other["pairs"].tolist())})


def apart(one, other, quantity):
    """The largest difference; of a contact's quantity, among the pairs that touch in both states."""
    of_one, of_other = np.asarray(one[quantity]), np.asarray(other[quantity])
    if quantity in IN_CONTACTS:
        places = [{pair: k for k, pair in enumerate(map(tuple, state["pairs"].tolist()))} for state in (one, other)]
        both = sorted(places[0].keys() & places[1].keys())
        of_one, of_other = of_one[[places[0][pair] for pair in both]], of_other[[places[1][pair] for pair in both]]
    return np.abs(of_one - of_other).max()


def assert_as_close_as_twins(states, step, quantity, judge):
    allowed = UNITS * UNIT * np.abs(states.yade[judge][quantity]).max()
    if step > LAST_OF_ROUNDINGS:
        allowed = max(allowed, SEPARATIONS * max(apart(states.unmoved[step], twin[step], quantity) for twin in states.twins))
    assert apart(states.run[step], states.yade[step], quantity) <= allowed


@pytest.mark.parametrize("step", prescribed.STEPS)
def test_the_same_pairs_touch_until_twins_are_apart(sheared, step):
    # Overlaps are float64's in either precision: for 400 steps nothing comes so close to touching that a rounding of forces decides it.
    among_twins = max(pairs_apart(sheared.unmoved[step], twin[step]) for twin in sheared.twins)
    assert pairs_apart(sheared.run[step], sheared.yade[step]) <= (0 if step <= 400 else SEPARATIONS * among_twins)


@pytest.mark.parametrize("quantity", [*IN_CONTACTS, "force", "torque", "stress", "position", "velocity", "angular_velocity", "cell"])
@pytest.mark.parametrize("step", prescribed.STEPS)
def test_a_prescribed_deformation_is_as_close_to_yades_as_to_its_twins(sheared, step, quantity):
    assert_as_close_as_twins(sheared, step, quantity, max(step, 10) if quantity in EARLY else step)


@pytest.mark.parametrize("quantity", isotropic.QUANTITIES)
@pytest.mark.parametrize("step", isotropic.STEPS)
def test_a_servo_driven_compression_is_as_close_to_yades_as_to_its_twins(compressed, step, quantity):
    assert_as_close_as_twins(compressed, step, quantity, max(step, 10) if quantity in EARLY else step)
