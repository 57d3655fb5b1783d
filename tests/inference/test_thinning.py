"""A dense curve is put together to the states that it needs, and says of the parameters what all of its rows say."""

import numpy as np
import pytest
from scipy.linalg import solve_triangular

from graincal import InputError, IterativeBayesianFilter, MeasurementError, ParameterSpace, PosteriorFilter, Reference, Stop
from graincal.inference.likelihood.error_model import error_model
from graincal.inference.likelihood.errors import observable_errors, sample_errors
from graincal.inference.likelihood.scoring import score
from graincal.inference.likelihood.thinning import FEWEST, MOST, Thinning

ROWS = 2000
STRAIN = np.linspace(0, 0.2, ROWS)
SPACE = ParameterSpace({"strength": (2.6, 3.4), "half_strain": (0.006, 0.014), "softening": (2.0, 8.0), "contraction": (0.1, 0.5), "dilation": (1.0, 3.0)})
TRUTH = np.array([3.0, 0.01, 5.0, 0.3, 2.0])
SD = np.array([0.03, 0.002])


def curves(theta, strain=STRAIN):
    """A drained triaxial test in closed form, with a peak: (..., T, 2)."""
    strength, half_strain, softening, contraction, dilation = (np.asarray(theta)[..., k, None] for k in range(5))
    ratio = 1 + strength * strain / (half_strain + strain) - softening * strain**2 / (0.1 + strain)
    return np.stack([ratio, contraction * strain / (1 + 40 * strain) - dilation * strain**2 / (0.05 + strain)], axis=-1)


def noise(length, rng):
    """Errors of sd 1 that are independent (None) or alike over a length in lengths of the curve: (T, 2)."""
    if length is None:
        return rng.standard_normal((ROWS, 2))
    kept = np.exp(-(STRAIN[1] - STRAIN[0]) / (length * STRAIN[-1]))
    errors = rng.standard_normal((ROWS, 2))
    for row in range(1, ROWS):
        errors[row] = kept * errors[row - 1] + np.sqrt(1 - kept**2) * errors[row]
    return errors


def reference(length=None, seed=1, thin_rows=1):
    values = curves(TRUTH) + SD * noise(length, np.random.default_rng(seed))
    names = ("stress_ratio", "volumetric_strain")
    errors = {name: MeasurementError(noise=sd) if length is None else MeasurementError(absolute=sd) for name, sd in zip(names, SD)}
    return Reference(STRAIN[::thin_rows], dict(zip(names, values[::thin_rows].T)), measurement_errors=errors)


def posterior(slopes, residual, errors):
    """Of parameters of which the curve is linear, slopes (n, T, J), by residuals at the truth (T, J): its mean and standard deviations, over all hypotheses on the errors."""
    states, means, covariances, evidences = len(residual), [], [], []
    for covariance, log_prior in zip(errors.covariances, errors.log_prior):
        precision, pulled, evidence = np.zeros((len(slopes), len(slopes))), np.zeros(len(slopes)), log_prior
        for observable in range(residual.shape[1]):
            block = slice(observable * states, (observable + 1) * states)
            factor = np.linalg.cholesky(covariance[block, block])
            white = solve_triangular(factor, np.column_stack([slopes[:, :, observable].T, residual[:, observable]]), lower=True)
            precision += white[:, :-1].T @ white[:, :-1]
            pulled += white[:, :-1].T @ white[:, -1]
            evidence += -0.5 * white[:, -1] @ white[:, -1] - np.log(np.diag(factor)).sum()
        covariances.append(np.linalg.inv(precision))
        means.append(covariances[-1] @ pulled)
        evidences.append(evidence + 0.5 * pulled @ means[-1] + 0.5 * np.linalg.slogdet(covariances[-1])[1])
    weights = np.exp(np.array(evidences) - max(evidences))
    weights /= weights.sum()
    mean = weights @ np.array(means)
    variance = weights @ np.array([np.diag(covariance) + (each - mean) ** 2 for covariance, each in zip(covariances, means)])
    return mean, np.sqrt(variance)


@pytest.mark.slow
@pytest.mark.parametrize("length", [None, 0.03, 0.3], ids=["independent", "alike over 0.03", "alike over 0.3"])
def test_the_posterior_is_that_of_all_rows(length):
    # 2,000 rows say so much that the curve is linear in the parameters over their posterior: it is exact then.
    whole = reference(length)
    thinning = Thinning.of(whole)
    step = 1e-4 * (SPACE.high - SPACE.low)
    slopes = np.array([(curves(TRUTH + d) - curves(TRUTH - d)) / (2 * d.sum()) for d in np.diag(step)])
    residual = whole.values - curves(TRUTH)
    mean, sd = posterior(slopes, residual, error_model(whole))
    thinned_mean, thinned_sd = posterior(thinning.reduce(slopes), thinning.reduce(residual[None])[0], error_model(thinning))
    assert np.all(np.abs(thinned_mean - mean) <= 0.1 * sd), (thinned_mean - mean) / sd
    assert np.all(np.abs(thinned_sd / sd - 1) <= 0.05), thinned_sd / sd


