import numpy as np
import pytest
from scipy.stats import qmc

from graincal.data import InputError, ParameterSpace
from graincal.inference.sampling.samples import halton, number_of_samples

SPACE = ParameterSpace.paper()


@pytest.mark.parametrize(("parameters", "count"), [(5, 80), (4, 55), (3, 33), (2, 20), (1, 20)])
def test_number_of_samples_is_that_of_eq_4(parameters, count):
    """alpha n ln n = 80.5, 55.5, 33.0 for five, four, three parameters; below, where n ln n is small, twice alpha."""
    assert number_of_samples(parameters, 10) == count


@pytest.mark.parametrize("alpha", [0, -1, np.nan, np.inf, 0.5])
def test_an_alpha_that_gives_no_batch_is_refused(alpha):
    with pytest.raises(InputError, match="alpha"):
        number_of_samples(1, alpha)


def test_one_seed_gives_one_set_of_points_and_another_seed_another():
    first, again, other = (halton(SPACE, 80, np.random.default_rng(seed)) for seed in (1, 1, 2))
    assert np.array_equal(first, again)
    assert np.all(first != other)


def test_points_lie_in_the_box_and_do_not_begin_in_its_corner():
    """The plain sequence begins at the corner; a scrambled one begins anywhere, so over 200 seeds the mean of its first point is the centre.

    A uniform coordinate has the standard deviation 0.289, its mean over 200 seeds 0.020; 5 of those are 0.10.
    """
    first = []
    for seed in range(200):
        theta = halton(SPACE, 80, np.random.default_rng(seed))
        assert SPACE.contains(theta).all()
        first.append(SPACE.to_unit(theta)[0])
    assert np.abs(np.mean(first, axis=0) - 0.5).max() < 0.10


def test_points_fill_the_box_more_evenly_than_random_ones():
    random = [qmc.discrepancy(np.random.default_rng(seed).random((80, 5))) for seed in range(20)]
    even = [qmc.discrepancy(SPACE.to_unit(halton(SPACE, 80, np.random.default_rng(seed)))) for seed in range(20)]
    assert max(even) < min(random)


def test_more_samples_than_can_be_held_are_refused():
    with pytest.raises(InputError, match="at most 1000000"):
        number_of_samples(5, alpha=1e9)
