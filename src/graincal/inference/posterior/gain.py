"""What a further test may be expected to tell of the parameters: by truths drawn from what is known now, each with the data that it would give."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from graincal.data import Reference
from graincal.inference.emulator.emulator import Emulator
from graincal.inference.likelihood.error_model import ErrorModel
from graincal.inference.likelihood.likelihood import ReducedLikelihood
from graincal.inference.likelihood.reduction import columns
from graincal.inference.sampling.posterior import PROBABILITY

FOLDS = 10
"""Parts of the truths: the data of each part are weighed by an emulator of the others."""


ERRORS = 4
"""Data of each truth: its run with so many errors, of which the mean is taken. An error costs nothing, and a truth a run."""


@dataclass(frozen=True, eq=False)
class Gain:
    """Of K truths, n parameters.

    information (K,): log p(θ_k | y_k) − log p(θ_k) in nats, whose mean is the mutual information of parameters and data (Lindley 1956, Ann. Math. Statist. 27).
    deviations (K, n): the parameters' standard deviations once y_k is known, in their own units; now (n,): those before.
    effective_samples (K,): of the posterior's samples, those that carry the weight then. within (K, n): how often the truth lies in the central 90 % interval that its data give. Each is a mean over the
    errors that y_k may have.
    """

    information: NDArray[np.float64]
    deviations: NDArray[np.float64]
    now: NDArray[np.float64]
    effective_samples: NDArray[np.float64]
    within: NDArray[np.float64]

    @property
    def mean_information(self) -> float:
        """The expected information gain, nats."""
        return float(self.information.mean())

    @property
    def information_error(self) -> float:
        """The standard error of that mean, over the truths."""
        return _standard_error(self.information)

    @property
    def shares(self) -> NDArray[np.float64]:
        """The expected standard deviations as parts of those now, (n,)."""
        return self.deviations.mean(axis=0) / self.now

    @property
    def share_errors(self) -> NDArray[np.float64]:
        """The standard errors of these, (n,)."""
        return np.array([_standard_error(column) for column in self.deviations.T]) / self.now

    @property
    def coverage(self) -> float:
        """How many of the true values, over truths and parameters, lie in their 90 % intervals: fewer where the emulator is surer than it ought to be."""
        return float(self.within.mean())


def expected_gain(
    theta: NDArray[np.float64],
    responses: NDArray[np.float64],
    samples: NDArray[np.float64],
    reference: Reference,
    errors: ErrorModel,
    rng: np.random.Generator,
    seen: slice | NDArray[np.intp] = slice(None),
) -> Gain:
    """What a test is expected to tell, from its runs at truths.

    theta (K, n): truths, draws from the present posterior, all different; responses (K, T, J): a run of the test at each. samples (M, n): equally probable ones of the present posterior.
    reference: of the test, whose values are the mean response; errors: what its data may be off by, beside what runs scatter by, which is in the runs. seen: an index of the parameters that the
    test depends on.

    The data of truth k are its run and an error drawn from `errors`, some times. They weigh the samples through an emulator that has not seen run k, whose doubt about the mean response is added, and
    so is the scatter of runs.
    """
    low = np.minimum(samples.min(axis=0), theta.min(axis=0))
    extent = np.maximum(samples.max(axis=0), theta.max(axis=0)) - low
    # Over the box of the posterior, in which the emulator is asked: in that of the ranges its draws may all be in one corner.
    unit, places = (np.divide(each - low, extent, out=np.zeros_like(each), where=extent > 0) for each in (theta, samples))
    data = columns(responses) + _errors(errors, (ERRORS, len(theta)), rng)
    information, effective = np.empty((2, ERRORS, len(theta)))
    deviations, within = np.empty((2, ERRORS, *theta.shape))
    with threadpool_limits(1):
        for rows, emulator in _emulators(unit, responses, reference, seen, rng):
            added, predicted, own = emulator.added(True), emulator.predict(places), emulator.predict(unit[rows])
            for error, (number, row) in itertools.product(range(ERRORS), enumerate(rows)):
                likelihood = ReducedLikelihood.of(_with_values(reference, data[error, row]), errors, emulator.centre, emulator.basis, added)
                logs, (of_truth,) = likelihood(*predicted), likelihood(*(each[[number]] for each in own))
                evidence = scipy.special.logsumexp(logs)
                information[error, row] = of_truth - evidence + np.log(len(samples))
                weights = np.exp(logs - evidence)
                effective[error, row] = 1 / np.sum(weights**2)
                deviations[error, row] = np.sqrt(weights @ (samples - weights @ samples) ** 2)
                within[error, row] = np.abs(weights @ (samples < theta[row]) - 0.5) <= PROBABILITY / 2
    return Gain(information.mean(axis=0), deviations.mean(axis=0), samples.std(axis=0), effective.mean(axis=0), within.mean(axis=0))


def _emulators(
    unit: NDArray[np.float64], responses: NDArray[np.float64], reference: Reference, seen: slice | NDArray[np.intp], rng: np.random.Generator
) -> Iterator[tuple[NDArray[np.intp], Emulator]]:
    """For each part of the runs: its rows, and an emulator of the other runs."""
    every = Emulator(unit, responses, reference, None, seen)
    parts = np.array_split(rng.permutation(len(unit)), FOLDS)
    for rows in parts:
        others = np.setdiff1d(np.arange(len(unit)), rows)
        # The search for its kernels begins at those of all, and looks at the others alone.
        emulator = Emulator(unit[others], responses[others], reference, every, seen)
        emulator.trust(np.full(len(others), 1 / len(others)))
        yield rows, emulator


def _errors(errors: ErrorModel, shape: tuple[int, ...], rng: np.random.Generator) -> NDArray[np.float64]:
    """Errors that data may have, (*shape, J T): each under a hypothesis drawn by its probability."""
    hypotheses = rng.choice(errors.size, size=shape, p=np.exp(errors.log_prior - scipy.special.logsumexp(errors.log_prior)))
    factors = np.linalg.cholesky(errors.covariances)
    return np.einsum("...ij,...j->...i", factors[hypotheses], rng.standard_normal((*shape, factors.shape[-1])))


def _with_values(reference: Reference, values: NDArray[np.float64]) -> Reference:
    """The same with other values (J T,), observable by observable."""
    return Reference(reference.control, dict(zip(reference.names, values.reshape(len(reference.names), -1))), control_name=reference.control_name)


def _standard_error(values: NDArray[np.float64]) -> float:
    return float(values.std(ddof=1) / np.sqrt(len(values)))
