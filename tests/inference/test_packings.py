"""What packings differ by, found from runs of a few of them, against what they were made with."""

from __future__ import annotations

import numpy as np
import pytest

import graincal as gc
from graincal.inference.likelihood.error_model import error_model
from graincal.inference.likelihood.packings import PLACES, REPEATED, REPEATS, SIBLINGS, PackingScatter, Siblings, gaussian_kernel, packing_scatter, places

from .curves import SHEAR_SPACE, SHEAR_TRUTH, reference_of, responses_of, shear

CONTROL = np.linspace(0, 0.2, 30)


def _smooth_curves(rng, *shape, deviation=(0.05, 0.002)):
    """Smooth curves (*shape, T, 2) with these standard deviations."""
    factor = np.linalg.cholesky(gaussian_kernel(CONTROL, 0.3) + 1e-9 * np.eye(30))
    return np.einsum("ij,...jk->...ik", factor, rng.standard_normal((*shape, 30, 2))) * deviation


def _responses(rng, packings, of_runs=1e-4, kept=True):
    """Of packings at three places, (S, P, R, T, 2): each differs by a smooth curve, one everywhere or another at each place, and runs by others, so many times as large."""
    own = _smooth_curves(rng, packings, 1 if kept else PLACES)
    runs = of_runs * _smooth_curves(rng, packings, PLACES, REPEATS)
    return _as_run(rng.random((PLACES, 1, 30, 2)) + own[:, :, None] + runs)


def _as_run(responses):
    """The own packing's, and of the siblings' those that are run."""
    responses[1 + REPEATED :, :, 1:] = np.nan
    return responses


@pytest.mark.parametrize("kept", [True, False])
@pytest.mark.parametrize("of_runs", [1e-4, 0.7])
def test_the_variance_is_that_between_packings(of_runs, kept):
    found, factors = [], []
    for seed in range(160):
        responses = _responses(np.random.default_rng(seed), SIBLINGS + 1, of_runs, kept)
        scatter = packing_scatter(responses[1:], responses[0, :, 0], CONTROL, Siblings())
        assert scatter.packings == SIBLINGS and scatter.degrees == SIBLINGS - 1
        found.append(np.diag(scatter.covariance))
        factors.append(scatter.apart)
    ratio = np.mean(found, axis=0) / np.repeat([0.05**2, 0.002**2], 30)
    assert np.all(np.abs(ratio - 1) < 0.35) and ratio.mean() == pytest.approx(1, abs=0.1)
    # The calibration's own packing is one more of them.
    assert np.sqrt(np.mean(np.square(factors))) == pytest.approx(1, abs=0.35)


def test_what_only_runs_scatter_by_is_no_difference_between_packings():
    found = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        responses = _as_run(_smooth_curves(rng, SIBLINGS + 1, PLACES, REPEATS) + rng.random((PLACES, 1, 30, 2)))
        found.append(np.diag(packing_scatter(responses[1:], responses[0, :, 0], CONTROL, Siblings()).covariance))
    # What is left is chance: none of it where runs scatter more than the packings' means do.
    assert np.mean(found / np.repeat([0.05**2, 0.002**2], 30)) < 0.35


def test_smaller_siblings_differ_by_more():
    responses = _responses(np.random.default_rng(1), SIBLINGS + 1)
    alike, smaller = (packing_scatter(responses[1:], responses[0, :, 0], CONTROL, Siblings(share=share)) for share in (1.0, 0.25))
    np.testing.assert_allclose(smaller.covariance, alike.covariance / 4)


def test_runs_that_failed_are_left_out():
    whole = _responses(np.random.default_rng(2), SIBLINGS + 1, of_runs=0.01)
    expected = packing_scatter(whole[1:], whole[0, :, 0], CONTROL, Siblings()).covariance
    # One of two runs is as good as both, where they scatter little.
    responses = whole.copy()
    responses[2, 1, 1] = np.nan
    some = packing_scatter(responses[1:], responses[0, :, 0], CONTROL, Siblings())
    np.testing.assert_allclose(np.diag(some.covariance), np.diag(expected), rtol=0.05)
    responses[1, 0] = np.nan
    assert packing_scatter(responses[1:], responses[0, :, 0], CONTROL, Siblings()).packings == SIBLINGS
    responses[1:5] = np.nan
    assert packing_scatter(responses[1:], responses[0, :, 0], CONTROL, Siblings()) is None


