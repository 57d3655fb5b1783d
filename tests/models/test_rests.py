"""A test rests at states of its own: its curve is the same whatever rows it is compared with."""

import numpy as np
import pytest

import graincal as gc
from graincal import demo
from graincal.data import Samples
from graincal.interpolation import interpolate
from graincal.models.contact_laws import LAWS
from graincal.models.rests import FIRST_STRAINS, strains_at_rest, stresses_at_rest

THETA = np.array([[8.2, 0.2, 30.0, 0.1, 0.3]])
PRESSURE = 1e5


@pytest.fixture(scope="module")
def packing():
    return demo.packing()


def stored(test, at):
    """The response as a campaign keeps it."""
    ((_, response),) = test.evaluate(Samples(np.arange(1), THETA, LAWS["linear"].names), at, workers=1)
    assert isinstance(response, gc.Response), response
    return response


def strains(at, every=0.004):
    return strains_at_rest(np.array(at, dtype=float), every).tolist()


def test_strains_are_met_closely_at_first_and_then_at_even_steps():
    assert strains([0.01]) == [0, *FIRST_STRAINS, 0.004, 0.008, 0.012]
    assert strains([0.01], every=0.002) == [0, 0.0005, 0.001, 0.002, 0.004, 0.006, 0.008, 0.01]
    assert strains([0.01], every=0.0005) == pytest.approx(np.arange(21) * 0.0005)
    assert strains([-0.004]) == [-strain for strain in strains([0.004])]
    assert strains([0.0]) == [0]


def test_a_path_rests_where_it_turns_around():
    assert strains([0.0022, 0.0008, 0.001]) == [0, 0.0005, 0.001, 0.002, 0.0022, 0.002, 0.001, 0.0008, 0.001]
    up_and_down = stresses_at_rest(np.array([2e5, 1.5e5]), 1e5)
    np.testing.assert_allclose(up_and_down / 1e5, [1, 10**0.125, 10**0.25, 2, 10**0.25, 10**0.125], rtol=1e-12)
    np.testing.assert_allclose(stresses_at_rest(np.array([0.5e5, 0.9e5]), 1e5) / 1e5, [1, 10**-0.125, 10**-0.25, 0.5, 10**-0.25, 10**-0.125, 1], rtol=1e-12)


@pytest.mark.parametrize(("pressure", "at"), [(1e3, [1e7, 1333.52]), (1e4, [2e7, 13335.2]), (1e5, [3.16227766e5, 1.0000000001e5]), (5e4, [1e5, 8e5, 1e5, 4e5])])
def test_stresses_that_are_rounded_are_reached(pressure, at):
    at = np.array(at)
    states = stresses_at_rest(at, pressure)
    turned = gc.Response(states, {"mean_stress": states}, {}, "mean_stress", pressure, ("mean_stress",))
    np.testing.assert_allclose(interpolate(turned, at).values["mean_stress"], at, rtol=1e-4)


@pytest.mark.parametrize("rows", [5, 50, 500, 2000])
def test_the_states_are_the_same_bit_for_bit_whatever_the_rows(packing, rows):
    test = gc.TriaxialTest(packing, PRESSURE)
    few, many = stored(test, [0.0195]), stored(test, np.linspace(0, 0.02, rows) ** 1.01 / 0.02**0.01)
    np.testing.assert_array_equal(few.control, many.control)
    assert few.details["steps"] == many.details["steps"]
    for name, values in few.values.items():
        np.testing.assert_array_equal(values, many.values[name], name)


def test_a_run_is_the_beginning_of_a_longer_one(packing):
    test = gc.OedometricTest(packing, PRESSURE, control="axial_stress")
    short, long = stored(test, [1.5e5]), stored(test, [1.2e5, 3.1e5])
    states = len(short.control)
    for name, values in short.values.items():
        np.testing.assert_array_equal(values, long.values[name][:states], name)


def test_rows_are_read_off_the_states(packing):
    test = gc.TriaxialTest(packing, PRESSURE)
    rows = np.array([0.0, 0.0007, 0.004, 0.0065])
    (curve,) = test.simulate(THETA, at=rows, threads=1)
    whole = stored(test, rows)
    np.testing.assert_array_equal(curve.control, rows)
    for name, values in curve.values.items():
        assert values[0] == whole.values[name][0] and values[2] == whole.values[name][whole.control == 0.004]
        assert whole.values[name].min() <= values.min() and values.max() <= whole.values[name].max()
