"""Bayesian inference: samples, weights, proposals, posteriors. NumPy in, NumPy out; it touches no files and knows nothing of the model."""

from graincal.inference.advice import Grade, grade, sample_size_advice
from graincal.inference.filter import IterativeBayesianFilter, SequentialMonteCarloFilter
from graincal.inference.iteration import Iteration
from graincal.inference.posterior import Posterior
from graincal.inference.posterior_filter import PosteriorFilter
from graincal.inference.samples import number_of_samples
from graincal.inference.stop import Stop

METHODS = {
    "iterative-bayesian": IterativeBayesianFilter,
    "sequential-monte-carlo": SequentialMonteCarloFilter,
    "posterior": PosteriorFilter,
}
"""The filters by the names that a calibration file knows them by."""

DEFAULT_METHOD = "posterior"

__all__ = [
    "DEFAULT_METHOD",
    "METHODS",
    "Grade",
    "IterativeBayesianFilter",
    "Iteration",
    "Posterior",
    "PosteriorFilter",
    "SequentialMonteCarloFilter",
    "Stop",
    "grade",
    "number_of_samples",
    "sample_size_advice",
]
