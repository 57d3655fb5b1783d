"""What runs at one and the same parameters differ by: the floor of everything that is compared with runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from graincal.data import Response
from graincal.inference.likelihood.errors import curve_error
from graincal.interpolation import interpolate

STRESS, STRAIN, ERROR = "ε stress ratio [%]", "ε volumetric strain [%]", "ε [%]"
"""Eq. 5 of each observable, and Eq. 6 of both."""

ERROR_OF = {"stress_ratio": STRESS, "volumetric_strain": STRAIN}

FABRIC = {"coordination_number": "ε_{Z} [%]", "a_c": "ε_{ac} [%]", "a_n": "ε_{an} [%]", "a_t": "ε_{at} [%]"}
"""Eq. 5 of each quantity of the fabric."""

STRAINS = np.linspace(0, 0.2, 51)
"""(51,): the axial strains at which runs are compared where there is no reference."""

Curves = Mapping[str, NDArray[np.float64]]
"""Quantities at the same states, (S,) each, by their names."""


def at(runs: Sequence[Response], control: NDArray[np.float64]) -> list[Response]:
    """The runs at these control values (T,), without those that do not reach so far."""
    return [met for run in runs if isinstance(met := interpolate(run, control), Response)]


def errors_between(run: Curves, other: Curves, shares: Mapping[str, float]) -> dict[str, float]:
    """Eq. 5 of each observable and Eq.

    6 of the curves of one run against others at the same states, percent. shares: the variance shares of the observables.
    """
    by_observable = [float(curve_error(run[name], other[name])) for name in shares]
    trust = 1 / np.array(list(shares.values()))
    return {ERROR_OF[name]: error for name, error in zip(shares, by_observable)} | {ERROR: float(by_observable @ trust / trust.sum())}


def fabric_errors(run: Response, truth: Response) -> dict[str, float]:
    """Eq. 5 of each quantity of the fabric of a run, percent, by its name."""
    return {name: float(curve_error(run.values[name], truth.values[name])) for name in FABRIC}


def floor(runs: Sequence[Response], control: NDArray[np.float64], shares: Mapping[str, float]) -> dict[str, float]:
    """What runs at the same parameters differ by: Eq. 5 and Eq. 6 of one against another, the median over all pairs, percent. Nothing for fewer than
    two.
    """
    pairs = [errors_between(one.values, other.values, shares) for one, other in combinations(at(runs, control), 2)]
    return {name: float(np.median([pair[name] for pair in pairs])) for name in pairs[0]} if pairs else {}


def floor_of(runs: Sequence[Response], name: str) -> float | None:
    """What runs at the same parameters, on the same states, differ by in one quantity: Eq. 5 of one against another, the median over all pairs,
    percent; None for fewer than two.
    """
    errors = [curve_error(one.values[name], other.values[name]) for one, other in combinations(runs, 2)]
    return float(np.median(errors)) if errors else None


def floor_of_steps(runs: Sequence[Response]) -> float | None:
    """What the numbers of steps of runs at the same parameters differ by, as a part of them, the median over all pairs; None for fewer than two."""
    steps = [run.details["steps"] for run in runs if "steps" in run.details]
    apart = [2 * abs(one - other) / (one + other) for one, other in combinations(steps, 2)]
    return float(np.median(apart)) if apart else None


def mean_of(runs: Sequence[Response], name: str) -> NDArray[np.float64]:
    """The mean curve of a quantity, (S,)."""
    return np.mean([run.values[name] for run in runs], axis=0)


def mean_run(runs: Sequence[Response]) -> Response:
    """The mean of runs on the same states."""
    return replace(runs[0], values={name: mean_of(runs, name) for name in runs[0].values}, details={})
