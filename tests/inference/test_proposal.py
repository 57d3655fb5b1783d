import numpy as np
import pytest
from scipy.integrate import cumulative_simpson, simpson
from scipy.stats import kstest, multivariate_normal, norm

from graincal.data import ParameterSpace
from graincal.inference.sampling.proposal import ProposalOutsideBox, TruncatedMixture, fit_mixture, systematic_resampling

ONE = ParameterSpace({"a": (-3, 5)})
TWO = ParameterSpace({"a": (-3, 5), "b": (0, 0.5)})
MIXTURE_1D = TruncatedMixture(ONE, np.array([0.3, 0.7]), np.array([[0.05], [0.8]]), np.array([[[0.01]], [[0.09]]]))
MIXTURE_2D = TruncatedMixture(
    TWO,
    np.array([0.4, 0.6]),
    np.array([[0.1, 0.95], [0.7, 0.4]]),
    np.array([[[0.04, -0.03], [-0.03, 0.09]], [[0.05, 0.04], [0.04, 0.05]]]),
)


def test_systematic_resampling_keeps_the_expectation():
    """Each row appears floor or ceil of count * w times, and count * w on average: over 4,000 seeds the mean of a difference below 1
    has a standard deviation below 0.5 / sqrt(4000) = 0.008; 5 of those are allowed. Rows of weight zero never appear."""
    weights = np.random.default_rng(1).dirichlet(np.full(12, 0.5))
    weights[[0, 5, 11]] = 0
    weights /= weights.sum()
    counts = np.array([np.bincount(systematic_resampling(weights, 50, np.random.default_rng(seed)), minlength=12) for seed in range(4000)])
    assert np.all(counts.sum(axis=1) == 50)
    assert np.all(np.abs(counts - 50 * weights) < 1)
    assert np.abs(counts.mean(axis=0) - 50 * weights).max() < 0.04
    assert np.all(counts[:, [0, 5, 11]] == 0)


def test_small_weights_are_not_lost_to_rounding_down():
    """A hundred samples of equal small weight beside a heavy one: copies counted by floor() would drop all hundred."""
    weights = np.concatenate([[0.9], np.full(100, 0.001)])
    rows = systematic_resampling(weights, 500, np.random.default_rng(0))
    assert np.sum(rows > 0) == 50


def test_rounding_never_carries_a_draw_past_the_last_row():
    """(count - 1 + u) / count is 1 in floating point for the largest u below 1; the last row that may be drawn is the last with weight."""

    class Largest:
        def random(self):
            return np.nextafter(1, 0)

    assert systematic_resampling(np.array([0.5, 0.5, 0.0]), 4, Largest())[-1] == 1


def test_the_density_of_a_truncated_mixture_integrates_to_one():
    """Simpson's rule on smooth densities is exact to 1e-8 here; what is left is the mass, known to 1e-4 in two dimensions."""
    a = np.linspace(-3, 5, 2001)
    assert simpson(np.exp(MIXTURE_1D.log_density(a[:, None])), x=a) == pytest.approx(1, abs=1e-6)
    b = np.linspace(0, 0.5, 401)
    grid = np.stack(np.meshgrid(a[::5], b, indexing="ij"), axis=-1)
    density = np.exp(MIXTURE_2D.log_density(grid.reshape(-1, 2))).reshape(grid.shape[:2])
    assert simpson(simpson(density, x=b), x=a[::5]) == pytest.approx(1, abs=2e-4)


def test_the_density_outside_the_box_is_zero():
    assert np.all(MIXTURE_2D.log_density(np.array([[-3.01, 0.2], [0.0, 0.51]])) == -np.inf)
    assert np.isfinite(MIXTURE_2D.log_density(np.array([[-3.0, 0.5]])))[0]


@pytest.mark.parametrize("size", [1, 2, 5])
def test_the_mass_in_the_box_is_that_of_the_gaussian(size):
    rng = np.random.default_rng(size)
    space = ParameterSpace({str(i): (0, 1) for i in range(size)})
    root = 0.4 * rng.standard_normal((size, size))
    covariance = root @ root.T + 0.01 * np.eye(size)
    mean = rng.random(size)
    mixture = TruncatedMixture(space, np.ones(1), mean[None], covariance[None])
    expected = multivariate_normal(mean, covariance, maxpts=2_000_000, abseps=1e-7).cdf(np.ones(size), lower_limit=np.zeros(size))
    assert mixture.mass == pytest.approx(expected, rel=1e-3)


def test_draws_follow_the_density_in_one_dimension():
    draws = MIXTURE_1D.draw(4000, np.random.default_rng(2))[:, 0]
    a = np.linspace(-3, 5, 2001)
    distribution = cumulative_simpson(np.exp(MIXTURE_1D.log_density(a[:, None])), x=a, initial=0)
    assert kstest(draws, lambda at: np.interp(at, a, distribution)).pvalue > 0.001


