"""The filters by name."""

from graincal.inference.iterative.filter import IterativeBayesianFilter, SequentialMonteCarloFilter
from graincal.inference.posterior.posterior_filter import PosteriorFilter

METHODS: dict[str, type[IterativeBayesianFilter] | type[PosteriorFilter]] = {
    "iterative-bayesian": IterativeBayesianFilter,
    "sequential-monte-carlo": SequentialMonteCarloFilter,
    "posterior": PosteriorFilter,
}
"""The filters by the names that a calibration file knows them by."""
