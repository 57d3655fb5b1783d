"""A run at one confining pressure is a run at another: where modulus and density go with the pressure, strains and ratios are the same bit for bit."""

import numpy as np
import pytest

import graincal as gc
from graincal import InputError, demo
from graincal.dem.stress_path_table import StressPathTable
from graincal.models import TESTS
from graincal.models.stress_path import IN_PASCAL

THETA = np.array([8.72, 0.227, 28.1, 0.079, 0.569])
PRESSURE = 0.5e6
OTHERS = (0.2e6, 123_456.7, 1e6)
STRAINS = [0.0, 0.001, 0.003, 0.0065]
PERCENT = "stress_x,stress_y,strain_z,stress_z\n{0},{0},,{1}\n{0},{0},0.002,\n{0},{2},0.004,\n"


@pytest.fixture(scope="module")
def packing():
    return demo.packing()


def run(test, at):
    """The response at a modulus that goes with the pressure."""
    theta = THETA + [np.log10(test.unit_of_stress / PRESSURE), 0, 0, 0, 0]
    (response,) = test.simulate([theta], at=at, threads=1)
    assert isinstance(response, gc.Response), response
    return response


def assert_proportional(one, other, pressure):
    """`other`, at this pressure, is `one` in proportion: bit for bit but for the stresses, which are a product."""
    there = one.at_pressure(pressure)
    assert there.confining_pressure == other.confining_pressure == pressure
    for name, values in other.values.items():
        if name in IN_PASCAL:
            np.testing.assert_allclose(there.values[name], values, rtol=1e-15, atol=1e-9, err_msg=name)
        else:
            np.testing.assert_array_equal(there.values[name], values, name)
    np.testing.assert_allclose(there.control, other.control, rtol=1e-15)


@pytest.mark.parametrize("accuracy", ["standard", "reference"])
@pytest.mark.parametrize("law", ["linear", "hertz-mindlin"])
def test_the_triaxial_test_is_the_same_at_every_pressure(packing, law, accuracy):
    runs = {pressure: run(gc.TriaxialTest(packing, pressure, law=law, accuracy=accuracy), STRAINS) for pressure in (PRESSURE, *OTHERS)}
    for pressure in OTHERS:
        assert_proportional(runs[PRESSURE], runs[pressure], pressure)
        assert runs[pressure].details["steps"] == runs[PRESSURE].details["steps"]


def test_a_density_scaling_of_ones_own_goes_with_the_pressure(packing):
    assert_proportional(
        run(gc.TriaxialTest(packing, PRESSURE, density_scaling=2e3), STRAINS),
        run(gc.TriaxialTest(packing, 2 * PRESSURE, density_scaling=4e3), STRAINS),
        2 * PRESSURE,
    )
    same = run(gc.TriaxialTest(packing, 2 * PRESSURE, density_scaling=2e3), STRAINS)
    assert not np.array_equal(same.values["stress_ratio"], run(gc.TriaxialTest(packing, 2 * PRESSURE), STRAINS).values["stress_ratio"])


@pytest.mark.parametrize("kind", sorted(TESTS.keys() - {"triaxial", "table"}))
@pytest.mark.parametrize("control", [0, -1], ids=["first control", "last control"])
def test_every_path_is_the_same_at_every_pressure(packing, kind, control):
    one, other = (TESTS[kind](packing, pressure, control=TESTS[kind].controls[control]) for pressure in (PRESSURE, 0.3e6))
    at = STRAINS if "stress" not in one.control else PRESSURE * np.array([1.0, 1.7, 1.2])
    assert_proportional(run(one, at), run(other, at if "stress" not in one.control else 0.6 * at), 0.3e6)


@pytest.mark.parametrize("consolidated", [True, False])
def test_a_table_whose_stresses_go_with_the_pressure_is_the_same(packing, tmp_path, consolidated):
    runs = []
    for pressure in (PRESSURE, 0.2e6):
        (tmp_path / "path.csv").write_text(PERCENT.format(pressure, 1.1 * pressure, 1.3 * pressure))
        test = gc.TableTest(packing, pressure if consolidated else None, table=StressPathTable.read(tmp_path / "path.csv"))
        runs.append(run(test, [1, 2, 3]))
    assert_proportional(*runs, runs[1].confining_pressure)


def test_a_response_without_a_pressure_is_not_taken_to_another():
    response = gc.Response(np.arange(3.0), {"stress_ratio": np.ones(3)})
    with pytest.raises(InputError, match="does not say at which confining pressure its test was run"):
        response.at_pressure(1e5)


def test_a_pressure_is_positive(packing):
    with pytest.raises(InputError, match="confining_pressure must be a positive number, not -1"):
        run(gc.TriaxialTest(packing, PRESSURE), [0.0]).at_pressure(-1)
