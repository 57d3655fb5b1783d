"""Bayesian inference: samples, weights, proposals, posteriors. NumPy in, NumPy out; it touches no files and knows nothing of the model."""

from typing import TYPE_CHECKING

from graincal.lazily import exported

if TYPE_CHECKING:
    from graincal.inference.driving.iteration import Iteration
    from graincal.inference.driving.stop import Stop
    from graincal.inference.iterative.advice import Grade, grade, sample_size_advice
    from graincal.inference.iterative.filter import IterativeBayesianFilter, SequentialMonteCarloFilter
    from graincal.inference.likelihood.errors import curve_error
    from graincal.inference.methods import METHODS
    from graincal.inference.posterior.posterior_filter import PosteriorFilter
    from graincal.inference.sampling.posterior import Posterior
    from graincal.inference.sampling.samples import number_of_samples

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
    "curve_error",
    "grade",
    "number_of_samples",
    "sample_size_advice",
]

__getattr__ = exported(
    __name__,
    {
        "graincal.inference.iterative.advice": ["Grade", "grade", "sample_size_advice"],
        "graincal.inference.likelihood.errors": ["curve_error"],
        "graincal.inference.iterative.filter": ["IterativeBayesianFilter", "SequentialMonteCarloFilter"],
        "graincal.inference.driving.iteration": ["Iteration"],
        "graincal.inference.methods": ["METHODS"],
        "graincal.inference.sampling.posterior": ["Posterior"],
        "graincal.inference.posterior.posterior_filter": ["PosteriorFilter"],
        "graincal.inference.sampling.samples": ["number_of_samples"],
        "graincal.inference.driving.stop": ["Stop"],
    },
)