@pytest.mark.parametrize("rows", [101, 300, 2000])
def test_some_fifty_to_a_hundred_states_are_kept(rows):
    strain = np.linspace(0, 0.2, rows)
    whole = Reference(strain, dict(zip(("stress_ratio", "volumetric_strain"), curves(TRUTH, strain).T)))
    thinning = Thinning.of(whole)
    kept = thinning.kept
    assert 0.8 * FEWEST <= len(kept.control) <= MOST and thinning.counts.sum() == rows and thinning.thinned
    # Closer together where the curve rises than where it is even.
    assert np.diff(kept.control)[:5].max() < 0.5 * np.diff(kept.control)[-5:].min() or rows < 300
    # They lie on the curve: within a thousandth of the peak.
    assert np.abs(kept.values - curves(TRUTH, kept.control)).max() < 4e-3


@pytest.mark.parametrize(("dense", "few"), [(1990, 10), (1940, 60), (1000, 1000)])
def test_few_rows_far_from_many_are_kept(dense, few):
    strain = np.concatenate([np.linspace(0, 0.001, dense), np.linspace(0.002, 0.2, few)])
    whole = Reference(strain, dict(zip(("stress_ratio", "volumetric_strain"), curves(TRUTH, strain).T)))
    thinning = Thinning.of(whole)
    far = thinning.first >= dense
    # No more rows to a state than there are rows for it.
    assert far.sum() >= min(few, 40) and thinning.counts[far].max() <= max(1, few / 20)


def test_a_curve_of_few_rows_is_left_as_it_is():
    whole = reference(thin_rows=20)
    assert len(whole.control) == MOST and not Thinning.of(whole).thinned and Thinning.of(whole).kept is whole
    assert not Thinning.of(reference(), thin=False).thinned


def test_a_state_is_the_mean_of_its_rows_and_so_is_a_response_there():
    whole = reference()
    thinning = Thinning.of(whole)
    bounds = np.append(thinning.first, ROWS)
    response = curves(TRUTH + 0.1)
    reduced = thinning.reduce(response[None])[0]
    for state, (first, end) in enumerate(zip(bounds, bounds[1:])):
        assert thinning.kept.control[state] == pytest.approx(STRAIN[first:end].mean(), rel=1e-12)
        np.testing.assert_allclose(thinning.kept.values[state], whole.values[first:end].mean(axis=0), rtol=1e-12)
        np.testing.assert_allclose(reduced[state], response[first:end].mean(axis=0), rtol=1e-12)
    # Of a response that was stopped, those states are known whose rows are.
    for rows in (0, 1, bounds[1] - 1, bounds[1], bounds[7] + 1, ROWS):
        states = thinning.states_of(response[:rows])
        assert len(states) == np.sum(bounds[1:] <= rows)
        np.testing.assert_allclose(states, reduced[: len(states)], rtol=1e-12)


def test_the_errors_of_the_states_are_those_of_the_means_of_their_rows():
    # An uneven logger, errors of each kind, and one state with rows far apart: all that the kernel of a state sums over.
    strain = np.cumsum(np.random.default_rng(0).exponential(1e-4, 400))
    strain[250:] += 0.05
    values = np.column_stack([1 + 3 * strain / (0.003 + strain), strain])
    errors = {"y": MeasurementError(absolute=0.03, relative=0.02, step=0.02), "z": MeasurementError(noise=0.01)}
    whole = Reference(strain, dict(zip("yz", values.T)), measurement_errors=errors, control_step=1e-4)
    thinning = Thinning.of(whole)
    means = np.zeros((len(thinning.first), len(strain)))
    for state, (first, count) in enumerate(zip(thinning.first, thinning.counts)):
        means[state, first : first + count] = 1 / count
    both = np.kron(np.eye(2), means)
    for length in (1e-9, 1e-5, 1e-3, 0.01, 0.3):
        exact = both @ error_model(whole, correlation_length=length, discrepancy=True).covariances[1] @ both.T
        np.testing.assert_allclose(error_model(thinning, correlation_length=length, discrepancy=True).covariances[1], exact, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("method", [PosteriorFilter, IterativeBayesianFilter])
@pytest.mark.parametrize("thin", [True, False, None])
def test_errors_are_of_all_rows_whatever_is_kept(method, thin):
    whole = reference(thin_rows=5)
    options = {} if thin is None else {"thin": thin}
    filter = method(SPACE, whole, stop=Stop(max_iterations=1), **options)
    samples = filter.ask()
    responses = curves(samples.theta)[:, ::5]
    filter.tell(samples, responses)
    iteration = filter.iterations[0]
    np.testing.assert_array_equal(iteration.errors, sample_errors(observable_errors(responses, whole), whole.shares))
    # The paper's method sees every row, unless it is told otherwise.
    assert (len(filter.kept[0].control) < 400) == (thin if thin is not None else method is PosteriorFilter)


def test_more_rows_than_memory_are_refused_in_a_sentence():
    strain = np.linspace(0, 0.2, 8496)
    dense = Reference(strain, dict(zip(("stress_ratio", "volumetric_strain"), curves(TRUTH, strain).T)))
    with pytest.raises(InputError, match="filter.thin = false keeps all 8496 rows of a reference with 2 observables, .* would need about 35 GB of memory"):
        PosteriorFilter(SPACE, dense, thin=False)
    PosteriorFilter(SPACE, dense)


def test_a_prediction_is_scored_on_any_number_of_rows():
    dense, sparse = (reference(thin_rows=rows) for rows in (1, 25))
    theta = TRUTH * (1 + 0.02 * np.random.default_rng(3).standard_normal((30, 5)))
    of_all, of_few = (score(curves(theta, each.control), each) for each in (dense, sparse))
    assert of_all.error == pytest.approx(of_few.error, rel=0.2)
    assert of_all.coverage == pytest.approx(of_few.coverage, abs=0.08)
