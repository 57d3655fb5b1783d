import numpy as np
import pytest
from scipy.stats import norm

from graincal.data import InputError, Reference
from graincal.inference.sampling.weights import (
    UnreachableSampleSize,
    effective_sample_size,
    error_scale,
    log_weights,
    misfit,
    solve_s,
)

from .curves import CENTRED, LINE_SPACE, SHEAR_SPACE, SHEAR_TRUTH, line, reference_of, shear

RNG_SEED = 3


def thetas(space, count=80):
    return space.from_unit(np.random.default_rng(RNG_SEED).random((count, space.size)))


def shear_misfits(scale="peak", shares=None, count=80):
    response = np.array([shear(theta) for theta in thetas(SHEAR_SPACE, count)])
    return misfit(response, reference_of(shear(SHEAR_TRUTH), shares=shares), scale)


def final_weights(misfits, s):
    return np.exp(log_weights(misfits, s))[-1]


def test_on_a_linear_model_the_weights_after_every_state_are_the_closed_form():
    """The product of the first t Gaussian likelihoods is a Gaussian in (slope, offset) with the normal equations of
    those states, whatever the samples. 1e-10: sums of 51 terms of order 10 carry errors of 1e-14, relative, into the weights."""
    truth = np.array([2.0, 0.3])
    y = line(truth)
    theta = thetas(LINE_SPACE)
    s = 0.05
    weights = np.exp(log_weights(misfit(np.array([line(one) for one in theta]), reference_of(y)), s))
    assert weights.shape == (51, 80)
    variance = s * np.abs(y).max() ** 2
    for t in range(51):
        design = np.stack([CENTRED[: t + 1], np.ones(t + 1)], axis=1)
        precision = design.T @ design / variance
        density = np.exp(-0.5 * np.einsum("ij,jk,ik->i", theta - truth, precision, theta - truth))
        assert np.abs(weights[t] - density / density.sum()).max() < 1e-10


def test_weights_follow_the_recursion_from_equal_weights():
    """w_t = w_(t-1) p(y_t | x_t), normalised, with the densities of two observables written out; W has determinant 1: 0.2 and 0.8 give 1/2 and 2."""
    s, y = 0.3, shear(SHEAR_TRUTH)
    x = np.array([shear(theta) for theta in thetas(SHEAR_SPACE)])
    weights = np.exp(log_weights(misfit(x, reference_of(y, shares=(0.2, 0.8))), s))
    expected = np.full(80, 1 / 80)
    for t in range(51):
        for j, relative_variance in enumerate((0.5, 2.0)):
            expected = expected * norm.pdf(y[t, j], x[:, t, j], np.sqrt(s * relative_variance) * np.abs(y[:, j]).max())
        expected /= expected.sum()
        assert np.abs(weights[t] - expected).max() < 1e-10


@pytest.mark.parametrize("target", [0.02, 0.1, 0.3, 0.7, 0.99])
def test_the_effective_sample_size_meets_its_target(target):
    misfits = shear_misfits()
    assert effective_sample_size(final_weights(misfits, solve_s(misfits, target))) == pytest.approx(target, abs=1e-9)


@pytest.mark.parametrize("unit", [1e-200, 1e-12, 1e-6, 1.0, 1e6, 1e200])
def test_s_is_found_at_every_magnitude_of_the_misfit(unit):
    """s is proportional to the misfit: a solver to an absolute tolerance loses small ones."""
    misfits = shear_misfits()
    assert solve_s(unit * misfits, 0.3) / unit == pytest.approx(solve_s(misfits, 0.3), rel=1e-9)


def test_samples_that_are_all_far_away_are_compared_without_underflow():
    """Adding the same misfit to all samples changes no weight, although every plain density is then exp(-5e6) = 0."""
    misfits = shear_misfits()
    s = solve_s(misfits, 0.3)
    far = misfits + 1e7 * s
    assert np.exp(-far.sum(axis=1) / (2 * s)).max() == 0
    assert solve_s(far, 0.3) == pytest.approx(s, rel=1e-6)
    # The sum is 5e8 s: its rounding is 1e-16 * 5e8 / 2.
    assert np.abs(final_weights(far, s) - final_weights(misfits, s)).max() < 1e-6
    farther = misfits + 1e10 * s
    assert effective_sample_size(final_weights(farther, solve_s(farther, 0.3))) == pytest.approx(0.3, abs=1e-9)


def test_s_grows_with_the_number_of_states_and_s_per_state_does_not():
    misfits = shear_misfits()
    assert solve_s(np.repeat(misfits, 4, axis=1), 0.3) == pytest.approx(4 * solve_s(misfits, 0.3), rel=1e-9)


def test_failures_have_weight_zero_and_count_among_the_samples():
    misfits = shear_misfits()
    with_failures = np.concatenate([misfits, np.full((20, 51), np.inf)])
    weights = final_weights(with_failures, solve_s(with_failures, 0.3))
    assert np.all(weights[80:] == 0)
    assert weights.sum() == pytest.approx(1, abs=1e-12)
    assert effective_sample_size(weights) == pytest.approx(0.3, abs=1e-9)
    # 0.3 of 100 samples is 0.375 of the 80 that did not fail.
    assert np.allclose(weights[:80], final_weights(misfits, solve_s(misfits, 0.375)), rtol=0, atol=1e-9)


