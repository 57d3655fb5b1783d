"""How many solutions are there? (section 3.3: Table 5, Figures 7 and 8)"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from graincal.campaign import Result
from graincal.data import Reference
from graincal.inference.iteration import Iteration
from graincal.notation.quantities import quantity
from graincal.report.drawing import Axis, Figure, Line, Panel, Points
from graincal.report.palette import REFERENCE, Style, sequence
from graincal.studies import paper
from graincal.studies.found import parameter_labels
from graincal.studies.particles import PRESSURE, on_toyoura
from graincal.studies.records import CANNOT_BE_TOLD, Conclusion, Findings, Judgement, Row, Table, Values, smaller
from graincal.studies.settings import OBSERVABLES, STRESS_TRUSTED, Setup
from graincal.studies.study import Case, Done, Study

PARTICLES, ITERATION, SHOWN = 2000, 5, 7
BEST = 10
"""Samples of the largest weight whose responses are shown."""

PRINTED = {
    ("log_E", "nu"): -0.676, ("log_E", "phi"): -0.479, ("log_E", "beta_m"): 0.660, ("log_E", "eta_m"): -0.133, ("nu", "phi"): -0.173,
    ("nu", "beta_m"): -0.599, ("nu", "eta_m"): -0.231, ("phi", "beta_m"): -0.332, ("phi", "eta_m"): 0.392, ("beta_m", "eta_m"): -0.483,
}  # fmt: skip
"""Table 5: of the samples of iteration 5."""


class Solutions(Study):
    name = "solutions"
    title = "Several solutions"
    where = "section 3.3, Table 5, Figures 7 and 8"
    question = "Toyoura sand at 0.5 MPa by 2,000 particles: where do the samples of the iterations lie, and how are the parameters related?"

    def cases(self, setup: Setup, done: Done) -> Sequence[Case]:
        return [on_toyoura(setup, PARTICLES, setup.long)]

    def findings(self, setup: Setup, done: Done) -> Findings:
        (case,) = self.cases(setup, done)
        results = [result for result in done.results(case) if len(result.iterations) > ITERATION]
        correlations = [np.corrcoef(result.iterations[ITERATION].samples.theta.T) for result in results]
        where = {name: number for number, name in enumerate(paper.PARAMETERS)}
        lines = [Row(first, second, value, tuple(float(each[where[first], where[second]]) for each in correlations)) for (first, second), value in PRINTED.items()]
        notes = ("They belong to one sequence of random numbers: what can be repeated is the shape of the samples, not these values.",)
        figures = {}
        if results:
            figures = {7: _planes(results[0]), 8: _bundles(results[0], setup.toyoura(PRESSURE, STRESS_TRUSTED))}
        return Findings((Table(5, f"Correlations of the samples of iteration {ITERATION}", tuple(lines), notes),), figures, _conclusions(correlations, results))


def _planes(result: Result) -> Figure:
    """Figure 7: the samples of the first iterations over each pair of parameters."""
    labels, iterations = parameter_labels(), result.iterations[:SHOWN]
    styles = sequence(len(iterations))
    panels = []
    for first, second in combinations(range(len(paper.PARAMETERS)), 2):
        marks = tuple(Points(each.samples.theta[:, first], each.samples.theta[:, second], style, f"iteration {each.index}") for each, style in zip(iterations, styles))
        panels.append(Panel("", Axis(labels[paper.PARAMETERS[first]]), Axis(labels[paper.PARAMETERS[second]]), marks))
    return Figure("figure-07", "Samples of the first iterations", "Iteration 0 fills the ranges evenly; later ones gather where samples fit.", tuple(panels), columns=3)


def _bundles(result: Result, reference: Reference) -> Figure:
    """Figure 8: the responses of the samples of the largest weight, an iteration a panel."""
    name, panels = OBSERVABLES[0], []
    for each in result.iterations[: SHOWN - 1]:
        lines = [Line(100 * run.control, run.values[name], Style("#0072b2", width=1, opacity=0.6), f"{BEST} samples of the largest weight") for run in _best_runs(result, each)]
        panels.append(Panel(f"iteration {each.index}", Axis("axial strain [%]"), Axis(quantity(name).axis), (*lines, Points(100 * reference.control, reference.observables[name], REFERENCE, "measured"))))
    return Figure("figure-08", "Responses of the samples of the largest weight", "The bundle narrows from iteration to iteration.", tuple(panels), columns=3)


def _best_runs(result: Result, iteration: Iteration) -> list:
    if iteration.unweighted:
        return []
    heaviest = np.argsort(-iteration.final_weights, kind="stable")[:BEST]
    return [result.response(int(iteration.samples.ids[row])) for row in heaviest if not iteration.failed[row]]


def _conclusions(correlations: Sequence[NDArray[np.float64]], results: Sequence[Result]) -> tuple[Conclusion, ...]:
    def size(first: str, second: str) -> Values:
        where = [paper.PARAMETERS.index(name) for name in (first, second)]
        return Values.of(f"|ρ| of {first} and {second}", [abs(each[tuple(where)]) for each in correlations], _of_chance(results), unit="")

    narrow = [result.iterations[ITERATION].samples.theta.std(axis=0) / result.iterations[0].samples.theta.std(axis=0) for result in results]
    narrowed = Values.of(f"the spread of log E in iteration {ITERATION}, in that of iteration 0,", [each[0] for each in narrow], unit="")
    one_seed = Judgement(CANNOT_BE_TOLD, "Correlations of samples in clusters belong to one sequence of random numbers, and the paper has one calibration.")
    claims = {
        "The samples gather: iteration 5 spreads over less than half the range of log E.": smaller(narrowed, Values("0.5", (0.5,), unit="")),
        "E is more strongly tied to ν and β_{m} than to η_{m}.": one_seed if len(correlations) < 2 else smaller(size("log_E", "eta_m"), size("log_E", "nu")),
    }
    return tuple(Conclusion(claim, judgement) for claim, judgement in claims.items())


def _of_chance(results: Sequence[Result]) -> float:
    """What a correlation of independent samples differs from zero by, about: one over the root of their number."""
    return 1 / np.sqrt(len(results[0].iterations[ITERATION].samples)) if results else 0.0
