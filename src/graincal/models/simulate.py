"""One test at chosen parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from graincal.data import Failure, InputError, Response, Samples
from graincal.execution import number_of_workers
from graincal.interpolation import interpolate
from graincal.models.model import Model


def simulate(
    model: Model, parameters: Mapping[str, float | ArrayLike], at: ArrayLike, *, workers: int | Literal["all"] = "all"
) -> Response | Failure | list[Response | Failure]:
    """Evaluate any model at parameters, {name: value} in the order that the model expects, or {name: values (N,)} for several runs, which gives a list.

    >>> simulate(test, {"log_E": 8.72, "nu": 0.227, "phi": 28.1, "beta_m": 0.079, "eta_m": 0.569}, at=np.arange(0, 0.2, 0.004))  # doctest: +SKIP

    at (T,): the control values that the responses are returned at. workers: evaluations at once. Raises InputError for numbers of values that differ, and as the model does.
    """
    values = {name: np.asarray(value, dtype=np.float64) for name, value in parameters.items()}
    if not values or len({value.shape for value in values.values()}) > 1 or any(value.ndim > 1 for value in values.values()):
        raise InputError("simulate: parameters must be {name: value}, or {name: values} with as many values of each.")
    theta = np.column_stack([np.atleast_1d(value) for value in values.values()])
    rows, samples = np.asarray(at, dtype=np.float64), Samples(np.arange(len(theta)), theta, tuple(values))
    outcomes = dict(model.evaluate(samples, rows, number_of_workers(workers)))
    met = [outcome if isinstance(outcome := outcomes[row], Failure) else interpolate(outcome, rows) for row in range(len(theta))]
    return met if next(iter(values.values())).ndim else met[0]
