"""The filters by name."""

from graincal.inference.filter import IterativeBayesianFilter, SequentialMonteCarloFilter
from graincal.inference.posterior_filter import PosteriorFilter

METHODS = {
    "iterative-bayesian": IterativeBayesianFilter,
    "sequential-monte-carlo": SequentialMonteCarloFilter,
    "posterior": PosteriorFilter,
}
"""The filters by the names that a calibration file knows them by."""
