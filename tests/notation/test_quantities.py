"""What quantities are called, and logarithms of them beside the quantities themselves."""

import math

import pytest

from graincal.notation.quantities import parameter, quantity


@pytest.mark.parametrize("unit", ["log10 Pa", "log10(Pa)", "log10 [Pa]"])
def test_a_logarithm_of_a_stiffness_has_the_stiffness_in_GPa_beside_it(unit):
    shown = parameter("log_E (0.5 MPa)", unit)
    assert shown.antilog.axis == "E (0.5 MPa) [GPa]" and shown.raised(9.0, 8.0) == pytest.approx((1.0, 0.1))
    # 10^8.48 = 0.302e9, 10^8.542 = 0.348e9.
    assert parameter("log_E", unit).without_log(8.48, 8.542) == " (E from 0.302 to 0.348 GPa)"
    assert parameter("log_E", unit).without_log(9.0) == " (E 1.00 GPa)"


def test_another_unit_than_pascals_is_kept():
    assert parameter("log_stiffness", "log10 N/m").without_log(math.log10(250.0)) == " (stiffness 250 N/m)"


def test_what_is_no_logarithm_to_base_10_has_nothing_beside_it():
    for shown in (parameter("phi", "deg"), parameter("log_E", ""), parameter("log_E", "log Pa"), parameter("modulus", "log10 Pa"), quantity("axial_strain")):
        assert shown.antilog is None and shown.without_log(1.0) == ""
