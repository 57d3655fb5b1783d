"""How far a reference may be from the truth: measurement errors as a laboratory states them, and what the model cannot reproduce."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from graincal.data import InputError, MeasurementError, Reference
from graincal.inference.thinning import Thinning

# Where a laboratory says nothing of its errors, an observable is taken to be measured to this part of its peak, by its variance share.
USUAL_ERROR = 0.01

# Errors along one curve are alike over a length that is rarely known: hypotheses on it, in lengths of the whole curve. None is zero, for fifty
# points of one curve are not fifty measurements.
CORRELATION_LENGTHS = (0.01, 0.03, 0.1, 0.3, 1.0)

# Hypotheses on the standard deviation of what the model cannot reproduce whatever its parameters, as parts of an observable's peak; and the length
# over which that is alike, in lengths of the curve.
DISCREPANCIES = (0.003, 0.01, 0.03, 0.1)
DISCREPANCY_LENGTH = 0.3

# Of an observable's peak: a point that is exactly known (a first state of zero) would make the covariance singular.
FLOOR = 1e-6


@dataclass(frozen=True, eq=False)
class ErrorModel:
    """Hypotheses on the covariance of reference minus true response, T states of J observables, observable by observable.

    covariances (H, J T, J T), in the observables' units; log_prior (H,), the logs of probabilities that sum to 1. correlation_lengths (H,) in lengths
    of the curve; discrepancies (H,) as parts of the observables' peaks, zero without.

    Each covariance is D K D + S + M: D the standard deviations of the devices, K the kernel exp(-|x - x'| / length) of an Ornstein-Uhlenbeck process
    over the control, S diagonal with step^2 / 12 and noise^2 of the observable and (dy/dx)^2 step^2 / 12 of the control, M the discrepancy, alike over a third
    of the curve. At the states of a reference that is thinned, it is what these are of the means of their rows.
    """

    covariances: NDArray[np.float64]
    log_prior: NDArray[np.float64]
    correlation_lengths: NDArray[np.float64]
    discrepancies: NDArray[np.float64]

    @property
    def size(self) -> int:
        """The number of hypotheses H."""
        return len(self.log_prior)


def error_model(reference: Reference | Thinning, *, correlation_length: float | None = None, discrepancy: bool = False) -> ErrorModel:
    """The hypotheses on a reference's errors, all equally probable; of one that is thinned, at the states that are kept.

    correlation_length: in lengths of the curve where it is known; five from 0.01 to 1 otherwise. discrepancy: whether the model may be unable to
    reproduce the test, by 0.3 to 10 % of each observable's peak.
    Raises InputError for a length that is not positive.
    """
    if correlation_length is not None and not (np.isfinite(correlation_length) and correlation_length > 0):
        raise InputError(f"filter.correlation_length must be a number above 0, in lengths of the whole curve, not {correlation_length}.")
    thinning = Thinning.of(reference, thin=False) if isinstance(reference, Reference) else reference
    whole = thinning.whole
    extent = whole.control[-1] - whole.control[0] if len(whole.control) > 1 else 1.0
    of_devices, independent, peaks = _device_variances(whole), _independent_variances(whole), _peaks(whole)
    lack = thinning.alike(np.ones(len(whole.control)), DISCREPANCY_LENGTH * extent)
    covariances, lengths, sizes = [], [], []
    for length in CORRELATION_LENGTHS if correlation_length is None else (correlation_length,):
        alone = [
            thinning.alike(np.sqrt(variance), length * extent) + np.diag(thinning.variances(own) + (FLOOR * peak) ** 2)
            for variance, own, peak in zip(of_devices.T, independent.T, peaks)
        ]
        for size in _discrepancies(discrepancy):
            covariances.append(block_diag(*(block + (size * peak) ** 2 * lack for block, peak in zip(alone, peaks))))
            lengths.append(length)
            sizes.append(size)
    count = len(covariances)
    return ErrorModel(np.array(covariances), np.full(count, -np.log(count)), np.array(lengths), np.array(sizes))


def mean_variances(reference: Reference, discrepancy: bool = False) -> NDArray[np.float64]:
    """The variances at each row, (T, J), the mean of all hypotheses."""
    lack = np.mean(np.square(_discrepancies(discrepancy)))
    return _device_variances(reference) + _independent_variances(reference) + (lack + FLOOR**2) * _peaks(reference) ** 2


def _device_variances(reference: Reference) -> NDArray[np.float64]:
    """Of the devices, (T, J)."""
    errors = measurement_errors(reference)
    return np.array([error.absolute**2 + (error.relative * values) ** 2 for error, values in zip(errors, reference.values.T)]).T


def _independent_variances(reference: Reference) -> NDArray[np.float64]:
    """Of what differs from row to row, (T, J)."""
    slopes = Thinning.of(reference).slopes()
    of_rows = np.array([error.independent_variance() for error in measurement_errors(reference)])
    return of_rows + (slopes * reference.control_step) ** 2 / 12


def _peaks(reference: Reference) -> NDArray[np.float64]:
    return np.abs(reference.values).max(axis=0)


def _discrepancies(discrepancy: bool) -> tuple[float, ...]:
    return DISCREPANCIES if discrepancy else (0.0,)


def hypotheses(discrepancy: bool) -> int:
    """How many there are at most, with a discrepancy allowed for or without."""
    return len(CORRELATION_LENGTHS) * len(_discrepancies(discrepancy))


def measurement_errors(reference: Reference) -> tuple[MeasurementError, ...]:
    """The errors of the observables as the reference states them; where it does not, 1 % of the peak, more or less by the variance shares."""
    log_shares = np.log(reference.shares)
    relative = np.exp(0.5 * (log_shares - log_shares.mean()))
    peaks = np.abs(reference.values).max(axis=0)
    return tuple(
        reference.measurement_errors.get(name) or MeasurementError(absolute=float(USUAL_ERROR * peak * share) or 1e-12)
        for name, peak, share in zip(reference.names, peaks, relative)
    )
