"""Bayesian inference: samples, weights, proposals, posteriors. NumPy in, NumPy out; it touches no files and knows nothing of the model."""

from typing import TYPE_CHECKING

from graincal.lazily import exported

if TYPE_CHECKING:
    from graincal.inference.advice import Grade, grade, sample_size_advice
    from graincal.inference.errors import curve_error
    from graincal.inference.filter import IterativeBayesianFilter, SequentialMonteCarloFilter
    from graincal.inference.iteration import Iteration
    from graincal.inference.methods import METHODS
    from graincal.inference.posterior import Posterior
    from graincal.inference.posterior_filter import PosteriorFilter
    from graincal.inference.samples import number_of_samples
    from graincal.inference.stop import Stop

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
        "graincal.inference.advice": ["Grade", "grade", "sample_size_advice"],
        "graincal.inference.errors": ["curve_error"],
        "graincal.inference.filter": ["IterativeBayesianFilter", "SequentialMonteCarloFilter"],
        "graincal.inference.iteration": ["Iteration"],
        "graincal.inference.methods": ["METHODS"],
        "graincal.inference.posterior": ["Posterior"],
        "graincal.inference.posterior_filter": ["PosteriorFilter"],
        "graincal.inference.samples": ["number_of_samples"],
        "graincal.inference.stop": ["Stop"],
    },
)
