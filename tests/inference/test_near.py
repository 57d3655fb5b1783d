"""Variances of an emulator made what the evaluations near a place show."""

from __future__ import annotations

import numpy as np
import pytest

from graincal import Reference
from graincal.inference.emulator.emulator import Emulator
from graincal.inference.emulator.near import BEFORE, WIDTH, NearBy

STRAIN = np.linspace(0, 1, 12)


def responses(unit):
    """Smooth in the one half of the box, and waves in the other."""
    rough = 1 / (1 + np.exp(-60 * (unit[:, :1] - 0.6)))
    amplitude = unit[:, :1] + 0.4 * unit[:, 1:] + 0.15 * rough * np.sin(25 * unit[:, :1] + 12 * unit[:, 1:])
    return (amplitude * STRAIN)[..., None]


@pytest.fixture(scope="module", params=[5, 6, 7])
def emulators(request):
    """The same, trusted as it is and by what the evaluations show, and places that it has not seen."""
    rng = np.random.default_rng(request.param)
    unit = rng.random((160, 2))
    reference = Reference(STRAIN, {"q": responses(np.array([[0.3, 0.5]]))[0, :, 0]})
    plain, trusted = Emulator(unit, responses(unit), reference), Emulator(unit, responses(unit), reference)
    trusted.trust(np.full(160, 1 / 160))
    return plain, trusted, rng.random((2000, 2))


def test_it_is_more_nearly_as_sure_as_it_is_right_where_responses_change_fast_and_where_slowly(emulators):
    plain, trusted, new = emulators
    true = (responses(new)[..., 0] - plain.centre) @ np.linalg.pinv(plain.basis).T
    of_plain, of_trusted = [], []
    for part in (new[:, 0] < 0.5, new[:, 0] > 0.7):
        for found, emulator in ((of_plain, plain), (of_trusted, trusted)):
            mean, variance = emulator.predict(new[part])
            total = variance[:, 0] + emulator.nuggets[0]
            squares = (true[part, 0] - mean[:, 0]) ** 2
            found.append((np.sqrt(np.mean(squares / total)), np.mean(-0.5 * (np.log(total) + squares / total))))
    assert of_plain[0][0] < 0.7
    for (off, density), (off_before, density_before) in zip(of_trusted, of_plain):
        assert abs(np.log(off)) < abs(np.log(off_before)) and density > density_before


def test_draws_scatter_as_much_as_is_predicted(emulators):
    _, trusted, new = emulators
    mean, variance = trusted.predict(new[:20])
    drawn = trusted.draw(new[:20], 4000, np.random.default_rng(1))
    np.testing.assert_allclose(drawn.mean(axis=0), mean, atol=0.1 * np.sqrt(variance.max()))
    np.testing.assert_allclose(drawn.std(axis=0), np.sqrt(variance), rtol=0.1)


def test_factors_are_means_of_what_is_near():
    points = np.array([[0.2, 0.2], [0.2, 0.2], [0.9, 0.9]])
    near = NearBy(points, np.array([[4.0], [2.0], [100.0]]), np.array([1.5]))
    # Two at the place itself, and the third out of sight.
    assert near.at(points[:1])[0, 0] == pytest.approx((BEFORE * 1.5 + 6) / (BEFORE + 2))
    assert near.at(np.array([[0.9, 0.1]]))[0, 0] == pytest.approx(1.5, abs=1e-6)
    # A standard deviation off in each coordinate.
    weight = np.exp(-0.5)
    assert near.at(points[2:] - WIDTH)[0, 0] == pytest.approx((BEFORE * 1.5 + 100 * weight) / (BEFORE + weight))
    np.testing.assert_allclose(near.held_out()[:, 0], [(BEFORE * 1.5 + 2) / (BEFORE + 1), (BEFORE * 1.5 + 4) / (BEFORE + 1), 1.5])
