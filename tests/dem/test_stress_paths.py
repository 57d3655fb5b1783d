"""Stress paths: each keeps its law at every state that it records, and the sample answers as a granular one does."""

import numpy as np
import pytest

from graincal import _native, demo
from graincal.dem.batch import run_batch
from graincal.dem.stress_path import (
    AXIAL_RATE,
    constant_mean_stress,
    drained_triaxial,
    isotropic,
    oedometric,
    oedometric_to_stresses,
    undrained_triaxial,
)

from .spheres import law

PRESSURE = 2e5
STRAINS = [0.0, 0.002, 0.005, 0.01, 0.02]
LATERAL, AXIAL = ("stress_xx", "stress_yy"), "stress_zz"

STRESS = 1e-3
"""The engine's tolerance of a stress, relative to its target."""

ROUNDING = 2e-12
"""Of strains that are imposed. A state is looked at for the second time when it is recorded, and was within 1e-6 of each strain at the first; the step in
between makes up for that but for half its square, 5e-13 an axis."""


def grains(friction_angle=30.0):
    return law(10**7.8, 0.2, np.tan(np.radians(friction_angle)), 0.1, 0.3)


def states(stages, contact_law=None):
    """The recorded states of the embedded packing along the stages, all of them at rest."""
    (run,) = run_batch(demo.packing(), [contact_law or grains()], stages, density=2.65e6, expected_steps=[1], threads=1, step_limit=300_000)
    assert run.status == "finished" and not run.consolidation_flagged and not run.columns["flagged"].any()
    return run.columns


def mean_stress(c):
    return (c["stress_xx"] + c["stress_yy"] + c["stress_zz"]) / 3


def volumetric_strain(c):
    return c["strain_x"] + c["strain_y"] + c["strain_z"]


def earth_pressure(c):
    """The coefficient of earth pressure at rest K0: lateral over axial stress."""
    return (c["stress_xx"] + c["stress_yy"]) / 2 / c[AXIAL]


def test_extension_holds_the_lateral_stresses_and_lets_the_axial_one_fall():
    extended, compressed = (states(drained_triaxial(PRESSURE, sign * np.array(STRAINS))) for sign in (-1, 1))
    for c, sign in ((extended, -1), (compressed, 1)):
        assert np.allclose(c["strain_z"], sign * np.array(STRAINS), rtol=0, atol=1e-6)
        for lateral in LATERAL:
            assert np.allclose(c[lateral], PRESSURE, rtol=STRESS, atol=0)
    assert np.all(np.diff(extended[AXIAL]) < 0) and np.all(extended[AXIAL] > 0)
    # The mean stress falls, and the sample swells from the first; in compression it rises, and a sample of this density contracts at first.
    assert np.all(np.diff(volumetric_strain(extended)) < 0) and volumetric_strain(compressed)[1] > 0


@pytest.mark.parametrize("sign", [1, -1], ids=["compression", "extension"])
def test_the_mean_stress_is_constant_while_the_sample_is_sheared(sign):
    c = states(constant_mean_stress(PRESSURE, sign * np.array(STRAINS)))
    # Each lateral stress is within a thousandth of its target (3p - axial)/2, which is at most 3/2 p: their sum puts the mean within a thousandth of p.
    assert np.allclose(mean_stress(c), PRESSURE, rtol=STRESS, atol=0)
    target = (3 * PRESSURE - c[AXIAL]) / 2
    for lateral in LATERAL:
        assert np.all(np.abs(c[lateral] - target) <= STRESS * target)
    assert np.allclose(c["strain_z"], sign * np.array(STRAINS), rtol=0, atol=1e-6)
    assert np.all(np.diff(sign * (c[AXIAL] - c[LATERAL[0]])) > 0)


@pytest.mark.parametrize("sign", [1, -1], ids=["compression", "extension"])
def test_an_undrained_sample_keeps_its_volume(sign):
    c = states(undrained_triaxial(PRESSURE, sign * np.array(STRAINS)))
    assert np.allclose(volumetric_strain(c), 0, rtol=0, atol=ROUNDING) and np.allclose(c["volume"], c["volume"][0], rtol=ROUNDING, atol=0)
    assert np.allclose(c["strain_z"], sign * np.array(STRAINS), rtol=0, atol=ROUNDING) and np.allclose(c["strain_x"], c["strain_y"], rtol=0, atol=ROUNDING)
    # What would drain contracts at first: the skeleton gives its lateral stress up to the water in compression, and takes it over in extension.
    assert np.all(np.diff(sign * c[LATERAL[0]]) < 0)


