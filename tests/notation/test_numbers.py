"""Numbers as they are written."""

import pytest

from graincal.notation.numbers import between, duration, estimate, percent, pressure, short, value, within


@pytest.mark.parametrize(
    ("mean", "spread", "written"),
    [
        (28.43, 1.13, "28.4 ± 1.1"),
        (0.2134, 0.00987, "0.2134 ± 0.0099"),
        (-3.2, 0.5, "−3.20 ± 0.50"),
        (2.1e8, 1.24e7, "(2.10 ± 0.12) × 10^{8}"),
        (3.1e-6, 2e-7, "(3.10 ± 0.20) × 10^{−6}"),
        (1234.0, 56.0, "1234 ± 56"),
        (12345.0, 678.0, "12340 ± 680"),
        (0.5, 0.0, "0.5000 ± 0.0000"),
    ],
)
def test_an_estimate_has_two_digits_of_its_deviation(mean, spread, written):
    assert estimate(mean, spread) == written


def test_percents_have_no_exponent():
    assert [percent(error, 2) for error in (0.0123, 1.57, 9.96, 107.4, 1234.5)] == ["0.012 %", "1.6 %", "10.0 %", "107 %", "1234 %"]
    assert [percent(error) for error in (1.567, 23.44, 107.4, float("nan"))] == ["1.57 %", "23.4 %", "107 %", "– %"]


def test_what_rounds_to_zero_has_no_sign():
    assert within(-1e-7, (-0.016, 0.016)) == "0.000"
    assert within(-1e-3, (-0.016, 0.016)) == "−0.001"


def test_other_numbers():
    assert between(0.208, 0.883) == "0.21 to 0.88"
    assert between(1.8e8, 1.8e9) == "1.8 × 10^{8} to 1.8 × 10^{9}"
    assert between(1.98e8, 2.31e8) == "(1.98 to 2.31) × 10^{8}"
    assert [short(number) for number in (0.0, 0.5, 60.0, 1000.0, 2e8)] == ["0", "0.5", "60", "1000", "2 × 10^{8}"]
    assert value(float("nan")) == "–"
    assert [duration(seconds) for seconds in (4e-6, 0.012, 59, 90, 7200)] == ["4 µs", "12 ms", "59 s", "1.5 min", "2 h"]
    assert (pressure(0.5e6), pressure(1e6)) == ("500 kPa", "1 MPa")
