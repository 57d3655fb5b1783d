"""How far a reference may be from the truth: measurement errors as a laboratory states them, and what the model cannot reproduce."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from graincal.data import InputError, MeasurementError, Reference

# Where a laboratory says nothing of its errors, an observable is taken to be measured to this part of its peak, by its variance share.
USUAL_ERROR = 0.01

# Errors along one curve are alike over a length that is rarely known: hypotheses on it, in lengths of the whole curve. None is zero, for fifty
# points of one curve are not fifty measurements.
CORRELATION_LENGTHS = (0.01, 0.03, 0.1, 0.3, 1.0)

# Hypotheses on the standard deviation of what the model cannot reproduce whatever its parameters, as parts of an observable's peak; and the length
# over which that is alike, in lengths of the curve.
DISCREPANCIES = (0.003, 0.01, 0.03, 0.1)
DISCREPANCY_LENGTH = 0.3


@dataclass(frozen=True, eq=False)
class ErrorModel:
    """Hypotheses on the covariance of reference minus true response, T states of J observables, observable by observable.

    covariances (H, J T, J T), in the observables' units; log_prior (H,), the logs of probabilities that sum to 1. correlation_lengths (H,) in lengths
    of the curve; discrepancies (H,) as parts of the observables' peaks, zero without.

    Each covariance is D K D + S + M: D the standard deviations of the devices, K the kernel exp(-|x - x'| / length) of an Ornstein-Uhlenbeck process
    over the control, S diagonal with step^2 / 12 of the observable and (dy/dx)^2 step^2 / 12 of the control, M the discrepancy, alike over a third
    of the curve.
    """

    covariances: NDArray[np.float64]
    log_prior: NDArray[np.float64]
    correlation_lengths: NDArray[np.float64]
    discrepancies: NDArray[np.float64]

    @property
    def size(self) -> int:
        """The number of hypotheses H."""
        return len(self.log_prior)


def error_model(reference: Reference, *, correlation_length: float | None = None, discrepancy: bool = False) -> ErrorModel:
    """The hypotheses on a reference's errors, all equally probable.

    correlation_length: in lengths of the curve where it is known; five from 0.01 to 1 otherwise. discrepancy: whether the model may be unable to
    reproduce the test, by 0.3 to 10 % of each observable's peak.
    Raises InputError for a length that is not positive.
    """
    if correlation_length is not None and not (np.isfinite(correlation_length) and correlation_length > 0):
        raise InputError(f"filter.correlation_length must be a number above 0, in lengths of the whole curve, not {correlation_length}.")
    control = reference.control
    extent = control[-1] - control[0] if len(control) > 1 else 1.0
    apart = np.abs(control[:, None] - control[None, :]) / extent
    peaks = np.abs(reference.values).max(axis=0)
    errors = measurement_errors(reference)
    slopes = [np.gradient(values, control) if len(control) > 1 else np.zeros(1) for values in reference.values.T]

    covariances, lengths, sizes = [], [], []
    for length in CORRELATION_LENGTHS if correlation_length is None else (correlation_length,):
        kernel = np.exp(-apart / length)
        for size in DISCREPANCIES if discrepancy else (0.0,):
            blocks = []
            for error, values, slope, peak in zip(errors, reference.values.T, slopes, peaks):
                variance = error.absolute**2 + (error.relative * values) ** 2
                independent = (error.step**2 + (slope * reference.control_step) ** 2) / 12
                lack = (size * peak) ** 2 * np.exp(-apart / DISCREPANCY_LENGTH)
                blocks.append(np.sqrt(variance)[:, None] * kernel * np.sqrt(variance)[None, :] + np.diag(independent) + lack)
            covariances.append(block_diag(*blocks))
            lengths.append(length)
            sizes.append(size)
    count = len(covariances)
    # A point that is exactly known (a first state of zero) would make the covariance singular.
    floor = np.repeat((1e-6 * peaks) ** 2, len(control))
    return ErrorModel(np.array(covariances) + np.diag(floor), np.full(count, -np.log(count)), np.array(lengths), np.array(sizes))


def measurement_errors(reference: Reference) -> tuple[MeasurementError, ...]:
    """The errors of the observables as the reference states them; where it does not, 1 % of the peak, more or less by the variance shares."""
    log_shares = np.log(reference.shares)
    relative = np.exp(0.5 * (log_shares - log_shares.mean()))
    peaks = np.abs(reference.values).max(axis=0)
    return tuple(
        reference.measurement_errors.get(name) or MeasurementError(absolute=float(USUAL_ERROR * peak * share) or 1e-12)
        for name, peak, share in zip(reference.names, peaks, relative)
    )
