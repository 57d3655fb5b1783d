"""How large each term of the errors was taken, what the curve says of them, and whether the answer is as far from the reference as they lead to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from graincal.campaign.found.emulated import Emulated
from graincal.inference.likelihood.reduction import columns
from graincal.notation.numbers import value
from graincal.notation.quantities import quantity
from graincal.notation.words import listed
from graincal.report.tables import Table


@dataclass(frozen=True, eq=False)
class ErrorTerms:
    """Of one experiment: the standard deviation of each term by its name, and of all together, as parts of the peaks, a mean over the states for each observable, (J,).

    discrepancy: what the curve makes of the model's own error, root mean square over the posterior, as a part of the peaks. packing_factor: of the factor on the variance between packings; NaN without.
    residual: root mean square of what the answer's mean response is off by, whitened by all together: about 1 where the errors are of the right size.
    """

    deviations: dict[str, NDArray[np.float64]]
    discrepancy: float
    packing_factor: float
    residual: float


def error_terms(emulated: Emulated) -> list[ErrorTerms]:
    """Of each experiment."""
    with threadpool_limits(1):
        return [_of_experiment(emulated, number) for number in range(len(emulated.result.experiments))]


def _of_experiment(emulated: Emulated, number: int) -> ErrorTerms:
    known, emulation = emulated.result.knowledge, emulated.emulation
    reference, errors, emulator, likelihood = known.kept[number], known.errors[number], emulation.emulators[number], emulation.likelihoods[number]
    # How probable each hypothesis is, over the posterior.
    logs = likelihood.hypotheses(*emulator.predict(emulated.result.space.to_unit(emulated.theta))) + likelihood.log_prior
    shares = np.exp(logs - logs.max(axis=1, keepdims=True))
    shares = (shares / shares.sum(axis=1, keepdims=True)).mean(axis=0)
    peaks = np.abs(reference.values).max(axis=0)

    def parts(variances: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.sqrt(variances.reshape(len(peaks), -1)).mean(axis=1) / peaks

    measured = known.errors_if(discrepancy=False, packings=False)[number]
    terms = {"measurement": parts(np.mean([np.diag(each) for each in measured.covariances], axis=0))}
    if scatter := known.packings[number]:
        terms["packings, as they were run"] = parts(known.counted(number) * np.diag(scatter.covariance))
    if known.scatters[number]:
        terms["one run of a simulation"] = parts(np.diag(emulator.simulator))
    discrepancy = float(np.sqrt(shares @ errors.discrepancies**2))
    if errors.discrepancies.any():
        terms["what the model cannot reproduce"] = np.full(len(peaks), discrepancy)
    terms["what the emulator's components leave out"] = parts(emulator.truncation)
    whole = np.tensordot(shares, errors.covariances, axes=1) + emulator.added(known.scatters[number])
    terms["all together, as the curve makes them"] = parts(np.diag(whole))
    return ErrorTerms(terms, discrepancy, float(shares @ errors.packing_factors) if scatter else np.nan, _residual(emulated, number, whole))


def _residual(emulated: Emulated, number: int, covariance: NDArray[np.float64]) -> float:
    """Of the runs at the answer, or of what is emulated there before it was run."""
    result, reference = emulated.result, emulated.result.knowledge.kept[number]
    rows = np.searchsorted(result.ids, emulated.answer.samples) + result.knowledge.before
    runs = result.knowledge.evaluations.responses[number][rows]
    runs = runs[np.isfinite(runs).all(axis=(1, 2))]
    if len(runs):
        mean = columns(runs.mean(axis=0))
    else:
        emulator = emulated.emulation.emulators[number]
        mean = columns(emulator.curves(emulator.predict(result.space.to_unit(emulated.answer.theta[None]))[0], len(reference.names))[0])
    white = scipy.linalg.solve_triangular(np.linalg.cholesky(covariance), columns(reference.values) - mean, lower=True)
    return float(np.sqrt(np.mean(white**2)))


def table(emulated: Emulated, terms: list[ErrorTerms]) -> Table:
    """The standard deviations, percent of the peak."""
    several = len(terms) > 1
    rows = []
    for experiment, each in zip(emulated.result.experiments, terms):
        for name, deviations in each.deviations.items():
            shown = dict(zip(experiment.reference.names, deviations))
            rows.append(
                (f"{experiment.name}: {name}" if several else name, *(f"{100 * shown[name]:.2g}" if name in shown else "–" for name in _observables(emulated)))
            )
    return Table(("standard deviation, % of the peak, mean over the states", *(quantity(name).label for name in _observables(emulated))), tuple(rows))


def sentence(emulated: Emulated, terms: list[ErrorTerms]) -> str:
    """What the curves say of them."""
    said = []
    for experiment, each in zip(emulated.result.experiments, terms):
        of = f"Of {experiment.name}, the" if len(terms) > 1 else "The"
        says = [f"that the model cannot reproduce {value(100 * each.discrepancy, 2)} % of the peak"] if each.discrepancy else []
        says += (
            [f"that packings differ by {value(np.sqrt(each.packing_factor), 2)} times as much as those that were run"]
            if np.isfinite(each.packing_factor)
            else []
        )
        said.append(
            (f"{of} curve says {listed(says)}. " if says else "")
            + f"What the answer is off by, whitened by all together, is {value(each.residual, 2)} on the mean, where 1 is as much as the errors lead to."
        )
    return " ".join(said)


def _observables(emulated: Emulated) -> list[str]:
    return list(dict.fromkeys(name for experiment in emulated.result.experiments for name in experiment.reference.names))