def test_one_response_that_is_not_a_number_leaves_the_other_weights_alone():
    response = np.array([shear(theta) for theta in thetas(SHEAR_SPACE)])
    reference = reference_of(shear(SHEAR_TRUTH))
    spoilt = response.copy()
    spoilt[7, 30, 1] = np.nan
    others = np.arange(80) != 7
    weights = np.exp(log_weights(misfit(spoilt, reference), 0.3))
    expected = np.exp(log_weights(misfit(response[others], reference), 0.3))
    assert np.all(weights[30:, 7] == 0)
    assert np.allclose(weights[30:, others], expected[30:], rtol=1e-12, atol=0)


def test_a_response_too_large_to_square_counts_as_infinitely_far():
    response = np.array([shear(theta) for theta in thetas(SHEAR_SPACE)])
    response[0] = 1e300
    assert np.all(misfit(response, reference_of(shear(SHEAR_TRUTH)))[0] == np.inf)


@pytest.mark.parametrize("failures", [56, 60, 79, 80])
def test_too_many_failures_for_the_target_are_said(failures):
    """24 of 80 samples left can reach 0.3 only at infinite s; with fewer not even then."""
    misfits = shear_misfits()
    misfits[:failures] = np.inf
    with pytest.raises(UnreachableSampleSize, match=f"only {80 - failures} of 80 samples have a usable response"):
        solve_s(misfits, 0.3)


def test_just_enough_valid_samples_are_enough():
    misfits = shear_misfits()
    misfits[:55] = np.inf
    weights = final_weights(misfits, solve_s(misfits, 0.3))
    assert effective_sample_size(weights) == pytest.approx(0.3, abs=1e-9)


@pytest.mark.parametrize(("tied", "solvable"), [(23, True), (24, False), (80, False)])
def test_too_many_equally_good_samples_for_the_target_are_said(tied, solvable):
    misfits = shear_misfits()
    misfits = misfits[np.argsort(misfits.sum(axis=1))]
    misfits[:tied] = misfits[0]
    if solvable:
        assert effective_sample_size(final_weights(misfits, solve_s(misfits, 0.3))) == pytest.approx(0.3, abs=1e-9)
    else:
        with pytest.raises(UnreachableSampleSize, match="fit the reference equally well"):
            solve_s(misfits, 0.3)


@pytest.mark.parametrize("scale", ["peak", "pointwise"])
def test_a_dilative_observable_weighs_as_much_as_its_mirror_image(scale):
    """The scale is that of |y|: with the largest signed value a dilative strain would count hundreds of times too much."""
    y = shear(SHEAR_TRUTH)
    x = np.array([shear(theta) for theta in thetas(SHEAR_SPACE)])
    mirror = np.array([1, -1])
    assert y[:, 1].min() < -abs(y[:, 1].max())
    assert np.array_equal(misfit(x, reference_of(y), scale), misfit(x * mirror, reference_of(y * mirror), scale))


@pytest.mark.parametrize("scale", ["peak", "pointwise"])
def test_zeros_and_zero_crossings_of_the_reference_neither_divide_by_zero_nor_decide_alone(scale):
    """A tenth of the peak off at one state: at the peak that is (0.1)^2; where the strain crosses zero at most (0.1 / 0.05)^2."""
    y = shear(SHEAR_TRUTH)
    y[20, 1] = 0.0
    assert y[0, 1] == 0 and np.any(np.diff(np.sign(y[1:, 1])))
    reference = reference_of(y)
    peak = np.abs(y[:, 1]).max()
    for t in range(51):
        x = y.copy()
        x[t, 1] += 0.1 * peak
        off = misfit(x[None], reference, scale).sum()
        assert 0.01 * (1 - 1e-12) <= off <= (0.01 if scale == "peak" else 4) * (1 + 1e-12)


def test_pointwise_scale_is_the_magnitude_above_its_floor():
    reference = Reference([0, 1, 2, 3], {"y": [0, -0.01, 0.5, -2]})
    assert np.allclose(error_scale(reference, "pointwise")[:, 0], [0.1, 0.1, 0.5, 2], rtol=1e-15)
    assert np.all(error_scale(reference, "peak") == 2)


def test_only_the_ratios_of_the_variance_shares_matter():
    assert np.allclose(shear_misfits(shares=(0.2, 0.8)), shear_misfits(shares=(1.0, 4.0)), rtol=1e-14, atol=0)


def test_an_observable_without_any_signal_is_refused():
    with pytest.raises(InputError, match="strain is zero"):
        error_scale(Reference([0, 1], {"stress": [1, 2], "strain": [0, 0]}))


def test_an_unknown_scale_is_refused():
    with pytest.raises(InputError, match="peak"):
        error_scale(reference_of(shear(SHEAR_TRUTH)), "range")
