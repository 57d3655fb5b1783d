"""The figures of simulated tests are those that the field draws."""

import numpy as np
import pytest

from graincal import IsotropicTest, OedometricTest, Reference, Response, TableTest, TriaxialTest, UndrainedTest
from graincal.cli.figures import response_figure

STRESS = np.array([1e4, 1e5, 8e5, 1e5])
STRAIN = np.array([0.0, 0.01, 0.02, 0.015])


def figure(test, control, **columns):
    names = {name for panel in test.shown for name in (panel.column, panel.over) if name}
    values = {name: np.linspace(1.0, 2.0, 4) for name in names} | columns
    return response_figure(Response(values.pop(control), values), control, test.shown).axes


@pytest.mark.parametrize(("test", "control"), [(OedometricTest, "axial_stress"), (IsotropicTest, "mean_stress")])
def test_compression_is_drawn_as_void_ratio_over_the_logarithm_of_the_stress(test, control):
    axes = figure(test, control, **{control: STRESS}, axial_strain=STRAIN)
    (panel,) = [each for each in axes if each.get_ylabel() == "void ratio"]
    assert panel.get_xscale() == "log" and panel.get_xlabel() == f"{control.replace('_', ' ')} (kPa)"
    np.testing.assert_allclose(panel.lines[0].get_xdata(), STRESS / 1e3)


def test_an_undrained_test_has_its_stress_path():
    axes = figure(UndrainedTest, "axial_strain", axial_strain=STRAIN, mean_stress=STRESS, deviatoric_stress=STRESS)
    path = axes[-1]
    assert (path.get_xlabel(), path.get_ylabel()) == ("mean stress (kPa)", "deviatoric stress (kPa)") and path.get_xlim()[0] == 0


def test_recorded_states_are_marked_and_rounding_is_not_drawn_at_full_scale():
    stage = np.array([1.0, 2.0, 4.0, 5.0])
    ratio, volume = figure(TableTest, "stage", stage=stage, volumetric_strain=np.array([0.0, 3e-16, -1e-14, 1e-16]))
    for panel in (ratio, volume):
        assert panel.lines[0].get_marker() == "." and list(panel.lines[0].get_xdata()) == list(stage)
    low, high = volume.get_ylim()
    # In percent.
    assert high - low == pytest.approx(0.01)
    assert np.ptp(ratio.get_ylim()) < 1.5


def test_a_reference_is_drawn_as_points_on_a_line():
    reference = Reference(STRAIN[:3], {"stress_ratio": [1.0, 2.0, 3.0]})
    drawn = response_figure(Response(STRAIN[:3], {"stress_ratio": np.array([1.0, 2.1, 2.9])}), "axial_strain", TriaxialTest.shown, reference)
    simulated, measured = drawn.axes[0].lines
    assert (simulated.get_marker(), simulated.get_linestyle()) == ("None", "-") and (measured.get_marker(), measured.get_linestyle()) == (".", "None")
