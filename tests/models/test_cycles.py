"""Compression tests along a cycle of loading and unloading, driven by the position along it."""

from dataclasses import replace

import numpy as np
import pytest

import graincal as gc
from graincal import InputError, demo
from graincal.data import Samples
from graincal.interpolation import interpolate
from graincal.models.contact_laws import LAWS
from graincal.positions import POSITION, positions

THETA = np.array([[8.2, 0.2, 30.0, 0.1, 0.3]])
PRESSURE, TURNS = 2e4, (1.6e5, 4e4)
STRESSES = [2e4, 5e4, 1.6e5, 1e5, 4e4, 1e5, 2.5e5]
AT = positions(STRESSES, PRESSURE)
CYCLES = [(gc.OedometricTest, "axial_stress"), (gc.IsotropicTest, "mean_stress")]


@pytest.fixture(scope="module")
def packing():
    return demo.packing()


def cycle(packing, kind=gc.OedometricTest, pressure=PRESSURE, turns=TURNS, **options):
    return kind(packing, pressure, control=POSITION, turns=turns, **options)


def stored(test, at, watch=None, theta=THETA):
    """The response as a campaign keeps it."""
    ((_, response),) = test.evaluate(Samples(np.arange(1), theta, LAWS["linear"].names), at, workers=1, watch=watch)
    assert isinstance(response, gc.Response), response
    return response


def test_a_cycle_rests_on_its_stresses_and_where_it_turns(packing):
    test = cycle(packing)
    states = test.states(AT)
    ratios = test.stress_at(states) / PRESSURE
    up = 10 ** (np.arange(8) / 8)
    np.testing.assert_allclose(ratios[:9], [*up, 8], rtol=1e-9)
    # 10^(7/8) = 7.5 is a rest on the way down too, and 10^(5/8) = 4.2 and 10^(3/8) = 2.4 are; the next is beyond the turn at 2.
    np.testing.assert_allclose(ratios[9:15], [*up[7:2:-1], 2], rtol=1e-9)
    assert states[-1] >= AT[-1] > states[-2]
    # Whatever is asked for, it is the beginning of one and the same path.
    for last in (0.0, 0.3, np.log(8) - 1e-6, np.log(8), np.log(8) + 1e-6, 3.0, 4.0):
        shorter = test.states([last])
        np.testing.assert_array_equal(shorter, states[: len(shorter)])
        assert shorter[-1] >= last - 1e-8 and (len(shorter) == 1 or shorter[-2] < last)


def test_a_stress_that_is_close_to_a_turn_is_no_rest(packing):
    # 10^(7/8) is 7.499, and 10^(3/8) is 2.37.
    test = cycle(packing, turns=(7.5 * PRESSURE, 2.4 * PRESSURE))
    states = test.states([5.0])
    np.testing.assert_allclose(test.stress_at(states)[6:14] / PRESSURE, [10**0.75, 7.5, 10**0.75, 10**0.625, 10**0.5, 2.4, 10**0.5, 10**0.625], rtol=1e-9)
    assert np.diff(states).min() > 0.02


@pytest.mark.parametrize(("kind", "stress"), CYCLES)
def test_a_cycle_is_the_path_to_the_same_stresses(packing, kind, stress):
    by_position = stored(cycle(packing, kind), AT)
    by_stress = stored(kind(packing, PRESSURE, control=stress), STRESSES)
    for name, values in by_stress.values.items():
        np.testing.assert_array_equal(by_position.values[name], values, name)
    np.testing.assert_allclose(by_position.values[stress], cycle(packing, kind).stress_at(by_position.control), rtol=1.5e-3)
    assert POSITION not in by_position.values and by_position.control_name == POSITION
    # What is read off between two states is the same too: no leg's curve knows the leg after it.
    rows = positions([3e4, 1.6e5, 9e4, 4.1e4, 4e4, 1.5e5, 2.2e5], PRESSURE)
    ours, theirs = interpolate(by_position, rows), interpolate(by_stress, np.array([3e4, 1.6e5, 9e4, 4.1e4, 4e4, 1.5e5, 2.2e5]))
    for name in ("void_ratio", "mean_stress", "stress_ratio"):
        np.testing.assert_allclose(ours.values[name], theirs.values[name], rtol=1e-9, err_msg=name)


def test_a_run_is_the_same_whatever_the_rows(packing):
    few, many = stored(cycle(packing), AT[-1:]), stored(cycle(packing), np.linspace(0, AT[-1], 333))
    np.testing.assert_array_equal(few.control, many.control)
    for name, values in few.values.items():
        np.testing.assert_array_equal(values, many.values[name], name)
    # To the middle of the way down it is the beginning.
    short = stored(cycle(packing), AT[:4])
    for name, values in short.values.items():
        np.testing.assert_array_equal(values, few.values[name][: len(short.control)], name)


