"""How many solutions are there? (section 3.3: Table 5, Figures 7 and 8)"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from graincal.data import Reference
from graincal.drawing.figure import Axis, Figure, Line, Panel, Points
from graincal.drawing.palette import REFERENCE, Style, sequence
from graincal.inference.driving.iteration import Iteration
from graincal.inference.sampling.posterior import Posterior
from graincal.notation.quantities import quantity
from graincal.result import Result
from graincal.studies import paper
from graincal.studies.common import PRESSURE
from graincal.studies.found import ITERATIONS, Fit, fits, parameter_labels, parameter_names, rows
from graincal.studies.judging import EXACT, Values, all_of, at_least, at_most, smaller, spread_at
from graincal.studies.particles import named, on_toyoura, on_toyoura_by_posterior
from graincal.studies.records import Conclusion, Findings, Row, Table, conclusions
from graincal.studies.settings import ITERATIVE, OBSERVABLES, POSTERIOR, STRESS_TRUSTED, Setup
from graincal.studies.study import Case, Done, Study

PARTICLES, ITERATION, SHOWN = 2000, 5, 7
SEVERAL = 1000
"""Particles of the calibrations that have several seeds, in the study of the number of particles."""

BEST = 10
"""Samples of the largest weight whose responses are shown."""

PRINTED = {
    ("log_E", "nu"): -0.676, ("log_E", "phi"): -0.479, ("log_E", "beta_m"): 0.660, ("log_E", "eta_m"): -0.133, ("nu", "phi"): -0.173,
    ("nu", "beta_m"): -0.599, ("nu", "eta_m"): -0.231, ("phi", "beta_m"): -0.332, ("phi", "eta_m"): 0.392, ("beta_m", "eta_m"): -0.483,
}  # fmt: skip
"""Table 5: of the samples of iteration 5."""

LAST = 11
"""The iteration that the paper's calibration ended with."""


class Solutions(Study):
    name = "solutions"
    title = "Several solutions"
    where = "section 3.3, Table 5, Figures 7 and 8"
    question = "Toyoura sand at 0.5 MPa by 2,000 particles: where do the samples of the iterations lie, and how are the parameters related?"

    def cases(self, setup: Setup, done: Done) -> Sequence[Case]:
        return [on_toyoura(setup, PARTICLES, setup.long), on_toyoura_by_posterior(setup, PARTICLES, setup.long)]

    def findings(self, setup: Setup, done: Done) -> Findings:
        iterative, by_posterior = self.cases(setup, done)
        results = _long_enough(done.results(iterative))
        posteriors = [result.posterior for result in done.results(by_posterior) if result.posterior is not None]
        several = _long_enough(done.results(on_toyoura(setup, SEVERAL, setup.short)))
        tables = (_table(results, posteriors, iterative.missing), _ended(fits(done.results(iterative)), iterative.missing))
        figures = {7: _planes(results[0]), 8: _bundles(results[0], setup.toyoura(PRESSURE, STRESS_TRUSTED))} if results else {}
        return Findings(tables, figures, _conclusions(results, several), (f"The calibrations are of {named(setup, PARTICLES)}.",))


def _long_enough(results: Sequence[Result]) -> list[Result]:
    """Those that came to the iteration of the table."""
    return [result for result in results if len(result.iterations) > ITERATION]


def _table(results: Sequence[Result], posteriors: Sequence[Posterior], missing: str) -> Table:
    where = {name: number for number, name in enumerate(paper.PARAMETERS)}
    by_method = {ITERATIVE: [_correlations(result) for result in results], POSTERIOR: [_weighted_correlations(each) for each in posteriors]}
    lines = [
        Row(first, second, value, tuple(float(each[where[first], where[second]]) for each in correlations), method=method, missing=missing)
        for (first, second), value in PRINTED.items()
        for method, correlations in by_method.items()
    ]
    notes = (
        "They belong to one sequence of random numbers: what can be repeated is the shape of the samples, not these values.",
        'Those by "posterior" are of the posterior itself.',
    )
    return Table(5, f"Correlations of the samples of iteration {ITERATION}", tuple(lines), notes)


def _ended(found: Sequence[Fit], missing: str) -> Table:
    """When the calibration ended, of the text."""
    return Table("solutions", "The last iteration", tuple(rows(f"{PARTICLES} particles", {ITERATIONS: LAST}, found, {}, (ITERATIONS,), missing=missing)))


def _correlations(result: Result) -> NDArray[np.float64]:
    return np.asarray(np.corrcoef(result.iterations[ITERATION].samples.theta.T))


def _weighted_correlations(posterior: Posterior) -> NDArray[np.float64]:
    covariance = np.cov(posterior.samples.T, aweights=posterior.weights)
    deviations = np.sqrt(np.diagonal(covariance))
    return covariance / np.outer(deviations, deviations)


