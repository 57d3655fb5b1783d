"""How far a reference may be from the truth: measurement errors as a laboratory states them, and what the model cannot reproduce."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypedDict

import numpy as np
import scipy
from numpy.typing import NDArray

from graincal.data import InputError, MeasurementError, Reference
from graincal.inference.likelihood.packings import FACTORS, PackingScatter
from graincal.inference.likelihood.thinning import Thinning

# Where a laboratory says nothing of its errors, an observable is taken to be measured to this part of its peak, by its variance share.
USUAL_ERROR = 0.01

# Errors along one curve are correlated over a length that is rarely known: hypotheses on it, in lengths of the whole curve. None is zero, for fifty
# points of one curve are not fifty measurements.
CORRELATION_LENGTHS = (0.01, 0.03, 0.1, 0.3, 1.0)

# Hypotheses on the standard deviation of what the model cannot reproduce of a measured test whatever its parameters, as parts of an observable's peak, and their probabilities.
# Spheres with four coefficients stand for grains of sand: published fits are 2 to 5 % off (docs/posterior.md), and none is off by a part of a percent. It is alike over
# DISCREPANCY_LENGTH of the curve.
DISCREPANCIES = (0.01, 0.02, 0.04)
DISCREPANCY_PRIOR = (0.25, 0.5, 0.25)
DISCREPANCY_LENGTH = 1 / 3

# Of an observable's peak: a point that is exactly known (a first state of zero) would make the covariance singular.
FLOOR = 1e-6


class ErrorOptions(TypedDict):
    """What is taken for granted of the errors of references; see `error_model`."""

    correlation_length: float | None
    discrepancy: bool | None


@dataclass(frozen=True, eq=False)
class ErrorModel:
    """Hypotheses on the covariance of reference minus mean response, T states of J observables, observable by observable.

    covariances (H, J T, J T), in the observables' units; log_prior (H,), the logs of probabilities that sum to 1. correlation_lengths (H,) in lengths
    of the curve, NaN for all of them together; discrepancies (H,) as parts of the observables' peaks, packing_factors (H,) on the variance between packings, zero without.

    Each covariance is D K D + S + M + P. D the standard deviations of the devices, K the kernel exp(-|x - x'| / length) of an Ornstein-Uhlenbeck process
    over the control, S diagonal with step^2 / 12 and noise^2 of the observable and (dy/dx)^2 step^2 / 12 of the control; M what the model cannot reproduce, P what packings
    differ by, both smooth along the curve. Beside M or P, K is the mean of its hypotheses. At the states of a reference that is thinned, each is what it is of the means of
    their rows.
    """

    covariances: NDArray[np.float64]
    log_prior: NDArray[np.float64]
    correlation_lengths: NDArray[np.float64]
    discrepancies: NDArray[np.float64]
    packing_factors: NDArray[np.float64]

    @property
    def size(self) -> int:
        """The number of hypotheses H."""
        return len(self.log_prior)


def error_model(
    reference: Reference | Thinning,
    *,
    correlation_length: float | None = None,
    discrepancy: bool | None = None,
    packings: PackingScatter | None = None,
    counted: float = 1.0,
) -> ErrorModel:
    """The hypotheses on a reference's errors; of one that is thinned, at the states that are kept.

    correlation_length: in lengths of the curve where it is known; five from 0.01 to 1 otherwise. discrepancy: whether the model may be unable to
    reproduce the test, by 1 to 4 % of each observable's peak; by default where the reference was measured. packings: what packings differ by, whose variance is counted so often.
    Raises InputError for a length that is not positive.
    """
    if correlation_length is not None and not (np.isfinite(correlation_length) and correlation_length > 0):
        raise InputError(f"filter.correlation_length must be a number above 0, in lengths of the whole curve, not {correlation_length}.")
    thinning = Thinning.of(reference, thin=False) if isinstance(reference, Reference) else reference
    whole = thinning.whole
    extent = whole.control[-1] - whole.control[0] if len(whole.control) > 1 else 1.0
    of_devices, independent, peaks = _device_variances(whole, whole.values), _independent_variances(whole), _peaks(whole)
    sizes, size_prior = discrepancies(reference if isinstance(reference, Reference) else whole, discrepancy)
    lack = thinning.smoothly_alike(DISCREPANCY_LENGTH * extent)
    lack = scipy.linalg.block_diag(*(peak**2 * lack for peak in peaks))
    factors, factor_prior = packings.factors if packings else ((0.0,), (1.0,))
    between = counted * packings.covariance if packings else np.zeros_like(lack)
    lengths: Sequence[float] = CORRELATION_LENGTHS if correlation_length is None else (correlation_length,)
    measured = [
        scipy.linalg.block_diag(
            *(
                thinning.alike(np.sqrt(variance), length * extent) + np.diag(thinning.variances(own) + (FLOOR * peak) ** 2)
                for variance, own, peak in zip(of_devices.T, independent.T, peaks)
            )
        )
        for length in lengths
    ]
    if packings or any(sizes):
        # Their length along the curve hardly matters beside what is smooth.
        measured, lengths = [np.mean(measured, axis=0)], [lengths[0] if len(lengths) == 1 else np.nan]
    hypotheses = [
        (alone + size**2 * lack + factor * between, np.log(share / len(measured)) + np.log(part), length, size, factor)
        for alone, length in zip(measured, lengths)
        for size, share in zip(sizes, size_prior)
        for factor, part in zip(factors, factor_prior)
    ]
    return ErrorModel(*(np.array(each) for each in zip(*hypotheses)))


def mean_variances(reference: Reference, discrepancy: bool | None, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """The variances (K, T, J) of the measurement of values (K, T, J) at a reference's rows, and of what the model cannot reproduce: the mean of all hypotheses."""
    sizes, prior = discrepancies(reference, discrepancy)
    lack = np.dot(prior, np.square(sizes))
    return _device_variances(reference, values) + _independent_variances(reference) + (lack + FLOOR**2) * _peaks(reference) ** 2


def _device_variances(reference: Reference, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Of the devices, where they measure values (..., J)."""
    errors = measurement_errors(reference)
    return np.array([error.absolute for error in errors]) ** 2 + (np.array([error.relative for error in errors]) * values) ** 2


def _independent_variances(reference: Reference) -> NDArray[np.float64]:
    """Of what differs from row to row, (T, J)."""
    slopes = Thinning.of(reference).slopes()
    of_rows = np.array([error.independent_variance() for error in measurement_errors(reference)])
    return of_rows + (slopes * reference.control_step) ** 2 / 12


def _peaks(reference: Reference) -> NDArray[np.float64]:
    return np.abs(reference.values).max(axis=0)


def discrepancies(reference: Reference, asked: bool | None) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """The sizes of what the model cannot reproduce, as parts of the peaks, and their probabilities: only none, for a simulation, or where that is asked for."""
    allowed = not reference.simulated if asked is None else asked
    return (DISCREPANCIES, DISCREPANCY_PRIOR) if allowed else ((0.0,), (1.0,))


def hypotheses(reference: Reference, discrepancy: bool | None, packings: bool) -> int:
    """How many there are at most, with what packings differ by or without."""
    smooth = len(discrepancies(reference, discrepancy)[0]) * (FACTORS if packings else 1)
    return max(len(CORRELATION_LENGTHS), smooth)


def measurement_errors(reference: Reference) -> tuple[MeasurementError, ...]:
    """The errors of the observables as the reference states them; where it does not, 1 % of the peak, more or less by the variance shares."""
    log_shares = np.log(reference.shares)
    relative = np.exp(0.5 * (log_shares - log_shares.mean()))
    peaks = np.abs(reference.values).max(axis=0)
    return tuple(
        reference.measurement_errors.get(name) or MeasurementError(absolute=float(USUAL_ERROR * peak * share) or 1e-12)
        for name, peak, share in zip(reference.names, peaks, relative)
    )
