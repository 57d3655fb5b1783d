"""Constraints between parameters and priors that are uniform in a logarithm: volumes, densities, and posteriors that are known exactly by quadrature."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import logsumexp

from graincal import InputError, IterativeBayesianFilter, ParameterSpace, PosteriorFilter, Reference, SequentialMonteCarloFilter, Stop
from graincal.inference.sampling.defensive import DefensiveMixture
from graincal.inference.sampling.explore import explore
from graincal.inference.sampling.proposal import TruncatedMixture
from graincal.inference.sampling.samples import halton, replicates
from graincal.models.derived import check_derived

CONTROL = np.linspace(0, 1, 30)
CORRELATION_LENGTH = 0.1
GRID = 1200
"""Points of the quadrature along each of two parameters, cell by cell at their middles: 40 a standard deviation and more, and of a cut through them 1 in 1,000 is on the wrong side."""


def grid(space: ParameterSpace) -> NDArray[np.float64]:
    """Points (M, 2) that fill the unit cube evenly, as far as the prior holds them possible."""
    middles = (np.arange(GRID) + 0.5) / GRID
    unit = np.stack(np.meshgrid(middles, middles, indexing="ij"), axis=2).reshape(-1, 2)
    return unit[space.contains(space.from_unit(unit))]


@dataclass(frozen=True, eq=False)
class Case:
    """A model theta (N, 2) -> (N, T, 1), a reference, and the moments of the posterior (2,) with the log evidence, by quadrature."""

    space: ParameterSpace
    reference: Reference
    model: Callable[[NDArray[np.float64]], NDArray[np.float64]]
    mean: NDArray[np.float64]
    deviation: NDArray[np.float64]
    log_evidence: float


def case(space, features, design, truth, error) -> Case:
    """The response is features(theta) (N, F) times a design (F, T), so that the likelihood is a Gaussian in the features; errors of one size are alike along the curve."""

    def model(theta):
        return (features(theta) @ design)[:, :, None]

    values = model(np.array([truth]))[0, :, 0] + 0.5 * error * np.cos(9 * CONTROL)
    reference = Reference(CONTROL, {"y": values}, measurement_errors={"y": error})
    kernel = np.exp(-np.abs(CONTROL[:, None] - CONTROL[None, :]) / CORRELATION_LENGTH)
    factor = np.linalg.cholesky(error**2 * kernel + (1e-6 * np.abs(values).max()) ** 2 * np.eye(len(CONTROL)))
    theta = space.from_unit(grid(space))
    whitened = np.linalg.solve(factor, design.T)
    misfit = np.linalg.solve(factor, values)[:, None] - whitened @ features(theta).T
    logs = -0.5 * np.sum(misfit**2, axis=0) - np.log(np.diag(factor)).sum() - 0.5 * len(CONTROL) * np.log(2 * np.pi)
    weights = np.exp(logs - logsumexp(logs))
    mean = weights @ theta
    return Case(space, reference, model, mean, np.sqrt(weights @ (theta - mean) ** 2), float(logsumexp(logs) - np.log(len(theta))))


def triangle() -> Case:
    """A Gaussian whose middle lies beyond the diagonal, which cuts it."""
    space = ParameterSpace({"v0": (0, 1), "v1": (0, 1)}, constraints=["v0 < v1"])
    return case(space, lambda theta: theta, np.stack([1 + CONTROL, CONTROL**2 - 0.5]), (0.55, 0.45), 0.2)


def two_modes() -> Case:
    """(a - 1/2)^2 is the same on both sides of the middle; the constraint goes through the mode on the right, at (0.8, 0.4)."""
    space = ParameterSpace({"a": (0, 1), "b": (0, 1)}, constraints=["a + 0.5 * b < 1"])
    return case(space, lambda theta: np.stack([(theta[:, 0] - 0.5) ** 2, theta[:, 1]], axis=1), np.stack([1 + CONTROL, CONTROL**2]), (0.8, 0.4), 0.03)


def logarithmic() -> Case:
    """A response that goes with the root of a parameter of two decades, of which a posterior in the value itself is skewed."""
    space = ParameterSpace({"E": (1e6, 1e8), "v": (0, 1)}, scale={"E": "log"})
    return case(space, lambda theta: np.stack([np.sqrt(theta[:, 0] / 1e7), theta[:, 1]], axis=1), np.stack([1 + CONTROL, CONTROL**2 - 0.5]), (2e7, 0.5), 0.3)


CASES = {"triangle": triangle, "two modes": two_modes, "logarithmic": logarithmic}


def finish(filter, model):
    while not filter.finished:
        samples = filter.ask()
        assert filter.space.contains(samples.theta).all()
        filter.tell(samples, model(samples.theta))
    return filter


def close_to(known: Case, filter) -> None:
    """Means within 2 % of the exact standard deviations, and standard deviations within 2 % of these: of the 3,000 samples of equal weight that there are, either is known to 1.8 %, and stratified ones to half of it."""
    assert np.all(np.abs(filter.posterior.mean() - known.mean) <= 0.02 * known.deviation)
    np.testing.assert_allclose(filter.posterior.std(), known.deviation, rtol=0.02)
    # A prior whose volume was off by more would show here.
    assert filter.log_evidence == pytest.approx(known.log_evidence, abs=0.02)
    assert filter.space.contains(filter.posterior.samples).all()


@pytest.mark.parametrize("name", CASES)
def test_the_posterior_by_the_runs_themselves_is_that_of_the_quadrature(name):
    known = CASES[name]()
    stop = Stop(max_iterations=False, max_evaluations=20_000)
    filter = PosteriorFilter(
        known.space, known.reference, emulator=False, first_batch=4000, batch=4000, correlation_length=CORRELATION_LENGTH, discrepancy=False, stop=stop
    )
    close_to(known, finish(filter, known.model))


@pytest.mark.parametrize("name", CASES)
def test_the_emulated_posterior_is_that_of_the_quadrature(name):
    known = CASES[name]()
    stop = Stop(posterior_shift=False, max_iterations=False, max_evaluations=40)
    filter = finish(
        PosteriorFilter(known.space, known.reference, first_batch=25, batch=12, correlation_length=CORRELATION_LENGTH, discrepancy=False, stop=stop),
        known.model,
    )
    close_to(known, filter)
    # The answer and the runs there are possible too, although the likelihood rises beyond the diagonal.
    assert known.space.contains(filter.emulation.answer[None])
    if name == "triangle":
        assert filter.emulation.answer[1] - filter.emulation.answer[0] < 1e-3


@pytest.mark.parametrize("name", CASES)
def test_the_first_iteration_of_the_paper_s_method_has_the_posterior_of_its_own_errors(name):
    # The paper's method chooses the size of the errors, s, by the effective sample size asked for, and its first iteration weighs samples of the prior: against the quadrature of the same.
    known = CASES[name]()
    alpha = 10_000
    filter = finish(SequentialMonteCarloFilter(known.space, known.reference, alpha=alpha, effective_sample_size=0.2), known.model)
    theta = known.space.from_unit(grid(known.space)[::7])
    values = known.reference.values[:, 0]
    misfit = np.sum((known.model(theta)[:, :, 0] - values) ** 2, axis=1) / np.abs(values).max() ** 2
    logs = -0.5 * misfit / filter.iterations[0].s
    weights = np.exp(logs - logsumexp(logs))
    mean = weights @ theta
    deviation = np.sqrt(weights @ (theta - mean) ** 2)
    assert np.all(np.abs(filter.posterior.mean() - mean) <= 0.02 * deviation)
    np.testing.assert_allclose(filter.posterior.std(), deviation, rtol=0.02)


@pytest.mark.parametrize("name", ["triangle", "two modes"])
def test_the_paper_s_method_stays_where_constraints_hold(name):
    known = CASES[name]()
    filter = finish(
        IterativeBayesianFilter(
            known.space, known.reference, alpha=30, stop=Stop(max_iterations=5, s=False, gl_error_increment=False, error=False, error_increment=False)
        ),
        known.model,
    )
    assert len(filter.iterations) == 5 and filter.iterations[-1].error < filter.iterations[0].gl_error


BOXES = {
    "triangle": (["v0 < v1"], 1 / 2),
    "circle": (["(v0 - 0.5)**2 + (v1 - 0.5)**2 < 0.25"], np.pi / 4),
    "in order": (["v0 < v1", "v1 < v2", "v2 < v3"], 1 / 24),
    "strip": (["abs(v0 - v1) < 0.01"], 1 - 0.99**2),
    "either": (["v0 < 0.1 or v1 < 0.1"], 1 - 0.9**2),
    "six in order": ([f"v{k} < v{k + 1}" for k in range(5)], 1 / 720),
}


def box(constraints) -> ParameterSpace:
    count = 2 if len(constraints) == 1 else len(constraints) + 1
    return ParameterSpace({f"v{k}": (0, 1) for k in range(count)}, constraints=constraints)


@pytest.mark.parametrize("name", BOXES)
def test_the_volume_of_a_prior_is_known_to_a_percent(name):
    constraints, volume = BOXES[name]
    space = box(constraints)
    assert np.exp(space.log_volume) == pytest.approx(volume, rel=0.01)
    points = halton(space, 2000, np.random.default_rng(1))
    assert space.contains(points).all()
    # Of two thousand samples a standard deviation is known to 1.6 %.
    np.testing.assert_allclose(points.std(axis=0), space.deviation, rtol=0.06)
    # Nothing is measured: the evidence is 1. Densities are known to 1 %, and to a few where next to nothing of the box is left.
    evidence = explore(space, lambda unit: np.zeros(len(unit)), np.random.default_rng(1)).log_evidence
    assert evidence == pytest.approx(0, abs=0.01 if volume > 0.01 else 0.05)


def test_units_and_logarithms_change_the_volume_by_what_they_are():
    # In ln E, of two decades, and in v, of a range of 4: half of the box, as E rises with v.
    space = ParameterSpace({"E": (1e6, 1e8), "v": (-1, 3)}, scale={"E": "log"}, constraints=["log10(E) - 6 < (v + 1) / 2"])
    assert np.exp(space.log_box_volume) == pytest.approx(4 * np.log(100))
    assert np.exp(space.log_volume) == pytest.approx(2 * np.log(100), rel=0.01)
    theta = halton(space, 5000, np.random.default_rng(0))
    # On the triangle under the diagonal u < w the mean of u is 1/3.
    assert np.mean(np.log10(theta[:, 0] / 1e6) / 2) == pytest.approx(1 / 3, abs=0.01)
    np.testing.assert_allclose(space.from_unit(space.to_unit(theta)), theta, rtol=1e-12)
    # An even distribution in the logarithm: half of the samples below the middle of the decades.
    alone = halton(ParameterSpace({"E": (1e6, 1e8)}, scale={"E": "log"}), 1000, np.random.default_rng(0))
    assert np.mean(alone < 1e7) == pytest.approx(0.5, abs=0.01) and alone.min() >= 1e6 and alone.max() <= 1e8


@pytest.mark.parametrize("means", [[[0.5, 0.5]], [[0.9, 0.2], [0.2, 0.4]]])
def test_the_density_of_a_truncated_mixture_integrates_to_one_and_is_that_of_its_draws(means):
    space = ParameterSpace({"v0": (0, 1), "v1": (10, 14)}, constraints=["4 * v0 < v1 - 10"])
    means = np.array(means)
    mixture = TruncatedMixture(space, np.full(len(means), 1 / len(means)), means, np.array([[[0.04, 0.01], [0.01, 0.02]]] * len(means)))
    theta = space.from_unit(grid(space))
    for density in (mixture, DefensiveMixture(space, mixture, 0.3), DefensiveMixture(space)):
        heights = np.exp(density.log_density(theta))
        assert heights.mean() * np.exp(space.log_volume) == pytest.approx(1, rel=0.01)
        draws = density.draw(4000, np.random.default_rng(0))
        assert space.contains(draws).all() and np.all(np.isneginf(density.log_density([[0.9, 10.1], [0.5, 14.1]])))
        mean = heights @ theta / heights.sum()
        deviation = np.sqrt(heights @ (theta - mean) ** 2 / heights.sum())
        # Four standard errors.
        assert np.all(np.abs(draws.mean(axis=0) - mean) <= 4 * deviation / np.sqrt(4000))
        np.testing.assert_allclose(draws.std(axis=0), deviation, rtol=4 / np.sqrt(2 * 4000))


def test_runs_at_one_place_next_to_a_constraint_all_meet_it():
    space = ParameterSpace({"v0": (0, 1), "v1": (0, 100)}, constraints=["100 * v0 < v1", "v0 > 0.2"])
    for theta in ([0.3, 30.00001], [0.2000001, 99.0], [0.9, 90.00001]):
        runs = replicates(np.array(theta), 3, space)
        assert space.contains(runs).all() and len(np.unique(runs, axis=0)) == 3
        np.testing.assert_allclose(runs, np.tile(theta, (3, 1)), atol=3e-4)
    decades = ParameterSpace({"E": (1e-3, 1e9)}, scale={"E": "log"})
    np.testing.assert_allclose(np.diff(decades.to_unit(replicates(np.array([2e-3]), 3, decades)), axis=0), 1e-6, rtol=1e-6)


def test_a_constraint_on_a_parameter_of_each_experiment_holds_in_each():
    space = ParameterSpace({"a": (0, 1), "b": (0, 1), "c": 0.4}, per_experiment=["b"], constraints=["a < b", "a > c / 2"]).for_experiments(["x", "y", "z"])
    assert space.names == ("a", "b (x)", "b (y)", "b (z)") and [each.source for each in space.constraints] == ["a < b"] * 3 + ["a > c / 2"]
    # The integral of (1 - a)^3 from 0.2 on.
    assert np.exp(space.log_volume) == pytest.approx(0.8**4 / 4, rel=0.01)
    theta = halton(space, 100, np.random.default_rng(0))
    assert np.all(theta[:, :1] < theta[:, 1:]) and np.all(theta[:, 0] > 0.2)
    own = space.of_experiment(1)
    assert own.names == ("a", "b") and own.order == ("a", "b", "c") and [each.source for each in own.constraints] == ["a < b", "a > c / 2"]
    assert own.contains([[0.3, 0.5], [0.5, 0.3], [0.1, 0.5]]).tolist() == [True, False, False]


@pytest.mark.parametrize(
    ("ranges", "options", "said"),
    [
        ({"a": (0, 1)}, {"scale": {"a": "log"}}, r'parameters.a: scale = "log" needs a range of numbers above 0, not \[0, 1\]'),
        ({"a": (0, 1)}, {"scale": {"a": "lg"}}, 'parameters.a: scale must be "linear" or "log", not "lg"'),
        ({"a": (0, 1)}, {"scale": {"b": "log"}}, "scale: b is not among the parameters a"),
        ({"a": (0, 1), "b": 2}, {"scale": {"b": "log"}}, "scale: b is fixed, and a parameter with a range was expected"),
        ({"a": (0, 1), "b": 2}, {"per_experiment": ["b"]}, "per_experiment: b is fixed"),
        ({"b": 2}, {}, "at least one parameter with its range is needed"),
        ({"a": (0, 1), "b": float("nan")}, {}, "parameters.b: fixed must be a finite number, not nan"),
        ({"a": (0, 1), "b": 10**400}, {}, "parameters.b: fixed must be a finite number, not inf"),
        ({"a": (0, 1)}, {"constraints": "a < 0.5"}, "constraints must be a list of conditions"),
        ({"a": (0, 1)}, {"constraints": [1]}, "constraint.require must be a condition such as"),
        ({"a": (0, 1)}, {"constraints": ["a <"]}, 'constraint.require = "a <": it cannot be read'),
        ({"a": (0, 1)}, {"constraints": ["a + 1"]}, r'constraint.require = "a \+ 1" is no condition'),
        ({"a": (0, 1)}, {"constraints": ["aa < 1"]}, 'constraint.require = "aa < 1" names aa, which is no parameter'),
        ({"a": (0, 1), "b": 2}, {"constraints": ["b < 1"]}, "names no parameter that has a range"),
        ({"a": (0, 1)}, {"constraints": ["a.real < 1"]}, "a point between names"),
        ({"a": (0, 1)}, {"constraints": ["-" * 950 + "a < 1"]}, "has too many brackets, signs or terms in one another|cannot be read"),
    ],
)
def test_what_cannot_be_is_said_in_one_sentence(ranges, options, said):
    with pytest.raises(InputError, match=said):
        ParameterSpace(ranges, **options)


@pytest.mark.parametrize(
    ("constraints", "said"),
    [
        (["a > 1.5"], 'constraint.require = "a > 1.5": of 1,048,576 points that fill the ranges none is left'),
        (["a < 0.5", "a > 0.6"], 'constraint.require = "a < 0.5", "a > 0.6": of'),
        (["a == b"], 'constraint.require = "a == b": of'),
        (["a < 2"], 'constraint.require = "a < 2" holds all over the ranges, so that it would change nothing'),
        (["a < b", "b >= 0"], 'constraint.require = "b >= 0" holds all over the ranges'),
        (["abs(a - 0.5) < 1e-6"], "they leave about .e-0. of the volume of the ranges, too little to know how much"),
    ],
)
def test_a_prior_that_is_empty_or_a_constraint_that_says_nothing_is_refused_before_anything_is_asked(constraints, said):
    space = ParameterSpace({"a": (0, 1), "b": (0, 1)}, constraints=constraints)
    for method in (PosteriorFilter, IterativeBayesianFilter):
        with pytest.raises(InputError, match=said):
            method(space, Reference(CONTROL, {"y": CONTROL}))


def test_a_parameter_cannot_have_the_name_of_a_number():
    with pytest.raises(InputError, match="pi is a number in conditions, and another name for a parameter was expected"):
        ParameterSpace({"pi": (0, 1), "a": (0, 1)}, constraints=["pi < a"])
    with pytest.raises(InputError, match="derived.b: pi is a number in expressions"):
        check_derived({"b": "2 * pi"}, ("pi",))
