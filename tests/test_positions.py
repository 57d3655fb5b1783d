"""Positions along a path that a stress drives up and down."""

import numpy as np
import pytest

from graincal import InputError
from graincal.positions import first_way, legs, positions, stresses_at, turning_points

CYCLE = [2e3, 20e3, 320e3, 40e3, 2e3, 80e3, 640e3]
TURNS = (320e3, 2e3)


def test_a_position_is_the_way_that_the_logarithm_of_the_stress_has_gone():
    way = [0, np.log(10), np.log(160), np.log(160) + np.log(8), 2 * np.log(160), 2 * np.log(160) + np.log(40), 2 * np.log(160) + np.log(320)]
    np.testing.assert_allclose(positions(CYCLE, 2e3), way, rtol=1e-14, atol=1e-15)
    # The way from the confining pressure to the first row counts.
    np.testing.assert_allclose(positions([5e3], 2e3), [np.log(2.5)])
    np.testing.assert_allclose(positions(1e-3 * np.array(CYCLE), 2.0), way, rtol=1e-14, atol=1e-14)


def test_a_path_turns_around_where_its_stress_does():
    assert turning_points(CYCLE, 2e3) == TURNS
    # Where the stress stands still nothing turns, and a path may turn after its start.
    assert turning_points([20e3, 320e3, 320e3, 40e3, 40e3, 20e3], 2e3) == (320e3,)
    assert turning_points([2e3, 8e3], 4e3) == (2e3,)
    assert turning_points([4e3, 8e3], 4e3) == turning_points([], 4e3) == ()


# stresses from 10, how far they may go back, where they turn around
WAVERING = [
    ([10, 20, 19.9, 40], 0.02, ()),
    ([10, 20, 19.9, 40], 0.0, (20, 19.9)),
    ([10, 20, 19, 40], 0.02, (20, 19)),
    # The furthest row is the turn, and small ones beside it are not.
    ([10, 40, 40.2, 39.9, 40.1, 20, 20.1, 19.9, 80], 0.02, (40.2, 19.9)),
    # Many small ones in a row come to a large one.
    ([10, 20, 19.8, 19.6, 19.4, 30], 0.02, (20, 19.4)),
    ([9.9, 10, 20], 0.02, ()),
    ([10, 10.1, 9.95], 0.02, ()),
    ([5, 5.05, 4, 8], 0.02, (4,)),
    ([], 0.02, ()),
]


@pytest.mark.parametrize(("stresses", "within", "turns"), WAVERING)
def test_a_path_that_wavers_does_not_turn_around(stresses, within, turns):
    assert turning_points(stresses, 10, within) == turns
    # On the rows that go on, a position is that of the path between its turns, which is one without noise.
    found = positions(stresses, 10, within)
    onward = np.flatnonzero(found >= np.maximum.accumulate(found)) if stresses else []
    kept = [row for row in onward if found[row] > 0]
    np.testing.assert_allclose(stresses_at(found[kept], 10, turns), np.array(stresses)[kept], rtol=1e-12)


def test_stresses_and_positions_are_each_others_inverse():
    np.testing.assert_allclose(stresses_at(positions(CYCLE, 2e3), 2e3, TURNS), CYCLE, rtol=1e-12)
    assert stresses_at(0.0, 2e3) == 2e3 and stresses_at(np.log(10), 2e3) == pytest.approx(20e3)
    # Down first, and on without bound after the last turn.
    np.testing.assert_allclose(stresses_at([np.log(2), np.log(4), np.log(32)], 8e3, [4e3]), [4e3, 8e3, 64e3])
    assert (first_way(8e3, [4e3]), first_way(8e3, [9e3]), first_way(8e3, [])) == (-1, 1, 1)


def test_legs_are_what_goes_one_way():
    assert [CYCLE[leg] for leg in legs(CYCLE)] == [[2e3, 20e3, 320e3], [320e3, 40e3, 2e3], [2e3, 80e3, 640e3]]
    assert legs([1, 2, 2, 1]) == [slice(0, 3), slice(2, 4)] and legs([3, 2]) == [slice(0, 2)] and legs([3]) == [slice(0, 1)]


@pytest.mark.parametrize(("stresses", "start"), [([1e3, 0.0], 1e3), ([1e3, np.nan], 1e3), ([[1e3]], 1e3), ([1e3], 0.0)])
def test_what_is_no_stress_is_refused(stresses, start):
    with pytest.raises(InputError, match="one row of finite numbers above 0"):
        positions(stresses, start)
