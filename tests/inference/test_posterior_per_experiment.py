"""Two experiments that share two parameters, with a third of which each has a value of its own: the posterior is Gaussian and known."""

from __future__ import annotations

import numpy as np
import pytest

from graincal import InputError, ParameterSpace, Reference, Samples
from graincal.inference import IterativeBayesianFilter, PosteriorFilter, Stop

from .linear_curves import CONTROL, CORRELATION_LENGTH, DESIGN, curves

SIXTY = Stop(posterior_shift=False, max_iterations=False, max_evaluations=60)
TRUTH = {"a": 1.0, "b (first)": 0.5, "b (second)": 0.9, "c": -0.3}
SEEN = ([0, 1, 3], [0, 2, 3])
DEVIATION = 0.05
KERNEL = DEVIATION**2 * np.exp(-np.abs(CONTROL[:, None] - CONTROL[None, :]) / CORRELATION_LENGTH) + 1e-12 * np.eye(len(CONTROL))


def reference(seen, phase):
    """What the truth gives, and an error that is one of the probable ones."""
    values = DESIGN @ np.array(list(TRUTH.values()))[seen]
    return Reference(CONTROL, {"y": values + 0.5 * DEVIATION * np.cos(9 * CONTROL + phase)}, measurement_errors={"y": DEVIATION})


REFERENCES = [reference(seen, phase) for seen, phase in zip(SEEN, (0.0, 2.0))]


def exact(numbers):
    """Mean and standard deviations of the posterior of (a, b, b, c) by some of the experiments; infinite for a parameter that they do not tell of."""
    precision, weighed = np.zeros((4, 4)), np.zeros(4)
    for number in numbers:
        design = np.zeros((len(CONTROL), 4))
        design[:, SEEN[number]] = DESIGN
        solved = np.linalg.solve(KERNEL, design)
        precision += design.T @ solved
        weighed += solved.T @ REFERENCES[number].values[:, 0]
    told = np.diag(precision) > 0
    covariance = np.linalg.inv(precision[np.ix_(told, told)])
    mean, deviation = np.full(4, np.nan), np.full(4, np.inf)
    mean[told], deviation[told] = covariance @ weighed[told], np.sqrt(np.diag(covariance))
    return mean, deviation


MEAN, SD = exact([0, 1])
# Wide enough for nothing of the Gaussian to be cut off: seven standard deviations or more each way.
HALF = 10 * np.array([SD[0], max(SD[1:3]), SD[3]])
SPACE = ParameterSpace({name: (m - h, m + h) for name, m, h in zip("abc", (MEAN[0], MEAN[1:3].mean(), MEAN[3]), HALF)}, per_experiment=["b"])


@pytest.fixture(scope="module")
def filter():
    found = PosteriorFilter(SPACE.for_experiments(["first", "second"]), REFERENCES, correlation_length=CORRELATION_LENGTH, discrepancy=False, stop=SIXTY)
    while not found.finished:
        samples = found.ask()
        found.tell(samples, [curves(samples.theta[:, seen]) for seen in SEEN])
    return found


def test_the_posterior_is_the_gaussian_that_it_is(filter):
    assert len(filter.evaluations) <= 60 and filter.space.names == tuple(TRUTH)
    assert np.all(np.abs(filter.posterior.mean() - MEAN) <= 0.25 * SD)
    ratio = filter.posterior.std() / SD
    assert 0.8 <= ratio.min() and ratio.max() <= 1.25
    assert np.all(np.abs(filter.posterior.mean() - list(TRUTH.values())) < 3 * filter.posterior.std())
    # The values are told apart: they differ by more than what either may be wrong by.
    assert np.diff(filter.posterior.mean()[1:3]) > 3 * filter.posterior.std()[1:3].max()


def test_what_is_shared_is_known_better_than_from_either_alone(filter):
    alone = np.min([exact([number])[1] for number in (0, 1)], axis=0)
    assert np.all(filter.posterior.std()[[0, 3]] < 0.9 * alone[[0, 3]])


def test_an_emulator_looks_at_what_its_model_sees_alone(filter):
    unit = np.full((3, 4), 0.5)
    unit[1, 1], unit[2, 2] = 0.9, 0.9
    (first, _), (second, _) = (emulator.predict(unit) for emulator in filter.emulation.emulators)
    # The same, but for the order in which products of matrices add up.
    assert np.allclose(first[0], first[2], rtol=1e-5) and not np.allclose(first[0], first[1], rtol=0.01)
    assert np.allclose(second[0], second[1], rtol=1e-5) and not np.allclose(second[0], second[2], rtol=0.01)


def test_columns_and_models_names():
    space = SPACE.for_experiments(["first", "second"])
    theta = np.arange(8.0).reshape(2, 4)
    for number, seen in enumerate(SEEN):
        samples = space.seen_by(number, Samples(np.arange(2), theta, space.names))
        assert samples.names == ("a", "b", "c")
        np.testing.assert_array_equal(samples.theta, theta[:, seen])
        np.testing.assert_array_equal(space.of_experiment(number).low, space.low[seen])
    assert space.for_experiments(["first", "second"]) is space
    assert SPACE.for_experiments(["only"]).names == ("a", "b", "c") and SPACE.for_experiments(["only"]).per_experiment == ()


@pytest.mark.parametrize("method", [PosteriorFilter, IterativeBayesianFilter])
def test_a_filter_needs_the_unknowns_told_apart(method):
    with pytest.raises(InputError, match="parameters: b is to have a value of its own in each experiment, and for 2 references space.for_experiments"):
        method(SPACE, REFERENCES)
    with pytest.raises(InputError, match="for 1 reference "):
        method(SPACE.for_experiments(["first", "second"]), REFERENCES[0])
    assert method(SPACE, REFERENCES[0]).ask().theta.shape[1] == 3


def test_names_that_mean_two_things_are_refused():
    with pytest.raises(InputError, match="per_experiment: d is not among the parameters a, b"):
        ParameterSpace({"a": (0, 1), "b": (0, 1)}, per_experiment=["d"])
    with pytest.raises(InputError, match=r'two unknowns would be called "a \(x\)"'):
        ParameterSpace({"a": (0, 1), "a (x)": (0, 1)}, per_experiment=["a"]).for_experiments(["x", "y"])