def test_draws_follow_the_density_in_two_dimensions():
    """Each coordinate against its marginal, and their product moment: its standard deviation over 4,000 draws is below 0.5 / sqrt(4000)."""
    draws = MIXTURE_2D.draw(4000, np.random.default_rng(3))
    assert TWO.contains(draws).all()
    a, b = np.linspace(-3, 5, 401), np.linspace(0, 0.5, 401)
    grid = np.stack(np.meshgrid(a, b, indexing="ij"), axis=-1)
    density = np.exp(MIXTURE_2D.log_density(grid.reshape(-1, 2))).reshape(grid.shape[:2])
    for values, at, marginal in ((draws[:, 0], a, simpson(density, x=b, axis=1)), (draws[:, 1], b, simpson(density, x=a, axis=0))):
        distribution = cumulative_simpson(marginal, x=at, initial=0)
        assert kstest(values, lambda x, at=at, distribution=distribution: np.interp(x, at, distribution)).pvalue > 0.001
    unit, unit_grid = TWO.to_unit(draws), TWO.to_unit(grid.reshape(-1, 2)).reshape(grid.shape)
    product = simpson(simpson(density * unit_grid[..., 0] * unit_grid[..., 1], x=b), x=a)
    assert np.mean(unit[:, 0] * unit[:, 1]) == pytest.approx(product, abs=5 * 0.5 / np.sqrt(4000))


def test_truncation_keeps_the_correlation_of_a_narrow_ridge():
    """A ridge along the diagonal that sticks out at both corners: its points stay on it, as replacing coordinates one by one would not."""
    space = ParameterSpace({"a": (0, 1), "b": (0, 1)})
    ridge = np.array([[0.25, 0.25], [0.25, 0.25]]) + 1e-4 * np.eye(2)
    draws = TruncatedMixture(space, np.ones(1), np.full((1, 2), 0.9), ridge[None]).draw(500, np.random.default_rng(4))
    # a - b has the standard deviation sqrt(2e-4) = 0.0141.
    assert np.abs(draws[:, 0] - draws[:, 1]).max() < 5 * 0.0142


def test_a_mixture_that_misses_the_box_says_so():
    astray = TruncatedMixture(ONE, np.ones(1), np.array([[2.0]]), np.array([[[0.01]]]))
    with pytest.raises(ProposalOutsideBox, match="lies within the parameters' ranges"):
        astray.draw(10, np.random.default_rng(0))


def test_a_mixture_in_a_corner_of_many_dimensions_is_still_drawn_from():
    """Centred on a corner of eight dimensions, a mixture has 2^-8 of its mass in the box."""
    space = ParameterSpace({str(i): (0, 1) for i in range(8)})
    corner = TruncatedMixture(space, np.ones(1), np.zeros((1, 8)), 0.01 * np.eye(8)[None])
    assert corner.mass == pytest.approx(2**-8, rel=1e-6)
    draws = corner.draw(200, np.random.default_rng(0))
    assert draws.shape == (200, 8) and space.contains(draws).all()


@pytest.mark.parametrize("covariance", ["tied", "full"])
def test_a_fit_has_the_mean_and_the_spread_of_the_weighted_samples(covariance):
    """A mixture has mean sum_k p_k m_k and covariance sum_k p_k (C_k + m_k m_k') - mean mean'. Resampling moves less than one copy in 2,000
    per row; the prior is worth one copy for the means and two for the covariances of each of up to 20 components of 100 copies: a few percent."""
    unit = np.random.default_rng(6).random((200, 2))
    weights = norm.pdf(unit[:, 0], 0.4, 0.1) * norm.pdf(unit[:, 1], 0.6 + 0.5 * (unit[:, 0] - 0.4), 0.1)
    weights /= weights.sum()
    proposal = fit_mixture(TWO, TWO.from_unit(unit), weights, np.random.default_rng(0), covariance=covariance)
    assert 1 <= len(proposal.weights) <= 20
    assert proposal.weights.sum() == pytest.approx(1, abs=1e-12)
    mean = proposal.weights @ proposal.means
    second = np.einsum("k,kij->ij", proposal.weights, proposal.covariances + np.einsum("ki,kj->kij", proposal.means, proposal.means))
    expected = weights @ unit
    spread = np.cov(unit.T, aweights=weights, ddof=0)
    assert np.abs(mean - expected).max() < 0.05 * 0.1
    assert np.allclose(second - np.outer(mean, mean), spread, rtol=0.1)


@pytest.mark.parametrize("covariance", ["tied", "full"])
def test_a_fit_survives_a_single_surviving_sample(covariance):
    theta = TWO.from_unit(np.random.default_rng(7).random((20, 2)))
    theta[3] = TWO.high
    weights = np.zeros(20)
    weights[3] = 1
    draws = fit_mixture(TWO, theta, weights, np.random.default_rng(0), covariance=covariance).draw(20, np.random.default_rng(1))
    assert TWO.contains(draws).all()
    assert np.abs(TWO.to_unit(draws) - 1).max() < 0.01


@pytest.mark.parametrize("covariance", ["tied", "full"])
def test_a_fit_survives_a_dimension_that_has_collapsed(covariance):
    theta = TWO.from_unit(np.random.default_rng(8).random((80, 2)))
    theta[:, 1] = 0.2
    draws = fit_mixture(TWO, theta, np.full(80, 1 / 80), np.random.default_rng(0), covariance=covariance).draw(400, np.random.default_rng(1))
    assert np.abs(draws[:, 1] - 0.2).max() < 0.01 * 0.5
    assert draws[:, 0].std() > 0.2 * 8