def test_a_run_that_is_watched_is_its_beginning(packing):
    whole = stored(cycle(packing), AT)
    stopped = stored(cycle(packing), AT, watch=lambda _, response: response.control[-1] > AT[2])
    assert stopped.stopped and len(stopped.control) < len(whole.control)
    rows = np.linspace(0, AT[-1], 100)
    met, expected = interpolate(stopped, rows), interpolate(whole, rows)
    assert AT[1] < met.control[-1] <= stopped.control[-1]
    for name, values in met.values.items():
        np.testing.assert_array_equal(values, expected.values[name][: len(values)], name)


@pytest.mark.parametrize(("kind", "stress"), CYCLES)
def test_a_cycle_is_the_same_in_units_of_its_pressure(packing, kind, stress):
    factor = 7.3
    one = stored(cycle(packing, kind), AT).at_pressure(factor * PRESSURE)
    other = stored(cycle(packing, kind, factor * PRESSURE, [factor * turn for turn in TURNS]), AT, theta=THETA + [np.log10(factor), 0, 0, 0, 0])
    np.testing.assert_array_equal(one.control, other.control)
    assert one.turns == other.turns
    np.testing.assert_array_equal(one.values["void_ratio"], other.values["void_ratio"])
    np.testing.assert_allclose(one.values[stress], other.values[stress], rtol=1e-14)


def test_a_curve_is_drawn_over_its_stress(packing):
    name, values, logarithmic = cycle(packing).abscissa(AT)
    assert name == "axial_stress" and logarithmic
    np.testing.assert_allclose(values, STRESSES, rtol=1e-9)
    assert cycle(packing, gc.IsotropicTest).abscissa(AT).name == "mean_stress"
    strains = np.array([0.0, 0.1])
    assert gc.OedometricTest(packing, PRESSURE).abscissa(strains) == ("axial_strain", strains, False)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"turns": [8e4]}, "turns are those of a path whose control is position, and this one's is axial_strain"),
        ({"turns": [8e4], "control": "axial_stress"}, 'write control = "position", or leave them out'),
        ({"turns": [8e4, 9e4], "control": "position"}, "number 2 was expected below the one before it, 80000 Pa, and it is 90000 Pa"),
        ({"turns": [1e4, 8e3], "control": "position"}, "number 2 was expected above the one before it, 10000 Pa"),
        ({"turns": [2e4], "control": "position"}, "number 1 was expected above the confining pressure, 20000 Pa"),
        ({"turns": [8e4, -1], "control": "position"}, "turns must be a list of positive numbers"),
        ({"turns": 8e4, "control": "position"}, "turns must be a list of positive numbers"),
        ({"turns": "8e4", "control": "position"}, "turns must be a list of positive numbers"),
        ({"turns": [1e20], "control": "position"}, "a turn is 1e[+]20 Pa, and 1 to 1e[+]12 Pa was expected"),
        ({"rest_every": 0.01, "control": "position"}, "driven by position rests at states of its own"),
    ],
)
def test_turns_that_are_none_are_refused(packing, options, message):
    with pytest.raises(InputError, match=message):
        gc.OedometricTest(packing, PRESSURE, **options)


@pytest.mark.parametrize("at", [[-1.0, 2.0], [1.0, 1.0], [2.0, 1.0], [], [np.nan]])
def test_positions_that_are_none_are_refused(packing, at):
    with pytest.raises(InputError, match="values of position must be one increasing row of numbers, not below 0"):
        cycle(packing).states(at)


def test_a_position_that_no_test_comes_to_is_refused(packing):
    # As where it was written in percent.
    with pytest.raises(InputError, match="axial_stress at position 530 is .* Pa, and 1 to 1e[+]12 Pa was expected"):
        cycle(packing).states([530.0])


@pytest.mark.parametrize(("kind", "stress"), CYCLES)
def test_what_a_cycle_costs_hardly_depends_on_the_modulus(packing, kind, stress):
    test = cycle(packing, kind)
    samples = Samples(np.arange(2), np.repeat(THETA, 2, axis=0) + [[-0.7, 0, 0, 0, 0], [1.8, 0, 0, 0, 0]], LAWS["linear"].names)
    steps = [outcome.details["steps"] for _, outcome in sorted(test.evaluate(samples, AT, workers=1), key=lambda pair: pair[0])]
    expected = test.expected_particle_steps(samples, AT) / packing.count
    assert np.all(np.abs(np.log(steps / expected)) < np.log(3))
    soft, stiff = (task.cost for task in replace(test, control=stress, turns=()).tasks(samples, [2e5]))
    assert soft == stiff