def test_places_are_the_best_and_others_that_fit_far_from_it():
    space = gc.ParameterSpace({"a": (0, 1), "b": (0, 10)})
    theta = space.from_unit(np.random.default_rng(0).random((100, 2)))
    errors = 100 * np.linalg.norm(space.to_unit(theta) - 0.5, axis=1)
    errors[:5] = np.nan
    chosen = places(space, theta, errors)
    assert chosen.shape == (PLACES, 2)
    np.testing.assert_array_equal(chosen[0], theta[np.nanargmin(errors)])
    unit = space.to_unit(chosen)
    assert np.all(np.linalg.norm(unit - 0.5, axis=1) < 0.2) and min(np.linalg.norm(a - b) for k, a in enumerate(unit) for b in unit[:k]) > 0.1


def test_each_term_is_in_the_covariance_as_often_as_it_is_counted():
    reference = gc.Reference(CONTROL, {"q": 1 + CONTROL, "v": 0.1 * CONTROL}, measurement_errors={"q": 0.02, "v": 0.001})
    scatter = PackingScatter(np.diag(np.r_[np.full(30, 0.03**2), np.full(30, 0.004**2)]), 5.0, 6, 1.0)
    alone = error_model(reference, discrepancy=False)
    assert alone.size == 5 and not alone.packing_factors.any()
    both = error_model(reference, packings=scatter, counted=0.5)
    assert both.size == 9 and np.exp(both.log_prior).sum() == pytest.approx(1)
    measured = np.mean([np.diag(each) for each in alone.covariances], axis=0)
    peaks = np.repeat([1.2, 0.02], 30)
    for covariance, size, factor in zip(both.covariances, both.discrepancies, both.packing_factors):
        np.testing.assert_allclose(np.diag(covariance), measured + (size * peaks) ** 2 + 0.5 * factor * np.diag(scatter.covariance), rtol=1e-9)
    # A simulation can be reproduced.
    simulated = gc.Reference(CONTROL, {"q": 1 + CONTROL}, measurement_errors={"q": 0.02}, simulated=True)
    assert error_model(simulated, packings=PackingScatter(np.eye(30), 5.0, 6, 1.0)).size == 3


def test_a_filter_learns_nothing_before_it_knows_what_packings_differ_by():
    reference = reference_of(shear(SHEAR_TRUTH))

    def driven(tell):
        filter = gc.PosteriorFilter(SHEAR_SPACE, reference, siblings=[Siblings()], seed=1, first_batch=40)
        samples = filter.ask()
        filter.tell(samples, responses_of(shear, samples))
        assert filter.places.shape == (PLACES, SHEAR_SPACE.size) and not filter.iterations and not filter.finished
        at = np.array([[shear(theta)] * REPEATS for theta in filter.places])
        filter.tell_packings(filter.places, [tell(at)])
        assert filter.places is None and len(filter.iterations) == 1
        return filter

    shapes = 0.05 * np.abs(reference.values).max(axis=0) * np.random.default_rng(0).standard_normal((SIBLINGS, 1, 1, 1, 2))
    differing, none = driven(lambda at: at + shapes), driven(lambda at: None)
    assert none.packings == (None,) and differing.packings[0].packings == SIBLINGS
    ratio = differing.posterior.std() / none.posterior.std()
    assert np.all(ratio > 0.8) and ratio.max() > 1.2
    wide = np.diag(differing.errors[0].covariances[differing.errors[0].packing_factors > 1][0])
    assert np.all(wide > np.diag(none.errors[0].covariances[0]))