def test_an_undrained_sample_keeps_its_volume_on_the_way_too():
    # The lateral axes go at half the axial rate. A step makes a length 1 + r dt times what it was, and volumes (1 - r dt)(1 + r dt/2)^2 = 1 - 3/4 (r dt)^2:
    # after a strain of ε that is 3/4 ε r dt. The axes' last steps differ by what has gone astray before, which is no more; twice the figure is allowed.
    packing, strain = demo.packing(), 0.002
    simulation = _native.Simulation(packing.positions, packing.radii, packing.edges, grains(), 2.65e6)
    simulation.run(1, 0.2)
    simulation.restart_strain()
    lateral = _native.AxisGoal(False, -0.5 * strain, 0.5 * AXIAL_RATE)
    simulation.set_goals([lateral, lateral, _native.AxisGoal(False, strain, AXIAL_RATE)])
    volume, largest, moving = np.linalg.det(simulation.edges), 0.0, 0
    while simulation.steps < 2000:
        simulation.run(1, 0.2)
        rates = np.diag(simulation.velocity_gradient)
        if rates[2] == -AXIAL_RATE:
            assert rates[0] == rates[1] == 0.5 * AXIAL_RATE
            moving += 1
        largest = max(largest, abs(np.linalg.det(simulation.edges) / volume - 1))
    assert moving > 20
    assert largest < 2 * 0.75 * strain * AXIAL_RATE * simulation.time_step
    assert np.linalg.det(simulation.edges) == pytest.approx(volume, rel=ROUNDING)


def test_oedometric_compression_has_no_lateral_strain_and_a_lateral_stress_below_the_axial_one():
    c = states(oedometric(PRESSURE, STRAINS))
    assert np.array_equal(c["strain_x"], np.zeros(5)) and np.array_equal(c["strain_y"], np.zeros(5))  # the rate of a strain that is met is zero
    assert np.allclose(c["strain_z"], STRAINS, rtol=0, atol=ROUNDING) and np.all(np.diff(c[AXIAL]) > 0)
    assert earth_pressure(c)[0] == pytest.approx(1, rel=2 * STRESS) and np.all(np.diff(earth_pressure(c)) < 0) and earth_pressure(c)[-1] > 0


def test_an_oedometer_is_loaded_to_stresses_and_unloaded():
    stresses = np.array([2e5, 4e5, 8e5, 4e5, 2e5])
    c = states(oedometric_to_stresses(PRESSURE, stresses))
    assert np.all(np.abs(c[AXIAL] - stresses) <= STRESS * stresses)
    assert np.array_equal(c["strain_x"], np.zeros(5)) and np.array_equal(c["strain_y"], np.zeros(5))
    assert c["strain_z"][4] < c["strain_z"][3] < c["strain_z"][2]
    # At the largest stress, four times what it was consolidated to, the coefficient is that of sands: 1 - sin φ' by Jaky, 0.35 to 0.6 for angles of friction
    # of the sample from 40 to 24 degrees. Unloading leaves a part of the lateral stress locked in.
    assert 0.35 < earth_pressure(c)[2] < 0.6
    assert earth_pressure(c)[3] > earth_pressure(c)[1] and earth_pressure(c)[4] > earth_pressure(c)[3]


CYCLE = np.array([5e4, 2e5, 4e5, 8e5, 4e5, 2e5, 5e4])


@pytest.fixture(scope="module")
def smooth_cycle():
    """An isotropic cycle of grains that slide easily."""
    return states(isotropic(CYCLE[0], CYCLE), grains(friction_angle=5.0))


def test_an_isotropic_cycle_meets_its_pressures_on_each_axis(smooth_cycle):
    for stress in (*LATERAL, AXIAL):
        assert np.all(np.abs(smooth_cycle[stress] - CYCLE) <= STRESS * CYCLE)


def test_a_sample_that_was_compressed_stays_denser_when_unloaded(smooth_cycle):
    def lost(c):
        """By how much the void ratio of unloading is below that of loading at the same pressure, and what two stresses within their tolerance make of it."""
        void_ratio = c["volume"] / demo.packing().solid_volume - 1
        steepest = np.abs(np.diff(void_ratio) / np.diff(CYCLE)).max()
        return void_ratio[:3] - void_ratio[:3:-1], 2 * STRESS * CYCLE[:3] * steepest

    # Grains that slide do not slide back.
    loss, tolerance = lost(smooth_cycle)
    assert np.all(loss > 10 * tolerance)
    # Rough grains hardly slide under equal stresses, and their springs give it all back: the cycle is as reversible as the stresses are met.
    loss, tolerance = lost(states(isotropic(CYCLE[0], CYCLE), grains(friction_angle=45.0)))
    assert np.all(np.abs(loss) < tolerance)