def _planes(result: Result) -> Figure:
    """Figure 7: the samples of the first iterations over each pair of parameters."""
    labels, iterations = parameter_labels(), result.iterations[:SHOWN]
    styles = sequence(len(iterations))
    panels = []
    for first, second in combinations(range(len(paper.PARAMETERS)), 2):
        marks = tuple(
            Points(each.samples.theta[:, first], each.samples.theta[:, second], style, f"iteration {each.index}") for each, style in zip(iterations, styles)
        )
        panels.append(Panel("", Axis(labels[paper.PARAMETERS[first]]), Axis(labels[paper.PARAMETERS[second]]), marks))
    caption = "Iteration 0 fills the ranges evenly; later ones gather where samples fit."
    return Figure("figure-07", "Samples of the first iterations", caption, tuple(panels), columns=3)


def _bundles(result: Result, reference: Reference) -> Figure:
    """Figure 8: the responses of the samples of the largest weight, an iteration a panel."""
    name, panels = OBSERVABLES[0], []
    measured = Points(100 * reference.control, reference.observables[name], REFERENCE, "measured")
    style, key = Style("#0072b2", width=1, opacity=0.6), f"{BEST} samples of the largest weight"
    for each in result.iterations[: SHOWN - 1]:
        lines = [Line(100 * run.control, run.values[name], style, key) for run in _best_runs(result, each)]
        panels.append(Panel(f"iteration {each.index}", Axis("axial strain [%]"), Axis(quantity(name).axis), (*lines, measured)))
    return Figure("figure-08", "Responses of the samples of the largest weight", "The bundle narrows from iteration to iteration.", tuple(panels), columns=3)


def _best_runs(result: Result, iteration: Iteration) -> list:
    if iteration.unweighted:
        return []
    heaviest = np.argsort(-iteration.final_weights, kind="stable")[:BEST]
    return [result.response(int(iteration.samples.ids[row])) for row in heaviest if not iteration.failed[row]]


def _conclusions(results: Sequence[Result], several: Sequence[Result]) -> tuple[Conclusion, ...]:
    def value(name: str, of: Callable[[Result], float], floor: float) -> Values:
        """A number of each calibration; for one seed its spread with fewer particles."""
        elsewhere = spread_at(f"{SEVERAL} particles", [of(result) for result in several])
        return Values.of_finite(name, [of(result) for result in results], floor, unit="", elsewhere=elsewhere)

    def tied(first: str, second: str) -> Values:
        where = tuple(paper.PARAMETERS.index(name) for name in (first, second))
        shown = parameter_names()
        return value(f"|ρ| of {shown[first]} and {shown[second]}", lambda result: abs(_correlations(result)[where]), _of_chance(results))

    narrowed = value(f"the spread of log E in iteration {ITERATION} as a part of that in iteration 0", _narrowed, EXACT)
    bent = value(f"|ρ| of η_{{m}} with the square of β_{{m}}, β_{{m}} given, in iteration {ITERATION}", _bent, EXACT)
    apart = value(f"the number of separate groups of samples in iteration {ITERATION}", _groups, EXACT)
    return conclusions(
        {
            "The samples gather: iteration 5 spreads over less than half the range of log E.": at_most(narrowed, 0.5),
            "E is more strongly tied to ν and to β_{m} than to η_{m}.": all_of(
                [smaller(tied("log_E", "eta_m"), tied("log_E", other)) for other in ("nu", "beta_m")]
            ),
            "β_{m} and η_{m} lie on a curved line: a parabola is better than a straight one, beyond chance.": at_least(bent, 2 * _of_chance(results)),
            "There are several minima: the samples of iteration 5 are in at least two separate groups.": at_least(apart, 1.5),
        }
    )


def _narrowed(result: Result) -> float:
    late, first = (result.iterations[number].samples.theta[:, 0] for number in (ITERATION, 0))
    return float(late.std() / first.std())


def _bent(result: Result) -> float:
    """The partial correlation of η_m with the square of β_m, of the samples, β_m given."""
    beta, eta = (result.iterations[ITERATION].samples.theta[:, paper.PARAMETERS.index(name)] for name in ("beta_m", "eta_m"))
    line = np.column_stack([np.ones(len(beta)), beta])
    left = [each - line @ np.linalg.lstsq(line, each, rcond=None)[0] for each in (eta, beta**2)]
    return abs(float(np.corrcoef(left)[0, 1]))


def _groups(result: Result) -> float:
    """One where no separate groups can be told."""
    from graincal.inference.sampling.groups import find_groups

    samples = result.iterations[ITERATION].samples.theta
    return float(max(1, len(find_groups(result.space, Posterior(paper.PARAMETERS, samples, np.full(len(samples), 1 / len(samples)))))))


def _of_chance(results: Sequence[Result]) -> float:
    """What a correlation of independent samples differs from zero by, about: one over the root of their number."""
    return 1 / np.sqrt(len(results[0].iterations[ITERATION].samples)) if results else np.nan
